"""Observed chords: times of disappearance and reappearance at stations, and misses, as rows in the order of time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.arguments import index_of
from ..base.epochs import dates
from ..base.foreign import are_dates, shown
from ..base.unit_names import unit_named
from ..base.units import is_quantity
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .columns import Rows, column, positive_rows
from .data import Observations
from .star import Star
from .stations import Stations
from .times import in_system, unmasked
from .vectors import Vectors

_OWNER = "StellarOccultation"
_ENDS = ("disappearance", "reappearance")


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
        if not isinstance(geometry, Vectors):
            raise InvalidInput(f"geometry of {_OWNER} is {geometry!r}; expected an observing.Geometry")
        self.star = Star(star, geometry)
        self.stations = Stations(stations, geometry, self.star)
        count = len(self.stations)
        #: The date from which seconds count, with the scale of the dates; or what the times are instead.
        self._origin: Any = None
        self._time_scale = "tdb"
        contacts = zip((disappearance, reappearance), _ENDS, strict=True)
        chords = np.stack([self._numbers(times, name, count) for times, name in contacts], axis=1)
        wrong = np.flatnonzero(chords[:, 1] <= chords[:, 0])
        if wrong.size:
            k = int(wrong[0])
            raise InvalidInput(
                f"reappearance of station {k} is {self._in_kind(chords[k, 1])}, not after its disappearance at "
                f"{self._in_kind(chords[k, 0])}; expected a later time"
            )
        timed: Any = np.isfinite(chords)
        missed = ~timed.any(axis=1)
        if not timed.any():
            raise InvalidInput(
                "disappearance and reappearance have no time that is not NaN; expected one chord or more"
            )
        watch = self._watch(watched, count)
        self._sigmas = self._errors(sigma, count)
        if self.stations.move and (missed & ~np.isfinite(watch).all(axis=1)).any():
            raise InvalidInput(
                f"station {int(np.argmax(missed))} moves and has a miss without an interval; give watched=(first, last)"
            )
        middle = np.full(count, chords[timed].mean())
        limited = np.isfinite(watch).all(axis=1)
        middle[limited] = watch[limited].mean(axis=1)
        entries = [
            (chords[k, side], k, sign) for side, sign in enumerate((-1.0, 1.0)) for k in np.flatnonzero(timed[:, side])
        ]
        entries += [(middle[k], k, 0.0) for k in np.flatnonzero(missed)]
        times, station, sign = (np.array(part) for part in zip(*entries, strict=True))
        rows = Rows(self._restored(times), {}, (), _OWNER)
        super().__init__(rows, geometry)
        self.station, self.sign = station[rows.kept].astype(np.intp), sign[rows.kept]
        self.rows = self.station
        #: The ends of the chord of each row, or of the interval of a miss, as numbers in the unit of the times.
        self.interval = np.where(missed[:, None], watch, chords)[self.station]
        side = np.where(self.sign > 0.0, 1, 0)
        self._sigma = positive_rows(self._sigmas[self.station, side], f"sigma of {_OWNER}")
        self.body = self._bodies(body, count)
        self._chords, self._watched = chords, watch

    def _numbers(self, source: Any, what: str, count: int) -> Floats:
        """Return times (S,) as numbers: seconds since the first date, or numbers in a unit; NaN for those not timed."""
        times, unit, mask = dates(source, what), None, None
        if are_dates(times):
            values, mask = unmasked(times)
        else:
            values, unit = column(times, f"{what} of {_OWNER}", "s" if is_quantity(times) else None)
        if values.shape != (count,):
            raise InvalidInput(f"{what} has shape {values.shape}; expected ({count},), one for each of stations")
        if mask is not None:
            if self._origin is None:
                if mask.all():
                    return np.full(count, np.nan)
                self._origin, self._time_scale = values[int(np.argmin(mask))].tdb, values.scale
            elif not are_dates(self._origin):
                raise InvalidInput(f"{what} has dates, and other times have none; expected dates for all of them")
            return np.where(mask, np.nan, (values.tdb - self._origin).to_value("s"))
        if np.isnan(values).all():
            return values
        kind = "numbers" if unit is None else "seconds"
        if self._origin is None:
            self._origin = kind
        elif are_dates(self._origin) or self._origin != kind:
            raise InvalidInput(f"{what} is {shown(source)}; expected times of the same kind as the others")
        return values

    def _in_kind(self, time: float) -> Any:
        return self._restored(np.array([time]))[0]

    def _restored(self, times: Floats) -> Any:
        """Return numbers as times of the kind that was given."""
        if not self.is_united:
            return times
        seconds = times * unit_named("s")
        return getattr(self._origin + seconds, self._time_scale) if are_dates(self._origin) else seconds

    def _watch(self, watched: Any, count: int) -> Floats:
        """Return the intervals (S, 2) in which the stations watched, infinite where none is given."""
        if watched is None:
            return np.tile([-np.inf, np.inf], (count, 1))
        try:
            first, last = watched
        except (TypeError, ValueError) as error:
            raise InvalidInput(f"watched is {shown(watched)}; expected (first, last), times (S,) each") from error
        parts = [self._numbers(part, f"watched ({name})", count) for part, name in ((first, "first"), (last, "last"))]
        watch = np.stack(parts, axis=1)
        wrong = np.flatnonzero(watch[:, 1] <= watch[:, 0])
        if wrong.size:
            raise InvalidInput(
                f"watched of station {int(wrong[0])} ends before it begins; expected the first time first"
            )
        return np.where(np.isnan(watch), [-np.inf, np.inf], watch)

    def _errors(self, sigma: Any, count: int) -> Floats:
        """Return standard errors (S, 2) in s, or as the plain numbers that were given."""
        values, unit = column(sigma, f"sigma of {_OWNER}", "s" if self.is_united and is_quantity(sigma) else None)
        if (unit is not None) != self.is_united:
            raise InvalidInput("only one of the times and sigma has a unit; expected both or neither")
        if values.shape not in ((), (count,), (count, 2)):
            raise InvalidInput(f"sigma has shape {values.shape}; expected (), ({count},) or ({count}, 2)")
        return np.array(np.broadcast_to(values[:, None] if values.ndim == 1 else values, (count, 2)))

    def _bodies(self, body: Any, count: int) -> tuple[Any, ...]:
        """Return the body of each station, ``None`` where it is not known."""
        if body is None or isinstance(body, str) or np.ndim(body) == 0:
            return (body,) * count
        if len(body) != count:
            raise InvalidInput(f"body has {len(body)} names; expected one, or {count}, one for each of stations")
        return tuple(body)

    @property
    def is_united(self) -> bool:
        """Whether the times have a unit, as dates and Quantities have."""
        return are_dates(self._origin) or self._origin == "seconds"

    @property
    def sigma(self) -> Any:
        """Standard errors (K,) of the rows."""
        return self._sigma * unit_named("s") if self.is_united else self._sigma

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
        return self._sigmas * unit_named("s") if self.is_united else self._sigmas

    def _with_gaps(self, times: Floats) -> Any:
        missing = np.isnan(times)
        times_of_kind = self._restored(np.where(missing, 0.0, times) if are_dates(self._origin) else times)
        if are_dates(times_of_kind) and missing.any():
            times_of_kind = times_of_kind.copy()
            times_of_kind[missing] = np.ma.masked
        return times_of_kind

    def times_in(self, system: SystemLike) -> Floats:
        """Return the times (K,) of the rows on the clock of a system."""
        return self._clock(system)

    def in_system(self, numbers: Any, system: SystemLike) -> Any:
        """Return times as they are kept, or a duration as a Quantity, on the clock and in the unit of a system."""
        if is_quantity(numbers):
            return float(system.context.units.strip(numbers, "time", "a time"))
        finite = np.isfinite(numbers)
        filled = np.where(finite, numbers, 0.0)
        times_of_kind = in_system(self._restored(filled.ravel()), system, f"times of {_OWNER}").reshape(filled.shape)
        return np.where(finite, times_of_kind, numbers)

    def errors_in(self, system: SystemLike, without_jitter: bool = False) -> Floats:
        """Return the standard errors (K,) in a system's unit of time, with a jitter or without it."""
        sigma = self._sigmas[self.station, np.where(self.sign > 0.0, 1, 0)] if without_jitter else self._sigma
        sigma = sigma * unit_named("s") if self.is_united else sigma
        return system.context.units.strip(sigma, "time", f"sigma of {_OWNER}")

    def may_be(self, system: SystemLike, body: int) -> Any:
        """Return which of the K rows may be due to a body."""
        names = system.context.names
        indices = [None if name is None else index_of(name, names, f"body of {_OWNER}") for name in self.body]
        return np.array([indices[station] in (None, body) for station in self.station])

    def _described(self) -> list[tuple[str, str]]:
        missed = int(np.sum(self.sign == 0.0))
        return [("stations", str(len(self.stations))), ("misses", str(missed)), ("body", str(set(self.body)))]
