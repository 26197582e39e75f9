"""Sunlight in pictures: the lit part of each body, with the shadows of the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..base import rotations
from ..record.record import Record
from ..typing import Floats
from ._style import surfaces

if TYPE_CHECKING:
    from ..observing.vectors import Vectors

#: The brightness with which the night side is drawn.
NIGHT = 0.18


def directions(run: Record, geometry: Vectors, times: Floats) -> Floats:
    """Return unit vectors (T, 3) to the Sun at times of a run, in the inertial frame, from the observing geometry."""
    from ..observing.vectors import local_geometry

    local = local_geometry(geometry, run.system)
    toward = local.sun(local.arrival(times))
    return np.asarray(toward / np.linalg.norm(toward, axis=1)[:, None])


def casts(run: Record, body: int) -> list[tuple[Floats, Floats]]:
    """Return the ellipsoids of a body that cast its shadow, in its frame: matrices to unit spheres, and centres.

    A polyhedron casts the shadow of an ellipsoid whose vertices have the same second moments.
    """
    ellipsoids = []
    for surface in surfaces(run, body):
        columns = surface.columns
        if surface.triangles is not None:
            # The mean of x^2 over the surface of an ellipsoid is about a^2 / 3.
            corners = surface.triangles.reshape(-1, 3)
            spread, axes = np.linalg.eigh(corners.T @ corners / len(corners))
            columns = np.asarray(surface.columns @ axes * np.sqrt(3.0 * spread))
        ellipsoids.append((np.asarray(np.linalg.inv(columns), dtype=np.float64), surface.position))
    return ellipsoids


class Sunlight:
    """The Sun's light on bodies at one moment.

    Parameters
    ----------
    run : Run
    sun : ndarray, (3,)
        Unit vector to the Sun.
    centres : ndarray, (N, 3)
    attitude : ndarray, (N, 4)
    """

    def __init__(self, run: Record, sun: Floats, centres: Floats, attitude: Floats) -> None:
        self._sun = sun
        rotation_matrices = rotations.matrices(attitude)
        self._casts = [
            (body, k, inverse @ rotation_matrices[body].T, centres[body] + rotation_matrices[body] @ position)
            for body in range(len(run.context))
            for k, (inverse, position) in enumerate(casts(run, body))
        ]

    def shade(self, body: int, part: int, points: Floats, normals: Floats) -> Floats:
        """Return the brightness (M,) of points (M, 3) of a part's surface, which is 1 where the Sun is overhead.

        Normals (M, 3) point outward, of any length.
        """
        height = normals @ self._sun / np.linalg.norm(normals, axis=1)
        lit = height > 0.0
        for other, k, inverse, centre in self._casts:
            if (other, k) == (body, part):
                continue
            point, way = (points - centre) @ inverse.T, inverse @ self._sun
            along = point @ way
            outside = np.sum(point**2, axis=1) - 1.0
            lit &= ~((along < 0.0) & (along**2 > way @ way * outside))
        return np.asarray(NIGHT + (1.0 - NIGHT) * np.where(lit, height, 0.0))
