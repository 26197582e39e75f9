"""Writes pair_jacobians.json: derivatives of force and torques of near and of distant pairs, in 25 digits.

    python tests/data/make_derivatives.py

Force and torques are sums over one body's focal ellipse of the other's field, by Carlson's integrals in mpmath; the derivatives are
central differences of fourth order of these sums. Some two minutes.
"""

import json
from pathlib import Path

import numpy as np
from mpmath import cos, elliprd, findroot, matrix, mp, mpf, sin, sqrt

mp.dps = 25
STEP = mpf(10) ** -5
#: Semi-axes of A and B, a >= b >= c, the separation, angles (phi, theta, psi), and Gauss points and angles of the rule.
POSES = {
    "near": ([1.0, 0.8, 0.6], [0.7, 0.5, 0.4], [1.5, 0.6, 0.7], [0.3, -0.2, 0.8], [1.1, 0.5, -0.4], (9, 36)),
    "far": ([1.0, 0.8, 0.6], [0.7, 0.5, 0.4], [30.0, -20.0, 15.0], [0.3, -0.2, 0.8], [1.1, 0.5, -0.4], (5, 20)),
    "oblate": ([1.0, 1.0, 0.6], [0.5, 0.5, 0.35], [1.3, 0.9, 0.8], [0.2, 0.4, -0.6], [-0.3, 0.9, 0.1], (8, 30)),
    "sphere": ([0.9, 0.9, 0.9], [0.6, 0.45, 0.3], [1.0, 1.1, 0.4], [0.5, 0.1, 0.2], [0.7, -0.6, 0.3], (8, 30)),
}


def field(x, axes):
    """Return g = grad Phi of a body of unit GM at an exterior point."""
    squares = [a * a for a in axes]
    r2 = sum(v * v for v in x)
    kappa = findroot(lambda k: sum(v * v / (s + k) for v, s in zip(x, squares, strict=True)) - 1, r2 - squares[0] / 2)
    a, b, c = (s + kappa for s in squares)
    return [-x[0] * elliprd(b, c, a), -x[1] * elliprd(c, a, b), -x[2] * elliprd(a, b, c)]


def rotation(phi, theta, psi):
    """R = Rz(psi) Ry(theta) Rx(phi)."""
    rx = matrix([[1, 0, 0], [0, cos(phi), -sin(phi)], [0, sin(phi), cos(phi)]])
    ry = matrix([[cos(theta), 0, sin(theta)], [0, 1, 0], [-sin(theta), 0, cos(theta)]])
    rz = matrix([[cos(psi), -sin(psi), 0], [sin(psi), cos(psi), 0], [0, 0, 1]])
    return rz * ry * rx


def small_rotation(v):
    """Return exp([v]x) of a small vector along an axis."""
    (axis,) = [k for k in range(3) if v[k] != 0] or [0]
    angles = [v[k] if k == axis else mpf(0) for k in range(3)]
    return rotation(*angles)


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def column(v):
    return matrix([[x] for x in v])


def rule(gauss, angles):
    """Return points of the unit disc with weights in proportion to sqrt(1 - x^2 - y^2)."""
    nodes, weights = legendre(2 * gauss + 1)
    points = []
    for t, w in zip(nodes, weights, strict=True):
        if t > mpf(10) ** -10:
            radius = sqrt(1 - t * t)
            for k in range(angles):
                angle = 2 * mp.pi * (k + mpf(1) / 2) / angles
                points.append((radius * cos(angle), radius * sin(angle), 3 * t * t * w / angles))
    return points


def legendre(n):
    """Return Gauss's nodes and weights on [-1, 1]."""
    guesses = np.polynomial.legendre.leggauss(n)[0]
    nodes = [findroot(lambda x: mp.legendre(n, x), mpf(float(g))) if abs(g) > 1e-12 else mpf(0) for g in guesses]
    slopes = [n * (x * mp.legendre(n, x) - mp.legendre(n - 1, x)) / (x * x - 1) for x in nodes]
    return nodes, [2 / ((1 - x * x) * s * s) for x, s in zip(nodes, slopes, strict=True)]


def loads(a, b, points, separation, ra, rb):
    """Return the force on A and the torques on A and B, by the field of A on the focal ellipse of B."""
    p, q = sqrt(b[0] ** 2 - b[2] ** 2), sqrt(b[1] ** 2 - b[2] ** 2)
    force, torque = [mpf(0)] * 3, [mpf(0)] * 3
    for u, v, w in points:
        y = rb * column([p * u, q * v, mpf(0)])
        x = list(ra.T * (column(separation) + y))
        g = list(ra * column(field(x, a)))
        force = [f + w * c for f, c in zip(force, g, strict=True)]
        torque = [m + w * c for m, c in zip(torque, cross(list(y), g), strict=True)]
    on_a = [-m - c for m, c in zip(torque, cross(separation, force), strict=True)]
    return [-f for f in force] + list(ra.T * column(on_a)) + list(rb.T * column(torque))


def jacobian(a, b, separation, angles_a, angles_b, order):
    """Return the Jacobian of the force on A and the torques on A and B by separation and rotation vectors of A and B."""
    a, b, separation = ([mpf(str(v)) for v in values] for values in (a, b, separation))
    ra, rb = (rotation(*[mpf(str(v)) for v in angles]) for angles in (angles_a, angles_b))
    points = rule(*order)
    columns = []
    for k in range(9):
        ends = {}
        for m in (-2, -1, 1, 2):
            move = [[mpf(0)] * 3 for _ in range(3)]
            move[k // 3][k % 3] = m * STEP
            displaced = [s + d for s, d in zip(separation, move[0], strict=True)]
            ends[m] = loads(a, b, points, displaced, ra * small_rotation(move[1]), rb * small_rotation(move[2]))
        columns.append(
            [
                (8 * (p - q) - (pp - qq)) / (12 * STEP)
                for p, q, pp, qq in zip(ends[1], ends[-1], ends[2], ends[-2], strict=True)
            ]
        )
    return [[mp.nstr(columns[j][i], 18) for j in range(9)] for i in range(9)]


def main():
    """Write the file."""
    cases = []
    for name, (a, b, separation, angles_a, angles_b, order) in POSES.items():
        cases.append(
            {
                "name": name,
                "axes_a": a,
                "axes_b": b,
                "separation": separation,
                "angles_a": angles_a,
                "angles_b": angles_b,
                "jacobian": jacobian(a, b, separation, angles_a, angles_b, order),
            }
        )
    Path(__file__).with_name("pair_jacobians.json").write_text(json.dumps(cases, indent=1) + "\n")


if __name__ == "__main__":
    main()
