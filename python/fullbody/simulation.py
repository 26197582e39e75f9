"""The stepping object behind :meth:`fullbody.System.integrate`."""

from __future__ import annotations

import contextlib
import copy
import json
import warnings
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from . import _core
from ._arguments import named_options
from ._doubts import of_start
from ._files import replacing
from ._overlap import explained, explaining
from ._units import Units, scalar
from .dense import Dense
from .errors import BodiesOverlap, FullbodyError, Interrupted, InvalidInput, caution
from .events import Event, Occurrence
from .integrators import Integrator, Verner98, rebuild
from .run import Run, Statistics
from .state import State
from .system import System
from .typing import Scalar

__all__ = ["Simulation"]

#: Under a name of its own, since the class has a property of the module's.
_Core: TypeAlias = _core.Simulation
_MAGIC = b"fullbody simulation\n"


@named_options
class Simulation:
    """A system at a state, to be moved step by step or run by run, forwards or backwards.

    Parameters
    ----------
    system : System
    state : State
    integrator : Integrator, optional
        :class:`fullbody.Verner98` unless given.

    Warns
    -----
    InconsistentInput
        For a start in which a body is ten times as fast as what could escape, and for a heavy body a thousand times as
        far from others as these are from each other.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> sim = fullbody.Simulation(system, state)
    >>> run = sim.integrate(10.0)
    >>> run = sim.integrate(0.0)
    >>> sim.time
    0.0
    """

    def __init__(self, system: System, state: State, integrator: Integrator | None = None) -> None:
        if not isinstance(system, System):
            raise InvalidInput(f"system is {system!r}; expected a System")
        integrator = Verner98() if integrator is None else integrator
        if not isinstance(integrator, Integrator):
            raise InvalidInput(f"integrator is {integrator!r}; expected one of fullbody's, such as Verner98(...)")
        self._system = system
        self._integrator = integrator
        start = system._strip(state)
        with explaining(system, lambda: start, " at the start"):
            self._idle = _core.Simulation(system._core, start, *integrator._arguments(self._time_of_step))
        for doubt in of_start(system, start, integrator._tolerance):
            caution(doubt)

    #: Whether a run or a step is under way; what is called from within one may not touch it.
    _running = False

    @property
    def _core(self) -> _Core:
        if self._running:
            raise FullbodyError(
                "the simulation is in the middle of a run; expected it to be used between runs (a function that is "
                "called in one is given the time or the state)"
            )
        return self._idle

    @contextlib.contextmanager
    def _run(self) -> Iterator[_Core]:
        core, self._running = self._core, True
        try:
            yield core
        finally:
            self._running = False

    def _time_of_step(self, step: Any) -> float:
        return self._system._units.number(step, "time", "step")

    @property
    def system(self) -> System:
        """The system."""
        return self._system

    @property
    def integrator(self) -> Integrator:
        """The integrator with its settings."""
        return self._integrator

    @property
    def time(self) -> Scalar:
        """Present time."""
        time: Scalar = self._system._units.attach(self._core.time, "time")
        return time

    @property
    def state(self) -> State:
        """Present state; setting it starts the integration anew from there."""
        return State._wrap(self._core.state, self._system._units)

    @state.setter
    def state(self, state: State) -> None:
        core = self._system._strip(state)
        with explaining(self._system, lambda: core):
            self._core.set_state(core)

    @property
    def statistics(self) -> Statistics:
        """Counts since the start."""
        return Statistics(*self._core.statistics)

    @property
    def quadrature(self) -> list[dict[str, Any]]:
        """The quadrature in force for each pair: bodies, the one integrated over, number of points, order."""
        names = self._system.names
        return [
            {"pair": (names[i], names[j]), "integrated": names[k], "points": points, "order": order}
            for i, j, k, points, order in self._core.rules
        ]

    def time_interaction(self, number: int = 1000, repeats: int = 5) -> float:
        """Shortest time of one interaction of the first pair at the present state, seconds; for benchmarks.

        Parameters
        ----------
        number, repeats : int
            Evaluations in a measurement, and measurements of which the shortest counts.
        """
        return self._core.time_interaction(number, repeats)

    def time_evaluation(self, number: int = 1000, repeats: int = 5) -> float:
        """Shortest time of one evaluation of all rates of change at the present state, seconds; for benchmarks.

        Parameters
        ----------
        number, repeats : int
        """
        return self._core.time_evaluation(number, repeats)

    def step(self, until: Any = float("inf")) -> None:
        """Take one accepted step towards a time, never beyond it; none where it is the present one."""
        end = scalar(self._system._units.strip(until, "time", "until"), "until")
        if np.isnan(end):
            raise InvalidInput(f"until is {until!r}; expected a number")
        if end == self._core.time:
            return
        # Far, but finite, so that differences of times stay numbers.
        try:
            with self._run() as core:
                core.step(float(np.clip(end, -1e300, 1e300)))
        except BodiesOverlap as error:
            raise explained(error, self._system, None) from None

    def integrate(
        self,
        until: Any,
        output: Any = None,
        *,
        events: Iterable[Event] = (),
        dense: bool = False,
        progress: Any = False,
        autosave: tuple[Any, float] | None = None,
    ) -> Run:
        """Move to a time and record; see :meth:`fullbody.System.integrate`.

        Parameters
        ----------
        until : float or Quantity
        output : None, float, Quantity or array_like
        events : iterable of Event
        dense : bool
        progress : bool, str or callable
        autosave : (path, seconds), optional
            Writes the simulation to a file when the run begins, every so many seconds, and when it ends, whatever ends
            it; :meth:`load` goes on from it. A file that cannot be written ends the run with an OSError.

        Returns
        -------
        Run
        """
        units = self._system._units
        end = scalar(units.strip(until, "time", "until"), "until")
        spacing, times = _output(output, units)
        if spacing is not None:
            self._refuse_flood((end - self._core.time) / spacing, output)
        watched = _events(events)
        described = [event._describe(self._system) for event in watched]
        keep = None
        if autosave is not None:
            path, seconds = _autosave(autosave)
            keep = (seconds, lambda data: self._write(path, data))
            # A place that cannot be written in is known now, not when the first file is due.
            self.save(path)
        before = self._core.statistics
        with _Bar(progress) as report, self._run() as core:
            record, error = core.integrate(end, spacing, times, described, bool(dense), report, keep)
        counts = Statistics(*(now - then for now, then in zip(self._core.statistics, before, strict=True)))
        happened, solution, (reason, _) = (record.pop(name) for name in ("events", "dense", "stop_reason"))
        run = Run(self._system, record, counts, self._integrator)
        run.events = [
            Occurrence(watched[index], units.attach(time, "time"), State._wrap(state, units))
            for index, time, state in happened
        ]
        run.dense = None if solution is None else Dense(self._system, solution)
        run.stop_reason = reason
        if autosave is not None:
            try:
                self.save(path)
            except OSError as unwritten:
                # What ended the run before that is told instead.
                error = unwritten if error is None else error
        if error is None:
            return run
        if isinstance(error, KeyboardInterrupt):
            interrupted = Interrupted(f"interrupted at time {self._core.time}; the run so far is in .run")
            interrupted.run = run
            raise interrupted from None
        if isinstance(error, BodiesOverlap):
            error = explained(error, self._system, None)
        # Nothing is lost: whatever cut the run short carries what there is of it.
        with contextlib.suppress(AttributeError):
            error.run = run  # type: ignore[attr-defined]
        raise error

    def _refuse_flood(self, count: float, output: Any) -> None:
        """Refuse more samples than a computer holds, rather than have the system end the process."""
        size = abs(count) * 8.0 * (13 * len(self._system) + 8)
        most = 2.0**34
        if size > most:
            raise InvalidInput(
                f"output is {output!r}, which asks for {abs(count):.3g} samples ({size / 1e9:.3g} GB); "
                f"expected a spacing with fewer than {abs(count) * most / size:.3g}"
            )

    def save(self, path: Any) -> None:
        """Write the simulation to a file, exactly and atomically; :meth:`load` reads it.

        A run that goes on from the file equals the unbroken one bit for bit, on a machine with the same vector
        instructions (or with ``vector_path="portable"``).

        Parameters
        ----------
        path : str or Path
        """
        self._write(Path(path), self._core.to_bytes())

    @classmethod
    def load(cls, path: Any) -> Simulation:
        """Read what :meth:`save` wrote.

        Parameters
        ----------
        path : str or Path

        Returns
        -------
        Simulation

        Raises
        ------
        InvalidInput
            For a file that is not a simulation, is truncated or has been altered; says what is wrong.
        """
        try:
            return cls._from_bytes(Path(path).read_bytes())
        except InvalidInput as error:
            raise InvalidInput(f"{path} is not a readable simulation of fullbody: {error}") from error

    def _to_bytes(self, core: bytes) -> bytes:
        # The core's archive has a checksum of its own; the line before it is what this package knows, with its own.
        system = self._system
        head = {"system": system._describe(), "integrator": self._integrator._describe(self._time_of_step)}
        line = json.dumps(head).encode()
        return _MAGIC + b"%08x " % zlib.crc32(line) + line + b"\n" + core

    @classmethod
    def _from_bytes(cls, data: bytes) -> Simulation:
        if not data.startswith(_MAGIC):
            raise InvalidInput("it does not begin like one")
        line, found, core = data[len(_MAGIC) :].partition(b"\n")
        if not found:
            raise InvalidInput("it is truncated within its first lines")
        checksum, _, head = line.partition(b" ")
        if checksum != b"%08x" % zlib.crc32(head):
            raise InvalidInput("its first lines have been altered: their checksum does not fit")
        try:
            described = json.loads(head)
            system, integrator = System._rebuild(described["system"]), rebuild(described["integrator"])
        except (ValueError, KeyError, TypeError) as error:
            raise InvalidInput(f"its first lines are damaged: {error}") from error
        sim = cls.__new__(cls)
        sim._system, sim._integrator = system, integrator
        sim._idle = _core.Simulation.from_bytes(core)
        return sim

    def _write(self, path: Path, core: bytes) -> None:
        with replacing(path) as temporary:
            temporary.write_bytes(self._to_bytes(core))

    def __deepcopy__(self, memo: Any) -> Simulation:
        return Simulation._from_bytes(self._to_bytes(self._core.to_bytes()))

    def __copy__(self) -> Simulation:
        return copy.deepcopy(self)

    def __reduce__(self) -> Any:
        return (Simulation._from_bytes, (self._to_bytes(self._core.to_bytes()),))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Simulation):
            return NotImplemented
        first, second = (sim._to_bytes(sim._core.to_bytes()) for sim in (self, other))
        return first == second

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Simulation({self._system!r}, time={self.time}, integrator={self._integrator!r})"


def _output(output: Any, units: Units) -> tuple[float | None, Any]:
    """Spacing or times."""
    if output is None:
        return None, None
    if isinstance(output, bool):
        raise InvalidInput(f"output is {output!r}; expected None, a spacing above zero, or times")
    values = units.strip(output, "time", "output")
    if values.ndim > 1:
        raise InvalidInput(f"output has shape {values.shape}; expected a number or (K,)")
    if values.ndim == 1:
        return None, values
    if not values > 0.0:
        raise InvalidInput(f"output is {output!r}; expected a spacing above zero, or times")
    return float(values), None


def _autosave(autosave: Any) -> tuple[Path, float]:
    """Where to write and how often, refused before the run starts."""
    try:
        where, every = autosave
        path, seconds = Path(where), float(every)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"autosave is {autosave!r}; expected (path, seconds)") from error
    if not 0.0 <= seconds < 1e9:
        raise InvalidInput(f"seconds of autosave is {seconds!r}; expected a number from 0 to below 1e9")
    return path, seconds


def _events(events: Iterable[Event]) -> list[Event]:
    if isinstance(events, str):
        raise InvalidInput(f"events is {events!r}, which is text; expected a list of fullbody.events")
    try:
        watched = list(events)
    except TypeError as error:
        raise InvalidInput(f"events is {events!r}; expected a list of fullbody.events") from error
    for event in watched:
        if not isinstance(event, Event):
            raise InvalidInput(f"events has {event!r}; expected fullbody.events")
    return watched


class _Bar:
    """A progress bar as a context; gives what the core is to call, or ``None``."""

    def __init__(self, progress: Any) -> None:
        self._progress = progress
        self._bar: Any = None
        self._end = ""

    def __enter__(self) -> Any:
        if not self._progress:
            return None
        if callable(self._progress):
            return self._progress
        from tqdm import TqdmWarning

        with warnings.catch_warnings():
            # In Jupyter without ipywidgets the bar is one of text, which needs no warning.
            warnings.simplefilter("ignore", TqdmWarning)
            from tqdm.auto import tqdm

        layout = "{l_bar}{bar}| {elapsed}<{remaining}{postfix}"
        label = self._progress if isinstance(self._progress, str) else None
        self._bar = tqdm(total=1.0, desc=label, bar_format=layout)
        return self._update

    def _update(self, start: float, time: float, end: float) -> None:
        self._bar.n = (time - start) / (end - start)
        # Time of the system passed a second of the clock.
        rate = abs(time - start) / max(self._bar.format_dict["elapsed"], 1e-9)
        self._end = f"t = {end:.6g}, {rate:.3g}/s"
        self._bar.set_postfix_str(f"t = {time:.6g}, {rate:.3g}/s", refresh=False)
        self._bar.refresh()

    def __exit__(self, kind: object, *_: object) -> None:
        if self._bar is not None:
            if kind is None:
                self._bar.n = 1.0
                self._bar.set_postfix_str(self._end, refresh=False)
            self._bar.close()
