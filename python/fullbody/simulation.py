"""The stepping object behind :meth:`fullbody.System.integrate`."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import _core
from ._units import scalar
from .errors import FullbodyError, Interrupted, InvalidInput
from .integrators import Verner98
from .run import Run, Statistics
from .state import State
from .system import System

__all__ = ["Simulation"]


class Simulation:
    """A system at a state, to be moved step by step or run by run, forwards or backwards.

    Parameters
    ----------
    system : System
    state : State
    integrator : Verner98, optional

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

    def __init__(self, system: System, state: State, integrator: Verner98 | None = None) -> None:
        if not isinstance(system, System):
            raise InvalidInput(f"system is {system!r}; expected a System")
        integrator = Verner98() if integrator is None else integrator
        if not isinstance(integrator, Verner98):
            raise InvalidInput(f"integrator is {integrator!r}; expected fullbody.Verner98(...)")
        self._system = system
        self._integrator = integrator
        name = type(integrator).__name__
        self._core = _core.Simulation(system._core, system._strip(state), name, integrator.rtol, integrator.atol)

    @property
    def system(self) -> System:
        """The system."""
        return self._system

    @property
    def integrator(self) -> Verner98:
        """The integrator with its settings."""
        return self._integrator

    @property
    def time(self) -> Any:
        """Present time."""
        return self._system._units.attach(self._core.time, "time")

    @property
    def state(self) -> State:
        """Present state."""
        return State._wrap(self._core.state, self._system._units)

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
        """Take one accepted step towards a time, never beyond it."""
        end = scalar(self._system._units.strip(until, "time", "until"), "until")
        if np.isnan(end):
            raise InvalidInput(f"until is {until!r}; expected a number")
        # Far, but finite, so that differences of times stay numbers.
        self._core.step(float(np.clip(end, -1e300, 1e300)))

    def integrate(self, until: Any, output: Any = None, progress: Any = False) -> Run:
        """Move to a time and record; see :meth:`fullbody.System.integrate`.

        Parameters
        ----------
        until : float or Quantity
        output : None, float, Quantity or array_like
        progress : bool, str or callable

        Returns
        -------
        Run
        """
        units = self._system._units
        end = scalar(units.strip(until, "time", "until"), "until")
        spacing, times = None, None
        if output is not None:
            values = units.strip(output, "time", "output")
            if values.ndim == 0:
                spacing = float(values)
                if not spacing > 0.0:
                    raise InvalidInput(f"output is {output!r}; expected a spacing above zero, or times")
            elif values.ndim == 1:
                times = values
            else:
                raise InvalidInput(f"output has shape {values.shape}; expected a number or (K,)")
        before = self._core.statistics
        with _Bar(progress) as report:
            record, error = self._core.integrate(end, spacing, times, report)
        counts = Statistics(*(now - then for now, then in zip(self._core.statistics, before, strict=True)))
        run = Run(self._system, record, counts, self._integrator)
        if error is None:
            return run
        if isinstance(error, KeyboardInterrupt):
            interrupted = Interrupted(f"interrupted at time {self._core.time}; the run so far is in .run")
            interrupted.run = run
            raise interrupted from None
        if isinstance(error, FullbodyError):
            error.run = run
        raise error

    def __repr__(self) -> str:
        return f"Simulation({self._system!r}, time={self.time}, integrator={self._integrator!r})"


class _Bar:
    """A progress bar as a context; gives what the core is to call, or ``None``."""

    def __init__(self, progress: Any) -> None:
        self._progress = progress
        self._bar: Any = None

    def __enter__(self) -> Any:
        if not self._progress:
            return None
        if callable(self._progress):
            return self._progress
        from tqdm.auto import tqdm

        layout = "{l_bar}{bar}| {elapsed}<{remaining}{postfix}"
        label = self._progress if isinstance(self._progress, str) else None
        self._bar = tqdm(total=1.0, desc=label, bar_format=layout)
        return self._update

    def _update(self, start: float, time: float, end: float) -> None:
        self._bar.n = (time - start) / (end - start)
        self._bar.set_postfix_str(f"t = {time:.6g}", refresh=False)
        self._bar.refresh()

    def __exit__(self, kind: object, *_: object) -> None:
        if self._bar is not None:
            if kind is None:
                self._bar.n = 1.0
            self._bar.close()
