"""Poles from which fits of rotating bodies start: grids on the sphere, and the mirror pole of light curves."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.differences import REFUSALS
from ..base.kinds import whole_number
from ..base.rotations import matrices
from ..base.units import need
from ..base.values import same
from ..frames import rotation
from ..observing import Photometry
from ..typing import Floats
from .point import EvaluatedPoint
from .problem import Problem
from .setup_result import SetupResult

#: The largest distance between two unit vectors of one direction, and the distance below which two fits have one pole.
_SAME, _NEAR = 1e-6, 0.3


class Poles(NamedTuple):
    """Directions on the sphere.

    Attributes
    ----------
    longitude, latitude : Quantity, (n,)
    """

    longitude: Any
    latitude: Any

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Poles) and same(tuple(self), tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other


def pole_grid(n: int) -> Poles:
    """Return n directions that are evenly spread over the sphere: a Fibonacci lattice (Gonzalez 2010, Math. Geosci. 42,
    49).

    Parameters
    ----------
    n : int

    Returns
    -------
    Poles

    Examples
    --------
    A fit that starts from each of them:

    >>> import fullbody
    >>> poles = fullbody.fitting.pole_grid(12)
    >>> starts = [{"period": 8.4, "longitude": lon, "latitude": lat} for lon, lat in zip(*poles)]
    >>> len(starts), poles.latitude[0].round(1)
    (12, <Quantity 66.4 deg>)
    """
    with need("units", "a grid of poles"):
        import astropy.units as u

    longitude, latitude = lattice(whole_number(n, "n"))
    return Poles(np.degrees(longitude) * u.deg, np.degrees(latitude) * u.deg)


def lattice(count: int) -> tuple[Floats, Floats]:
    """Return longitudes and latitudes (n,) in radians of a Fibonacci lattice."""
    k = np.arange(count) + 0.5
    return np.mod(np.pi * (1.0 + np.sqrt(5.0)) * k, 2.0 * np.pi), np.arcsin(1.0 - 2.0 * k / count)


def mirror_start(problem: Problem, points: list[EvaluatedPoint]) -> Floats | None:
    """Return values (P,) with the mirror of the pole of the first of some points, at the longitude plus 180 degrees.

    The light curves of a body near the plane of the ecliptic hardly tell the two apart (Kaasalainen & Lamberg 2006,
    Inverse Problems 22, 749). The parameter of the longitude is that whose change by 180 degrees has this effect.
    ``None`` is returned without points or such a parameter, and if one of the points is near that pole already.
    """
    if not points or not any(isinstance(item, Photometry) for item in points[0].observations):
        return None
    setup_result, values, parameters = points[0].setup_result, points[0].values, problem.parameters
    if len(setup_result.system) != 1:
        return None
    mirrored = _direction(setup_result) * [-1.0, -1.0, 1.0]
    for k, value in enumerate(values):
        half = np.copysign(0.5 * parameters.period(k), value - 0.5 * parameters.period(k))
        for moved in (value - half, value + half):
            if np.isfinite(half) and parameters.lower[k] <= moved <= parameters.upper[k]:
                start = values.copy()
                start[k] = moved
                try:
                    pole = _direction(problem.make(start))
                except REFUSALS:
                    continue
                if _distance(pole, mirrored) < _SAME < _distance(pole, _direction(setup_result)):
                    return (
                        None
                        if any(_distance(pole, _direction(point.setup_result)) < _NEAR for point in points)
                        else start
                    )
    return None


def _distance(pole: Floats, other: Floats) -> float:
    return float(np.linalg.norm(pole - other))


def _direction(setup_result: SetupResult) -> Floats:
    """Return the unit vector (3,) of the spin of a body alone, in the ecliptic if the system has a frame."""
    spin = matrices(setup_result.core.attitude[0]) @ setup_result.core.spin[0]
    frame = setup_result.system.context.frame
    spin = spin if frame is None else rotation(frame, "ecliptic") @ spin
    return spin / max(float(np.linalg.norm(spin)), np.finfo(float).tiny)


def tilted(axes: Floats, tilt: Floats) -> Floats:
    """Return axes (..., 3, 3) after the smallest rotation that tilts the last one.

    The tilt (..., 2) has the components of the tilted unit vector along the other two axes.
    """
    p = np.asarray(tilt)[..., None]
    pz = np.sqrt(1.0 - np.sum(p**2, axis=-2))
    first, second, pole = axes
    new = p[..., 0, :] * first + p[..., 1, :] * second + pz * pole
    across = (new + pole) / (1.0 + pz)
    return np.stack([first - p[..., 0, :] * across, second - p[..., 1, :] * across, new], axis=-2)
