"""Outlines of bodies in the sky: predicted, with what other bodies hide and the Sun lights, and as measured points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.foreign import are_dates
from ..base.kinds import whole_number
from ..base.rotations import matrices
from ..base.units import is_quantity
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .columns import DataColumn
from .light_centres import refuse_directions
from .light_curve import epochs_of
from .limbs import PosedLimbs, limbs_of
from .sky import SkyPoints, east_and_north, in_mas, in_unit, offsets, sky_axes
from .states import into_body
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
    whole_number(n, "n", 3)
    system = run.system
    axes = sky_axes(system, frame, "an outline")
    if np.ndim(time) > 0:
        raise InvalidInput(f"time has shape {np.shape(time)}; expected one time")
    epochs = next(epochs_of(run, time, geometry, "an outline"))
    refuse_directions(epochs, "an outline")
    to_observer, to_sun = (vector[0] / np.linalg.norm(vector[0], axis=1, keepdims=True) for vector in epochs.vectors())
    angles = 2.0 * np.pi * np.arange(n) / n
    rays = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    centres, rotations = epochs.position[0], matrices(epochs.attitude[0])
    bodies = [PosedLimbs(limbs_of(system, k), centres[k], rotations[k]) for k in range(len(centres))]
    shape = len(bodies), n
    points, hidden, lit = np.zeros((*shape, 2)), np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
    line = -epochs.to_observer @ axes.T
    for body, posed in enumerate(bodies):
        limb = posed.outermost(to_observer[body], east_and_north(-to_observer[body], axes[2]), rays)
        points[body] = offsets(np.tile(line, (n, 1)), limb.points @ axes.T)
        rays_to = (vector[0] - limb.points for vector in (epochs.to_observer, epochs.to_sun))
        observer_rays, sun_rays = (vector / np.linalg.norm(vector, axis=1, keepdims=True) for vector in rays_to)
        lit[body] = limb.normals @ to_sun[body] > 0.0
        for other in bodies[:body] + bodies[body + 1 :]:
            hidden[body] |= other.hides(limb.points, observer_rays)
            lit[body] &= ~other.hides(limb.points, sun_rays)
    return SkyOutlines(in_mas(points, system), hidden, lit)


class Outline(SkyPoints):
    """Measured points of a body's limb, which are compared with its outline along the normal of the outline.

    Parameters
    ----------
    time : astropy Time, float or Quantity, () or (K,)
        When the light arrived: one time for all points, or one for each.
    east, north : array_like or Quantity, (K,)
        Offsets of the points from the direction of the geometry's barycentre; plain numbers are radians. Rows with
        masked or NaN values are left out, with a warning.
    sigma : float, array_like or Quantity, () or (K,)
        Standard errors of the points along the normal.
    body : int or str
        The body: its index in the system, or its name.
    geometry : Geometry
    frame : str or astropy frame
        The axes of the sky, as for :class:`Astrometry`.

    Raises
    ------
    InvalidInput
        For errors that are not above zero, and when a run is compared for a body without a surface.

    Warns
    -----
    InconsistentInput
        For rows that are left out.

    Notes
    -----
    Predictions are the distances from the points to the outline along its outward normal, positive where the outline is
    farther out, and the observed values are zero. The normal is that at the nearest point of the outline of a part of
    the body. Give the points of the lit limb; a terminator is not an outline. An unknown pointing of the telescope is a
    parameter of a fit with a function in place of data, such as
    ``lambda dx, dy: Outline(time, east - dx, north - dy, ...)``.

    Examples
    --------
    >>> import astropy.units as u, fullbody, numpy as np
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> run = system.integrate(state, "1 day", dense=True)
    >>> view = {"to_observer": [0.1, 0.01, 0.0] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au, "frame": "ecliptic"}
    >>> geometry = observing.Geometry([0.0, 2.0] * u.day, **view)
    >>> east, north = observing.outline(run, 5 * u.h, geometry, n=12).points[0].T
    >>> data = observing.Outline(5 * u.h, east, north, 0.1 * u.mas, body="Didymos", geometry=geometry)
    >>> bool(abs(data.residuals(run)).max() < 1e-5 * u.mas)
    True
    """

    _columns = (DataColumn("east"), DataColumn("north"), DataColumn("sigma"))
    _options = ("body", "frame")
    _names = ("distance from the outline",)
    _depends_on_figures = True

    def __init__(
        self,
        time: Any,
        east: Any,
        north: Any,
        sigma: Any,
        *,
        body: int | str = 0,
        geometry: Vectors,
        frame: Any = "equatorial",
    ) -> None:
        points = {"east": east, "north": north, "sigma": sigma}
        self._read_points(_repeated(time, east), points, {}, geometry, frame)
        self.body = body

    @classmethod
    def _arguments(cls, read: dict[str, Any]) -> dict[str, Any]:
        return {"time": read.pop("times"), **read}

    def _observed(self, system: SystemLike) -> Floats:
        return np.zeros((len(self), 1))

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        return in_unit(values[:, 0], self.unit)

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        axes = sky_axes(system, self.frame, "an outline")
        body = system.context.index(self.body, "body of Outline")
        if not (limbs := limbs_of(system, body)):
            raise InvalidInput(f"{system.context.names[body]} is a point; expected a body with an outline")
        retarded = self._retarded(system, states, masses)
        centre = retarded.centre[..., body, :]
        attitude = retarded.attitude(states["attitude"], states["spin"])[..., body, :]
        to_observer = retarded.observer - centre
        distance = np.sqrt(np.sum(to_observer * to_observer, axis=-1, keepdims=True))
        direction = to_observer / distance
        # The sky about the body has its centre as the origin, and lengths instead of angles.
        point = distance * (self._values - offsets(-retarded.observer @ axes.T, centre @ axes.T))
        offset = np.einsum("...a,...ax->...x", point, east_and_north(-direction.real, axes[2]))
        ray = into_body(attitude, offset), into_body(attitude, direction)
        distances = np.stack([limb.distance(*ray) for limb in limbs])
        nearest = np.argmin(distances.real, axis=0)
        return -np.take_along_axis(distances, nearest[None], axis=0)[0][..., None] / distance


def _repeated(time: Any, values: Any) -> Any:
    """Return one time for each of the values, if there is one for all of them."""
    if np.ndim(time) > 0 or np.ndim(values) != 1 or isinstance(time, str):
        return time
    if are_dates(time):
        from astropy.time import TimeDelta

        return time + TimeDelta(np.zeros(len(values)), format="sec")
    return np.full(len(values), time.value) * time.unit if is_quantity(time) else np.full(len(values), time)
