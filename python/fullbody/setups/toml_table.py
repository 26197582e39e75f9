"""Tables of a TOML file with their location, so that errors name the file, the key, the value and the expectation.

A number of a file may be published: ``{ value = 2.26, unit = "h", error = "0.0001", source = "N20" }``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import numpy as np

from ..base.arguments import suggestion
from ..base.kinds import Number, choice
from ..base.units import Units
from ..errors import FullbodyError, InvalidInput
from ..typing import Floats

#: Tables and keys of a file that describe a published system and build nothing.
METADATA = (
    *("title", "text", "example", "assumed", "sources", "not_used"),
    *("sun", "variants", "no_frame", "default_frame", "parameters"),
)
#: The keys of a published number. The doubt says how far the number, or its error, could be confirmed.
_KEYS = ("value", "unit", "error", "source", "doubt")
#: Units in km, hour, kg, rad.
_FACTORS = {
    **{"km": 1.0, "m": 1e-3, "au": 149597870.7},
    **{"h": 1.0, "day": 24.0, "s": 1.0 / 3600.0},
    **{"kg": 1.0, "g/cm^3": 1e12, "kg/m^3": 1e9, "km^3/s^2": 3600.0**2},
    **{"rad": 1.0, "deg": math.pi / 180.0, "rad/h": 1.0, "": 1.0},
}


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
        """Return the one of these keys that the table has, or ``None``; more than one is an error."""
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


def is_published(item: Any) -> bool:
    """Return whether an item of a file is a published number, or a list of them with one unit."""
    return isinstance(item, dict) and "value" in item


def replaced(item: Any, convert: Callable[[Any, str], Any], path: str = "") -> Any:
    """Return the contents of a file with each published number replaced by ``convert(value, unit)``."""
    if is_published(item):
        for key in item:
            if key not in _KEYS:
                raise InvalidInput(f"{path}: {key!r} is not a key of a published number; expected {', '.join(_KEYS)}")
        values, unit = item["value"], item.get("unit", "")
        return [convert(value, unit) for value in values] if isinstance(values, list) else convert(values, unit)
    if isinstance(item, dict):
        return {key: replaced(part, convert, f"{path}.{key}" if path else key) for key, part in item.items()}
    if isinstance(item, list):
        return [replaced(part, convert, f"{path}[{index}]") for index, part in enumerate(item)]
    return item


def text_with_unit(value: Any, unit: str) -> Any:
    """Return a number as text with its unit."""
    return f"{value} {unit}" if unit else value


def in_usual_units(value: float, unit: str) -> float:
    """Return a number in km, hour, kg, rad."""
    choice(unit, "unit", _FACTORS)
    return value * _FACTORS[unit]
