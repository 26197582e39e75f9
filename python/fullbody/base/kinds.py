"""Kinds of values of arguments and fields: functions that return a checked value or raise an error.

The argument ``what`` names the value in errors.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..errors import InvalidInput
from .arguments import directions, integer
from .limits import FINITE, Limits
from .units import ANY, Units, as_quantity, is_quantity
from .values import ScalarFields


def whole_number(value: object, what: str, least: int = 1, most: float = np.inf, other: str = "") -> int:
    """Return a whole number within bounds as an ``int``; ``other`` ends the error, with alternatives to a number."""
    number = integer(value)
    if number is None or not least <= number <= most:
        bounds = {0: ", zero or above", 1: " above zero"}.get(least, f", {least} or more")
        bounds = bounds if most == np.inf else f" from {least} to {most}"
        raise InvalidInput(f"{what} is {value!r}; expected a whole number{bounds}{other}")
    return number


def choice(value: Any, what: str, words: Collection[Any]) -> Any:
    """Return a value that is one of ``words``: texts, and ``None`` where that is one of them."""
    if not any(type(value) is type(word) and value == word for word in words):
        *first, last = map(repr, words)
        first = [", ".join(first)] if first else []
        raise InvalidInput(f"{what} is {value!r}; expected {' or '.join([*first, last])}")
    return value


def flag(value: object, what: str) -> bool:
    """Return a ``bool`` from ``True`` or ``False`` of Python or numpy."""
    if not isinstance(value, bool | np.bool_):
        raise InvalidInput(f"{what} is {value!r}; expected True or False")
    return bool(value)


def function(value: Any, what: str, expected: str = "a function") -> Any:
    """Return a value that can be called."""
    if not callable(value):
        raise InvalidInput(f"{what} is {value!r}; expected {expected}")
    return value


def instance(value: Any, what: str, kind: Any, expected: str = "") -> Any:
    """Return an object of the class ``kind``, or of one of several, which ``expected`` then describes."""
    if not isinstance(value, kind):
        raise InvalidInput(f"{what} is {value!r}; expected {expected or f'a {kind.__name__}'}")
    return value


def with_unit(value: Any, dimension: str, units: Units) -> Any:
    """Return a plain number as a Quantity in a system's units, and a Quantity or ``None`` unchanged."""
    return value if value is None or is_quantity(value) else units.attach(value, dimension)


def direction(value: Any, what: str) -> tuple[float, ...]:
    """Return a vector (3,) of any length above zero in any unit as a tuple, which can be compared and hashed."""
    return tuple(map(float, directions(value, what, single=True)))


def crossing_direction(value: object, what: str) -> int:
    """Return the direction in which a function crosses zero: 1 rising, -1 falling, 0 either."""
    if (number := integer(value)) not in (-1, 0, 1):
        raise InvalidInput(f"{what} is {value!r}; expected -1, 0 or 1")
    return number


@dataclass(frozen=True, slots=True)
class Number:
    """The kind of a number, or of an array of numbers, that may have a unit.

    A letter in the shape stands for any length. A missing number is refused if ``required``, although the field has a
    default of ``None``.
    """

    dimension: str = "number"
    limits: Limits = FINITE
    shape: tuple[int | str, ...] = ()
    required: bool = False

    def __call__(self, value: Any, what: str) -> Any:
        """Return a value in its own unit, after all checks that need no system."""
        if value is None and self.required:
            raise InvalidInput(f"{what} is not given; expected {self.limits.expected(self.shape != ())}")
        # Any unit of the dimension passes; only the checks count here.
        self.unitless(value, what, ANY)
        return as_quantity(value, what, self.dimension)

    def unitless(self, value: Any, what: str, units: Units) -> Any:
        """Return a value as numbers in a system's units: a float, or lists of floats."""
        return units.numbers(value, self.dimension, what, self.shape, self.limits).tolist()

    def attached(self, value: Any, units: Units) -> Any:
        """Return numbers in a system's units with their unit, if the system has units and the numbers a dimension."""
        if self.dimension == "number":
            return value
        return units.attach(np.array(value) if self.shape else value, self.dimension)


def body_index(value: Any, what: str) -> Any:
    """Return the index or the name of a body unchanged, since only a system can check whether it exists."""
    return value


Kind = Callable[[Any, str], Any]


def of_kind(kind: Kind) -> dict[str, Kind]:
    """Return the metadata by which a field of a dataclass declares the kind of its values."""
    return {"kind": kind}


def kinds_of(owner: Any) -> dict[str, Kind]:
    """Return the kinds of a dataclass's fields by name, of those that have one."""
    return {entry.name: entry.metadata["kind"] for entry in fields(owner) if "kind" in entry.metadata}


class Declared(ScalarFields):
    """Base class of dataclasses that declare the kinds of their fields, by which the values are checked."""

    __slots__ = ()

    def __post_init__(self) -> None:
        self._check_fields()

    def _what(self, name: str, of: str = "") -> str:
        """Return how errors call a field: its name, and ``of``, the name of the object, or else its class."""
        return f"{name} of {of or type(self).__name__}"

    def _check_fields(self) -> None:
        """Check all fields that have a value or need one, and replace it by the value that the kind returns."""
        for entry in fields(self):  # type: ignore[arg-type]
            kind, value = entry.metadata.get("kind"), getattr(self, entry.name)
            if kind and (value is not None or entry.default is not None or getattr(kind, "required", False)):
                object.__setattr__(self, entry.name, kind(value, self._what(entry.name)))

    def _numbers(self) -> dict[str, tuple[Any, str]]:
        """Return the values and dimensions of all numbers that have both, by name."""
        kinds = {name: kind for name, kind in kinds_of(self).items() if isinstance(kind, Number)}
        values = {name: (getattr(self, name), kind.dimension) for name, kind in kinds.items()}
        return {name: entry for name, entry in values.items() if entry[0] is not None and entry[1] != "number"}

    def _unitless(self, units: Units, index: Callable[[Any, str], Any] | None = None, of: str = "") -> dict[str, Any]:
        """Return the numbers among the fields in a system's units, ``None`` for missing ones, by name.

        With a function ``index`` of a body and of how errors call it, the indices of bodies are returned as well.
        """
        numbers = {}
        for name, kind in kinds_of(self).items():
            value = getattr(self, name)
            if isinstance(kind, Number):
                numbers[name] = None if value is None else kind.unitless(value, self._what(name, of), units)
            elif kind is body_index and index is not None:
                numbers[name] = None if value is None else index(value, self._what(name))
        return numbers
