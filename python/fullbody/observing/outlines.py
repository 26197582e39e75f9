"""Outlines of bodies in the sky, with the parts that other bodies hide and that the Sun lights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.kinds import whole
from ..base.rotations import matrices
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..record.record import Record
from ..typing import Floats
from .astrometry import offsets, sky_axes
from .light_centres import in_mas, refuse_directions
from .light_curve import epochs_of
from .silhouettes import hides, limb, solids
from .vectors import Vectors


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SkyOutlines(ArrayFields):
    """The outlines of N bodies in the sky, each by n points at equal position angles about its centre.

    Attributes
    ----------
    points : ndarray or Quantity, (N, n, 2)
        The outermost points of the limbs to the east and to the north of the barycentre: in mas if the system has
        units, otherwise in radians. The position angle, from north through east, is 2 pi k / n for the point k. A body
        without a size has its centre, as have rays that miss a composite.
    hidden : ndarray of bool, (N, n)
        Whether another body hides the point from the observer.
    lit : ndarray of bool, (N, n)
        Whether the point is in sunlight: the surface there is turned to the Sun, and no other body is between.
    """

    points: Any
    hidden: Any
    lit: Any


def outline(run: Record, time: Any, geometry: Vectors, n: int = 360, *, frame: Any = "equatorial") -> SkyOutlines:
    """Compute the outlines of the bodies in the sky, with the parts that other bodies hide.

    Parameters
    ----------
    run : Run
        A run with ``dense=True``.
    time : astropy Time, float or Quantity
        The time at which the light arrives at the observer.
    geometry : Geometry
        A geometry that includes the Sun.
    n : int
        The number of points of each outline, from 3 on.
    frame : str or astropy frame
        The axes of the sky: ``"equatorial"`` (east and north), ``"ecliptic"`` (along longitude and latitude).

    Returns
    -------
    SkyOutlines

    Raises
    ------
    InvalidInput
        For a body of Stokes coefficients, and for the reasons of :func:`combined_light`.

    Notes
    -----
    The outline of an ellipsoid with the matrix Q = R diag(a^2) R^T is the ellipse with the matrix P Q P^T, where P
    projects on the sky. That of a polyhedron consists of the edges between faces that are turned to the observer and
    faces that are turned away. Each body is where it was when its light left it.

    Examples
    --------
    >>> import astropy.units as u, fullbody
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> run = system.integrate(state, "1 day", dense=True)
    >>> view = {"to_observer": [0.1, 0.01, 0.0] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au, "frame": "ecliptic"}
    >>> geometry = observing.Geometry([0.0, 2.0] * u.day, **view)
    >>> outlines = observing.outline(run, 5 * u.h, geometry)
    >>> outlines.points.shape, outlines.hidden.any(axis=1), outlines.lit.mean(axis=1).round(1)
    ((2, 360, 2), array([False, False]), array([0.5, 0.5]))
    """
    whole(n, "n", 3)
    system = run.system
    axes = sky_axes(system, frame, "an outline")
    if np.ndim(time) > 0:
        raise InvalidInput(f"time has shape {np.shape(time)}; expected one time")
    epochs = next(epochs_of(run, time, geometry, "an outline"))
    refuse_directions(epochs, "an outline")
    toward, sunward = (vector[0] / np.linalg.norm(vector[0], axis=1, keepdims=True) for vector in epochs.ways())
    angles = 2.0 * np.pi * np.arange(n) / n
    directions = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    count = len(system.context)
    centres = epochs.position[0]
    bodies = [
        solids(system, k, centre, matrix)
        for k, (centre, matrix) in enumerate(zip(centres, matrices(epochs.attitude[0]), strict=True))
    ]
    points, hidden, lit = np.zeros((count, n, 2)), np.zeros((count, n), dtype=bool), np.zeros((count, n), dtype=bool)
    line = -epochs.to_observer @ axes.T
    for body, parts in enumerate(bodies):
        found = limb(parts, centres[body], toward[body], sky_of(toward[body], axes), directions)
        points[body] = offsets(np.tile(line, (n, 1)), found.points @ axes.T)
        sights, suns = (vector[0] - found.points for vector in (epochs.to_observer, epochs.to_sun))
        sights, suns = (way / np.linalg.norm(way, axis=1, keepdims=True) for way in (sights, suns))
        lit[body] = found.normals @ sunward[body] > 0.0
        for other, solid in enumerate(bodies):
            if other != body:
                hidden[body] |= hides(solid, centres[other], found.points, sights)
                lit[body] &= ~hides(solid, centres[other], found.points, suns)
    return SkyOutlines(in_mas(points, system), hidden, lit)


def sky_of(toward: Floats, axes: Floats) -> Floats:
    """Return unit vectors (..., 2, 3) to the east and to the north of bodies, in a system's axes.

    ``toward`` (..., 3) are the unit vectors to the observer, and ``axes`` (3, 3) is the matrix to the axes of the sky.
    """
    x, y, z = np.moveaxis(-toward @ axes.T, -1, 0)
    level = np.hypot(x, y)
    east, north = [-y, x, 0.0 * z], [-x * z, -y * z, level * level]
    rows = np.stack([np.stack(row, axis=-1) for row in (east, north)], axis=-2)
    return np.asarray(rows / level[..., None, None] @ axes)
