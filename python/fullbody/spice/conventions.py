"""Conversion of a system to SPICE's conventions of time, length, axes and numbers of bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import epochs
from ..base.arguments import integer, suggestion
from ..base.units import need
from ..errors import InvalidInput
from ..frames import rotation
from ..model.context import SystemLike


def spiceypy() -> Any:
    """Import the package spiceypy, or raise an error that says how to install it."""
    with need("spice", "a SPICE kernel"):
        import spiceypy
    return spiceypy


def message_of(error: Exception) -> str:
    """Return the message of an error of SPICE in one line."""
    return str(getattr(error, "long", "") or getattr(error, "explain", "") or error).strip()


class Conventions:
    """The conversions of a system's times and vectors to SPICE's.

    The system's units of length in km and of time in s are ``km`` and ``second``, ``axes`` (3, 3) is the matrix from
    the system's axes to those of J2000, and ``epoch`` is time zero in seconds of TDB past J2000.
    """

    def __init__(self, system: SystemLike, what: str) -> None:
        spiceypy()
        missing = {
            "units": (system.context.units.names, "units=('km', 'hour', 'kg')"),
            "epoch": (system.context.epoch, "epoch='2022-09-26T00:00:00 TDB'"),
            "frame": (system.context.frame, "frame='ecliptic'"),
        }
        for name, (value, example) in missing.items():
            if value is None:
                raise InvalidInput(f"{what} needs the system's {name}; give fullbody.System(..., {example})")
        self.km = float(system.context.units.unit("length").to("km"))
        self.second = float(system.context.units.unit("time").to("s"))
        self.axes = rotation(system.context.frame, "equatorial")
        date = epochs.to_time(str(system.context.epoch)).tdb
        # The fraction of the day has digits that would be lost in the number of days.
        self.epoch = float((date.jd1 - 2451545.0) * 86400.0 + date.jd2 * 86400.0)

    def et(self, time: Any) -> Any:
        """Convert times of the system to seconds of TDB past J2000, which doubles today resolve to 1e-7 s."""
        return self.epoch + np.asarray(time) * self.second

    def time(self, et: Any) -> Any:
        """Convert seconds of TDB past J2000 to times of the system."""
        return (np.asarray(et) - self.epoch) / self.second


def number(value: object, what: str) -> int:
    """Check a body's number with NAIF."""
    numbers = integer(value)
    if numbers is None or numbers == 0 or not abs(numbers) < 2**31:
        raise InvalidInput(f"{what} is {value!r}; expected the number that NAIF gives it, such as 120065803")
    return numbers


def body_numbers(values: Any, names: tuple[str, ...]) -> dict[int, int]:
    """Return NAIF's number of each named body by its index in the system."""
    try:
        pairs = dict(values).items()
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"ids is {values!r}; expected NAIF's numbers by name, such as {_example(names)}") from error
    numbers: dict[int, int] = {}
    for name, value in pairs:
        if name not in names:
            raise InvalidInput(f"ids has {name!r}; {suggestion(str(name), names, 'names of bodies:')}")
        index, code = names.index(name), number(value, f"the id of {name}")
        if code in numbers.values():
            raise InvalidInput(f"the id of {name} is {code}, that of another body; expected distinct numbers")
        numbers[index] = code
    if not numbers:
        raise InvalidInput(f"ids names no body; expected such as {_example(names)}")
    return numbers


def _example(names: tuple[str, ...]) -> dict[str, int]:
    return {name: 20000000 + 100000000 * (9 if k == 0 else k) + 65803 for k, name in enumerate(names[:3])}
