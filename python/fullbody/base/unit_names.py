"""Names of units as users write them, the units of dimensions, and factors between units.

``astropy.units`` is imported only once one of them is used.
"""

from __future__ import annotations

import re
from functools import cache, lru_cache
from typing import Any

import numpy as np

from .limits import LARGEST, SMALLEST

#: Exponents of length, time, mass and angle.
_DIMENSIONS: dict[str, tuple[int, int, int, int]] = {
    "length": (1, 0, 0, 0),
    "time": (0, 1, 0, 0),
    "mass": (0, 0, 1, 0),
    "density": (-3, 0, 1, 0),
    "area": (2, 0, 0, 0),
    "volume": (3, 0, 0, 0),
    "inertia": (2, 0, 1, 0),
    "velocity": (1, -1, 0, 0),
    "spin": (0, -1, 0, 1),
    "angle": (0, 0, 0, 1),
    "force": (1, -2, 1, 0),
    "torque": (2, -2, 1, 0),
    "energy": (2, -2, 1, 0),
    "momentum": (1, -1, 1, 0),
    "angular momentum": (2, -1, 1, 0),
    "potential": (2, -2, 0, 0),
    "acceleration": (1, -2, 0, 0),
    "gravity gradient": (0, -2, 0, 0),
    "angular acceleration": (0, -2, 0, 1),
    "pressure": (-1, -2, 1, 0),
    "rate": (0, -1, 0, 0),
    "force gradient": (0, -2, 1, 0),
    "number": (0, 0, 0, 0),
    "G": (3, -2, -1, 0),
    "mu": (3, -2, 0, 0),
    "area to mass": (2, 0, -1, 0),
}


#: Plurals and short forms that astropy does not know. A month is not among them, since it has no fixed length.
_WORDS = {
    "s": ("seconds", "sec", "secs"),
    "min": ("minutes", "mins"),
    "hour": ("hours", "hrs"),
    "day": ("days",),
    "week": ("weeks", "wks"),
    "year": ("years", "yrs"),
    "deg": ("degrees", "degs"),
    "rad": ("radians", "rads"),
    "m": ("meters", "metre", "metres"),
    "km": ("kilometers", "kilometre", "kilometres", "kms"),
    "cm": ("centimeters", "centimetre", "centimetres"),
    "mm": ("millimeters", "millimetre", "millimetres"),
    "kg": ("kilograms", "kgs"),
    "g": ("grams",),
    "t": ("tonnes",),
}
#: Short forms that are not accepted, since they are ambiguous, with the units that they may mean.
_AMBIGUOUS = {"cc": "cm3", "ccm": "cm3", "gm": "g", "gms": "g", "gr": "g", "mtr": "m", "mtrs": "m", "kmh": "km/h"}


def read(kind: Any, text: str) -> Any:
    """Return the Quantity or the unit of a text, the unit of which may be spelt as in plain English."""
    try:
        return kind(text)
    except (TypeError, ValueError):
        from astropy import units as u

        # Enabling the aliases takes half a millisecond.
        with u.add_enabled_aliases({word: getattr(u, unit) for unit, words in _WORDS.items() for word in words}):
            return kind(text)


def intended_unit(unit: str) -> str | None:
    """Return the unit that a text which is none may mean, or ``None``."""
    better = re.sub(r"[A-Za-z]+", lambda word: _AMBIGUOUS.get(word[0].lower(), word[0]), unit)
    return better if better != unit else None


@cache
def unit_named(text: str) -> Any:
    """Return the unit of a text in the program, which is read once."""
    from astropy import units as u

    return u.Unit(text)


@lru_cache(maxsize=1024)
def derived(length: Any, time: Any, mass: Any, dimension: str) -> Any:
    """Return the unit of a dimension as the same object at each call, since astropy takes long to multiply units."""
    from astropy import units as u

    powers = _DIMENSIONS[dimension]
    return length ** powers[0] * time ** powers[1] * mass ** powers[2] * u.rad ** powers[3]


@lru_cache(maxsize=1024)
def factor(unit: Any, target: Any) -> float:
    """Return the factor from one unit to another one, which astropy takes long to find."""
    from astropy import units as u

    factor = float(unit.to(target, 1.0, equivalencies=u.dimensionless_angles()))
    if not 0.0 < abs(factor) < np.inf:
        raise OverflowError(f"the factor between the units is {factor}")
    return factor


def usable_unit(value: Any) -> Any:
    """Return a unit from anything that astropy takes for one, unless numbers in it overflow when they are converted."""
    from astropy import units as u

    unit = read(u.Unit, value) if isinstance(value, str) else u.Unit(value)
    if isinstance(unit, u.StructuredUnit):
        raise ValueError("it is a structure of several units")
    try:
        scale = float(getattr(unit.decompose(), "scale", 1.0))
    except (ArithmeticError, TypeError) as error:
        raise ValueError(f"its scale is out of range: {error}") from error
    # The scale of a magnitude is negative: it is -0.4 powers of ten.
    if not SMALLEST <= abs(scale) <= LARGEST:
        raise ValueError(f"its scale is {scale}; expected 1e-60 to 1e60 in units of the SI")
    return unit


def with_error(quantity: Any, error: Any) -> Any:
    """Return a Quantity that knows its standard error, in its own unit, until it is computed with."""
    quantity._standard_error = error
    return quantity


def error_of(value: Any) -> Any:
    """Return the standard error of a value, in its own unit, or ``None`` if it was given without one."""
    return getattr(value, "_standard_error", None)
