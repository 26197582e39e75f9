"""Writes thin_forces.json: force, torques and energy of pairs with very thin or very small bodies, in 30 digits.

Independent of the code: the closed-form field with mpmath's Carlson integrals, its mean over the other body's focal
ellipse by a product rule in 40 digits, the same to 1e-25 with a finer rule. Per G m_A m_B.
Run: python tests/data/make_thin_forces.py
"""

import json
import pathlib

import mpmath as mp
import numpy as np

mp.mp.dps = 40

#: Name, semi-axes of both, separation, angles of both, body that is integrated over.
PAIRS = [
    (
        "needle at a large body",
        (18.85, 13.48, 15.09),
        (0.0494, 5.6e-6, 2.7e-6),
        (9.46, -7.57, 9.46),
        (0.2, -0.3, 0.9),
        (-0.5, 0.4, 1.7),
        1,
    ),
    (
        "disc and triaxial body",
        (1.0, 1.0, 1e-6),
        (0.3, 0.25, 0.2),
        (0.5, 0.4, 0.9),
        (0.3, 0.2, -0.4),
        (1.0, 0.6, 0.2),
        1,
    ),
    (
        "needle and needle",
        (1e-4, 1.0, 1e-4),
        (1e-7, 2e-7, 1e-3),
        (0.03, 0.4, -0.02),
        (0.1, 0.02, 0.1),
        (-2.0, 0.7, 0.3),
        1,
    ),
    (
        "grain above a disc",
        (2e-6, 0.9, 1.0),
        (0.9e-6, 0.8e-6, 1e-6),
        (4e-6, 2e-5, -3e-5),
        (0.0, 0.0, 0.0),
        (0.7, -0.2, 0.5),
        1,
    ),
    (
        "grain above a flat side",
        (0.17, 0.12, 0.1),
        (3e-7, 2e-7, 1e-7),
        (0.02, -0.01, 0.1001),
        (0.0, 0.0, 0.0),
        (0.4, 1.1, -0.6),
        1,
    ),
    ("moonlet", (1.0, 0.9, 0.8), (9e-4, 1e-3, 8e-4), (1.1, -0.7, 0.5), (0.4, -0.2, 0.1), (0.3, 0.5, -1.0), 1),
]


def rotation(angles):
    """Rz(psi) Ry(theta) Rx(phi)."""
    (cf, ct, cp), (sf, st, sp) = ([f(mp.mpf(v)) for v in angles] for f in (mp.cos, mp.sin))
    rz = mp.matrix([[cp, -sp, 0], [sp, cp, 0], [0, 0, 1]])
    ry = mp.matrix([[ct, 0, st], [0, 1, 0], [-st, 0, ct]])
    rx = mp.matrix([[1, 0, 0], [0, cf, -sf], [0, sf, cf]])
    return rz * ry * rx


def cross(a, b):
    return mp.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def field(axes, x):
    """Return potential and field at a point in the frame of the body."""
    squares, x2 = [a * a for a in axes], [v * v for v in x]
    # sum x_i^2/(a_i^2 + kappa) falls through one.
    low, high = mp.mpf(0), mp.fsum(x2)
    for _ in range(180):
        kappa = (low + high) / 2
        outside = mp.fsum(v / (a + kappa) for v, a in zip(x2, squares, strict=True)) > 1
        low, high = (kappa, high) if outside else (low, kappa)
    s = [a + kappa for a in squares]
    assert abs(mp.fsum(v / w for v, w in zip(x2, s, strict=True)) - 1) < mp.mpf("1e-30")
    rd = [mp.elliprd(s[(i + 1) % 3], s[(i + 2) % 3], s[i]) for i in range(3)]
    return mp.fsum((w - v) * r for w, v, r in zip(s, x2, rd, strict=True)) / 2, mp.matrix(
        [-v * r for v, r in zip(x, rd, strict=True)]
    )


def gauss_legendre(n):
    nodes, weights = [], []
    for x in np.polynomial.legendre.leggauss(n)[0]:
        x = mp.mpf(float(x))
        for _ in range(4):
            previous, value = mp.mpf(1), x
            for k in range(2, n + 1):
                previous, value = value, ((2 * k - 1) * x * value - (k - 1) * previous) / k
            slope = n * (x * value - previous) / (x * x - 1)
            x -= value / slope
        nodes.append(x)
        weights.append(2 / ((1 - x * x) * slope**2))
    return nodes, weights


def interaction(pair, radii, angles):
    """Return the force on A (inertial), torques (body frames) and energy, means over the focal ellipse of one body."""
    _, axes_a, axes_b, separation, angles_a, angles_b, integrated = pair
    bodies = [([mp.mpf(v) for v in axes], rotation(euler)) for axes, euler in ((axes_a, angles_a), (axes_b, angles_b))]
    (carrier, rotation_matrix), (source, frame) = bodies[integrated], bodies[1 - integrated]
    r = mp.matrix([mp.mpf(v) for v in separation]) * (1 if integrated else -1)
    shortest = min(range(3), key=lambda i: carrier[i])
    p, q = (i for i in range(3) if i != shortest)
    focal = {i: mp.sqrt((carrier[i] - carrier[shortest]) * (carrier[i] + carrier[shortest])) for i in (p, q)}
    force, torque, energy = mp.matrix(3, 1), mp.matrix(3, 1), mp.mpf(0)
    for t, weight in zip(*gauss_legendre(2 * radii + 1), strict=True):
        if t < mp.mpf("1e-20"):
            continue
        rho = mp.sqrt(1 - t * t)
        for k in range(angles):
            y = mp.matrix(3, 1)
            y[p] = focal[p] * rho * mp.cos(2 * mp.pi * (k + mp.mpf(1) / 2) / angles)
            y[q] = focal[q] * rho * mp.sin(2 * mp.pi * (k + mp.mpf(1) / 2) / angles)
            y = rotation_matrix * y
            phi, g = field(source, frame.T * (r + y))
            g, share = frame * g, 3 * t * t * weight / angles
            force, torque, energy = force + share * g, torque + share * cross(y, g), energy - share * phi
    other = frame.T * -(torque + cross(r, force))
    torques = [rotation_matrix.T * torque, other] if integrated == 0 else [other, rotation_matrix.T * torque]
    return force if integrated == 0 else -force, *torques, energy


def main():
    cases = []
    for pair in PAIRS:
        coarse, fine = interaction(pair, 9, 28), interaction(pair, 12, 36)
        lever = [max(pair[1]), max(pair[2])]
        size = mp.norm(fine[0])
        for one, two, scale in zip(coarse[:3], fine[:3], (size, size * lever[0], size * lever[1]), strict=True):
            assert mp.norm(one - two) < mp.mpf("1e-22") * scale, (pair[0], mp.nstr(mp.norm(one - two) / scale, 3))
        names = ("name", "axes_a", "axes_b", "separation", "angles_a", "angles_b")
        values = zip(("force_on_a_inertial", "torque_on_a_body", "torque_on_b_body"), fine[:3], strict=True)
        cases.append(
            {
                **dict(zip(names, pair[:6], strict=True)),
                **{name: [mp.nstr(v, 25) for v in vector] for name, vector in values},
                "potential_energy": mp.nstr(fine[3], 25),
            }
        )
    path = pathlib.Path(__file__).with_name("thin_forces.json")
    path.write_text("[\n" + ",\n".join(json.dumps(c) for c in cases) + "\n]\n")


if __name__ == "__main__":
    main()
