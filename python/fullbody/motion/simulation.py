"""The stepping object behind :meth:`fullbody.System.integrate`."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterable, Iterator
from typing import Any, TypeAlias

import numpy as np

import fullbody._core as _core

from ..base.atomic import as_path, content, other_reader
from ..base.attributes import Attribute, WithUnit
from ..base.limits import Limits
from ..errors import FullbodyError, InvalidInput
from ..events import Event
from ..model.description import functions
from ..model.failures import explaining
from ..model.force import Force, forces_of
from ..model.interactions import Invariants
from ..model.state import State, strip, wrap
from ..record import conserved
from ..record.integrators import Integrator, rebuild
from ..record.record import Statistics
from ..typing import Scalar
from .integration import Task, advance, begin, write
from .run import Run
from .system import System, system_of

#: A second name of the core's class, since the class below has a property with the module's name.
_Core: TypeAlias = _core.Simulation


class Simulation:
    """A system at a state, which is integrated step by step or run by run, forwards or backwards.

    Parameters
    ----------
    system : System
    state : State
    integrator : Integrator, optional
        The integrator; by default :class:`fullbody.Verner98`.

    Warns
    -----
    InconsistentInput
        If a body at the start is more than ten times as fast as its speed of escape, if a heavy body is a thousand
        times as far from others as these are from each other, and if a body turns by more than a radian within the lag
        of a tide.

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

    def __init__(self, system: System, state: State, *, integrator: Integrator | None = None) -> None:
        if not isinstance(system, System):
            raise InvalidInput(f"system is {system!r}; expected a System")
        self._system = system
        self._idle, self._integrator = begin(system.context, state, integrator)

    #: Whether a run or a step is under way; functions that are called in one may not use the simulation.
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

    system = Attribute[System]("_system", "The system.")
    integrator = Attribute[Integrator]("_integrator", "The integrator with its settings.")
    time = WithUnit[Scalar]("Present time.", "_core.time", "time")

    @property
    def state(self) -> State:
        """Present state; setting it starts the integration anew from there."""
        return wrap(self._core.state, self._system.context)

    @state.setter
    def state(self, state: State) -> None:
        core = strip(state, self._system.context)
        with explaining(self._system.context, core):
            self._core.set_state(core)

    statistics = Attribute[Statistics](lambda sim: Statistics(*sim._core.statistics), "Counts since the start.")
    start = Attribute[Invariants](
        lambda sim: conserved.named(sim._core.start, sim._system.context.units),
        "Time, energy and angular momentum at the state with which the simulation began or to which it was last set.",
    )
    energy_drift = Attribute[float](
        lambda sim: sim._drift("energy_drift"),
        """Change of the total energy since the start of the simulation, relative to its value there unless it is zero.

        That of a run, in contrast, is relative to the start of that run.
        """,
    )
    energy_drift_orbital = Attribute[float](
        lambda sim: sim._drift("energy_drift_orbital"),
        "Change of the total energy since the start, relative to abs(potential + translational) there.",
    )
    angular_momentum_drift = Attribute[float](
        lambda sim: sim._drift("angular_momentum_drift"),
        "Length of the change of the angular momentum since the start, relative to its length there.",
    )

    def _drift(self, name: str) -> float:
        invariants, sums = np.array([self._core.invariants]), np.array(self._core.work_and_impulse).reshape(1, -1, 7)
        record = {"energy": invariants[:, 1:5], "angular_momentum": invariants[:, 5:]}
        record |= {"work": sums[..., 0], "angular_impulse": sums[..., 4:]}
        return float(conserved.drift(name, np.array(self._core.start), record)[0])

    @property
    def quadrature(self) -> list[dict[str, Any]]:
        """The quadrature of each pair of bodies, and for composites of each pair of parts, but for pairs of points.

        Each is a dictionary: ``pair`` has the names of the bodies, ``parts`` the indices of the parts if one of these
        is a composite, ``method`` the method in use (``"harmonic"`` where the default takes the series), ``integrated``
        the name of the body integrated over, ``points`` the number of points at the present state, and ``order`` the
        order of the rule; the last three are None for a series.
        """
        names = self._system.names
        rows = []
        for (i, j), parts, method, rule in self._core.rules:
            integrated, points, order = rule or (None, None, None)
            row = {"pair": (names[i], names[j]), "parts": None if parts is None else tuple(parts), "method": method}
            name = None if integrated is None else names[integrated]
            rows.append({**row, "integrated": name, "points": points, "order": order})
        return rows

    def step(self, until: Any = float("inf")) -> None:
        """Take one accepted step towards a time, but never beyond it; no step is taken if it is the present time."""
        end = self._system.context.units.number(until, "time", "until", Limits(infinite=True, text="a number"))
        if end == self._core.time:
            return
        # The default is far away but finite, so that differences of times stay numbers.
        with self._run() as core, explaining(self._system.context):
            core.step(float(np.clip(end, -1e300, 1e300)))

    def integrate(
        self,
        until: Any = None,
        *,
        duration: Any = None,
        output: Any = None,
        events: Iterable[Event] = (),
        dense: bool = False,
        progress: Any = False,
        autosave: tuple[Any, float] | None = None,
        derivatives: bool | Iterable[str] = False,
        chaos: bool = False,
    ) -> Run[System]:
        """Integrate to a time, or for a duration, and record the run; see :meth:`fullbody.System.integrate`.

        Derivatives and chaos indicators start at the state at which this call begins; files of the simulation do not
        contain them.
        """
        options: dict[str, Any] = {"duration": duration, "output": output, "events": events}
        options |= {"dense": dense, "derivatives": derivatives, "chaos": chaos}
        with self._run() as core:
            task = Task(self._system, self._integrator, core.time, until, **options)
            return advance(core, task, progress, autosave)

    def save(self, path: Any) -> None:
        """Write the simulation to a file, exactly and atomically; :meth:`load` of the same version of fullbody reads
        it.

        A run that continues from the file equals the uninterrupted run bit for bit, on a machine with the same vector
        instructions (or with ``vector_path="portable"``). Links and permissions are kept as by
        :meth:`fullbody.Run.save`.
        """
        write(as_path(path), self._core.to_bytes())

    @classmethod
    def load(cls, path: Any, forces: Iterable[Force] = ()) -> Simulation:
        """Read a simulation that :meth:`save` wrote.

        Parameters
        ----------
        path : str or Path
        forces : iterable of Force
            The :class:`fullbody.forces.Function` forces of the simulation, with the same names, since files do not keep
            functions.

        Raises
        ------
        InvalidInput
            If the file is not a simulation, is truncated or altered, or was written by another version with another
            layout; the message says what is wrong.
        OSError
            If there is no such file, or if it cannot be read.
        """
        path = as_path(path)
        try:
            return cls._from_bytes(content(path), forces_of(forces))
        except InvalidInput as error:
            other = other_reader(path, "fullbody.Simulation.load")
            raise InvalidInput(f"{path} is not a readable simulation of fullbody: {error}{other}") from error

    @classmethod
    def _from_bytes(cls, data: bytes, forces: tuple[Force, ...] = ()) -> Simulation:
        described, text = _core.Simulation.described(data)
        required = (force for force in described["forces"] if force["kind"] == "Function")
        stored = {force["name"]: force["depends_on_velocity"] for force in required}
        replacements = {force.name: force for force in forces}
        if stored.keys() != replacements.keys():
            expected = f"expected the functions {sorted(stored)}, which the file cannot keep"
            raise InvalidInput(f"forces is {sorted(replacements)}; {expected}")
        for name, force in replacements.items():
            if (kind := type(force).__name__) != "Function":
                raise InvalidInput(f"{name} is a {kind}; expected the Function that the file cannot keep")
            if force.depends_on_velocity != stored[name]:
                setting = f"depends_on_velocity of {name} is {force.depends_on_velocity}"
                raise InvalidInput(f"{setting}; expected {stored[name]}, as in the file")
        try:
            notes = json.loads(text) if text else {}
            system = system_of({**described, "notes": notes}, replacements)
            integrator = rebuild(described["integrator"])
        except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
            # Errors of many kinds are possible, since the notes may be any JSON.
            raise InvalidInput(f"the notes of the simulation are damaged: {error}") from error
        calls = {name: call.core_arguments() for name, call in system.context.calls.items()}
        sim = cls.__new__(cls)
        sim._system, sim._integrator, sim._idle = system, integrator, _core.Simulation.from_bytes(data, calls)
        return sim

    def __deepcopy__(self, memo: Any) -> Simulation:
        make, arguments = self.__reduce__()
        return make(*arguments)

    def __reduce__(self) -> Any:
        return (Simulation._from_bytes, (self._core.to_bytes(), tuple(functions(self._system).values())))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Simulation):
            return NotImplemented
        return self._core.to_bytes() == other._core.to_bytes()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Simulation({self._system!r}, time={self.time}, integrator={self._integrator!r})"
