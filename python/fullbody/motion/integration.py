"""The integration of a system, and of particles among its bodies: checks of start and options, and the result."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.arguments import names_of, sequence
from ..base.atomic import as_path, replacing
from ..base.progress import Progress, over_time
from ..errors import Interrupted, InvalidInput, caution, keep_result
from ..events import Event, Occurrence
from ..model.context import Context, S
from ..model.failures import explained, explaining
from ..model.state import State, strip, wrap
from ..particles.events import ParticleEvent
from ..particles.flight import Flight
from ..particles.initial import Particles
from ..particles.rules import Bounce, EscapeDistance, Radiation
from ..particles.task import FlightTask
from ..record.dense import Dense
from ..record.integrators import Integrator, Verner98
from ..record.record import Statistics
from ..record.times import end_of_run, refuse_flood, sampling, spacing_warning
from .input_warnings import start_warnings
from .run import Run


def integrate(
    system: S,
    state: State,
    until: Any = None,
    *,
    duration: Any = None,
    output: Any = None,
    integrator: Integrator | None = None,
    events: Iterable[Event] = (),
    dense: bool = False,
    progress: Any = False,
    autosave: tuple[Any, float] | None = None,
    derivatives: bool | Iterable[str] = False,
    chaos: bool = False,
) -> Run[S]:
    """Integrate the motion from a state to a time.

    Parameters
    ----------
    state : State
    until, duration : float, Quantity or text with a unit
        End of the run, a time; or its length, such as ``"30 day"``. A time before ``state.time`` and a length below
        zero make a run backwards.
    output : None, "ends", float, Quantity or array_like
        The times that are recorded. ``None`` means every accepted step, ``"ends"`` the start and the end, a number the
        spacing of times from the start to the end, and an array exactly these times; with an empty array only events
        (and ``dense``) are recorded.
    integrator : Integrator, optional
        :class:`fullbody.Verner98` unless given.
    events : iterable of Event
        Events to detect, from :mod:`fullbody.events`; a terminal one ends the run.
    dense : bool
        Whether the run is kept as a function of time, ``run(t)``, which takes 2.3 kB per step for two bodies.
    progress : bool, str or callable
        ``True`` or a title for a progress bar, or a function of (done, total, description) that is called at most every
        50 ms, with the time that has passed and the length of the run. An error that it raises ends the run.
    autosave : (path, seconds), optional
        The path of a file and an interval. The simulation is written to the file when the run begins, at this interval
        and when the run ends for whatever reason; :meth:`fullbody.Simulation.load` continues from it. A file that
        cannot be written ends the run with an OSError.
    derivatives : bool or sequence of str
        Whether the run is differentiated with respect to its start, for ``run.transition``; or the names from
        ``system.parameters`` by which it is differentiated as well, for ``run.sensitivity``. The motion itself has the
        same bits with and without derivatives.
    chaos : bool
        Whether tangent growth is measured, for ``run.megno``, ``run.lyapunov`` and ``run.fast_lyapunov``.

    Returns
    -------
    Run

    Raises
    ------
    InvalidInput, BodiesOverlap, NotConverged, StepSizeTooSmall, ChartSingularity
        If an error ends the run; the run so far is in its attribute ``run``.
    Interrupted
        On Ctrl-C; it is a KeyboardInterrupt with the run so far in its attribute ``run``.

    Warns
    -----
    InconsistentInput
        For starts that are probably a mistake, see :class:`fullbody.Simulation`; for a text as ``until`` that is a time
        before the start; and for a spacing that is longer than the run.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> run = system.integrate(state, 10.0, output=1.0)
    >>> run.position.shape
    (11, 2, 3)
    """
    core, chosen = begin(system.context, state, integrator)
    options: dict[str, Any] = {"duration": duration, "output": output, "events": events}
    options |= {"dense": dense, "derivatives": derivatives, "chaos": chaos}
    return advance(core, Task(system, chosen, core.time, until, **options), progress, autosave)


def integrator_of(integrator: Integrator | None) -> Integrator:
    """Return the integrator, the default one for ``None``, or raise an error for another object."""
    integrator = Verner98() if integrator is None else integrator
    if not isinstance(integrator, Integrator):
        raise InvalidInput(f"integrator is {integrator!r}; expected one of fullbody's, such as Verner98(...)")
    return integrator


def begin(context: Context, state: State, integrator: Integrator | None) -> tuple[_core.Simulation, Integrator]:
    """Make a simulation of the core, and warn of a start that is probably a mistake."""
    integrator, start = integrator_of(integrator), strip(state, context)
    with explaining(context, start, " at the start"):
        core = _core.Simulation(context.core, start, integrator._describe(context.units), json.dumps(context.notes))
    for warning in start_warnings(context, start, integrator._tolerance):
        caution(warning)
    return core, integrator


def advance(core: _core.Simulation, task: Task, progress: Any, autosave: tuple[Any, float] | None) -> Any:
    """Move a simulation of the core through a task, and return the run."""
    path, saving = None, None
    if autosave is not None:
        path, seconds = target = _autosaving(autosave)
        saving = (seconds, lambda data: write(target[0], data))
        # A path that cannot be written is reported now, not when the first file is due.
        write(path, core.to_bytes())
    if (warning := spacing_warning(task.output, task.until - core.time, task.context.units)) is not None:
        caution(warning)
    previous = core.statistics
    with Progress(progress) as report:
        options = task.until, task.output, task.conditions, task.dense
        arrays, error = core.integrate(*options, over_time(report), saving, task.following)
    counts = (count - previous_count for count, previous_count in zip(core.statistics, previous, strict=True))
    run = task.run(arrays, counts)
    if path is not None:
        try:
            write(path, core.to_bytes())
        except OSError as write_error:
            # An error that ended the run earlier is raised instead.
            error = write_error if error is None else error
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
        system: Any,
        integrator: Integrator,
        start: float,
        until: Any = None,
        *,
        duration: Any = None,
        output: Any = None,
        events: Iterable[Event] = (),
        dense: bool = False,
        derivatives: bool | Iterable[str] = False,
        chaos: bool = False,
    ) -> None:
        self._system, self._integrator = system, integrator
        self.context: Context = system.context
        self.until = end_of_run(until, duration, start, self.context.units)
        self.derivatives = differentiated(derivatives)
        self.output = sampling(output, self.context.units)
        bodies, parameters = len(self.context), self.derivatives
        derived = 0 if parameters is None else 12 * bodies * (12 * bodies + len(parameters))
        refuse_flood(self.output, start, self.until, 13 * bodies + 8 + derived, self.context.units)
        self.events = watched(events)
        self.conditions = [event._event_spec(self.context) for event in self.events]
        self.dense = bool(dense)
        #: The parameters of derivatives and whether chaos is measured, as the core takes them.
        self.following = (self.derivatives, bool(chaos))

    def run(self, arrays: dict[str, Any], counts: Iterable[int]) -> Run[Any]:
        """Return the run of the core's arrays."""
        context = self.context
        parts = ("start", "events", "dense", "stop_reason", "switched_off")
        start, happened, solution, (reason, _), switched_off = (arrays.pop(name) for name in parts)
        off = zip(context.forces, switched_off, strict=True)
        options: dict[str, Any] = {"stop_reason": reason, "parameters": tuple(self.derivatives or ())}
        options["switched_off"] = {force: times for force, times in off if times is not None}
        options["events"] = [
            Occurrence(self.events[index], context.units.attach(time, "time"), wrap(state, context), derivatives)
            for index, time, state, derivatives in happened
        ]
        dense = None if solution is None else Dense(context, solution)
        return Run(self._system, self._integrator, arrays, np.array(start), Statistics(*counts), dense=dense, **options)

    def failed(self, error: BaseException, run: Run[Any], time: float) -> BaseException:
        """Return the error that ended a run at a time, with the run so far in its attribute ``run``."""
        error = explained(error, self.context)
        if isinstance(error, KeyboardInterrupt):
            # This is also the case if Ctrl-C arrived within a function of the caller.
            run.stop_reason = "interrupted"
            error = Interrupted(f"interrupted at time {time}; the run so far is in .run")
        keep_result(error, "run", run)
        return error


def watched(events: Iterable[Event]) -> list[Event]:
    """Return the events as a list, or raise an error for an object that is no event."""
    if isinstance(events, str):
        raise InvalidInput(f"events is {events!r}, which is text; expected a list of fullbody.events")
    return list(sequence(events, Event, "events", "a list of fullbody.events", "fullbody.events"))


def differentiated(derivatives: Any) -> list[str] | None:
    """Return the parameters by which a run is differentiated, or ``None`` if it is not differentiated."""
    if isinstance(derivatives, bool):
        return [] if derivatives else None
    return names_of(derivatives, "derivatives")


def _autosaving(autosave: Any) -> tuple[Path, float]:
    """Return the path to write to, and the number of seconds between two files."""
    try:
        where, every = autosave
        path, seconds = as_path(where), float(every)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"autosave is {autosave!r}; expected (path, seconds)") from error
    if not 0.0 <= seconds < 1e9:
        raise InvalidInput(f"seconds of autosave is {seconds!r}; expected a number from 0 to below 1e9")
    return path, seconds


def fly(
    system: S,
    state: State,
    particles: Particles,
    until: Any = None,
    *,
    duration: Any = None,
    output: Any = None,
    integrator: Integrator | None = None,
    contact: str | Bounce = "stop",
    escape: EscapeDistance | None = None,
    radiation: Radiation | None = None,
    events: Iterable[ParticleEvent] = (),
    bodies_integrator: Integrator | None = None,
    threads: int | None = None,
    progress: Any = False,
) -> Flight[S]:
    """Fly massless particles among the bodies, from a state to a time.

    The bodies are integrated first, as by :meth:`integrate`, and the particles are integrated along their continuous
    solution, which takes 2.3 kB per step for two bodies. For several flights along the same motion, keep a run with
    ``dense=True`` and use :meth:`fullbody.Run.fly`, where the other parameters are described.

    Parameters
    ----------
    state : State
        State of the bodies at the particles' time.
    particles : Particles
    until, duration : float, Quantity or text with a unit
        End of the flight, before ``state.time`` for a flight backwards, or its length.
    bodies_integrator : Integrator, optional
        Integrator of the bodies, as in :meth:`integrate`.

    Raises
    ------
    InvalidInput, Interrupted
        For the same reasons as :meth:`fullbody.Run.fly` and :meth:`integrate`.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> up = fullbody.Particles.from_surface(system, state, "Beta", longitude=0.0, latitude=0.5, speed=0.1)
    >>> system.fly(state, up, 24.0).fate.tolist()
    ['impact']
    """
    options: dict[str, Any] = {"integrator": integrator, "contact": contact, "escape": escape}
    options |= {"radiation": radiation, "events": events, "threads": threads}
    # Options that are refused are refused before the bodies move.
    task = FlightTask(system.context, particles, **options)
    sampling(output, system.context.units)
    options = {"output": [], "integrator": bodies_integrator, "dense": True, "progress": progress and "bodies"}
    dense = integrate(system, state, until, duration=duration, **options).continuous()
    start, end = dense.range
    with Progress(progress if callable(progress) else progress and "particles") as report:
        return task.fly(system, dense, start, end, None, output, report)
