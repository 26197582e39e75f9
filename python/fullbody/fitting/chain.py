"""Derivatives of what a setup returns, the start and the system's parameters, with respect to those of a fit.

A setup integrates nothing, so that its derivatives are computed by differences. Systems are compared by the numbers
that describe them. From the changes of these numbers it is computed which parameters of the system have changed, and by
how much. Motions cannot be differentiated with respect to a change that no parameter of the system makes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import rotations
from ..base.differences import Differences, difference
from ..errors import InvalidInput
from ..model.description import functions
from ..model.state import State, strip
from ..motion.system import System
from .free import Parameters

__all__ = ["Chain", "SetupDerivatives", "SetupResult"]

_Array = npt.NDArray[np.float64]

#: The largest part of a change of the system, relative to it, that its parameters may leave unexplained.
_UNEXPLAINED = 1e-6
#: The relative rounding error of numbers.
_ROUNDING = 1e-13
#: The step of a parameter of the system, relative to its natural size. The numbers are linear functions of it.
_STEP = 1e-3


class SetupResult:
    """A system and a state that a setup has made.

    Attributes
    ----------
    system : System
    state : State
    """

    def __init__(self, system: System, state: State) -> None:
        self.system, self.state = system, state

    def __reduce__(self) -> Any:
        return (SetupResult, (self.system, self.state))

    @cached_property
    def core(self) -> Any:
        """The state as the core has it, in numbers of the system's units."""
        return strip(self.state, self.system.context)

    @cached_property
    def numbers(self) -> dict[str, float]:
        """The numbers that describe bodies, forces and G, by their places in the description."""
        return {place: value for place, value in self._entries if isinstance(value, float)}

    @cached_property
    def rest(self) -> dict[str, Any]:
        """All of the description that is not such a number, by its place."""
        context = self.system.context
        return {
            **{place: value for place, value in self._entries if not isinstance(value, float)},
            **{f"notes {name}": context.notes[name] for name in ("units", "epoch", "frame")},
            **{f"settings {name}": value for name, value in context.core.settings.items()},
            **{f"the function of the force {force.name}": force for force in functions(self.system).values()},
        }

    @cached_property
    def _entries(self) -> list[tuple[str, Any]]:
        context = self.system.context
        return list(_entries({"G": context.G, "bodies": context.core.bodies, "forces": context.core.forces}))

    def moved(self, other: SetupResult) -> _Array:
        """Return the tangent vector (12 N,) from this state to another one, and the change of its time, (12 N + 1,)."""
        parts = [
            other.core.position - self.core.position,
            other.core.velocity - self.core.velocity,
            rotations.between(self.core.attitude, other.core.attitude),
            other.core.spin - self.core.spin,
        ]
        return np.append(np.stack(parts, axis=1).ravel(), other.core.time - self.core.time)

    def sizes(self) -> _Array:
        """Return sizes (12 N + 1,) of the components of the start, to which their rounding errors are relative."""
        core = self.core
        largest = [np.abs(core.position).max(), np.abs(core.velocity).max(), 1.0, np.abs(core.spin).max()]
        return np.append(np.tile(np.repeat(largest, 3), len(core.position)), abs(core.time))

    def difference(self, other: SetupResult) -> str | None:
        """Return the first place at which two descriptions differ in other than numbers, or ``None``."""
        places = (*self.rest, *other.rest)
        return next((place for place in places if self.rest.get(place, ...) != other.rest.get(place, ...)), None)


def _entries(node: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the entries of a description, which is made of dicts and lists, with their places."""
    if isinstance(node, dict):
        for name, value in node.items():
            yield from _entries(value, f"{place} {name}".strip())
    elif isinstance(node, list | tuple | np.ndarray):
        yield f"number of {place}", len(node)
        for index, value in enumerate(node):
            yield from _entries(value, f"{place}[{index}]")
    else:
        yield place, node


@dataclass
class SetupDerivatives:
    """Derivatives of the system and state of a setup with respect to P parameters.

    Attributes
    ----------
    start : ndarray, (12 N, P)
        Derivatives of the start of the run, as tangent vectors, at the time of the start.
    system : dict of ndarray, (P,)
        Derivatives of the parameters of the system that change, by their names.
    undifferentiable : dict of str
        The parameters that change something by which motions cannot be differentiated, with what that is.
    """

    start: _Array
    system: dict[str, _Array]
    undifferentiable: dict[str, str]


class Chain:
    """The derivatives of a setup, wherever they are computed in a fit; the steps of differences are kept.

    Parameters
    ----------
    make : callable
        A function that takes values (P,) and returns the :class:`SetupResult` of the setup.
    parameters : Parameters
    """

    def __init__(self, make: Callable[[_Array], SetupResult], parameters: Parameters) -> None:
        self._make, self._parameters = make, parameters
        self.differences = [Differences() for _ in parameters.names]

    def at(self, base: SetupResult, values: _Array) -> SetupDerivatives:
        """Differentiate at values (P,), for which the setup returns ``base``.

        Raises
        ------
        InvalidInput
            For a setup whose results are not smooth in a parameter.
        """
        tangent = len(base.core.position) * 12
        columns = np.zeros((tangent + 1 + len(base.numbers), len(values)))
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
        start, times, numbers = columns[:tangent], columns[tangent], columns[tangent + 1 :]
        if times.any():
            if "ThirdBody" in base.system.context.forces.values():
                # The barycentre of an earlier start would have another velocity than the nominal one.
                moving = (name for name, time in zip(self._parameters.names, times, strict=True) if time)
                undifferentiable |= dict.fromkeys(moving, "the time of the start beside a third body")
            # A start that is later by dt corresponds to one whose state is behind by f dt, with f the rates of change.
            start = start - np.outer(base.system.context.core.jacobian(base.core, [])[3], times)
        system, unexplained = _parameters_of_system(base, numbers)
        for name, place in zip(self._parameters.names, unexplained, strict=True):
            if place is not None:
                undifferentiable.setdefault(name, place)
        return SetupDerivatives(start, system, undifferentiable)

    def _column(self, base: SetupResult, values: _Array, k: int, other: list[str]) -> _Array | None:
        """Return derivatives of the start, its time and the system's numbers; ``other`` receives all other changes."""
        numbers = np.array(list(base.numbers.values()))
        noise = _ROUNDING * np.concatenate([base.sizes(), np.abs(numbers)])
        start = np.append(np.tile(np.repeat(np.arange(4), 3), len(base.core.position)), 4)
        groups = np.concatenate([start, np.arange(len(numbers)) + 5])

        def shifted(by: float) -> _Array:
            made = self._make(self._parameters.shifted(values, k, by))
            if (place := base.difference(made)) is not None:
                other.append(place)
                return np.zeros(len(noise))
            return np.concatenate([base.moved(made), np.array(list(made.numbers.values())) - numbers])

        size = self._parameters.size(k, values[k])
        return self.differences[k].derivative(shifted, size, noise, groups, 0.1 * max(size, 1.0))


def _parameters_of_system(base: SetupResult, numbers: _Array) -> tuple[dict[str, _Array], list[str | None]]:
    """Solve for the derivatives of a system's parameters from those (D, P) of the numbers that describe it.

    Returns the derivatives by name, and for each of P the place of a number whose change no parameter makes, or
    ``None``.
    """
    changing = np.asarray(numbers.any(axis=1))
    if not changing.any():
        return {}, [None] * numbers.shape[1]
    columns = {name: column for name, column in _columns(base) if column[changing].any()}
    scale = np.abs(list(base.numbers.values()))
    scale = np.where(scale > 0.0, scale, np.maximum(np.abs([*columns.values(), 0.0 * scale]).max(axis=0), 1e-300))
    used: dict[str, _Array] = {}
    for name, column in columns.items():
        widths = np.linalg.norm([*used.values(), column / scale], axis=1)
        # A parameter whose change is that of others together, such as a density, is not needed beside them.
        if np.linalg.matrix_rank(np.array([*used.values(), column / scale]) / widths[:, None], 1e-9) > len(used):
            used[name] = column / scale
    matrix, wanted = np.array([*used.values(), 0.0 * scale]).T, numbers / scale[:, None]
    width = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    solved = np.linalg.lstsq(matrix / width, wanted, rcond=1e-10)[0]
    remaining = np.abs(wanted - matrix / width @ solved)
    left = remaining.max(axis=0) > _UNEXPLAINED * np.abs(wanted).max(axis=0)
    places = [list(base.numbers)[k] for k in remaining.argmax(axis=0)]
    solved = np.where(np.abs(solved) > 1e-9 * np.abs(solved).max(axis=0), solved, 0.0) / width[:, None]
    by_name = {name: row for name, row in zip(used, solved, strict=False) if row.any()}
    return by_name, [place if is_left else None for place, is_left in zip(places, left, strict=True)]


def _columns(base: SetupResult) -> Iterator[tuple[str, _Array]]:
    """Yield the parameters of a system with the derivatives (D,) of the numbers that describe it."""
    core, numbers = base.system.context.core, np.array(list(base.numbers.values()))
    for name in base.system.parameters:

        def shifted(by: float, name: str = name) -> _Array:
            bodies, forces, G, _ = core.changed(name, by)
            entries = _entries({"G": G, "bodies": bodies, "forces": forces})
            return np.asarray([value for _, value in entries if isinstance(value, float)] - numbers)

        yield name, difference(shifted, _STEP * core.changed(name, 0.0)[3])
