"""Outlines of bodies in the sky, and measured points of a limb."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.foreign import are_dates
from ..base.kinds import whole
from ..base.rotations import matrices
from ..base.units import is_quantity
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .astrometry import in_unit, offsets, sky_axes, warn_if_wide
from .centre_of_light import complex_matrices
from .columns import DataColumn, Rows, column, jitter_of, positive_rows, refuse_rounded
from .data import Observations
from .light_centres import in_mas, refuse_directions
from .light_curve import epochs_of
from .silhouettes import Solid, hides, limb, silhouette_edges, solids
from .vectors import Vectors

#: The number of normals among which the one at the nearest point of an ellipse is sought, and of steps of Newton's
#: method from there.
_NORMALS, _STEPS = 64, 12


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
    """Return unit vectors (2, 3) to the east and to the north of a body, in a system's axes.

    ``toward`` (3,) is the unit vector to the observer, and ``axes`` (3, 3) the matrix to the axes of the sky.
    """
    x, y, z = axes @ -toward
    level = np.hypot(x, y)
    return np.array([[-y, x, 0.0], [-x * z, -y * z, level * level]]) / level @ axes


class Outline(Observations):
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
    farther out, and the observed values are zero. The normal is that at the nearest point of an ellipse, and for a
    polyhedron that of the edge in the direction from its centre to the point. Give the points of the lit limb; a
    terminator is not an outline. An unknown pointing of the telescope is a parameter of a fit with a function in place
    of data, such as ``lambda dx, dy: Outline(time, east - dx, north - dy, ...)``.

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
    _names = ("distance from the outline",)

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
        values = {"east": east, "north": north, "sigma": sigma}
        read = {name: column(value, f"{name} of Outline", "rad") for name, value in values.items()}
        self.unit = read["east"][1]
        for name, (_, unit) in read.items():
            if (unit is None) != (self.unit is None):
                raise InvalidInput(f"only one of east and {name} of Outline has a unit; expected both or neither")
        numbers = {name: given for name, (given, _) in read.items()}
        for name in ("east", "north"):
            refuse_rounded(values[name], numbers[name], numbers["sigma"], f"{name} of Outline")
        rows = Rows(_repeated(time, numbers["east"]), numbers, ("east", "north"), "Outline")
        super().__init__(rows, geometry)
        self.body, self.frame = body, frame
        self._points = np.stack([rows.of("east"), rows.of("north")], axis=1)
        if self.unit is None:
            warn_if_wide(self._points, "the points of Outline")
        self._sigma = positive_rows(rows.of("sigma"), "sigma of Outline")

    @property
    def east(self) -> Any:
        """Offsets (K,) of the points to the east."""
        return in_unit(self._points[:, 0], self.unit)

    @property
    def north(self) -> Any:
        """Offsets (K,) of the points to the north."""
        return in_unit(self._points[:, 1], self.unit)

    @property
    def sigma(self) -> Any:
        """Standard errors (K,) along the normal."""
        return in_unit(self._sigma, self.unit)

    def _in_table(self) -> tuple[dict[str, Any], dict[str, Any]]:
        columns = {"east": self.east, "north": self.north, "sigma": self.sigma}
        return columns, {"body": self.body, "frame": str(self.frame)}

    @classmethod
    def _arguments(cls, read: dict[str, Any]) -> dict[str, Any]:
        return {"time": read.pop("times"), **read}

    def _observed(self, system: SystemLike) -> Floats:
        return np.zeros((len(self), 1))

    def _covariance(self, system: SystemLike) -> Floats:
        return np.asarray(self._sigma[:, None, None] ** 2)

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        return in_unit(values[:, 0], self.unit)

    def _widen(self, jitter: Any) -> None:
        self._sigma = np.hypot(self._sigma, jitter_of(jitter, "rad"))

    def _depends_on_figures(self) -> bool:
        return True

    def _model(self, system: SystemLike, states: dict[str, Floats], masses: Any = None) -> Floats:
        axes = sky_axes(system, self.frame, "an outline")
        body = system.context.index(self.body, "body of Outline")
        retarded = self._retarded(system, states, masses)
        centre = retarded.centre[..., body, :]
        attitude = retarded.attitude(states["attitude"], states["spin"])[..., body, :]
        away = retarded.observer - centre
        distance = np.sqrt(np.sum(away * away, axis=-1))
        shape = np.broadcast_shapes(centre.shape[:-1], attitude.shape[:-1])
        place = np.broadcast_to(offsets(-retarded.observer @ axes.T, centre @ axes.T), (*shape, 2))
        matrix = np.broadcast_to(complex_matrices(attitude), (*shape, 3, 3))
        distance = np.broadcast_to(distance, shape)
        result = np.zeros(shape, dtype=np.result_type(place, matrix, distance))
        for index in np.ndindex(shape):
            k = index[-1]
            toward = np.real(np.broadcast_to(away, (*shape, 3))[index] / distance[index])
            # The sky about the body has its centre as the origin, and angles instead of lengths.
            projection = sky_of(toward, axes)
            parts = solids(system, body, np.zeros(3), matrix[index])
            if not parts:
                raise InvalidInput(f"{system.context.names[body]} is a point; expected a body with an outline")
            point = self._points[k] - place[index]
            found = [_distance(part, toward, projection, distance[index], point) for part in parts]
            result[index] = -min(found, key=np.real)
        return result[..., None]

    def _described(self) -> list[tuple[str, str]]:
        return [("body", str(self.body)), ("frame", str(self.frame))]


def _repeated(time: Any, values: Floats) -> Any:
    """Return one time for each of the values, if there is one for all of them."""
    if np.ndim(time) > 0 or np.ndim(values) != 1 or isinstance(time, str):
        return time
    if are_dates(time):
        from astropy.time import TimeDelta

        return time + TimeDelta(np.zeros(len(values)), format="sec")
    return np.full(len(values), time.value) * time.unit if is_quantity(time) else np.full(len(values), time)


def _distance(part: Solid, sight: Floats, projection: Floats, distance: Any, point: Any) -> Any:
    """Return the distance of a point (2,) from the outline of a part along its outward normal, positive outside.

    The point is relative to the body's centre, in radians, and the part at a ``distance`` from the observer. The
    function is analytic: it takes complex numbers.
    """
    if part.corners is None:
        ellipse = projection @ part.columns @ part.columns.T @ projection.T / distance**2
        from_middle = point - projection @ part.centre / distance
        normal = _normal_at_nearest(ellipse.real, from_middle.real)
        # The distance is the largest height above a tangent, so that a change of the normal has no effect.
        return normal @ from_middle - np.sqrt(normal @ ellipse @ normal)
    ends = part.corners[silhouette_edges(part, sight)] @ projection.T / distance
    p, q = ends[:, 0], ends[:, 1]
    ray, along = point.real, (q - p).real
    across = ray[0] * along[:, 1] - ray[1] * along[:, 0]
    share = np.divide(
        ray[1] * p[:, 0].real - ray[0] * p[:, 1].real, across, out=np.full(len(p), -1.0), where=across != 0.0
    )
    reach = np.where((share >= 0.0) & (share <= 1.0), p.real @ ray + share * (along @ ray), -np.inf)
    edge = int(np.argmax(reach))
    side, from_end = q[edge] - p[edge], point - p[edge]
    # Edges run clockwise in a sky with the east along the first axis.
    return (side[0] * from_end[1] - side[1] * from_end[0]) / np.sqrt(side @ side)


def _normal_at_nearest(ellipse: Floats, point: Floats) -> Floats:
    """Return the unit normal (2,) of an ellipse x^T A^-1 x = 1 at the point that is nearest to another one."""

    def terms(angle: Any) -> tuple[Any, Any, Any]:
        n = np.stack([np.cos(angle), np.sin(angle)])
        t = np.stack([-np.sin(angle), np.cos(angle)])
        size = np.sqrt(np.sum(n * (ellipse @ n), axis=0))
        slope = np.sum(t * (ellipse @ n), axis=0) / size
        curvature = np.sum(t * (ellipse @ t), axis=0) / size - slope**2 / size
        return point @ n - size, point @ t - slope, -(point @ n) - curvature + size

    angles = 2.0 * np.pi * np.arange(_NORMALS) / _NORMALS
    angle = angles[np.argmax(terms(angles)[0])]
    for _ in range(_STEPS):
        _, first, second = terms(angle)
        if second >= 0.0:
            break
        angle -= float(np.clip(first / second, -0.1, 0.1))
    return np.array([np.cos(angle), np.sin(angle)])
