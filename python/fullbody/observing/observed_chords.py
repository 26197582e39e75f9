"""Observed chords: times of disappearance and reappearance at stations, and misses, as rows in the order of time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.epochs import dates
from ..base.foreign import are_dates, shown
from ..base.kinds import instance
from ..base.unit_names import unit_named
from ..base.units import is_quantity
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .columns import DataColumn, Rows, column, jitter_of, positive_rows
from .data import Observations
from .event_tables import table_of
from .star import Star
from .stations import Stations
from .times import to_system_times, unmasked
from .vectors import Vectors

_OWNER = "StellarOccultation"
#: The columns of a table: times, intervals of watches, stations on the Earth, and vectors, at both times or at one.
_TIMES, _WATCH = ("disappearance", "reappearance"), ("watched_from", "watched_until")
_EARTH, _VECTOR = ("longitude", "latitude", "height"), ("x", "y", "z")
_AT_REAPPEARANCE = tuple(f"{name}_at_reappearance" for name in _VECTOR)


class ObservedChords(Observations):
    """Base class of :class:`fullbody.observing.StellarOccultation`, where its parameters are described.

    Attributes
    ----------
    times : astropy Time, Quantity or ndarray, (K,)
        The times of all contacts in their order; for a miss the middle of its interval, or of the event.
    station : ndarray of int, (K,)
        The station of each row.
    sign : ndarray, (K,)
        -1 for a disappearance, 1 for a reappearance, 0 for a miss.
    """

    _columns = (
        *(DataColumn(name, kind="times") for name in _TIMES),
        DataColumn("sigma", parts=tuple(f"sigma_{name}" for name in _TIMES)),
        DataColumn("body", required=False, kind="labels"),
        *(DataColumn(name, required=False, kind="times") for name in _WATCH),
        *(DataColumn(name, required=False, kind="numbers") for name in (*_EARTH, *_VECTOR, *_AT_REAPPEARANCE)),
    )

    def __init__(
        self,
        star: Any,
        stations: Any,
        disappearance: Any,
        reappearance: Any,
        sigma: Any,
        geometry: Any,
        body: Any,
        watched: Any,
    ) -> None:
        instance(geometry, f"geometry of {_OWNER}", Vectors, "an observing.Geometry")
        self.star = Star(star, geometry)
        self.stations = Stations(stations, geometry, self.star)
        #: The date from which seconds count, with the scale of the dates; or what the times are instead, "numbers" or
        #: "seconds".
        self._origin: Any = None
        self._time_scale = "tdb"
        #: Times (S, 2) of the contacts, intervals (S, 2) of watches and standard errors (S, 2), in s or plain numbers.
        contacts = zip((disappearance, reappearance), _TIMES, strict=True)
        self._chords = np.stack([self._numbers(*contact) for contact in contacts], axis=1)
        wrong = np.flatnonzero(self._chords[:, 1] <= self._chords[:, 0])
        if wrong.size:
            begin, end = self._restored(self._chords[wrong[0]])
            raise InvalidInput(
                f"reappearance of station {int(wrong[0])} is {end}, not after its disappearance at {begin}; expected a "
                "later time"
            )
        timed: Any = np.isfinite(self._chords)
        if not timed.any():
            raise InvalidInput(
                "disappearance and reappearance have no time that is not NaN; expected one chord or more"
            )
        self._watched, self._sigmas = self._watch(watched), self._errors(sigma)
        limited: Any = np.isfinite(self._watched).all(axis=1)
        misses = np.flatnonzero(~timed.any(axis=1))
        if self.stations.has_two_times and not limited[misses].all():
            raise InvalidInput(
                f"station {misses[0]} moves and has a miss without an interval; give watched=(first, last)"
            )
        middle = np.full(len(self.stations), self._chords[timed].mean())
        middle[limited] = self._watched[limited].mean(axis=1)
        side, station = np.nonzero(timed.T)
        times = np.concatenate([self._chords[station, side], middle[misses]])
        rows = Rows(self._restored(times), {}, (), _OWNER)
        super().__init__(rows, geometry)
        self.rows = self.station = np.concatenate([station, misses])[rows.indices]
        self.sign = np.concatenate([2.0 * side - 1.0, np.zeros(len(misses))])[rows.indices]
        #: The ends of the chord of each row, or of the interval of a miss, as numbers in the unit of the times.
        self._interval = np.where((self.sign == 0.0)[:, None], self._watched[self.station], self._chords[self.station])
        self._original_sigma = self._sigmas[self.station, np.where(self.sign > 0.0, 1, 0)]
        self._sigma = positive_rows(self._original_sigma, f"sigma of {_OWNER}")
        self.body = self._bodies(body)

    def _numbers(self, source: Any, what: str) -> Floats:
        """Return times (S,) as numbers: seconds since the first date, or numbers in a unit; NaN for those not timed."""
        times, count = dates(source, what), len(self.stations)
        if are_dates(times):
            values, mask = unmasked(times)
        else:
            values, unit = column(times, f"{what} of {_OWNER}", "s" if is_quantity(times) else None)
            mask, kind = np.isnan(values), "numbers" if unit is None else "seconds"
        if values.shape != (count,):
            raise InvalidInput(f"{what} has shape {values.shape}; expected ({count},), one for each of stations")
        if mask.all():
            return np.full(count, np.nan)
        if are_dates(times):
            if self._origin is None:
                self._origin, self._time_scale = values[int(np.argmin(mask))].tdb, values.scale
            elif not are_dates(self._origin):
                raise InvalidInput(f"{what} has dates, and other times have none; expected dates for all of them")
            return np.where(mask, np.nan, (values.tdb - self._origin).to_value("s"))
        self._origin = kind if self._origin is None else self._origin
        if are_dates(self._origin) or self._origin != kind:
            raise InvalidInput(f"{what} is {shown(source)}; expected times of the same kind as the others")
        return values

    def _restored(self, times: Floats) -> Any:
        """Return numbers as times of the kind that was given."""
        if are_dates(self._origin):
            return getattr(self._origin + self._with_unit(times), self._time_scale)
        return self._with_unit(times)

    def _watch(self, watched: Any) -> Floats:
        """Return the intervals (S, 2) in which the stations watched, infinite where none is given."""
        if watched is None:
            return np.tile([-np.inf, np.inf], (len(self.stations), 1))
        try:
            first, last = watched
        except (TypeError, ValueError) as error:
            raise InvalidInput(f"watched is {shown(watched)}; expected (first, last), times (S,) each") from error
        parts = [self._numbers(part, f"watched ({name})") for part, name in ((first, "first"), (last, "last"))]
        watch = np.stack(parts, axis=1)
        wrong = np.flatnonzero(watch[:, 1] <= watch[:, 0])
        if wrong.size:
            raise InvalidInput(
                f"watched of station {int(wrong[0])} ends before it begins; expected the first time first"
            )
        return np.where(np.isnan(watch), [-np.inf, np.inf], watch)

    def _errors(self, sigma: Any) -> Floats:
        """Return standard errors (S, 2) in s, or as the plain numbers that were given."""
        count = len(self.stations)
        values, unit = column(sigma, f"sigma of {_OWNER}", "s" if self._has_unit and is_quantity(sigma) else None)
        if (unit is not None) != self._has_unit:
            raise InvalidInput("only one of the times and sigma has a unit; expected both or neither")
        if values.shape not in ((), (count,), (count, 2)):
            raise InvalidInput(f"sigma has shape {values.shape}; expected (), ({count},) or ({count}, 2)")
        return np.array(np.broadcast_to(values[:, None] if values.ndim == 1 else values, (count, 2)))

    def _bodies(self, body: Any) -> tuple[Any, ...]:
        """Return the body of each station, ``None`` where it is not known."""
        count = len(self.stations)
        if body is None or isinstance(body, str) or np.ndim(body) == 0:
            return (body,) * count
        if len(body) != count:
            raise InvalidInput(f"body has {len(body)} names; expected one, or {count}, one for each of stations")
        return tuple(body)

    @property
    def _has_unit(self) -> bool:
        """Whether the times have a unit, as dates and Quantities have."""
        return are_dates(self._origin) or self._origin == "seconds"

    def _with_unit(self, durations: Floats) -> Any:
        return durations * unit_named("s") if self._has_unit else durations

    @property
    def sigma(self) -> Any:
        """Standard errors (K,) of the rows."""
        return self._with_unit(self._sigma)

    @property
    def chords(self) -> tuple[Any, Any]:
        """The times of disappearance and reappearance (S, 2), and the watched intervals (S, 2) or ``None``.

        Dates are masked where they are not known, and other times are NaN.
        """
        limited: Any = np.isfinite(self._watched).all(axis=1)
        watched = np.where(limited[:, None], self._watched, np.nan)
        return self._with_gaps(self._chords), self._with_gaps(watched) if limited.any() else None

    @property
    def errors_of_chords(self) -> Any:
        """The standard errors (S, 2) of disappearances and reappearances, as they were given."""
        return self._with_unit(self._sigmas)

    def _with_gaps(self, times: Floats) -> Any:
        """Return times of the kind that was given, in which NaN is masked if they are dates."""
        if not are_dates(self._origin):
            return self._restored(times)
        missing = np.isnan(times)
        result = self._restored(np.where(missing, 0.0, times)).copy()
        if missing.any():
            result[missing] = np.ma.masked
        return result

    def _interval_in(self, system: SystemLike) -> Floats:
        """Return the intervals (K, 2) of the rows on the clock of a system, with NaN and infinities."""
        is_finite = np.isfinite(self._interval)
        numbers = np.where(is_finite, self._interval, 0.0)
        times = to_system_times(self._restored(numbers.ravel()), system, f"times of {_OWNER}").reshape(numbers.shape)
        return np.where(is_finite, times, self._interval)

    def _standard_errors(self, system: SystemLike, sigma: Floats | None = None) -> Floats:
        """Return standard errors (K, 1) in a system's unit of time, those with a jitter unless others are given."""
        sigma = self._sigma if sigma is None else sigma
        return system.context.units.strip(self._with_unit(sigma), "time", f"sigma of {_OWNER}")[:, None]

    def _rows_of(self, system: SystemLike, body: int) -> Any:
        """Return the indices (M,) of the rows that may be due to a body."""
        what = f"body of {_OWNER}"
        indices = [None if name is None else system.context.index(name, what) for name in self.body]
        return np.flatnonzero([indices[station] in (None, body) for station in self.station])

    def _add_jitter(self, jitter: Any) -> None:
        self._sigma = np.hypot(self._sigma, jitter_of(jitter, "s" if self._has_unit else None))

    def _observed(self, system: SystemLike) -> Floats:
        return np.zeros((len(self), 1))

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        return system.context.units.attach(values[:, 0], "time")

    def _summary(self) -> list[tuple[str, str]]:
        misses = int(np.sum(self.sign == 0.0))
        return [("stations", str(len(self.stations))), ("misses", str(misses)), ("body", str(set(self.body)))]

    def to_table(self) -> Any:
        """Return the chords as an astropy ``QTable`` with a row for each station, which ``from_table`` reads.

        It has the columns ``disappearance`` and ``reappearance``, masked where they were not timed, their standard
        errors ``sigma_disappearance`` and ``sigma_reappearance``, ``body``, and the positions of the stations:
        ``longitude``, ``latitude`` and ``height`` on the Earth, or ``x``, ``y`` and ``z``.
        """
        chords, watched = self.chords
        columns: dict[str, Any] = {name: _masked(chords[:, side]) for side, name in enumerate(_TIMES)}
        columns |= {f"sigma_{name}": self.errors_of_chords[:, side] for side, name in enumerate(_TIMES)}
        columns["body"] = ["" if body is None else str(body) for body in self.body]
        if watched is not None:
            columns |= {name: _masked(watched[:, side]) for side, name in enumerate(_WATCH)}
        if self.stations.on_earth:
            geodetic = self.stations.locations.to_geodetic("WGS84")
            return table_of(columns | dict(zip(_EARTH, (geodetic.lon, geodetic.lat, geodetic.height), strict=True)))
        vectors = self.stations.vectors
        at_times = np.moveaxis(vectors, 1, 0) if self.stations.has_two_times else [vectors]
        for names, positions in zip((_VECTOR, _AT_REAPPEARANCE), at_times, strict=False):
            columns |= dict(zip(names, positions.T, strict=False))
        return table_of(columns)

    @classmethod
    def _arguments(cls, read: dict[str, Any]) -> dict[str, Any]:
        arguments = {name: read[name] for name in (*_TIMES, "sigma")}
        if "body" in read:
            arguments["body"] = [str(body) or None for body in read["body"]]
        if all(name in read for name in _WATCH):
            arguments["watched"] = tuple(read[name] for name in _WATCH)
        if all(name in read for name in _EARTH):
            from astropy import units as u
            from astropy.coordinates import EarthLocation

            units = zip(_EARTH, (u.deg, u.deg, u.m), strict=True)
            arguments["stations"] = EarthLocation.from_geodetic(*(u.Quantity(read[name], unit) for name, unit in units))
        elif "x" in read:
            columns = ([read[name] for name in names if name in read] for names in (_VECTOR, _AT_REAPPEARANCE))
            vectors = [np.stack(column, axis=-1) for column in columns if column]
            arguments["stations"] = vectors[0] if len(vectors) == 1 else np.stack(vectors, axis=1)
        return arguments


def _masked(times: Any) -> Any:
    """Return times as a column in which those that are NaN are masked."""
    if are_dates(times):
        return times
    from astropy.table import MaskedColumn

    values = np.asarray(getattr(times, "value", times))
    return MaskedColumn(np.nan_to_num(values), mask=np.isnan(values), unit=getattr(times, "unit", None))
