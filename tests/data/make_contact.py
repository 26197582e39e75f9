"""Writes contact.json: the factor by which two ellipsoids must grow to touch, down to c/a = 1e-12, in 70 digits.

Independent of the code: Perram & Wertheim's function s (1-s) r^T [(1-s) A + s B]^-1 r with exact rotations of the
quaternions, its maximum by bisection of its slope. `condition` says how the rounding of an input counts in the factor:
(separation / factor + largest semi-axes) / (extents of both bodies along their common normal).
Run: python tests/data/make_contact.py
"""

import json
import pathlib

import mpmath as mp
import numpy as np

mp.mp.dps = 70


def rotation(q):
    w, x, y, z = (mp.mpf(float(v)) for v in q)
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return mp.matrix(rows) / (w * w + x * x + y * y + z * z)


def contact(a, b, separation, p, q):
    """Return the growth factor and the condition."""
    spreads = [
        matrix * mp.diag([mp.mpf(float(v)) ** 2 for v in axes]) * matrix.T
        for axes, matrix in ((a, rotation(p)), (b, rotation(q)))
    ]
    r = mp.matrix([float(v) for v in separation])
    first, second = spreads

    def at(u):
        s, complement = 1 / (1 + mp.exp(-u)), 1 / (1 + mp.exp(u))
        w = mp.lu_solve(complement * first + s * second, r)
        extents = [mp.sqrt((w.T * m * w)[0]) for m in (first, second)]
        slope = complement * extents[0] - s * extents[1]
        return slope, mp.sqrt(s * complement * (r.T * w)[0]), mp.fsum(extents) / mp.norm(w)

    low, high = mp.mpf(-80), mp.mpf(80)
    while high - low > mp.mpf("1e-15"):
        middle = (low + high) / 2
        low, high = (middle, high) if at(middle)[0] > 0 else (low, middle)
    _, growth, thickness = at(low)
    return growth, (mp.norm(r) / growth + float(max(a)) + float(max(b))) / thickness


def about(axis, angle):
    axis = np.asarray(axis, dtype=float)
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis / np.linalg.norm(axis))])


def product(p, q):
    w, v, a, b = p[0], p[1:], q[0], q[1:]
    return np.array([w * a - v @ b, *(w * b + a * v + np.cross(v, b))])


def shape(rng, thinnest):
    """Return the semi-axes of a disc, a needle, a blade or a shape between these."""
    c = 10 ** rng.uniform(np.log10(thinnest), 0)
    b = 10 ** rng.uniform(np.log10(c), 0)
    return np.array([[1, 1, c], [1, c, c], [1, b, c], [1, 1 - b / 2, c], [1, c * (1 + b), c]][rng.integers(5)])


def pose(rng, thinnest):
    """Return two bodies near contact along a normal that is often the thinnest direction of one or both."""
    a = shape(rng, thinnest)
    b = a.copy() if rng.random() < 0.5 else shape(rng, thinnest)
    if rng.random() < 0.5:
        b = b * 10 ** rng.uniform(-4, 4)
    p = rng.normal(size=4)
    p /= np.linalg.norm(p)
    small, angle = 10 ** rng.uniform(-12, 0), rng.uniform(0, 2 * np.pi)
    rotations_of_second = [
        about([1, 0, 0], 0.0),
        about(rng.normal(size=3), small),
        about(rng.normal(size=3), angle),
        about(np.eye(3)[rng.integers(3)], angle),
        about(np.eye(3)[rng.integers(3)], np.pi / 2),
        product(about([0, 0, 1], angle), about([1, 0, 0], small)),
    ]
    q = product(p, rotations_of_second[rng.choice(len(rotations_of_second), p=[0.3, 0.2, 0.1, 0.1, 0.1, 0.2])])
    frames = [np.array(rotation(quaternion).tolist(), dtype=float) for quaternion in (p, q)]
    normals = [
        frames[0][:, 2],
        frames[1][:, rng.integers(3)],
        rng.normal(size=3),
        frames[0][:, 2] + small * rng.normal(size=3),
        np.cross(frames[0][:, 0], frames[1][:, 0]) + 1e-13 * frames[0][:, 1],
    ]
    n = normals[rng.choice(len(normals), p=[0.45, 0.1, 0.1, 0.15, 0.2])]
    n /= np.linalg.norm(n)
    arms = [frame.T @ n * axes for frame, axes in zip(frames, (a, b), strict=True)]
    extents = [np.linalg.norm(arm) for arm in arms]
    touching = sum(frame @ (arm * axes) / h for frame, arm, axes, h in zip(frames, arms, (a, b), extents, strict=True))
    # From far inside to a thousand thicknesses apart, half of the poses within a hundredth of contact.
    gap = 10 ** rng.uniform(-3, -2) * rng.choice([-1, 1]) if rng.random() < 0.5 else 10 ** rng.uniform(-2, 3)
    gap = -rng.uniform(0, 1) if gap > 0.01 and rng.random() < 0.3 else gap
    return a, b, touching + gap * sum(extents) * n, p, q


def main():
    rng = np.random.default_rng(1985)
    names = ("first", "second", "separation", "attitude_first", "attitude_second")
    cases = []
    for thinnest, count in ((1e-1, 20), (1e-9, 140), (1e-12, 20)):
        for _ in range(count):
            values = pose(rng, thinnest)
            growth, condition = contact(*values)
            case = {name: [float(v) for v in value] for name, value in zip(names, values, strict=True)}
            cases.append({**case, "growth": mp.nstr(growth, 20), "condition": float(mp.nstr(condition, 4))})
    path = pathlib.Path(__file__).with_name("contact.json")
    path.write_text("[\n" + ",\n".join(json.dumps(c) for c in cases) + "\n]\n")


if __name__ == "__main__":
    main()
