"""Equality, hashes and short texts of values that may be arrays or have units."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..errors import InvalidInput
from .units import is_quantity


class ByName(dict[str, Any]):
    """A dictionary that finds a name in another normal form of Unicode too."""

    def __missing__(self, name: Any) -> Any:
        for form in ("NFC", "NFKC") if isinstance(name, str) else ():
            if (other := unicodedata.normalize(form, name)) in self:
                return self[other]
        raise KeyError(name)


def brief(value: Any) -> str:
    """Return a value as one line of text: a scalar in full, an array by its shape and range."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name!r}: {brief(part)}" for name, part in value.items()) + "}"
    if not isinstance(value, np.ndarray | np.generic):
        return f"{value}" if is_quantity(value) else repr(value)
    if value.ndim == 0:
        return f"{value}"
    if value.size == 0:
        return f"<{value.shape}>"
    array, unit = np.asarray(getattr(value, "value", value)), getattr(value, "unit", "")
    return f"<{value.shape}, {array.min():.6g} to {array.max():.6g} {unit}".rstrip() + ">"


def block(head: str, **parts: Any) -> str:
    """Return several lines of text, one for each part, with vectors to six decimals of their largest component."""
    with np.printoptions(precision=6, suppress=False):
        rows = [f"  {label}={_rounded(value)!s}" for label, value in parts.items()]
    body = ",\n".join(row.replace("\n", "\n" + " " * (row.index("=") + 1)) for row in rows)
    return f"{head}\n{body})"


def _rounded(value: Any) -> Any:
    """Return vectors rounded to the digits that are shown, since round-off would be printed with all its zeros."""
    if not np.ndim(value):
        return value
    array = np.asarray(getattr(value, "value", value))
    largest = np.abs(array).max(axis=-1, keepdims=True)
    with np.errstate(divide="ignore"):
        scale = 10.0 ** np.floor(np.log10(largest))
    # The scale is one if the largest component is zero, or so small that its power of ten is not a double.
    scale = np.where(scale > 0.0, scale, 1.0)
    # The addition of zero turns -0 into 0.
    rounded = np.round(array / scale, 6) * scale + 0.0
    return rounded << value.unit if is_quantity(value) else rounded


def same(first: Any, second: Any) -> bool:
    """Return whether two values are equal: arrays are compared as wholes, and nan equals itself."""
    if isinstance(first, dict):
        return (
            isinstance(second, dict) and first.keys() == second.keys() and all(same(first[k], second[k]) for k in first)
        )
    if isinstance(first, tuple) and isinstance(second, tuple):
        return len(first) == len(second) and all(map(same, first, second))
    if is_quantity(first) != is_quantity(second):
        return False
    if isinstance(first, np.ndarray | float) or isinstance(second, np.ndarray | float):
        # Numpy cannot compare numbers with None or text.
        if any(part is None or isinstance(part, str) for part in (first, second)):
            return first is second
        return bool(np.array_equal(first, second, equal_nan=True))
    return bool(first == second)


def hashed(value: Any) -> int:
    """Return a hash of a scalar. A Quantity has the hash of its dimension, since conversions round."""
    if is_quantity(value):
        return hash(str(value.si.unit))
    return hash(value.item() if isinstance(value, np.ndarray) else value)


class _Fields:
    """Base class of dataclasses (``eq=False``) that are equal if their fields are."""

    __slots__ = ()

    def _parts(self) -> tuple[Any, ...]:
        return tuple(getattr(self, f.name) for f in fields(self))  # type: ignore[arg-type]

    def __eq__(self, other: object) -> bool:
        return same(self._parts(), other._parts()) if type(other) is type(self) else NotImplemented


class ScalarFields(_Fields):
    """Base class of dataclasses (``eq=False``) of scalars with or without units, with equal hashes of equal ones."""

    __slots__ = ()

    def __hash__(self) -> int:
        return hash((type(self), *map(hashed, self._parts())))


@dataclass(frozen=True)
class UnstoredFunction:
    """The placeholder for a user's function in an object from a file, which keeps only the function's name."""

    name: str
    advice: str

    @property
    def __name__(self) -> str:
        """The name, where functions have theirs."""
        return self.name

    def __call__(self, *arguments: Any) -> Any:
        """Raise an error, since the file has only the function's name."""
        raise InvalidInput(f"the function {self.name} is not in the file, only its name; {self.advice}")


class ArrayFields(_Fields):
    """Base class of dataclasses (``eq=False, repr=False``) whose fields may be arrays."""

    __slots__ = ()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        parts = (f"{f.name}={brief(getattr(self, f.name))}" for f in fields(self))  # type: ignore[arg-type]
        return f"{type(self).__name__}({', '.join(parts)})"
