"""Meshes, poses and comparisons of numbers for the tests of polyhedra."""

import fullbody
import numpy as np
import trimesh
from fullbody import Polyhedron

CUBE = np.array([0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4]).reshape(6, 3)
CUBE = np.concatenate([CUBE, [[2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]])
CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=float)


def box(*sides):
    """A box about the origin."""
    return Polyhedron((CORNERS - 0.5) * sides, CUBE)


def octahedron(a, b, c):
    ends = np.repeat(np.diag([a, b, c]), 2, axis=0) * np.tile([1.0, -1.0], 3)[:, None]
    faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    return Polyhedron(ends, faces)


def torus(radius, tube, count=12, around=6):
    """A ring about the z axis, `count` corners long and `around` corners about its tube."""
    a, b = np.meshgrid(np.arange(count) * 2.0 * np.pi / count, np.arange(around) * 2.0 * np.pi / around, indexing="ij")
    rho = radius + tube * np.cos(b)
    faces = []
    for i in range(count):
        for j in range(around):
            ends = [((i + p) % count) * around + (j + q) % around for p, q in ((0, 0), (1, 0), (1, 1), (0, 1))]
            faces += [[ends[0], ends[1], ends[2]], [ends[0], ends[2], ends[3]]]
    return Polyhedron(np.stack([rho * np.cos(a), rho * np.sin(a), tube * np.sin(b)], axis=-1).reshape(-1, 3), faces)


def icosphere(level, axes=(1.0, 1.0, 1.0)):
    """20 * 4**level triangles with corners on an ellipsoid."""
    ball = trimesh.creation.icosphere(subdivisions=level)
    return Polyhedron(np.array(ball.vertices) * axes, np.array(ball.faces))


def convex_hull(points):
    """The convex polyhedron of points, with outward faces."""
    solid = trimesh.convex.convex_hull(points)
    return Polyhedron(np.array(solid.vertices), np.array(solid.faces))


def close(result, expected, tolerance, scale=None):
    size = np.abs(expected).max() if scale is None else scale
    assert np.abs(np.asarray(result) - expected).max() <= tolerance * size, (result, expected)


def pose(separation, seed=3, spin=0.0):
    rng = np.random.default_rng(seed)
    attitude = rng.normal(size=(2, 4))
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    position = np.array([np.zeros(3), separation])
    return fullbody.State(position, np.zeros((2, 3)), attitude=attitude, spin=spin * rng.normal(size=(2, 3)))


def focal_points(a, b, c, n=12, m=48):
    """Points and weights that attract like an ellipsoid (Maclaurin's theorem)."""
    t, w = np.polynomial.legendre.leggauss(2 * n + 1)
    t, w = t[t > 1e-9], w[t > 1e-9]
    alpha = 2.0 * np.pi * (np.arange(m) + 0.5) / m
    ring = np.sqrt(1.0 - t * t)[:, None] * np.array([np.cos(alpha), np.sin(alpha)])[:, None]
    points = np.stack([(a * a - c * c) ** 0.5 * ring[0], (b * b - c * c) ** 0.5 * ring[1], 0.0 * ring[0]], axis=-1)
    # Numpy's weights of many points are good to some 1e-14.
    weights = t * t * w / (t * t * w).sum()
    return points.reshape(-1, 3), np.repeat(weights / m, m)


def with_more_faces(solid):
    """Divide each face of a solid into three."""
    corners = solid.vertices[solid.faces]
    middle = len(solid.vertices) + np.arange(len(solid.faces))
    faces = [np.column_stack([solid.faces[:, k], solid.faces[:, (k + 1) % 3], middle]) for k in range(3)]
    return Polyhedron(np.concatenate([solid.vertices, corners.mean(axis=1)]), np.concatenate(faces))
