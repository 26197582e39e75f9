"""Writes exterior_field.json: potential and field of hard ellipsoids in 40 digits.

Independent of the code: kappa from the cubic by bisection, the integrals of Ferrers and Dirichlet
    Phi = 3/4 int_kappa^inf (1 - sum x_i^2/(a_i^2+u)) du/Delta(u),  g_i = -3/2 x_i int_kappa^inf du/((a_i^2+u) Delta(u))
by mpmath's tanh-sinh, checked against sums over the volume where those converge. GM = 1.
Run: python tests/data/make_exterior_field.py
"""

import json
import math
import pathlib

import mpmath as mp
import numpy as np

mp.mp.dps = 40


def kappa_of(axes, x):
    """Return the largest root of sum x_i^2/(a_i^2+kappa) = 1, bracketed from the pole of the smallest axis."""

    def f(k):
        return mp.fsum(xi**2 / (ai**2 + k) for ai, xi in zip(axes, x, strict=False)) - 1

    high = mp.fsum(xi**2 for xi in x)
    low = -mp.mpf("1e-3") * min(axes) ** 2
    for _ in range(400):
        middle = (low + high) / 2
        low, high = (middle, high) if f(middle) > 0 else (low, middle)
    return (low + high) / 2


def exterior(axes, x):
    """Return kappa, potential and field; the substitution u + c^2 = v^2 removes the root's singularity."""
    axes, x = [mp.mpf(a) for a in axes], [mp.mpf(v) for v in x]
    kappa, c = kappa_of(axes, x), min(axes)
    start = mp.sqrt(kappa + c * c)
    shifted = [(a - c) * (a + c) for a in axes]  # a_i^2 + u = v^2 + shifted

    def integral(f):
        # v = 1/t; the remaining scales are those of the axes
        largest = mp.sqrt(max(shifted)) if max(shifted) > 0 else mp.mpf(0)
        cuts = [mp.mpf(0), *sorted({1 / start} | {1 / (start + largest * mp.mpf(10) ** (-k)) for k in range(0, 4)})]
        return mp.quad(lambda t: f(1 / t) / t**2, cuts)

    smallest = axes.index(c)
    other_shifts = [s for i, s in enumerate(shifted) if i != smallest]

    def weight(v):
        return 2 / mp.sqrt((v * v + other_shifts[0]) * (v * v + other_shifts[1]))

    potential = (
        mp.mpf(3)
        / 4
        * integral(lambda v: weight(v) * (1 - mp.fsum(xi**2 / (v * v + s) for xi, s in zip(x, shifted, strict=False))))
    )
    field = [
        -mp.mpf(3) / 2 * xi * integral(lambda v: weight(v) / (v * v + s)) for xi, s in zip(x, shifted, strict=False)
    ]
    return kappa, potential, field


def volume_potential(axes, x, n=40):
    """Return the mean of 1/|x - y| over the volume by a product rule, for distant points."""
    t, wt = np.polynomial.legendre.leggauss(n)
    radius, wr = (t + 1) / 2, wt / 2
    angle = 2 * np.pi * (np.arange(2 * n) + 0.5) / (2 * n)
    r, z, al = np.meshgrid(radius, t, angle, indexing="ij")
    w = (3 * wr * radius**2)[:, None, None] * (wt / 2)[None, :, None] / (2 * n)
    s = np.sqrt(1 - z**2)
    y = [r * s * np.cos(al) * axes[0], r * s * np.sin(al) * axes[1], r * z * axes[2]]
    return float(np.sum(w / np.sqrt(sum((xi - yi) ** 2 for xi, yi in zip(x, y, strict=False)))))


def on_surface(axes, theta, alpha):
    return [
        axes[0] * math.sin(theta) * math.cos(alpha),
        axes[1] * math.sin(theta) * math.sin(alpha),
        axes[2] * math.cos(theta),
    ]


def main():
    shapes = {
        "sphere": (1.0, 1.0, 1.0),
        "almost_sphere": (1.0, 1.0 - 1e-13, 1.0 - 2e-13),
        "almost_oblate": (1.0, 1.0 - 1e-13, 0.5),
        "almost_prolate": (1.0, 0.5, 0.5 - 5e-14),
        "prolate": (2.0, 0.7, 0.7),
        "oblate": (1.0, 1.0, 0.25),
        "kw4_alpha": (0.766, 0.7475, 0.6735),
        "needle": (1.0, 0.02, 0.02),
        "disc": (1.0, 1.0, 0.02),
        "blade": (1.0, 0.3, 0.02),
        "unsorted": (0.3, 0.5, 0.9),
    }
    cases = []
    for name, axes in shapes.items():
        points = {
            "pole": [0.0, 0.0, axes[2]],
            "tip": [axes[0], 0.0, 0.0],
            "near_pole": on_surface(axes, 1e-7, 0.4),
            "near_rim": on_surface(axes, math.pi / 2 - 1e-7, 1e-7),
            "surface": on_surface(axes, 1.1, 0.7),
            "beside_rim": [1.001 * v for v in on_surface(axes, 1.5, 0.2)],
            "above": [0.3 * axes[0], 0.2 * axes[1], axes[2] + 0.01],
            "outside": [1.1 * axes[0], 0.9 * axes[1], 0.8 * axes[2] + 0.4],
            "away": [3.7, -2.9, 2.3],
            "far": [-31.0, 17.0, 55.0],
            "very_far": [4e5, -6e5, 7e5],
        }
        for point_name, x in points.items():
            kappa, potential, field = exterior(axes, x)
            if point_name == "away":
                assert abs(volume_potential(axes, x) / float(potential) - 1) < 1e-13, (name, point_name)
            cases.append(
                {
                    "name": f"{name}/{point_name}",
                    "axes": [repr(a) for a in axes],
                    "point": [repr(v) for v in x],
                    "kappa": mp.nstr(kappa, 25),
                    "potential": mp.nstr(potential, 25),
                    "field": [mp.nstr(g, 25) for g in field],
                }
            )
    path = pathlib.Path(__file__).with_name("exterior_field.json")
    path.write_text("[\n" + ",\n".join(json.dumps(c) for c in cases) + "\n]\n")


if __name__ == "__main__":
    main()
