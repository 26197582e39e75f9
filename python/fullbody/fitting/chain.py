"""Derivatives of what a setup returns, the start and the system's parameters, with respect to those of a fit.

A setup integrates nothing, so that its derivatives are computed by differences: those of the state, and of the
parameters that lead from one system to another. Motions cannot be differentiated with respect to a change that no
parameter of the system makes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base import rotations
from ..base.differences import Differences
from ..errors import InvalidInput
from ..model.description import functions
from ..model.state import State, strip
from ..motion.system import System
from ..typing import Floats
from .free import Parameters

#: The relative rounding error of numbers.
_ROUNDING = 1e-13


class SetupResult:
    """A system and a state that a setup has made."""

    def __init__(self, system: System, state: State) -> None:
        self.system, self.state = system, state

    def __reduce__(self) -> Any:
        return (SetupResult, (self.system, self.state))

    @cached_property
    def core(self) -> Any:
        """The state as the core has it, in numbers of the system's units."""
        return strip(self.state, self.system.context)

    @cached_property
    def parameters(self) -> dict[str, float]:
        """The values of the system's parameters by their names."""
        return self.system.context.core.parameter_values

    @cached_property
    def rest(self) -> dict[str, Any]:
        """Units, settings and functions of the system, which no parameter of the system changes, by their names."""
        context = self.system.context
        return {
            **{f"notes {name}": context.notes[name] for name in ("units", "epoch", "frame")},
            **{f"settings {name}": value for name, value in context.core.settings.items()},
            **{f"the function of the force {force.name}": force for force in functions(self.system).values()},
        }

    def moved(self, other: SetupResult) -> Floats:
        """Return the tangent vector from this state to another one with as many bodies, and the change of time.

        The array has the shape (12 N + 1,).
        """
        parts = [
            other.core.position - self.core.position,
            other.core.velocity - self.core.velocity,
            rotations.between(self.core.attitude, other.core.attitude),
            other.core.spin - self.core.spin,
        ]
        return np.append(np.stack(parts, axis=1).ravel(), other.core.time - self.core.time)

    def sizes(self) -> Floats:
        """Return sizes (12 N + 1,) of the components of the start, to which their rounding errors are relative."""
        core = self.core
        largest = [np.abs(core.position).max(), np.abs(core.velocity).max(), 1.0, np.abs(core.spin).max()]
        return np.append(np.tile(np.repeat(largest, 3), len(core.position)), abs(core.time))

    def changes(self, other: SetupResult) -> tuple[Floats, str | None]:
        """Return the changes (P,) of the parameters to another system, and what of it they leave unexplained."""
        changed, unexplained = self.system.context.core.parameter_changes(other.system.context.core)
        if unexplained is None:
            paths = (*self.rest, *other.rest)
            differing = (path for path in paths if self.rest.get(path, ...) != other.rest.get(path, ...))
            unexplained = next(differing, None)
        return np.array([changed.get(name, 0.0) for name in self.parameters]), unexplained


@dataclass
class SetupDerivatives:
    """Derivatives of the system and state of a setup with respect to P parameters.

    Those of the ``start`` (12 N, P) are tangent vectors at the time of the start, those of the ``system`` are (P,) for
    each of its parameters that change; ``undifferentiable`` has the parameters that change something by which motions
    cannot be differentiated, with what that is.
    """

    start: Floats
    system: dict[str, Floats]
    undifferentiable: dict[str, str]


class Chain:
    """The derivatives of a setup, wherever they are computed in a fit; the steps of differences are kept.

    The function ``make`` takes values (P,) and returns the :class:`SetupResult` of the setup.
    """

    def __init__(self, make: Callable[[Floats], SetupResult], parameters: Parameters) -> None:
        self._make, self._parameters = make, parameters
        self.differences = [Differences() for _ in parameters.names]

    def at(self, base: SetupResult, values: Floats) -> SetupDerivatives:
        """Differentiate at values (P,), for which the setup returns ``base``, or raise an error where it is not
        smooth.
        """
        tangent = len(base.core.position) * 12
        columns = np.zeros((tangent + 1 + len(base.parameters), len(values)))
        undifferentiable: dict[str, str] = {}
        for k, name in enumerate(self._parameters.names):
            other: list[str] = []
            try:
                column = self._column(base, values, k, other)
            except InvalidInput as error:
                raise InvalidInput(
                    f"setup cannot be differentiated with respect to {name} at {values[k]:.9g}: {error}"
                ) from error
            if other:
                undifferentiable[name] = other[0]
            elif column is None:
                raise InvalidInput(
                    f"the results of setup do not change evenly with {name} near {values[k]:.9g}; expected a function "
                    "without jumps, rounded numbers, tables without interpolation and random numbers"
                )
            else:
                columns[:, k] = column
        start, times = columns[:tangent], columns[tangent]
        if times.any():
            if "ThirdBody" in base.system.context.forces.values():
                # The barycentre of an earlier start would have another velocity than the nominal one.
                moving = (name for name, time in zip(self._parameters.names, times, strict=True) if time)
                undifferentiable |= dict.fromkeys(moving, "the time of the start beside a third body")
            # A start that is later by dt corresponds to one whose state is behind by f dt, with f the rates of change.
            start = start - np.outer(base.system.context.core.jacobian(base.core, [])[3], times)
        rows = zip(base.parameters, columns[tangent + 1 :], strict=True)
        return SetupDerivatives(start, {name: row for name, row in rows if row.any()}, undifferentiable)

    def _column(self, base: SetupResult, values: Floats, k: int, other: list[str]) -> Floats | None:
        """Return derivatives of start, time and parameters of the system; ``other`` receives all other changes."""
        parameters = np.abs(list(base.parameters.values()))
        noise = _ROUNDING * np.concatenate([base.sizes(), parameters])
        start = np.append(np.tile(np.repeat(np.arange(4), 3), len(base.core.position)), 4)
        groups = np.concatenate([start, np.arange(len(parameters)) + 5])

        def shifted(by: float) -> Floats:
            made = self._make(self._parameters.shifted(values, k, by))
            changes, unexplained = base.changes(made)
            if unexplained is not None:
                other.append(unexplained)
                return np.zeros(len(noise))
            return np.concatenate([base.moved(made), changes])

        size = self._parameters.size(k, values[k])
        return self.differences[k].derivative(shifted, size, noise, groups, 0.1 * max(size, 1.0))
