"""The integration of a system: checks of its start and options, and the run made of the core's record."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..base.atomic import replacing
from ..base.progress import Progress, over_time
from ..base.units import scalar
from ..errors import FullbodyError, Interrupted, InvalidInput, caution
from ..events import Event, Occurrence
from ..model.failures import explained, explaining
from ..model.state import State
from ..record.dense import Dense
from ..record.integrators import Integrator, Verner98
from ..record.statistics import Statistics
from .input_warnings import start_warnings
from .options import autosaving, differentiated, sampling, watched
from .run import Run

if TYPE_CHECKING:
    from .system import System

__all__ = ["Task", "begin", "integrate", "prepare", "write"]


def prepare(
    system: System, state: State, integrator: Integrator | None
) -> tuple[_core.State, Integrator, dict[str, Any]]:
    """Check the system, the state and the integrator of a new simulation.

    Returns
    -------
    start : _core.State
        The state in the system's units.
    integrator : Integrator
        The given integrator, or the default one.
    described : dict
        The description of the integrator that the core takes.
    """
    integrator = Verner98() if integrator is None else integrator
    if not isinstance(integrator, Integrator):
        raise InvalidInput(f"integrator is {integrator!r}; expected one of fullbody's, such as Verner98(...)")
    start = system._strip(state)
    return start, integrator, integrator._describe(lambda step: system._units.number(step, "time", "step"))


def begin(system: System, state: State, integrator: Integrator | None) -> tuple[_core.Simulation, Integrator]:
    """Make a simulation of the core, and warn of a start that is probably a mistake."""
    start, integrator, described = prepare(system, state, integrator)
    with explaining(system.context, start, " at the start"):
        core = _core.Simulation(system._core, start, described, json.dumps(system.context.notes))
    for warning in start_warnings(system, start, integrator._tolerance):
        caution(warning)
    return core, integrator


def integrate(
    system: System,
    integrator: Integrator,
    core: _core.Simulation,
    until: Any,
    output: Any,
    *,
    events: Iterable[Event],
    dense: bool,
    progress: Any,
    autosave: tuple[Any, float] | None,
    derivatives: bool | Iterable[str],
    chaos: bool,
) -> Run:
    """Move a simulation of the core to a time; see :meth:`fullbody.System.integrate`."""
    task = Task(system, integrator, core.time, until, output, events, dense, derivatives, chaos)
    path, keep = None, None
    if autosave is not None:
        path, seconds = place = autosaving(autosave)
        keep = (seconds, lambda data: write(place[0], data))
        # A path that cannot be written is reported now, not when the first file is due.
        write(path, core.to_bytes())
    before = core.statistics
    with Progress(progress) as report:
        record, error = core.integrate(
            task.until, task.output, task.conditions, task.dense, over_time(report), keep, task.following
        )
    counts = (now - then for now, then in zip(core.statistics, before, strict=True))
    run = task.run(record, counts)
    if path is not None:
        try:
            write(path, core.to_bytes())
        except OSError as unwritten:
            # An error that ended the run earlier is raised instead.
            error = unwritten if error is None else error
    if error is None:
        return run
    failed = task.failed(error, run, core.time)
    raise failed from failed.__cause__


def write(path: Path, data: bytes) -> None:
    """Write a file atomically."""
    with replacing(path) as temporary:
        temporary.write_bytes(data)


class Task:
    """The checked options of a run from a time, which turn the core's result into a run or an error."""

    def __init__(
        self,
        system: System,
        integrator: Integrator,
        time: float,
        until: Any,
        output: Any,
        events: Iterable[Event],
        dense: bool,
        derivatives: bool | Iterable[str] = False,
        chaos: bool = False,
    ) -> None:
        self._system, self._integrator = system, integrator
        self.until = scalar(system._units.strip(until, "time", "until"), "until")
        self.derivatives = differentiated(derivatives)
        self.output = sampling(output, system._units)
        if isinstance(self.output, float):
            self._refuse_flood((self.until - time) / self.output, until, output)
        self.events = watched(events)
        self.conditions = [event._event_spec(system.context) for event in self.events]
        self.dense = bool(dense)
        #: The parameters of derivatives and whether chaos is measured, as the core takes them.
        self.following = (self.derivatives, bool(chaos))

    def _refuse_flood(self, count: float, until: Any, output: Any) -> None:
        """Raise an error for more samples than the memory can hold, instead of letting the process be killed."""
        numbers = 13 * len(self._system) + 8
        if self.derivatives is not None:
            numbers += 12 * len(self._system) * (12 * len(self._system) + len(self.derivatives))
        most = 2.0**34 / (8.0 * numbers)
        if abs(count) > most:
            raise InvalidInput(
                f"until is {until!r} and output is {output!r}, which ask for {abs(count):.3g} samples; expected a time "
                f"and a spacing with at most {most:.3g}, which take 17 GB"
            )

    def run(self, record: dict[str, Any], counts: Iterable[int]) -> Run:
        """Return the run of a record."""
        system, units = self._system, self._system._units
        parts = ("start", "events", "dense", "stop_reason", "switched_off")
        start, happened, solution, (reason, _), switched_off = (record.pop(name) for name in parts)
        off = zip(system.forces, switched_off, strict=True)
        return Run(
            system,
            self._integrator,
            record,
            np.array(start),
            Statistics(*counts),
            events=[
                Occurrence(self.events[index], units.attach(time, "time"), system._state(state), derivatives)
                for index, time, state, derivatives in happened
            ],
            stop_reason=reason,
            dense=None if solution is None else Dense(system, solution),
            switched_off={force.name: times for force, times in off if times is not None},
            parameters=tuple(self.derivatives or ()),
        )

    def failed(self, error: BaseException, run: Run, time: float) -> BaseException:
        """Return the error that ended a run at a time, with the run so far in its attribute ``run``."""
        error = explained(error, self._system.context)
        if isinstance(error, KeyboardInterrupt):
            # This is also the case if Ctrl-C arrived within a function of the caller.
            run.stop_reason = "interrupted"
            error = Interrupted(f"interrupted at time {time}; the run so far is in .run")
        if isinstance(error, FullbodyError):
            # A copy of the error is kept: with the error itself, the two would refer to each other and stay in memory
            # until Python's search for cycles.
            run.error = type(error)(*error.args)
        with contextlib.suppress(AttributeError):
            error.run = run  # type: ignore[attr-defined]
        return error
