"""The gravitational parameter of an orbit, with the units that it gives to lengths and times."""

from __future__ import annotations

from typing import Any

from ..base.unit_names import unit_named
from ..base.units import as_quantity, is_quantity, numbers, scalar, strip_to, units_of
from ..errors import InvalidInput


def mu_and_units(length: Any, mu: Any, what: str) -> tuple[float, Any, Any]:
    """Return mu as a number, and its units of length and of inverse time, which are ``None`` for plain numbers."""
    mu = as_quantity(mu, "mu", "mu")
    system = units_of(mu)
    if not is_quantity(length) and system is not None:
        # Plain numbers are in the units of the system to which mu belongs.
        return float(mu.value), system.unit("length"), 1 / system.unit("time")
    if is_quantity(length) != is_quantity(mu):
        names, unit = ((what, "mu"), length.unit) if is_quantity(length) else (("mu", what), mu.unit)
        raise InvalidInput(f"{names[0]} has the unit {unit}, but {names[1]} has none; expected both or neither")
    if not is_quantity(length):
        return scalar(numbers(mu, "mu"), "mu"), None, None
    strip_to(length, unit_named("m"), what)
    strip_to(mu, unit_named("m3 / s2"), "mu")
    # Results are in the unit of time in which mu is given.
    powers = zip(mu.unit.bases, mu.unit.powers, strict=True)
    rate = 1 / next((base for base, power in powers if base.is_equivalent("s") and power), unit_named("s"))
    return scalar(strip_to(mu, length.unit**3 * rate**2, "mu"), "mu"), length.unit, rate


def in_unit(unit: Any, value: Any, what: str) -> Any:
    """Return a value as numbers in a unit; plain numbers are taken to be in it already."""
    return strip_to(value, unit, what) if is_quantity(value) else numbers(value, what)
