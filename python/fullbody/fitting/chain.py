"""Derivatives of what a setup returns, the start and the system's parameters, with respect to those of a fit.

A setup integrates nothing, so that its derivatives are computed by differences. Systems are compared by the numbers
that describe them. From the changes of these numbers it is computed which parameters of the system have changed, and by
how much. Motions cannot be differentiated with respect to a change that no parameter of the system makes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base import rotations
from ..errors import InvalidInput
from .differences import derivative

if TYPE_CHECKING:
    from ..model.state import State
    from ..motion.system import System

__all__ = ["Chain", "SetupDerivatives", "SetupResult"]

_Array = npt.NDArray[np.float64]

#: The largest part of a change of the system, relative to it, that its parameters may leave unexplained.
_LEFT = 1e-6
#: The relative rounding error of numbers.
_ROUNDING = 1e-13


class SetupResult:
    """A system and a state that a setup has made, in plain numbers.

    Attributes
    ----------
    system : System
    state : State
    numbers : ndarray, (D,)
        The numbers that describe bodies, forces and G; ``places`` says where in the description each of them is.
    rest : dict
        All of the description that is not a number, by its place.
    """

    def __init__(self, system: System, state: State) -> None:
        self.system, self.state = system, state
        self.core = system._strip(state)
        self.numbers, self.places, self.rest = _described(system)
        self.functions = system._functions()

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
        if self.functions != other.functions:
            names = [force.name for force in (*self.functions, *other.functions)]
            return f"the function of the force {names[0]}"
        return next(
            (
                place
                for place in (*self.rest, *other.rest)
                if self.rest.get(place, _ABSENT) != other.rest.get(place, _ABSENT)
            ),
            None,
        )


_ABSENT = object()


def _described(system: System) -> tuple[_Array, list[str], dict[str, Any]]:
    """Return the numbers of a system's description, the place of each, and the rest of the description by its place."""
    described = system._describe()
    notes = {name: value for name, value in described.pop("notes").items() if name not in ("bodies", "forces")}
    found: list[float] = []
    places: list[str] = []
    rest: dict[str, Any] = {}

    def walk(node: Any, place: str) -> None:
        if isinstance(node, dict):
            for name, value in node.items():
                walk(value, f"{place} {name}".strip())
        elif isinstance(node, list | tuple | np.ndarray):
            rest[f"number of {place}"] = len(node)
            for index, value in enumerate(node):
                walk(value, f"{place}[{index}]")
        elif isinstance(node, float) and not place.startswith("settings"):
            found.append(node)
            places.append(place)
        else:
            rest[place] = node

    walk(described | {"notes": notes}, "")
    return np.array(found), places, rest


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
    """The derivatives of a setup, wherever they are computed in a fit.

    The steps of differences are found once, as are the numbers of the system that are parameters of it.

    Parameters
    ----------
    make : callable
        A function that takes values (P,) and returns the :class:`SetupResult` of the setup.
    names : sequence of str
    """

    def __init__(self, make: Callable[[_Array], SetupResult], names: Sequence[str]) -> None:
        self._make, self._names = make, tuple(names)
        self._steps: list[dict[str, float]] = [{} for _ in names]
        self._system = _SystemChain()

    def at(self, base: SetupResult, values: _Array, sizes: _Array) -> SetupDerivatives:
        """Differentiate at values (P,), for which the setup returns ``base``; it is smooth over their sizes (P,).

        Raises
        ------
        InvalidInput
            For a setup whose results are not smooth in a parameter.
        """
        tangent = len(base.core.position) * 12
        columns = np.zeros((tangent + 1 + len(base.numbers), len(values)))
        found: dict[str, str] = {}
        for k, name in enumerate(self._names):
            other: list[str] = []
            try:
                column = self._column(base, values, k, sizes[k], other)
            except InvalidInput as error:
                raise InvalidInput(
                    f"setup cannot be differentiated with respect to {name} at {values[k]:.9g}: {error}"
                ) from error
            if other:
                found[name] = other[0]
            elif column is None:
                raise InvalidInput(
                    f"the results of setup do not change evenly with {name} near {values[k]:.9g}; expected a function "
                    "without jumps and random numbers"
                )
            else:
                columns[:, k] = column
        start, times, numbers = columns[:tangent], columns[tangent], columns[tangent + 1 :]
        if times.any():
            # A start that is later by dt corresponds to one whose state is behind by f dt, with f the rates of change.
            start = start - np.outer(base.system._core.jacobian(base.core, [])[3], times)
        system, left = self._system.solve(base, numbers)
        for name, place in zip(self._names, left, strict=True):
            if place is not None:
                found.setdefault(name, place)
        return SetupDerivatives(start, system, found)

    def _column(self, base: SetupResult, values: _Array, k: int, size: float, other: list[str]) -> _Array | None:
        """Return derivatives of the start, its time and the system's numbers; ``other`` receives all other changes."""
        noise = _ROUNDING * np.concatenate([base.sizes(), np.abs(base.numbers)])
        start = np.append(np.tile(np.repeat(np.arange(4), 3), len(base.core.position)), 4)
        groups = np.concatenate([start, np.arange(len(base.numbers)) + 5])

        def shifted(by: float) -> _Array:
            moved = values.copy()
            moved[k] += by
            made = self._make(moved)
            if (place := base.difference(made)) is not None:
                other.append(place)
                return np.zeros(len(noise))
            return np.concatenate([base.moved(made), made.numbers - base.numbers])

        return derivative(shifted, size, noise, groups, self._steps[k])


class _SystemChain:
    """Finds the parameters of a system that have changed, from the changes of the numbers that describe it."""

    def __init__(self) -> None:
        self._steps: dict[str, dict[str, float]] = {}
        #: The constant derivatives of the numbers with respect to those parameters that are themselves one of the
        #: numbers.
        self._own: dict[str, _Array] = {}
        #: Names of parameters that make the same change as one of ``_own``, and are not needed beside it.
        self._spare: set[str] = set()

    def solve(self, base: SetupResult, numbers: _Array) -> tuple[dict[str, _Array], list[str | None]]:
        """Solve for the derivatives of a system's parameters from those (D, P) of the numbers that describe it.

        Returns the derivatives by name, and for each of P the place of a number whose change no parameter makes, or
        ``None``.
        """
        solved, left = self._solve(base, numbers)
        if self._spare and any(place is not None for place in left):
            # A parameter of the system that was not needed at other values may be needed at these.
            self._spare.clear()
            solved, left = self._solve(base, numbers)
        return solved, left

    def _solve(self, base: SetupResult, numbers: _Array) -> tuple[dict[str, _Array], list[str | None]]:
        left: list[str | None] = [None] * numbers.shape[1]
        rows: npt.NDArray[np.bool_] = np.asarray(numbers.any(axis=1))
        if not rows.any():
            return {}, left
        names = [name for name in base.system.parameters if name not in self._spare]
        known = {name: found for name in names if (found := self._changes(base, name)) is not None}
        owned = np.any([np.zeros(len(rows), bool), *(column != 0.0 for column in self._own.values())], axis=0)
        for name, column in known.items():
            if name not in self._own and np.count_nonzero(column) == 1 and owned[column != 0.0].all():
                self._spare.add(name)
        columns = np.stack(list(known.values()), axis=1) if known else np.zeros((len(rows), 0))
        scale = np.abs(base.numbers)
        scale = np.where(scale > 0.0, scale, np.maximum(np.abs(columns).max(axis=1, initial=0.0), 1e-300))
        used: dict[str, _Array] = {}
        for name, column in zip(known, (columns / scale[:, None]).T, strict=True):
            # If several parameters make the same change, the first of them is used.
            if column[rows].any() and not any(_parallel(column, other) for other in used.values()):
                used[name] = column
        scaled = np.stack(list(used.values()), axis=1) if used else np.zeros((len(rows), 0))
        width = np.abs(scaled).max(axis=0, initial=1e-300)
        wanted = numbers / scale[:, None]
        solved = np.linalg.lstsq(scaled / width, wanted, rcond=1e-10)[0] if used else np.zeros((0, len(left)))
        remaining = np.abs(wanted - scaled / width @ solved)
        for k in range(len(left)):
            if remaining[:, k].max() > _LEFT * np.abs(wanted[:, k]).max():
                left[k] = base.places[int(np.argmax(remaining[:, k]))]
        solved = np.where(np.abs(solved) > 1e-9 * np.abs(solved).max(axis=0, initial=1e-300), solved, 0.0)
        return {name: row for name, row in zip(used, solved / width[:, None], strict=True) if row.any()}, left

    def _changes(self, base: SetupResult, name: str) -> _Array | None:
        """Return the derivatives (D,) of the numbers that describe a system with respect to one of its parameters.

        It is ``None`` if motions of this system cannot be differentiated with respect to the parameter.
        """
        if (own := self._own.get(name)) is not None and len(own) == len(base.numbers):
            return own
        system = base.system
        try:
            system._core.jacobian(base.core, [name])
            size = system._changed(name, 0.0)[1]

            def shifted(by: float) -> _Array:
                return _described(system._changed(name, by)[0])[0] - base.numbers

            groups = np.arange(len(base.numbers))
            found = derivative(
                shifted, size, _ROUNDING * np.abs(base.numbers), groups, self._steps.setdefault(name, {})
            )
        except InvalidInput:
            return None
        if found is not None and np.count_nonzero(found) == 1 and abs(found.max() - 1.0) < 1e-9:
            self._own[name] = found
        return found


def _parallel(first: _Array, second: _Array) -> bool:
    product = abs(float(first @ second))
    return product >= (1.0 - 1e-12) * float(np.linalg.norm(first) * np.linalg.norm(second))
