"""Published numbers in a TOML file: ``{ value = 2.26, unit = "h", error = "0.0001", source = "N20" }`` for a number."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ..base.kinds import choice
from ..errors import InvalidInput

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


def is_published(item: Any) -> bool:
    """Return whether an item of a file is a published number, or a list of them with one unit."""
    return isinstance(item, dict) and "value" in item


def replaced(item: Any, convert: Callable[[Any, str], Any], path: str = "") -> Any:
    """Return the contents of a file with each published number replaced by what ``convert`` makes of value and unit."""
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


def with_unit(value: Any, unit: str) -> Any:
    """Return a number as text with its unit."""
    return f"{value} {unit}" if unit else value


def in_usual_units(value: float, unit: str) -> float:
    """Return a number in km, hour, kg, rad."""
    choice(unit, "unit", _FACTORS)
    return value * _FACTORS[unit]
