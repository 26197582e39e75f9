"""Tables of a TOML file that know their place in it, so that a fault names file, key, value and what is expected."""

from __future__ import annotations

import reprlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import suggestion
from ..base.units import Units, from_text, scalar
from ..errors import FullbodyError, InvalidInput

__all__ = ["Table"]


class Table:
    """A table of the file that knows its place."""

    def __init__(self, path: Path, place: str, content: dict[str, Any]) -> None:
        self.path, self.place, self.content = path, place, content

    def __contains__(self, key: str) -> bool:
        return key in self.content

    def fault(self, key: str, message: str) -> InvalidInput:
        """An error that names file and key."""
        place = ".".join(part for part in (self.place, key) if part)
        return InvalidInput(f"{self.path}: {place}: {message}" if place else f"{self.path}: {message}")

    def naming(self, key: str) -> Naming:
        """A context in which this package's errors gain file and key."""
        return Naming(self, key)

    def take(self, key: str, expected: str) -> Any:
        """A value that must be there."""
        if key not in self:
            raise self.fault(key, f"is missing; expected {expected}")
        return self.content[key]

    def text(self, key: str, expected: str = "text") -> str:
        """A text."""
        value = self.take(key, expected)
        if not isinstance(value, str):
            raise self.fault(key, f"is {value!r}; expected {expected}")
        return value

    def choice(self, key: str, choices: tuple[str, ...]) -> str:
        """One of some texts; the first where nothing is said."""
        value = self.content[key] if key in self else choices[0]
        if value not in choices:
            raise self.fault(key, f"is {value!r}; expected one of {', '.join(map(repr, choices))}")
        return str(value)

    def table(self, key: str, required: bool = True) -> Table:
        """A table below this one."""
        value = self.take(key, "a table") if required else self.content.get(key, {})
        if not isinstance(value, dict):
            raise self.fault(key, f"is {value!r}; expected a table")
        return Table(self.path, f"{self.place}.{key}" if self.place else key, value)

    def tables(self, key: str) -> list[Table]:
        """The tables of an array such as ``[[body]]``."""
        value = self.take(key, f"at least one [[{key}]]")
        if not isinstance(value, list) or not value or not all(isinstance(item, dict) for item in value):
            raise self.fault(key, f"is {value!r}; expected tables, each headed [[{key}]]")
        return [Table(self.path, f"{key}[{k}]", item) for k, item in enumerate(value)]

    def value(
        self, key: str, dimension: str | None, units: Units, shape: tuple[int, ...] | None
    ) -> npt.NDArray[np.float64]:
        """Numbers, or texts with units, as numbers in the system's units; ``shape`` None takes a number or a list."""
        expected = "a number" if shape == () else f"{shape[0]} numbers" if shape else "a number or a list of them"
        unit = "" if dimension is None else ", or text with a unit"
        value = self.take(key, expected + unit)
        items = value if isinstance(value, list) else [value]
        if shape is not None and (isinstance(value, list) != bool(shape) or (shape and len(items) != shape[0])):
            raise self.fault(key, f"is {value!r}; expected {expected}{unit}")
        plain = [self._number(key, item, dimension, units, expected + unit) for item in items]
        return np.array(plain if isinstance(value, list) else plain[0])

    def _number(self, key: str, item: Any, dimension: str | None, units: Units, expected: str) -> float:
        if isinstance(item, int | float) and not isinstance(item, bool):
            try:
                number = float(item)
            except OverflowError:
                number = np.inf
            if not np.isfinite(number):
                # Cut short in the middle where it has hundreds of digits.
                raise self.fault(key, f"is {reprlib.repr(item)}; expected a finite number")
            return number
        if not isinstance(item, str) or dimension is None:
            raise self.fault(key, f"is {item!r}; expected {expected}")
        try:
            quantity = from_text(item, "", dimension)
        except InvalidInput as error:
            raise self.fault(key, str(error).strip()) from error
        with self.naming(key):
            return scalar(units.strip(quantity, dimension, repr(item)), repr(item))

    def only(self, *known: str) -> Table:
        """Refuse keys other than these, before a misspelt one is reported as missing."""
        for key in self.content:
            if key not in known:
                raise self.fault(key, f"is no key of this table; {suggestion(key, known)}")
        return self


class Naming:
    """Adds file and key to errors raised inside."""

    def __init__(self, table: Table, key: str) -> None:
        self.table, self.key = table, key

    def __enter__(self) -> None: ...

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, FullbodyError) and not str(error).startswith(f"{self.table.path}: "):
            raise self.table.fault(self.key, str(error)) from error
