"""Tables of a TOML file that know their location, so that errors name file, key, value and what is expected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import numpy as np

from ..base.arguments import suggestion
from ..base.kinds import Number
from ..base.units import Units
from ..errors import FullbodyError, InvalidInput
from ..typing import Floats


class TomlTable:
    """A table of the file with its location and the units of its plain numbers."""

    def __init__(self, path: Path, location: str, content: dict[str, Any], units: Units) -> None:
        self.path, self.location, self.content, self.units = path, location, content, units

    def __contains__(self, key: str) -> bool:
        return key in self.content

    def fault(self, key: str, message: str) -> InvalidInput:
        """Make an error that names file and key."""
        location = ".".join(part for part in (self.location, key) if part)
        return InvalidInput(f"{self.path}: {location}: {message}" if location else f"{self.path}: {message}")

    @contextmanager
    def naming(self, key: str) -> Iterator[None]:
        """Context manager that adds file and key to this package's errors unless they name them already."""
        try:
            yield
        except FullbodyError as error:
            if str(error).startswith(f"{self.path}: "):
                raise
            raise self.fault(key, str(error)) from error

    def take(self, key: str, expected: str) -> Any:
        """Return a required value."""
        if key not in self:
            raise self.fault(key, f"is missing; expected {expected}")
        return self.content[key]

    def text(self, key: str, expected: str = "text") -> str:
        """Return a text."""
        value = self.take(key, expected)
        if not isinstance(value, str):
            raise self.fault(key, f"is {value!r}; expected {expected}")
        return value

    def choice(self, key: str, choices: tuple[str, ...]) -> str:
        """Return the text of an entry, which must be one of these; by default the first one."""
        value = self.content[key] if key in self else choices[0]
        if value not in choices:
            raise self.fault(key, f"is {value!r}; expected one of {', '.join(map(repr, choices))}")
        return str(value)

    def only_key(self, *keys: str) -> str | None:
        """Return which one of these keys is given, or ``None``; more than one is an error."""
        present = [key for key in keys if key in self]
        if len(present) > 1:
            raise self.fault("", f"has {' and '.join(present)}; expected one of {', '.join(keys)}")
        return present[0] if present else None

    def table(self, key: str, required: bool = True) -> TomlTable:
        """Return a table below this one."""
        value = self.take(key, "a table") if required else self.content.get(key, {})
        if not isinstance(value, dict):
            raise self.fault(key, f"is {value!r}; expected a table")
        return TomlTable(self.path, f"{self.location}.{key}" if self.location else key, value, self.units)

    def tables(self, key: str) -> list[TomlTable]:
        """Return the tables of an array such as ``[[body]]``."""
        location = f"{self.location}.{key}" if self.location else key
        value = self.take(key, f"at least one [[{location}]]")
        if not isinstance(value, list) or not value or not all(isinstance(item, dict) for item in value):
            raise self.fault(key, f"is {value!r}; expected tables, each headed [[{location}]]")
        return [TomlTable(self.path, f"{location}[{k}]", item, self.units) for k, item in enumerate(value)]

    def number(self, key: str, dimension: str) -> float:
        """Return a number in the table's units, or a pure one, of the dimension "number"; a text may have a unit."""
        return self._number(key, self.take(key, _expected("a number", dimension)), "a number", dimension)

    def numbers(self, kinds: Mapping[str, Number]) -> dict[str, float]:
        """Return those numbers of some kinds that are given, by their keys."""
        return {key: self.number(key, kind.dimension) for key, kind in kinds.items() if key in self}

    def vector(self, key: str, dimension: str, count: int | None = None) -> Floats:
        """Return a list of numbers in the table's units, of any length unless a count is given."""
        what = f"{count or 'a list of'} numbers"
        items = self.take(key, _expected(what, dimension))
        if not isinstance(items, list) or (count and len(items) != count):
            raise self.fault(key, f"is {items!r}; expected {_expected(what, dimension)}")
        return np.array([self._number(key, item, what, dimension) for item in items])

    def array(self, key: str, dimension: str) -> Any:
        """Return a number, a list of numbers, or a list of lists of them."""

        def numbers_of(item: Any) -> Any:
            if isinstance(item, list):
                return [numbers_of(part) for part in item]
            return self._number(key, item, "numbers", dimension)

        return numbers_of(self.content[key])

    def _number(self, key: str, item: Any, what: str, dimension: str) -> float:
        kinds: Any = int | float if dimension == "number" else int | float | str
        if isinstance(item, bool) or not isinstance(item, kinds):
            raise self.fault(key, f"is {item!r}; expected {_expected(what, dimension)}")
        try:
            return self.units.number(item, dimension, key)
        except InvalidInput as error:
            raise self.fault(key, str(error).removeprefix(f"{key} ")) from error

    def fields_of(self, kind: type, key: str) -> list[str]:
        """Return the names of those fields of a dataclass that are given beside a key; required ones must be."""
        entries = fields(kind)
        self.only(key, *(entry.name for entry in entries))
        for entry in entries:
            if entry.default is MISSING and entry.name not in self:
                raise self.fault(entry.name, f"is missing; {kind.__name__} needs it")
        return [entry.name for entry in entries if entry.name in self]

    def only(self, *keys: str) -> TomlTable:
        """Refuse keys other than these, before a misspelt one is reported as missing."""
        for key in self.content:
            if key not in keys:
                raise self.fault(key, f"is not a key of this table; {suggestion(key, keys)}")
        return self


def _expected(what: str, dimension: str) -> str:
    return what if dimension == "number" else f"{what}, or text with a unit"
