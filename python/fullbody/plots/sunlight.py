"""Sunlight on the bodies of a picture, with their shadows on each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..base import rotations
from ..record.record import Record
from ..typing import Floats
from . import _style

if TYPE_CHECKING:
    from ..observing.vectors import Vectors

#: The brightness with which the night side is drawn.
NIGHT = 0.18


def directions(run: Record, geometry: Vectors, times: Floats, to: Literal["sun", "observer"] = "sun") -> Floats:
    """Return unit vectors (T, 3) to the Sun or the observer, in the inertial frame, at times (T,) of a run."""
    from ..observing.vectors import local_geometry

    local = local_geometry(geometry, run.system)
    toward = getattr(local, to)(local.arrival(times))
    return np.asarray(toward / np.linalg.norm(toward, axis=1)[:, None])


def shadow_ellipsoids(run: Record, body: int) -> list[tuple[Floats, Floats]]:
    """Return the ellipsoids that cast a body's shadow: maps (3, 3) to unit spheres, and centres (3,), body frame."""
    ellipsoids = []
    for surface in _style.surfaces(run, body):
        columns = surface.columns
        if surface.triangles is not None:
            # The mean of x^2 over the surface of an ellipsoid is about a^2 / 3.
            corners = surface.triangles.reshape(-1, 3)
            spread, axes = np.linalg.eigh(corners.T @ corners / len(corners))
            columns = np.asarray(surface.columns @ axes * np.sqrt(3.0 * spread))
        ellipsoids.append((np.asarray(np.linalg.inv(columns), dtype=np.float64), surface.position))
    return ellipsoids


class Sunlight:
    """Sunlight on bodies at one time, from the unit vector (3,) to the Sun, centres (N, 3) and attitudes (N, 4)."""

    def __init__(self, run: Record, sun: Floats, centres: Floats, attitude: Floats) -> None:
        self._sun = sun
        self._ellipsoids = [
            (body, k, inverse @ R.T, centres[body] + R @ position)
            for body, R in enumerate(rotations.matrices(attitude))
            for k, (inverse, position) in enumerate(shadow_ellipsoids(run, body))
        ]

    def _clearance(self, body: int, part: int, points: Floats) -> Floats:
        """Return numbers (...) that are above zero for points (..., 3) of a part that no other part hides from the Sun.

        They are continuous: outside an ellipsoid that is scaled to a unit sphere, the square of the distance of the ray
        to the Sun from its centre, less one.
        """
        clearance = np.full(points.shape[:-1], np.inf)
        for other, k, inverse, centre in self._ellipsoids:
            if (other, k) != (body, part):
                point, direction = (points - centre) @ inverse.T, inverse @ self._sun
                behind = np.minimum(point @ direction, 0.0)
                squared_distance = np.sum(point**2, axis=-1) - behind**2 / (direction @ direction)
                clearance = np.minimum(clearance, squared_distance - 1.0)
        return clearance

    def _brightness(self, normals: Floats, clear: Any) -> Floats:
        """Return the brightness (M,) of points with normals (M, 3): 1 where the Sun is overhead and not hidden."""
        sine_of_height = normals @ self._sun / np.linalg.norm(normals, axis=-1)
        return np.asarray(NIGHT + (1.0 - NIGHT) * np.where(clear, np.maximum(sine_of_height, 0.0), 0.0))

    def pieces(self, body: int, part: int, corners: Floats, normals: Floats) -> tuple[list[Floats], Floats]:
        """Divide cells of a part along the edges of shadows, and return the polygons (M', k, 3) and their brightness.

        The cells have corners (M, k, 3), and normals (M, k, 3), or (M, 1, 3) if they are flat.
        """
        clearance, mean = self._clearance(body, part, corners), normals.mean(axis=1)
        shades = self._brightness(mean, clearance.min(axis=1) >= 0.0)
        pieces = list(corners)
        low, high = clearance.min(axis=1), clearance.max(axis=1)
        divided = np.flatnonzero((low < 0.0) & (high > 0.0) & (mean @ self._sun > 0.0))
        lit = []
        for cell in divided.tolist():
            pieces.append(_where_positive(corners[cell], clearance[cell]))
            pieces[cell] = _where_positive(corners[cell], -clearance[cell])
            lit.append(mean[cell])
        bright = self._brightness(np.reshape(lit, (-1, 3)), True)
        return pieces, np.concatenate([shades, bright])


def _where_positive(corners: Floats, values: Floats) -> Floats:
    """Return the part of a polygon (k, 3) in which values (k,) at its corners, linear between them, are positive."""
    points = []
    following = zip(np.roll(corners, -1, axis=0), np.roll(values, -1), strict=True)
    for corner, value, (next_corner, next_value) in zip(corners, values, following, strict=True):
        if value >= 0.0:
            points.append(corner)
        if (value < 0.0) != (next_value < 0.0):
            points.append(corner + (next_corner - corner) * (value / (value - next_value)))
    return np.array(points)
