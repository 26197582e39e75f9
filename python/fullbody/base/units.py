"""Units at the boundary: Quantities are stripped on the way in and attached on the way out.

``astropy.units`` is imported only once a Quantity or ``units=`` is seen.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache, cached_property, lru_cache
from typing import Any

import numpy as np

from ..errors import InvalidInput
from ..typing import Floats, Scalar
from .foreign import array_or_quantity, shown
from .limits import FINITE, Limits
from .unit_names import derived, error_of, factor, intended_unit, usable_unit, with_error
from .version import to_install

#: The unit of each dimension that error messages use in examples of text.
_EXAMPLES = {
    "length": "km",
    "time": "h",
    "mass": "kg",
    "density": "g/cm3",
    "velocity": "m/s",
    "spin": "rad/h",
    "angle": "deg",
    "force": "N",
    "torque": "N m",
    "angular acceleration": "rad/day2",
    "pressure": "Pa",
    "G": "m3/(kg s2)",
    "mu": "km3/s2",
    "area to mass": "m2/kg",
    "number": "",
}
#: A number at the beginning of a text, before its unit.
_NUMBER = re.compile(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*(?=\S)")
#: The units of ``units=True``, followed by other units that a misspelt name may mean.
DEFAULT_UNITS = ("km", "hour", "kg")
_COMMON = (
    ("km", "m", "cm", "mm", "au", "AU", "R_earth", "R_jup", "R_sun", "lyr", "pc"),
    ("hour", "h", "hr", "s", "second", "min", "minute", "day", "d", "week", "yr", "year"),
    ("kg", "g", "t", "M_earth", "M_jup", "M_sun"),
)


def is_quantity(value: object) -> bool:
    """Return whether a value has a unit."""
    return hasattr(value, "unit") and hasattr(value, "to_value")


def without_unit(value: Any) -> Floats:
    """Return the numbers of a Quantity in its own unit, or plain numbers as they are, as an array of floats."""
    return np.asarray(getattr(value, "value", value), dtype=np.float64)


def refuse_booleans(value: object, what: str, expected: str = "numbers") -> None:
    """Raise an error for True and False, and for arrays of them, where numbers are meant."""
    if isinstance(value, bool | np.bool_):
        raise InvalidInput(f"{what} is {value!r}; expected {expected}")
    if getattr(getattr(value, "dtype", None), "kind", "") == "b":
        raise InvalidInput(f"{what} is an array of True and False; expected numbers")
    if isinstance(value, list | tuple):
        for part in value:
            if not _is_number(part):
                refuse_booleans(part, what, expected)


def _is_number(value: object) -> bool:
    """Return whether a value is one of Python's own numbers, of which True and False are none."""
    return type(value) is float or type(value) is int


def numbers(value: object, what: str, expected: str = "numbers") -> Floats:
    """Return a float array of pure numbers, or raise an error that names the argument."""
    value = as_quantity(value, what, "number", expected)
    if not is_quantity(value):
        return _floats(value, what, expected)
    from astropy import units as u

    try:
        return _floats(value.to_value(u.dimensionless_unscaled), what)  # type: ignore[attr-defined]
    except u.UnitConversionError as error:
        raise InvalidInput(f"{what} has the unit {value.unit}; expected pure numbers") from error  # type: ignore[attr-defined]


def _floats(value: object, what: str, expected: str = "numbers") -> Floats:
    try:
        array = np.asarray(value)
        text = array.dtype.kind == "O" and any(part is None or isinstance(part, str | bytes) for part in array.flat)
        if value is None or array.dtype.kind not in "iufO" or text:
            raise TypeError("numpy would make it nan or one, drop the imaginary part, or read the text")
        return np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"{what} is {shown(value)}; expected {expected}") from error


def as_quantity(value: Any, what: str, dimension: str = "any", expected: str = "numbers") -> Any:
    """Return text such as ``"1 day"``, a list of texts and Quantities, or another library's value, as one Quantity.

    Values without a unit are returned as they are. A mixture with plain numbers is refused, since numpy would take the
    Quantities' numbers and drop their units. Masked values are refused, since numpy would take what lies under the
    mask. The dimension chooses the example in error messages.
    """
    kind = type(value)
    if isinstance(value, float | int) or (kind is np.ndarray and value.dtype.kind in "fiu"):
        return value
    # These two need no conversion, and asking them for attributes that they lack takes as long as a small computation.
    if kind.__module__ == "astropy.units.quantity" or (kind in (list, tuple) and all(map(_is_number, value))):
        return value
    if isinstance(value, str):
        return from_text(value, what, dimension, expected)
    refuse_masked(value, what)
    if not isinstance(value, list | tuple):
        return array_or_quantity(value, what)
    parts = [as_quantity(part, what, dimension, expected) for part in value]
    with_units = [part for part in parts if is_quantity(part)]
    if not with_units:
        return value
    if len(with_units) < len(parts):
        raise InvalidInput(f"{what} mixes Quantities and plain numbers; expected one or the other throughout")
    from astropy import units as u

    try:
        quantity = u.Quantity(parts)
    except (u.UnitConversionError, ValueError, TypeError) as error:
        raise InvalidInput(f"{what} has parts that do not go together: {error}") from error
    if any(error_of(part) is not None for part in parts):
        with_error(quantity, [(error_of(part) or 0.0) * part.unit.to(quantity.unit) for part in parts])
    return quantity


def refuse_masked(value: Any, what: str) -> None:
    """Raise an error for a masked value, and for an array or a list that contains one."""
    mask = getattr(value, "mask", None)
    if isinstance(value, list | tuple):
        masked = sum(part is np.ma.masked for part in value)
        size = len(value)
    elif isinstance(value, np.ndarray) and value.dtype == object:
        masked, size = sum(part is np.ma.masked for part in value.flat), value.size
    elif isinstance(mask, np.ndarray | np.bool_):
        masked, size = int(np.sum(mask)), np.size(mask)
    else:
        return
    if masked:
        masked_text = "is masked" if size == 1 else f"has {masked} masked value{'s' if masked > 1 else ''} of {size}"
        raise InvalidInput(f"{what} {masked_text}; expected numbers throughout")


def from_text(text: str, what: str, dimension: str = "any", expected: str = "numbers") -> Any:
    """Return the Quantity of a text with a unit."""
    with need("units", "text with a unit"):
        from astropy import units as u

    from .printed import printed

    unit = _EXAMPLES.get(dimension)
    example = f", such as '2.5 {unit}'" if unit else ""
    wanted = expected if dimension == "number" else f"{expected}, or text with a unit{example}"
    try:
        quantity = printed(text, what)
    except InvalidInput:
        # This error is a ValueError as well, and says more.
        raise
    except (TypeError, ValueError) as error:
        unknown, number = "", _NUMBER.match(text)
        if number:
            name = text[number.end() :]
            better = intended_unit(name)
            guess = f"; did you mean '{number[0].strip()} {better}'?" if better else ";"
            unknown = f", whose unit {name!r} is not known{guess}"
        raise InvalidInput(f"{what} is {text!r}{unknown or ';'} expected {wanted}") from error
    if quantity.unit == u.dimensionless_unscaled:
        if dimension == "number":
            if error_of(quantity) is not None:
                return quantity
            raise InvalidInput(f"{what} is {text!r}, which is text; expected plain {expected}")
        wanted = f"text such as '{text} {unit}', or a number" if unit else expected
        raise InvalidInput(f"{what} is {text!r}, which has no unit; expected {wanted}")
    return quantity


@contextmanager
def need(extra: str | None, what: str) -> Iterator[None]:
    """Context manager that makes the error about a missing optional package say what to install."""
    try:
        yield
    except ModuleNotFoundError as error:
        name = (error.name or "").partition(".")[0]
        install = to_install(name, extra)
        # The error itself is left out, since its traceback would bury this line.
        raise ModuleNotFoundError(f"{what} needs the package {name}: pip install {install}", name=name) from None


class Units:
    """The units of length, time and mass of a system, or none for plain numbers; ``True`` stands for km, hour, kg."""

    def __init__(self, names: tuple[object, object, object] | bool | None = None) -> None:
        if isinstance(names, bool | np.bool_):
            names = DEFAULT_UNITS if names else None
        self._base: tuple[Any, Any, Any] | None = None
        if names is None:
            return
        with need("units", "a system with units"):
            from astropy import units as u

        try:
            length, time, mass = names
        except (TypeError, ValueError) as error:
            raise InvalidInput(f"units is {names!r}; expected (length, time, mass), such as {DEFAULT_UNITS}") from error
        parts = zip((length, time, mass), _COMMON, strict=True)
        base = tuple(_unit(name, common) for name, common in parts)
        for unit, expected in zip(base, (u.m, u.s, u.kg), strict=True):
            if not unit.is_equivalent(expected):
                kind = f"a unit of {expected.physical_type} there, such as {expected}"
                raise InvalidInput(f"units has {str(unit)!r}; expected {kind}")
        self._base = base

    @property
    def defined(self) -> bool:
        """Return whether results are Quantities."""
        return self._base is not None

    @property
    def names(self) -> tuple[str, str, str] | None:
        """Return the units as strings."""
        base = self._base
        return None if base is None else (str(base[0]), str(base[1]), str(base[2]))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Units) and self.names == other.names

    def __hash__(self) -> int:
        return hash(self.names)

    def unit(self, dimension: str) -> Any:
        """Return the unit of a dimension; angles are in radians."""
        if self._base is None:
            raise InvalidInput("this system has no units; give fullbody.System(..., units=('km', 'hour', 'kg'))")
        return derived(*self._base, dimension)

    def strip(self, value: object, dimension: str, what: str, expected: str = "numbers") -> Floats:
        """Return a value as numbers in this system's units."""
        if dimension == "number":
            return numbers(value, what, expected)
        value = as_quantity(value, what, dimension, expected)
        if not is_quantity(value):
            return _floats(value, what, expected)
        from astropy import units as u

        if dimension == "angle":
            unit = u.rad
        elif self._base is None:
            raise InvalidInput(
                f"{what} has the unit {value.unit}, but the system has no units; "  # type: ignore[attr-defined]
                "give fullbody.System(..., units=('km', 'hour', 'kg')) or a plain number"
            )
        else:
            unit = self.unit(dimension)
        if dimension in ("spin", "angular acceleration") and _counts_turns(value.unit):  # type: ignore[attr-defined]
            expected = "expected an angle by a time, such as rad / h or cycle / h"
            raise InvalidInput(f"{what} has the unit {value.unit}, which may count turns; {expected}")  # type: ignore[attr-defined]
        return strip_to(value, unit, what)

    def number(self, value: object, dimension: str, what: str, limits: Limits = FINITE) -> float:
        """Return a value as one number in this system's units, or raise an error if it is not within the limits."""
        return float(self.numbers(value, dimension, what, (), limits))

    def numbers(
        self,
        value: object,
        dimension: str,
        what: str,
        shape: tuple[int | str, ...] | None = None,
        limits: Limits = FINITE,
    ) -> Floats:
        """Return a value as numbers in this system's units, all within limits, of a shape with letters or ``"..."`` in
        front.
        """
        expected = limits.expected(shape != ())
        refuse_booleans(value, what, expected)
        array = self.strip(value, dimension, what, expected)
        if shape is not None and not has_shape(array, shape):
            if shape and not limits.text:
                wanted = str(shape).replace("'", "")
                raise InvalidInput(f"{what} has shape {array.shape}; expected {wanted}, {expected}")
            raise InvalidInput(f"{what} is {value!r}, of shape {array.shape}; expected {expected}")
        if not np.all(good := limits.contain(array)):
            is_scalar_array = type(value) is np.ndarray and not array.ndim
            bad = array[~good][0] if array.size >= 10 else float(array) if is_scalar_array else value
            raise InvalidInput(f"{what} {'is' if array.size < 10 else 'has'} {bad!r}; expected {expected}")
        return array

    def attach(self, value: Any, dimension: str) -> Any:
        """Return the value as a Quantity, or unchanged if the system has no units."""
        if self._base is None:
            return value
        return value << self.unit(dimension)

    def text(self, value: float, dimension: str, digits: int = 8) -> str:
        """Return a number in this system's units as text, with its unit if the system has units."""
        return f"{float(value):.{digits}g} {self.unit(dimension) if self.defined else ''}".rstrip()

    def attach_mu(self, value: float) -> Scalar:
        """Return G times masses of a system as a Quantity that knows the system's units until it is computed with."""
        mu: Any = self.attach(value, "mu")
        if self.defined:
            mu._units_of_system = self
        scalar_mu: Scalar = mu
        return scalar_mu

    @cached_property
    def gravitational_constant(self) -> float:
        """Return Newton's constant (CODATA, as in astropy) in these units."""
        from astropy import constants

        return float(constants.G.to_value(self.unit("G")))


class AnyUnits(Units):
    """Units where there is no system yet: Quantities of the right dimension count in their own units, angles in rad."""

    def strip(self, value: object, dimension: str, what: str, expected: str = "numbers") -> Floats:
        """Return a value as numbers in its own units."""
        value = as_quantity(value, what, dimension, expected)
        if is_quantity(value) and dimension not in ("angle", "number"):
            _si().strip(value, dimension, what)
            value = value.value  # type: ignore[attr-defined]
        return super().strip(value, dimension, what, expected)


@cache
def _si() -> Units:
    return Units(("m", "s", "kg"))


#: Units for pure numbers and angles, and for numbers before there is a system.
UNITLESS, ANY = Units(), AnyUnits()


def units_of(mu: Any) -> Units | None:
    """Return the units of the system to which this mu belongs; ``None`` for any other number or Quantity."""
    return getattr(mu, "_units_of_system", None)


def similar_names(name: str, names: Sequence[str]) -> list[str]:
    """Return a list with that of some names which resembles this one most, or an empty list."""
    # The import is deferred, since most sessions contain no misspelt name.
    import difflib

    return difflib.get_close_matches(name, names, 1)


def _unit(name: object, common: tuple[str, ...]) -> Any:
    """Return a unit, or raise an error that shows the text that is not a unit."""
    try:
        return usable_unit(name)
    except (TypeError, ValueError, OverflowError) as error:
        similar = similar_names(str(name), common)
        guess = f"did you mean {similar[0]!r}? " if similar else ""
        raise InvalidInput(
            f"units has {name!r}, which is not a unit; {guess}expected (length, time, mass), such as {DEFAULT_UNITS}"
        ) from error


@lru_cache(maxsize=1024)
def _counts_turns(unit: Any) -> bool:
    """Return whether a spin is in hertz, or by a time alone, so that turns would be taken as radians."""
    from astropy import units as u

    alone = unit.decompose().bases == [u.s]
    return alone or any(base.is_equivalent(u.Hz) for base in unit.bases)


def strip_to(value: Any, unit: Any, what: str) -> Floats:
    """Return a Quantity as numbers in a unit, or raise an error that names both units."""
    if value.unit is unit:
        return _floats(value.value, what)
    from astropy import units as u

    try:
        # A value that overflows becomes infinite, which the callers refuse.
        with np.errstate(over="ignore"):
            if isinstance(value.unit, u.UnitBase) and isinstance(unit, u.UnitBase):
                return _floats(value.value * factor(value.unit, unit), what)
            return _floats(value.to_value(unit, equivalencies=u.dimensionless_angles()), what)
    except u.UnitConversionError as error:
        raise InvalidInput(f"{what} has the unit {value.unit}; expected a unit such as {unit}") from error
    except ArithmeticError as error:
        raise InvalidInput(f"{what} has a unit that is too small or too large: {error}") from error


def has_shape(array: Any, wanted: tuple[int | str, ...]) -> bool:
    """Return whether an array has a shape, in which a letter is any length, and ``"..."`` in front any axes."""
    last = wanted[1:] if wanted[:1] == ("...",) else wanted
    present = array.shape[len(array.shape) - len(last) :] if last is not wanted else array.shape
    return len(present) == len(last) and all(n in (length, str(n)) for length, n in zip(present, last, strict=True))


def scalar(value: Floats, what: str) -> float:
    """Return a single number, or raise an error that names the argument."""
    if value.ndim != 0:
        raise InvalidInput(f"{what} has shape {value.shape}; expected a single number")
    return float(value)
