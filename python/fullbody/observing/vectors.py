"""Vectors to the observer and to the Sun as functions of time, and in the time, units and axes of a system."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from ..base import values
from ..base.arguments import directions, refuse_mixture
from ..base.epochs import dates, refuse_coarse
from ..base.foreign import are_dates, shown
from ..base.kinds import flag, instance
from ..base.splines import relative_error
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, Units, as_quantity, is_quantity, need, strip_to
from ..errors import InvalidInput, caution
from ..frames import rotation
from ..model.context import SystemLike
from ..typing import Array, Floats
from .times import LIGHT_SPEED, kilometres, seconds, system_epoch

#: The error of the spline between rows, relative to the distance, above which a warning is given.
_COARSE = 1e-3
#: The difference in seconds below which two dates count as one.
_ROUNDING = 1e-6
#: The number of iterations of a time of arrival, each of which gains four digits, those of c over the speed.
_ITERATIONS = 6


class Vectors:
    """Base class of :class:`fullbody.observing.Geometry`, where its parameters are described."""

    def __init__(
        self, times: Any, *, to_observer: Any, to_sun: Any = None, frame: Any = None, light_time: bool = True
    ) -> None:
        flag(light_time, "light_time")
        if frame is not None:
            cached_rotation("equatorial", frame)
        self.frame = frame
        self.light_time = bool(light_time)
        #: The date of the zero of the axis, TDB, if times are dates.
        self._origin: Any = None
        #: The unit of the axis in s, and of the vectors in km; ``None`` for plain numbers.
        self._second: float | None = None
        axis = self._axis(times, first=True)
        if axis.ndim != 1 or not len(axis):
            raise InvalidInput(f"times has shape {axis.shape}; expected (K,), one time or more")
        order = np.argsort(axis, kind="stable")
        self._times = axis[order]
        if (equal := np.flatnonzero(np.diff(self._times) == 0.0)).size:
            raise InvalidInput(f"times has {self._attached_time(self._times[equal[0]])} twice; expected distinct times")
        vectors = {"to_observer": as_quantity(to_observer, "to_observer", "length")}
        if to_sun is not None:
            vectors["to_sun"] = as_quantity(to_sun, "to_sun", "length")
        self._km = 1.0 if refuse_mixture(vectors) else None
        self._observer = self._vectors(vectors["to_observer"], "to_observer", order)
        self._sun = self._vectors(vectors["to_sun"], "to_sun", order) if to_sun is not None else None
        #: The ends of the span along the axis; tables that this package makes have rows beyond them.
        self._ends = (float(self._times[0]), float(self._times[-1]))
        #: Cached results: splines, whether there was a warning, and geometries of systems.
        self._cache: dict[Any, Any] = {}

    def _axis(self, times: Any, first: bool = False) -> Floats:
        """Return times as numbers along the spline: seconds since the first date, seconds, or plain numbers."""
        times = dates(times, "times")
        if are_dates(times):
            if first:
                self._origin, self._second = np.ravel(times)[0].tdb, 1.0
            elif self._origin is None:
                raise InvalidInput("time is a date, but the geometry has times since an epoch; expected such a time")
            return np.asarray((times.tdb - self._origin).to_value("s"), dtype=np.float64)
        refuse_coarse(times, None, "times of the geometry")
        times = as_quantity(times, "times", "time")
        if self._origin is not None:
            raise InvalidInput(f"time is {shown(times)}; expected a date (an astropy Time), as the geometry has them")
        if first:
            self._second = 1.0 if is_quantity(times) else None
        elif is_quantity(times) != (self._second is not None):
            expected = "a plain number" if self._second is None else "a Quantity"
            raise InvalidInput(f"time is {shown(times)}; expected {expected}, as the geometry has them")
        return (UNITLESS if self._second is None else Units(("km", "s", "kg"))).numbers(times, "time", "times")

    def _vectors(self, vectors: Any, what: str, order: Any) -> Floats:
        rows = directions(vectors, what)
        if rows.ndim > 2 or (rows.ndim == 2 and len(rows) != len(order)):
            raise InvalidInput(f"{what} has shape {rows.shape}; expected ({len(order)}, 3), a row for each of times")
        rows = strip_to(vectors, unit_named("km"), what) if is_quantity(vectors) else rows
        return np.array(np.broadcast_to(rows, (len(order), 3))[order], dtype=np.float64)

    @property
    def span(self) -> Any:
        """The first and the last time: dates, Quantities or numbers."""
        return self._attached_time(self._ends[0]), self._attached_time(self._ends[1])

    def _attached_time(self, time: float) -> Any:
        if self._origin is None and self._second is None:
            return float(time)
        elapsed = time * unit_named("s")
        return elapsed if self._origin is None else self._origin + elapsed

    def to_observer(self, times: Any) -> Array:
        """Return vectors from the system's barycentre to the observer, in the geometry's frame.

        Parameters
        ----------
        times : astropy Time, float, Quantity or array_like, (...)
            Times of the kind with which the geometry was made.

        Returns
        -------
        ndarray or Quantity, (..., 3)
            In km if the vectors were given with units.
        """
        return self._attached(self._at(self._observer, self._axis(times)))

    def to_sun(self, times: Any) -> Array:
        """Return vectors from the system's barycentre to the Sun, in the form of :meth:`to_observer`."""
        return self._attached(self._at(self._sun_table(), self._axis(times)))

    def phase_angle(self, times: Any) -> Any:
        """Return the angles (...) between the directions to the observer and to the Sun, in radians, at times (...)."""
        axis = self._axis(times)
        e, s = self._at(self._observer, axis), self._at(self._sun_table(), axis)
        angle = np.arctan2(np.linalg.norm(np.cross(e, s), axis=-1), np.einsum("...x,...x->...", e, s))
        return float(angle) if np.ndim(angle) == 0 else angle

    @property
    def has_sun(self) -> bool:
        """Whether the geometry has vectors to the Sun."""
        return self._sun is not None

    def _attached(self, vectors: Floats) -> Any:
        return vectors if self._km is None else vectors * unit_named("km")

    def _sun_table(self) -> Floats:
        if self._sun is None:
            raise InvalidInput("the geometry has no Sun; give to_sun=")
        return self._sun

    def _at(self, table: Floats, axis: Floats, derivative: int = 0) -> Floats:
        """Return the vectors of a table, or their derivatives, at times along the axis."""
        # Dates and their differences are rounded, so that the ends have a tolerance.
        slack = _ROUNDING if self._origin is not None else 8.0 * np.spacing(np.abs(self._times).max())
        outside = (axis < self._ends[0] - slack) | (axis > self._ends[1] + slack)
        if np.any(outside):
            first, last = self.span
            time = self._attached_time(float(np.atleast_1d(axis)[np.atleast_1d(outside)][0]))
            raise InvalidInput(f"time {time} is outside the span of the geometry, {first} to {last}")
        if len(self._times) == 1:
            vectors = np.broadcast_to(table[0] if derivative == 0 else np.zeros(3), (*axis.shape, 3))
            return np.array(vectors, dtype=np.float64)
        spline = self._cache.get(id(table))
        if spline is None:
            with need("observing", "a geometry"):
                from scipy.interpolate import CubicSpline

            spline = self._cache[id(table)] = CubicSpline(self._times, table, axis=0)
        row = np.clip(np.searchsorted(self._times, axis), 1, len(self._times) - 1)
        gap = np.minimum(np.abs(axis - self._times[row - 1]), np.abs(axis - self._times[row]))
        if derivative or np.any(gap > slack):
            self._warn_if_coarse(table)
        return np.asarray(spline(axis, derivative), dtype=np.float64)

    def _warn_if_coarse(self, table: Floats) -> None:
        """Warn once if rows are so far apart that the spline between them does not follow the path."""
        if ("warned", id(table)) in self._cache:
            return
        self._cache["warned", id(table)] = True
        error, row = relative_error(self._times, table)
        if error > _COARSE:
            caution(
                "the vectors of the geometry are so far apart in time that the spline between them is wrong by about "
                f"{error:.1g} of the distance near {self._attached_time(self._times[row])}; expected rows nearer to "
                "each other, or times that are among those of the geometry"
            )

    def __eq__(self, other: object) -> bool:
        return values.same(self._parts(), other._parts()) if isinstance(other, Vectors) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def _parts(self) -> tuple[Any, ...]:
        origin = None if self._origin is None else (self._origin.jd1, self._origin.jd2)
        scales = (origin, self._second, self._km, self.frame, self.light_time)
        return (*scales, self._times, self._observer, self._sun)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_cache": {}}

    def __repr__(self) -> str:
        first, last = self.span
        sun = "" if self.has_sun else ", without the Sun"
        return f"{type(self).__name__}({len(self._times)} times from {first} to {last}{sun})"


_named_rotation = functools.cache(rotation)


def cached_rotation(origin: Any, target: Any) -> Floats:
    """Return the matrix of :func:`fullbody.frames.rotation`, which is cached for frames that are named."""
    return (_named_rotation if isinstance(origin, str) and isinstance(target, str) else rotation)(origin, target)


def rotation_to_system(frame: Any, system: SystemLike, what: str) -> Floats:
    """Return the matrix (3, 3) from a frame to the axes of a system; ``what`` names in an error what needs these."""
    if system.context.frame is None:
        raise InvalidInput(
            f"{what} needs the axes of the system, which are not known; give fullbody.System(..., frame='ecliptic')"
        )
    return cached_rotation(frame, system.context.frame)


def local_geometry(geometry: Vectors, system: SystemLike) -> SystemGeometry:
    """Return a geometry in the time, units and axes of a system."""
    instance(geometry, "geometry", Vectors, "an observing.Geometry")
    key = ("system", system.context.epoch, system.context.units.names, system.context.frame)
    if key not in geometry._cache:
        geometry._cache[key] = SystemGeometry(geometry, system)
    return geometry._cache[key]


class SystemGeometry:
    """A geometry in the time, units and axes of a system, all in plain numbers.

    The ``light_speed`` is infinite if the geometry has no light time. Only directions of ``distant`` vectors count, as
    those of plain numbers without light time.
    """

    def __init__(self, geometry: Vectors, system: SystemLike) -> None:
        self._geometry = geometry
        #: The time zero of the system, its unit of time and its unit of length in those of the geometry.
        self._zero, self._second, self._length, self._rotation = 0.0, 1.0, 1.0, np.eye(3)
        if geometry._origin is not None:
            self._zero = float((system_epoch(system, "a geometry with dates") - geometry._origin).to_value("s"))
        if geometry._second is not None:
            self._second = seconds(system, "a geometry with units of time")
        if geometry._km is not None:
            self._length = kilometres(system, "a geometry with units of length")
        if geometry.frame is not None:
            what = f"a geometry in the frame {geometry.frame!r}"
            self._rotation = rotation_to_system(geometry.frame, system, what)
        self.light_speed = np.inf
        self.distant = not geometry.light_time and geometry._km is None
        if geometry.light_time:
            what = "the light time (light_time=True of the geometry)"
            self.light_speed = LIGHT_SPEED / kilometres(system, what) * seconds(system, what)

    def _evaluate(self, table: Floats, times: Floats, derivative: int = 0) -> Floats:
        vectors = self._geometry._at(table, times * self._second + self._zero, derivative)
        return np.asarray(vectors @ self._rotation.T / self._length * self._second**derivative)

    def observer(self, times: Floats) -> Floats:
        """Return vectors (..., 3) from the barycentre to the observer at times (...) of the system's clock."""
        return self._evaluate(self._geometry._observer, times)

    def observer_velocity(self, times: Floats) -> Floats:
        """Return rates of change (..., 3) of the vectors to the observer."""
        return self._evaluate(self._geometry._observer, times, 1)

    def sun(self, times: Floats) -> Floats:
        """Return vectors (..., 3) from the barycentre to the Sun at times (...) of the system's clock."""
        return self._evaluate(self._geometry._sun_table(), times)

    def sun_velocity(self, times: Floats) -> Floats:
        """Return rates of change (..., 3) of the vectors to the Sun."""
        return self._evaluate(self._geometry._sun_table(), times, 1)

    def emission(self, arrival: Any) -> Floats:
        """Return the times (...) at which the light that arrives at given times left the barycentre."""
        times: Floats = np.asarray(arrival, dtype=np.float64)
        if np.isinf(self.light_speed):
            return times
        return np.asarray(times - np.linalg.norm(self.observer(times), axis=-1) / self.light_speed)

    def arrival(self, times: Any, position: Any = 0.0) -> Floats:
        """Return times (...) at which light from the barycentre, or positions (..., 3), arrives at the observer."""
        emitted = np.asarray(times, dtype=np.float64)
        if np.isinf(self.light_speed):
            return emitted
        low, high = self.ends()
        arrived = emitted
        for _ in range(_ITERATIONS):
            # Before the iteration has converged a time may be a little outside the span.
            distance = np.linalg.norm(self.observer(np.clip(arrived, low, high)) - position, axis=-1)
            arrived = emitted + distance / self.light_speed
        return np.asarray(np.clip(arrived, low, high))

    def ends(self) -> tuple[float, float]:
        """Return the first and the last time of observation."""
        first, last = ((end - self._zero) / self._second for end in self._geometry._ends)
        return first, last

    def common_span(self, system: SystemLike, first: float, last: float) -> tuple[float, float]:
        """Return the times of observation of a run from a first to a last time, after checking that there are some."""
        begin, end = self.ends()
        common = max(begin, float(self.arrival(first))), min(end, float(self.arrival(last)))
        if not common[0] < common[1]:
            first_text, last_text, begin_text, end_text = (
                str(system.context.units.attach(time, "time")) for time in (first, last, begin, end)
            )
            raise InvalidInput(
                f"the run, from {first_text} to {last_text}, and the geometry, from {begin_text} to {end_text} at the "
                "observer, have no time in common"
            )
        return common

    def rows(self) -> Floats:
        """Return the times of observation of the rows of the table."""
        return np.asarray((self._geometry._times - self._zero) / self._second)

    def delays(self, observer: Floats, position: Floats, velocity: Floats) -> Floats:
        """Return the delays (..., N) of the light of bodies on straight lines relative to light from the barycentre.

        Positions and velocities (..., N, 3) from the barycentre are those when the light left it. The delay t solves
        abs(d - r - v t) = abs(d) - c t; the root is computed without a difference of large numbers.
        """
        if np.isinf(self.light_speed):
            return np.zeros(position.shape[:-1])
        c, d = self.light_speed, observer[..., None, :]
        # The equation is a t^2 - 2 b t + e = 0.
        a = c * c - np.einsum("...x,...x->...", velocity, velocity)
        b = np.linalg.norm(d, axis=-1) * c - np.einsum("...x,...x->...", d - position, velocity)
        e = np.einsum("...x,...x->...", position, 2.0 * d - position)
        return np.asarray(e / (b + np.sqrt(b * b - a * e)))
