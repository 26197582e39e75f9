"""The dimensionless cases against a second program in 80-bit arithmetic, written here and sharing nothing.

Its field is the paper's appendix (oblate spheroid, inverse sine), its integrator Gragg's extrapolated midpoint rule,
its quadrature a product of numpy's Gauss-Legendre nodes and equal angles on the focal disc. Only where a long double
has 64 bits of mantissa.
"""

import fullbody
import numpy as np
import pytest
from support import angle_between, reference

LD = np.longdouble
pytestmark = pytest.mark.skipif(np.finfo(LD).nmant < 63, reason="long double is no longer than double here")

PI = LD(4) * np.arctan(LD(1))
MASS, C2 = LD(2), LD(1) / 16  # both bodies: semi-axes 1, 1, 1/4
E = np.sqrt(1 - C2)
INERTIA = MASS / 5 * np.array([1 + C2, 1 + C2, 2], dtype=LD)


def gauss_legendre(n):
    """Nodes and weights on [-1, 1], numpy's polished by Newton in long double."""
    x = np.polynomial.legendre.leggauss(n)[0].astype(LD)
    for _ in range(3):
        before, now = np.ones_like(x), x
        for k in range(2, n + 1):
            before, now = now, ((2 * k - 1) * x * now - (k - 1) * before) / k
        slope = n * (x * now - before) / (x * x - 1)
        x = x - now / slope
    return x, 2 / ((1 - x * x) * slope * slope)


def focal_disc(nodes=28, angles=28):
    """Points of the focal disc and their shares of the mass, density ~ sqrt(1 - rho^2)."""
    x, w = gauss_legendre(nodes)
    t, w = x[x > 0], w[x > 0] * 3 * x[x > 0] ** 2
    rho = E * np.sqrt(1 - t * t)
    alpha = 2 * PI * np.arange(angles, dtype=LD) / angles
    points = [np.outer(rho, np.cos(alpha)).ravel(), np.outer(rho, np.sin(alpha)).ravel(), np.zeros(rho.size * angles)]
    return np.stack(points, axis=1).astype(LD), np.repeat(w / angles, angles)


POINTS, WEIGHTS = focal_disc()


def field(r):
    """The paper's appendix: field of the oblate spheroid at points outside, G = 1."""
    r2, z2 = r[:, 0] ** 2 + r[:, 1] ** 2, r[:, 2] ** 2
    half = (1 + C2 - r2 - z2) / 2
    kappa = -half + np.sqrt(half * half - (C2 - r2 * C2 - z2))
    arc = np.arcsin(E / np.sqrt(1 + kappa)) / E
    rho = 3 * MASS / 4 / E**2  # pi rho a^2 c / (a^2 - c^2)
    across = 2 * rho * (np.sqrt(C2 + kappa) / (1 + kappa) - arc)
    along = 4 * rho * (arc - 1 / np.sqrt(C2 + kappa))
    return np.stack([r[:, 0] * across, r[:, 1] * across, r[:, 2] * along], axis=1)


def rotation(q):
    w, x, y, z = q / np.sqrt(q @ q)
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def rates(y):
    r, v, q, spin = y[:6].reshape(2, 3), y[6:12], y[12:20].reshape(2, 4), y[20:].reshape(2, 3)
    first, second = rotation(q[0]), rotation(q[1])
    arms = POINTS @ first.T
    forces = field((arms + r[0] - r[1]) @ second) @ second.T * (MASS * WEIGHTS)[:, None]
    force = forces.sum(axis=0)
    torque = np.cross(arms, forces).sum(axis=0)
    other = -torque + np.cross(r[1] - r[0], force)
    turning, spinning = [], []
    for frame, moment, p, o in ((first, torque, q[0], spin[0]), (second, other, q[1], spin[1])):
        spinning.append((frame.T @ moment - np.cross(o, INERTIA * o)) / INERTIA)
        turning.append(np.concatenate([[-(p[1:] @ o)], p[0] * o + np.cross(p[1:], o)]) / 2)
    return np.concatenate([v, force / MASS, -force / MASS, *turning, *spinning])


def extrapolated_step(y, step, columns=9):
    """Gragg's modified midpoint rule with 2, 4, ... substeps, extrapolated in their squares."""
    row = []
    for k in range(1, columns + 1):
        h = step / (2 * k)
        before, now = y, y + h * rates(y)
        for _ in range(2 * k - 1):
            before, now = now, before + 2 * h * rates(now)
        new = [now]
        for j in range(1, k):
            ratio = (LD(k) / (k - j)) ** 2
            new.append(new[-1] + (new[-1] - row[j - 1]) / (ratio - 1))
        row = new
    return row[-1]


def start(case):
    half = LD(np.pi / 32) / 2
    quaternions = np.zeros((2, 4), dtype=LD)
    quaternions[:, 0] = np.cos(half)
    quaternions[:, 1 if case == "case1" else 2] = [np.sin(half), -np.sin(half)]
    spin = 0 if case == "case1" else 2
    parts = [[-4, 0, 0, 4, 0, 0], [0, LD(0.3), 0, 0, -LD(0.3), 0], quaternions.ravel(), [0, 0, spin] * 2]
    return np.concatenate([np.array(part, dtype=LD) for part in parts])


@pytest.mark.parametrize(("case", "until", "steps"), [("case1", 50, 30), ("case2", 50, 60)])
def test_cases_are_those_of_extended_precision(case, until, steps):
    y = start(case)
    for _ in range(steps):
        y = extrapolated_step(y, LD(until) / steps)
    system, state = getattr(fullbody.systems, case)()
    run = system.integrate(state, until, output=[until], integrator=fullbody.Verner98(rtol=1e-14, atol=1e-14))
    assert np.abs(run.position[0] - y[:6].reshape(2, 3)).max() < 4e-14
    assert np.abs(run.velocity[0] - y[6:12].reshape(2, 3)).max() < 1e-14
    assert np.abs(run.spin[0] - y[20:].reshape(2, 3)).max() < 1e-14
    frames = np.array([rotation(q) for q in y[12:20].reshape(2, 4)]).astype(float)
    assert angle_between(frames, run[0].rotation_matrix).max() < 1e-13
    # The reference file's positions against this program: what its 'agreement' leaves out.
    row = reference("trajectories")["runs"][case][0]
    assert row["time"] == until
    assert np.abs(np.array(row["position"]) - y[:6].reshape(2, 3)).max() < 1e-13
