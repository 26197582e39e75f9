"""What a run is asked to do, in numbers of its system's units, and the run that becomes of it."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from typing import Any, TypeVar

import numpy as np

from .. import _core
from ..base.units import scalar
from ..errors import BodiesOverlap, FullbodyError, Interrupted, InvalidInput
from ..events import Event, Occurrence
from ..model.state import State
from ..model.system import BaseSystem
from ..record.base import BaseRun
from ..record.dense import Dense
from ..record.integrators import Integrator, Verner98
from ..record.statistics import Statistics
from .options import differentiated, sampling, watched

__all__ = ["Task", "beginning"]

_Run = TypeVar("_Run", bound=BaseRun)


def beginning(
    system: BaseSystem, state: State, integrator: Integrator | None
) -> tuple[_core.State, Integrator, dict[str, Any]]:
    """What a simulation begins with, checked: the state in the system's units, the integrator and its description."""
    if not isinstance(system, BaseSystem):
        raise InvalidInput(f"system is {system!r}; expected a System")
    integrator = Verner98() if integrator is None else integrator
    if not isinstance(integrator, Integrator):
        raise InvalidInput(f"integrator is {integrator!r}; expected one of fullbody's, such as Verner98(...)")
    start = system._strip(state)
    return start, integrator, integrator._describe(lambda step: system._units.number(step, "time", "step"))


class Task:
    """The options of a run from a time, checked, and what the core makes of them turned into a run or an error."""

    def __init__(
        self,
        system: BaseSystem,
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
            self._refuse_flood((self.until - time) / self.output, output)
        self.events = watched(events)
        self.conditions = [event._watched(system) for event in self.events]
        self.dense = bool(dense)
        #: What is followed beside the run, as the core takes it.
        self.following = (self.derivatives, bool(chaos))

    def _refuse_flood(self, count: float, output: Any) -> None:
        """Refuse more samples than a computer holds, rather than have the system end the process."""
        numbers = 13 * len(self._system) + 8
        if self.derivatives is not None:
            numbers += 12 * len(self._system) * (12 * len(self._system) + len(self.derivatives))
        size = abs(count) * 8.0 * numbers
        most = 2.0**34
        if size > most:
            raise InvalidInput(
                f"output is {output!r}, which asks for {abs(count):.3g} samples ({size / 1e9:.3g} GB); "
                f"expected a spacing with fewer than {abs(count) * most / size:.3g}"
            )

    def run(self, kind: type[_Run], record: dict[str, Any], counts: Iterable[int]) -> _Run:
        """The run of a record."""
        system, units = self._system, self._system._units
        parts = ("start", "events", "dense", "stop_reason", "switched_off")
        start, happened, solution, (reason, _), switched_off = (record.pop(name) for name in parts)
        run = kind(system, record, Statistics(*counts), self._integrator)
        run._start = None if start is None else np.array(start)
        run.events = [
            Occurrence(self.events[index], units.attach(time, "time"), system._state(state))
            for index, time, state in happened
        ]
        run.dense = None if solution is None else Dense(system, solution)
        run.stop_reason = reason
        run._parameters = tuple(self.derivatives or ())
        off = zip(system.forces, switched_off, strict=True)
        run.switched_off = {force.name: times for force, times in off if times is not None}
        return run

    def failed(self, error: BaseException, run: BaseRun, time: float) -> BaseException:
        """What cut a run short at a time, with the run so far: nothing is lost."""
        error = self._system._caused(error)
        if isinstance(error, KeyboardInterrupt):
            # This holds too where Ctrl-C came within a function of the caller's.
            run.stop_reason = "interrupted"
            error = Interrupted(f"interrupted at time {time}; the run so far is in .run")
        if isinstance(error, BodiesOverlap):
            error = self._system._explained(error, None)
        if isinstance(error, FullbodyError):
            # Another one, or neither would be given back before Python looks for circles.
            run.error = type(error)(*error.args)
        with contextlib.suppress(AttributeError):
            error.run = run  # type: ignore[attr-defined]
        return error
