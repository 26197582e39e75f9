"""Chords of stellar occultations, and lists of them as tables."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.epochs import to_time
from ..base.units import need
from ..model.context import SystemLike
from .times import seconds

if TYPE_CHECKING:
    from ..typing import Scalar


@dataclass(frozen=True, slots=True)
class Chord:
    """The occultation of a star by a body as one station sees it.

    Attributes
    ----------
    station : int
        The index of the station.
    body : str
        The name of the body.
    disappearance, reappearance : float, Quantity or None
        Times at the station on the system's clock, numbers or Quantities since the epoch; ``None`` where the searched
        span begins or ends while the star is hidden.
    """

    station: int
    body: str
    disappearance: Scalar | None
    reappearance: Scalar | None

    @property
    def duration(self) -> Scalar | None:
        """The time from disappearance to reappearance, or ``None`` if one of them is ``None``."""
        if self.disappearance is None or self.reappearance is None:
            return None
        return self.reappearance - self.disappearance


@dataclass(frozen=True, slots=True)
class Miss:
    """The closest approach of a body to the line of sight of a station from which it hides nothing.

    Attributes
    ----------
    station : int
    body : str
    time : float or Quantity
        The time at which the body's centre is nearest to the line of sight, on the system's clock.
    distance : float or Quantity
        The distance of the body's centre from the line of sight then.
    """

    station: int
    body: str
    time: Scalar
    distance: Scalar


class Chords(list[Chord]):
    """A list of chords by station and time, made by :func:`occultation_chords`.

    Parameters
    ----------
    chords : iterable of Chord
    misses : iterable of Miss
    system : System
        The system on whose clock the times are.

    Attributes
    ----------
    misses : list of Miss
        For each station and each body that hides nothing from it in the searched span, its closest approach.
    """

    def __init__(self, chords: Iterable[Chord], misses: Iterable[Miss], system: SystemLike) -> None:
        super().__init__(chords)
        self.misses = list(misses)
        self._system = system

    def to_table(self) -> Any:
        """Return an astropy ``QTable`` with a row for each chord.

        It has the columns ``station``, ``body``, ``disappearance``, ``reappearance`` and ``duration``. Times are dates
        in UTC if the system has an epoch, by the clock of the station. A time that a chord does not have is masked.

        Examples
        --------
        >>> import astropy.units as u, fullbody
        >>> from fullbody import observing
        >>> system, state = fullbody.systems.didymos(units=True)
        >>> run = system.integrate(state, "10 min", dense=True)
        >>> path = {"to_observer": [[1e7, -2.0, 0.0], [1e7, 4.0, 0.0]] * u.km, "frame": "ecliptic"}
        >>> geometry = observing.Geometry([0.0, 300.0] * u.s, **path)
        >>> chords = observing.occultation_chords(run, [-1.0, 0.0, 0.0], [[0.0, 0.0, 0.0]] * u.km, geometry)
        >>> chords.to_table()["station", "body"].pformat()[-1].split()
        ['0', 'Dimorphos']
        """
        with need("observing", "a table"):
            from astropy.table import QTable

        table = QTable({name: [getattr(chord, name) for chord in self] for name in ("station", "body")})
        for name in ("disappearance", "reappearance"):
            table[name] = time_column([getattr(chord, name) for chord in self], self._system)
        durations = [chord.duration for chord in self]
        table["duration"] = _masked(durations, self._system)
        return table


def _masked(times: list[Any], system: SystemLike) -> Any:
    """Return times as a column of numbers, in which ``None`` is masked."""
    from astropy.table import MaskedColumn

    units = system.context.units
    plain = [0.0 if time is None else float(units.strip(time, "time", "time")) for time in times]
    unit = units.unit("time") if units.defined else None
    return MaskedColumn(plain, mask=[time is None for time in times], unit=unit, dtype=float)


def time_column(times: list[Any], system: SystemLike) -> Any:
    """Return times of a system's clock as a column of dates in UTC, or of numbers if the system has no epoch.

    ``None`` is masked.
    """
    column, context = _masked(times, system), system.context
    if context.epoch is None:
        return column
    from astropy.time import TimeDelta

    since = TimeDelta(np.asarray(column.data.data) * seconds(system, "a table of times"), format="sec")
    dates = (to_time(context.epoch).tdb + since).utc.copy()
    dates.format = "iso"
    if column.mask.any():
        dates[column.mask] = np.ma.masked
    return dates
