"""Surfaces of section, and the frequencies of a motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.arguments import sequence
from ..base.kinds import function, instance, whole_number
from ..base.tables import Table, Tabled
from ..base.units import UNITLESS
from ..base.values import ArrayFields, block
from ..ensembles.members import integrate_many
from ..errors import FullbodyError, InvalidInput
from ..events import Event
from ..model.state import State
from ..motion.system import System
from ..observables._signal import periodic_terms
from ..record.record import Record
from ..typing import Array
from . import pictures


@dataclass(frozen=True, eq=False, repr=False)
class Section(Tabled):
    """The states in which motions cross a surface, made by :func:`section`.

    Attributes
    ----------
    system : System
    crossings : tuple of tuple of State
        For each start its crossings in the order of time.
    errors : tuple of FullbodyError or None
        For each start the error that ended its run early, or ``None``; the crossings until then are kept.
    """

    system: System
    crossings: tuple[tuple[State, ...], ...]
    errors: tuple[FullbodyError | None, ...]

    def values(self, coordinate: Callable[[State], Any]) -> tuple[Any, ...]:
        """Return arrays (C,), one for each start, of a function of a State that gives a number or Quantity."""
        function(coordinate, "coordinate", "a function of a State")
        columns = []
        for states in self.crossings:
            values = [coordinate(state) for state in states]
            unit = getattr(values[0], "unit", None) if values else None
            numbers = np.array([float(value if unit is None else value.to_value(unit)) for value in values])
            columns.append(numbers if unit is None else numbers << unit)
        return tuple(columns)

    plot = pictures.section

    def __len__(self) -> int:
        return len(self.crossings)

    def _tables(self) -> tuple[Table, ...]:
        rows = [
            (str(k), str(len(states)), "-" if error is None else str(error))
            for k, (states, error) in enumerate(zip(self.crossings, self.errors, strict=True))
        ]
        return (Table("Section", ("start", "crossings", "cut short by"), list(rows)),)

    def __repr__(self) -> str:
        failed = sum(error is not None for error in self.errors)
        counts = f"{sum(map(len, self.crossings))} crossings"
        return f"Section({len(self)} starts, {counts}{f', {failed} cut short' if failed else ''})"


def section(
    system: System,
    states: State | Sequence[State],
    until: Any = None,
    event: Event | None = None,
    *,
    duration: Any = None,
    threads: int | None = None,
) -> Section:
    """Compute a surface of section: the states in which motions make an event happen.

    Parameters
    ----------
    system : System
    states : State or sequence of State
        The states in which the motions start.
    event : Event
        The event that defines the surface, from :mod:`fullbody.events`, such as :class:`fullbody.events.Periapsis` or a
        :class:`fullbody.events.Function` with a direction.
    until, duration, threads
        As in :func:`fullbody.integrate_many`.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4_ho2021()
    >>> found = fullbody.analysis.section(system, state, 60.0, fullbody.events.Periapsis(0, 1))
    >>> len(found.crossings[0])
    3
    """
    states = [states] if isinstance(states, State) else states
    starts = sequence(states, State, "states", "a State or several", "States")
    members = [(system, state) for state in starts]
    watched: Event = instance(event, "event", Event, "one of fullbody.events")
    results = integrate_many(members, until, duration=duration, output="ends", events=[watched], threads=threads)
    crossings, errors = [], []
    for result in results:
        if isinstance(result, Exception) and not isinstance(result, FullbodyError):
            raise result
        errors.append(result if isinstance(result, FullbodyError) else None)
        run = result.run if isinstance(result, FullbodyError) else result
        crossings.append(() if run is None else tuple(item.state for item in run.events))
    return Section(system, tuple(crossings), tuple(errors))


@dataclass(frozen=True, eq=False, repr=False)
class Frequencies(ArrayFields):
    """The strongest periodic terms of a quantity along a run.

    Attributes
    ----------
    frequency : ndarray or Quantity, (F,)
        Angular frequencies, the one of largest amplitude first.
    amplitude : ndarray or Quantity, (F,)
        Half of the peak-to-peak size of each term, in the unit of the quantity.
    """

    frequency: Array
    amplitude: Array

    def __repr__(self) -> str:
        return block("Frequencies(", frequency=self.frequency, amplitude=self.amplitude)


def frequencies(run: Record, quantity: Any, *, n: int = 3) -> Frequencies:
    """Find the strongest periodic terms of a quantity along a run.

    Parameters
    ----------
    run : Run
        A run with several samples in the shortest period of interest.
    quantity : array_like or Quantity, (K,), or callable
        The values at the samples of the run, or a function of the run that returns them.
    n : int
        The largest number of terms.

    Notes
    -----
    The method is Laskar's (1990): peaks of the spectrum under a Hann window are refined in turn, and fitted together.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.didymos()
    >>> run = system.integrate(state, 200.0, output=0.5)
    >>> yaw = fullbody.observables.roll_pitch_yaw(run)[:, 2]
    >>> fullbody.analysis.frequencies(run, yaw, n=2).frequency.shape
    (2,)
    """
    time = instance(run, "run", Record, "a fullbody.Run").arrays["time"]
    values = quantity(run) if callable(quantity) else quantity
    unit = getattr(values, "unit", None)
    numbers = UNITLESS.numbers(getattr(values, "value", values), "number", "quantity", time.shape)
    if len(time) < 8:
        raise InvalidInput(f"the run has {len(time)} samples; the frequencies need 8 or more")
    columns, amplitude = periodic_terms(time, numbers, whole_number(n, "n"))
    order = np.argsort(-amplitude)
    sizes: Any = amplitude[order] if unit is None else amplitude[order] << unit
    return Frequencies(run.context.units.attach(columns[order], "spin"), sizes)
