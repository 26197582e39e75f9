"""A mutual event of two bodies with its contacts, and lists of them as tables."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..model.context import SystemLike
from .event_tables import table_of, time_column

if TYPE_CHECKING:
    from ..typing import Scalar


@dataclass(frozen=True, slots=True)
class MutualEvent:
    """A mutual event: one body hides another one from the observer, or from the Sun.

    Times are those at which the observer sees the event, on the system's clock: numbers, or Quantities since the epoch.
    The outlines of the bodies overlap from ``begin`` to ``end``, as seen from the observer or from the Sun. The hidden
    part need not be one that the observer sees; ``depth`` and a light curve give the loss of light.

    Attributes
    ----------
    kind : str
        ``"occultation"`` (by a body between it and the observer) or ``"eclipse"`` (by one between it and the Sun).
    body, by : str
        Names of the hidden body and of the other one.
    begin, end : float, Quantity or None
        First and last contact; ``None`` where the run, or the geometry, begins or ends within the event. They are
        contacts with the penumbra for an eclipse with the Sun's disc.
    total_begin, total_end : float, Quantity or None
        First and last time of totality, when the whole outline is hidden from the observer, or from all of the Sun's
        disc; ``None`` for a partial event, and where the run begins or ends within totality.
    umbra_begin, umbra_end : float, Quantity or None
        First and last time at which a part of the body is hidden from all of the Sun's disc; ``None`` if there is
        no such part, and for occultations and a Sun without a disc.
    depth : float or None
        The largest loss of the light of all bodies during the event, in magnitudes, by all events at that time.
    deepest : float, Quantity or None
        The time of this loss.
    """

    kind: str
    body: str
    by: str
    begin: Scalar | None
    end: Scalar | None
    total_begin: Scalar | None = None
    total_end: Scalar | None = None
    umbra_begin: Scalar | None = None
    umbra_end: Scalar | None = None
    depth: float | None = None
    deepest: Scalar | None = None

    @property
    def middle(self) -> Scalar | None:
        """The mean of ``begin`` and ``end``, or ``None`` if one of them is ``None``."""
        return None if self.begin is None or self.end is None else 0.5 * (self.begin + self.end)

    @property
    def duration(self) -> Scalar | None:
        """The time from ``begin`` to ``end``, or ``None`` if one of them is ``None``."""
        return None if self.begin is None or self.end is None else self.end - self.begin


#: The contacts of an event in the order of time.
_CONTACTS = ("begin", "umbra_begin", "total_begin", "total_end", "umbra_end", "end")


class MutualEvents(list[MutualEvent]):
    """A list of mutual events in the order of time, made by :func:`mutual_events`.

    Parameters
    ----------
    events : iterable of MutualEvent
    system : System
        The system on whose clock the times are.
    """

    def __init__(self, events: Iterable[MutualEvent], system: SystemLike) -> None:
        super().__init__(events)
        self._system = system

    def to_table(self) -> Any:
        """Return an astropy ``QTable`` with a row for each event.

        It has the columns ``kind``, ``body`` and ``by``, the contacts ``begin``, ``umbra_begin``, ``total_begin``,
        ``total_end``, ``umbra_end`` and ``end``, and ``deepest`` and ``depth`` in magnitudes. Times are dates in UTC
        if the system has an epoch, by the clock of the observer. A time that an event does not have is masked, and
        columns of times that no event has are left out.

        Examples
        --------
        >>> import astropy.units as u, fullbody
        >>> from fullbody import observing
        >>> system, state = fullbody.systems.didymos(units=True)
        >>> run = system.with_options(epoch="2022-09-26 TDB").integrate(state, "8 h", dense=True)
        >>> view = {"to_observer": [0.1, 0.01, 0.0] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au}
        >>> events = observing.mutual_events(run, observing.Geometry([-1.0, 2.0] * u.day, **view))
        >>> events.to_table()["kind", "body", "end"][:1].pformat()[-1].split()[:3]
        ['eclipse', 'Didymos', '2022-09-26']
        """
        table = table_of({name: [getattr(event, name) for event in self] for name in ("kind", "body", "by")})
        for name in (*_CONTACTS, "deepest"):
            times = [getattr(event, name) for event in self]
            if any(time is not None for time in times) or name in ("begin", "end"):
                table[name] = time_column(times, self._system)
        depths = [event.depth for event in self]
        if any(depth is not None for depth in depths):
            from astropy.table import MaskedColumn

            is_missing = [depth is None for depth in depths]
            table["depth"] = MaskedColumn([depth or 0.0 for depth in depths], mask=is_missing, unit="mag")
        return table
