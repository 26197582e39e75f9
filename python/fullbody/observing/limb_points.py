"""Measured points of a body's limb, and their distances from its outline."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.foreign import are_dates
from ..base.units import is_quantity
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .astrometry import in_unit, offsets, sky_axes, warn_if_wide
from .centre_of_light import complex_matrices
from .columns import DataColumn, Rows, column, jitter_of, positive_rows, refuse_rounded
from .data import Observations
from .outlines import sky_of
from .silhouettes import Solid, silhouette_edges, solids
from .vectors import Vectors

#: The number of normals among which the one at the nearest point of an ellipse is sought, and of steps of Newton's
#: method from there.
_NORMALS, _STEPS = 64, 12


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
        # The sky about the body has its centre as the origin, and angles instead of lengths.
        point = self._points - offsets(-retarded.observer @ axes.T, centre @ axes.T)
        projection = sky_of(np.real(away / distance[..., None]), axes) / distance[..., None, None]
        parts = solids(system, body, np.zeros(3), complex_matrices(attitude))
        if not parts:
            raise InvalidInput(f"{system.context.names[body]} is a point; expected a body with an outline")
        found = np.stack([_distances(part, np.real(away), projection, point) for part in parts])
        nearest = np.argmin(found.real, axis=0)
        return -np.take_along_axis(found, nearest[None], axis=0)[0][..., None]

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


def _distances(part: Solid, away: Floats, projection: Any, point: Any) -> Any:
    """Return the distances (...) of points from the outline of a part along its outward normal, positive outside.

    The function is analytic: it takes complex numbers.

    Parameters
    ----------
    part : Solid
        The part in its poses (...) relative to the centre of its body.
    away : ndarray, (..., 3)
        Vectors from the body to the observer.
    projection : ndarray, (..., 2, 3)
        Matrices from lengths to angles in the sky.
    point : ndarray, (..., 2)
        Points in the sky from the body's centre.
    """
    if part.corners is None:
        columns = projection @ part.columns
        ellipse = columns @ np.swapaxes(columns, -1, -2)
        from_middle = point - (projection @ part.centre[..., None])[..., 0]
        normal = _normals_at_nearest(ellipse.real, from_middle.real)
        height = np.sum(normal * from_middle, axis=-1)
        # The distance is the largest height above a tangent, so that a change of the normal has no effect.
        return height - np.sqrt(np.einsum("...i,...ij,...j->...", normal, ellipse, normal))
    shape = np.broadcast_shapes(point.shape[:-1], projection.shape[:-2], part.corners.shape[:-2])
    point, projection, away = (
        np.broadcast_to(given, (*shape, *given.shape[-rank:]))
        for given, rank in ((point, 1), (projection, 2), (away, 1))
    )
    all_corners = np.broadcast_to(part.corners, (*shape, *part.corners.shape[-2:]))
    found = np.zeros(shape, dtype=np.result_type(point, projection, all_corners))
    for index in np.ndindex(shape):
        corners = all_corners[index]
        edges = silhouette_edges(corners.real, part.faces, away[index])
        p, q = np.moveaxis(corners[edges] @ projection[index].T, 1, 0)
        found[index] = _distance_from_edges(p, q, point[index])
    return found


def _distance_from_edges(p: Any, q: Any, point: Any) -> Any:
    """Return the distance of a point (2,) from the edge in its direction, of edges from p (E, 2) to q (E, 2)."""
    ray, along = point.real, (q - p).real
    across = ray[0] * along[:, 1] - ray[1] * along[:, 0]
    offset = ray[1] * p[:, 0].real - ray[0] * p[:, 1].real
    share = np.divide(offset, across, out=np.full(len(p), -1.0), where=across != 0.0)
    reach = np.where((share >= 0.0) & (share <= 1.0), p.real @ ray + share * (along @ ray), -np.inf)
    edge = int(np.argmax(reach))
    side, from_end = q[edge] - p[edge], point - p[edge]
    # Edges run clockwise in a sky with the east along the first axis.
    return (side[0] * from_end[1] - side[1] * from_end[0]) / np.sqrt(side @ side)


def _normals_at_nearest(ellipse: Floats, point: Floats) -> Floats:
    """Return the unit normals (..., 2) of ellipses x^T A^-1 x = 1 at the points that are nearest to others (..., 2)."""

    def terms(angle: Any, matrix: Any, x: Any) -> tuple[Any, Any, Any]:
        """Return the height above the tangent at a normal's angle, and its first and second derivatives."""
        n = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        t = np.stack([-n[..., 1], n[..., 0]], axis=-1)
        along, aside = (np.einsum("...i,...ij,...j->...", v, matrix, n) for v in (n, t))
        size = np.sqrt(along)
        slope = aside / size
        curvature = (np.einsum("...i,...ij,...j->...", t, matrix, t) - slope**2) / size
        height = np.sum(x * n, axis=-1)
        return height - size, np.sum(x * t, axis=-1) - slope, size - height - curvature

    angles = 2.0 * np.pi * np.arange(_NORMALS) / _NORMALS
    angle = angles[np.argmax(terms(angles, ellipse[..., None, :, :], point[..., None, :])[0], axis=-1)]
    for _ in range(_STEPS):
        _, first, second = terms(angle, ellipse, point)
        # Where the height is not concave there is no maximum for Newton's method, and the best of the grid stays.
        step = np.divide(first, second, out=np.zeros_like(first), where=second < 0.0)
        angle = angle - np.clip(step, -0.1, 0.1)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
