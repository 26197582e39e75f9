"""Geodesic meshes of the unit sphere, and real spherical harmonics at their points."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..typing import Floats


class GeodesicMesh(NamedTuple):
    """An icosahedron whose faces are divided into equal triangles, projected on the unit sphere.

    Attributes
    ----------
    points : ndarray, (V, 3)
    faces : ndarray of int, (F, 3)
        Indices of the points of each triangle, counterclockwise as seen from outside.
    solid_angles : ndarray, (V,)
        A third of the solid angles of the triangles at each point; their sum is 4 pi.
    """

    points: Floats
    faces: npt.NDArray[np.int64]
    solid_angles: Floats


@lru_cache(maxsize=8)
def geodesic_mesh(parts: int) -> GeodesicMesh:
    """Return the mesh of 20 n^2 triangles and 10 n^2 + 2 points for n equal parts of each edge of the icosahedron."""
    golden = 0.5 * (1.0 + 5.0**0.5)
    corners = np.array([np.roll([0.0, a, b * golden], k) for k in range(3) for a in (1, -1) for b in (1, -1)])
    corners /= np.linalg.norm(corners[0])
    near = np.linalg.norm(corners[:, None] - corners, axis=-1) < 1.2
    triples = [
        t for t in itertools.combinations(range(12), 3) if all(near[i, j] for i, j in itertools.combinations(t, 2))
    ]
    points: list[Floats] = []
    faces: list[list[int]] = []
    indices: dict[Any, int] = {}

    def index_of(point: Floats) -> int:
        key = tuple((np.round(point, 9) + 0.0).tolist())
        if key not in indices:
            indices[key] = len(points)
            points.append(point)
        return indices[key]

    for triple in triples:
        a, b, c = corners[list(triple if np.linalg.det(corners[list(triple)]) > 0.0 else triple[::-1])]
        grid = {}
        for i, j in _within(parts):
            point = a * (parts - i - j) + b * i + c * j
            grid[i, j] = index_of(point / np.linalg.norm(point))
        for i, j in _within(parts - 1):
            faces.append([grid[i, j], grid[i + 1, j], grid[i, j + 1]])
            if i + j < parts - 1:
                faces.append([grid[i + 1, j], grid[i + 1, j + 1], grid[i, j + 1]])
    return GeodesicMesh(np.array(points), (triangles := np.array(faces)), _shares(np.array(points), triangles))


def _within(parts: int) -> Iterator[tuple[int, int]]:
    """Return the pairs of whole numbers from zero on whose sum is at most this one."""
    return ((i, j) for i in range(parts + 1) for j in range(parts + 1 - i))


def _shares(points: Floats, faces: npt.NDArray[np.int64]) -> Floats:
    """Return a third of the solid angles at each point (Van Oosterom & Strackee 1983, IEEE Trans. Biomed. Eng. 30)."""
    a, b, c = np.moveaxis(points[faces], 1, 0)
    cosines = sum(np.sum(u * v, axis=1) for u, v in ((a, b), (b, c), (c, a)))
    angles = 2.0 * np.arctan2(np.linalg.det(points[faces]), 1.0 + cosines)
    return np.asarray(np.bincount(faces.ravel(), np.repeat(angles / 3.0, 3), len(points)), dtype=np.float64)


@lru_cache(maxsize=8)
def mesh_harmonics(parts: int, degree: int) -> Floats:
    """Return the harmonics (V, (L + 1)^2) up to a degree L at the points of a mesh; see :func:`harmonics`."""
    return harmonics(geodesic_mesh(parts).points, degree)


def harmonics(directions: Floats, degree: int) -> Floats:
    """Return real spherical harmonics (F, (L + 1)^2) up to a degree L at unit vectors (F, 3).

    They have a mean square of one over the sphere, as in geodesy ("4pi"), and no sign (-1)^m. Their order is by degree
    and, within a degree, from the sines of m = l to those of m = 1, and from the cosines of m = 0 to those of m = l.
    """
    return _core.solid_harmonics(directions, degree) * np.sqrt(2.0 * degrees(degree) + 1.0)


def degrees(degree: int) -> Floats:
    """Return the degree ((L + 1)^2,) of each harmonic up to a degree L."""
    return np.floor(np.sqrt(np.arange((degree + 1) ** 2) + 0.5))


def parts_of(faces: int, per_square: int, more: int = 0) -> int:
    """Return the least n for which ``per_square`` n^2 + ``more``, the number of faces or points, reaches ``faces``."""
    return max(1, int(np.ceil(np.sqrt(max(faces - more, 1) / per_square) - 1e-9)))
