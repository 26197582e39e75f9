"""The light of a sphere that is partly behind a disc, by sums over strips."""

from itertools import pairwise

import numpy as np
from scipy.optimize import brentq


def strips(radius, gap, s, law):
    """A unit sphere at the origin, seen from z, behind a disc whose edge is at x = gap and which reaches over larger x.

    In rows of constant distance from the centre line of the disc: Gauss's rule in y between the places where the
    disc's edge, the limb and the terminator cross, and in x from the terminator or the limb to the disc.
    """
    nodes, weights = np.polynomial.legendre.leggauss(160)

    def edge(y):
        # x = gap + R - sqrt(R^2 - y^2), without cancellation.
        return gap + y * y / (radius + np.sqrt(radius * radius - y * y))

    def ends(y, round_by=0.0):
        """The lit interval of the angle on the row at y, or the one a turn away; and where the disc's edge cuts it."""
        rho = np.sqrt(1.0 - y * y)
        size, middle = np.hypot(s[2], s[0]), np.arctan2(s[0], s[2]) + round_by
        half = np.arccos(np.clip(-s[1] * y / np.maximum(rho * size, 1e-300), -1.0, 1.0))
        low = np.maximum(middle - half, -np.pi / 2)
        high = np.minimum(middle + half, np.pi / 2)
        cut = np.arcsin(np.clip(edge(y) / np.maximum(rho, 1e-300), -1.0, 1.0))
        return low, high, cut, rho

    grid = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 4001))[1:-1] * min(1.0, radius)
    # Beyond rows at this distance all is dark, or all is lit.
    last = np.hypot(s[0], s[2])
    breaks = [-min(1.0, radius), -last, last, min(1.0, radius)]
    marks = [
        lambda y: edge(y) - np.sqrt(1.0 - y * y),
        lambda y: edge(y) + np.sqrt(1.0 - y * y),
        lambda y: (lambda a: np.minimum(a[2], np.pi / 2) - a[0])(ends(y)),
        lambda y: (lambda a: a[2] - a[1])(ends(y)),
        lambda y: (lambda a: a[0] + np.pi / 2)(ends(y)) - 1e-15,
        lambda y: (lambda a: a[1] - np.pi / 2)(ends(y)) + 1e-15,
    ]
    for mark in marks:
        values = mark(grid)
        for k in np.nonzero(values[1:] * values[:-1] < 0)[0]:
            breaks.append(brentq(mark, grid[k], grid[k + 1], xtol=1e-16, rtol=1e-15))
    breaks = np.unique(breaks)
    total = 0.0
    shares = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 9))
    for a, b in pairwise(breaks):
        for p, q in pairwise(a + (b - a) * shares):
            t, w = 0.5 * nodes * (3.0 - nodes**2), weights * 1.5 * (1.0 - nodes**2)
            y, weight = 0.5 * (p + q) + 0.5 * (q - p) * t, 0.5 * (q - p) * w
            for round_by in (0.0, -2.0 * np.pi, 2.0 * np.pi):
                low, high, cut, rho = ends(y, round_by)
                high = np.minimum(high, cut)
                width = np.maximum(0.5 * (high - low), 0.0)
                if not width.any():
                    continue
                angle = 0.5 * (low + high)[:, None] + width[:, None] * nodes
                mu = rho[:, None] * np.cos(angle)
                mu0 = s[1] * y[:, None] + rho[:, None] * (s[0] * np.sin(angle) + s[2] * np.cos(angle))
                mu0 = np.maximum(mu0, 0.0)
                value = mu * mu0 / np.maximum(mu + mu0, 1e-300) if law == "seeliger" else mu * mu0
                total += np.sum((value @ weights) * width * weight)
    return total
