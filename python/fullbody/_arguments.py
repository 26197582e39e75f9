"""Checks that many functions share: places of bodies, directions, names of options."""

from __future__ import annotations

import difflib
import functools
import inspect
import operator
import unicodedata
from collections.abc import Callable, Iterable, Sequence
from typing import Any, ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

from ._units import Units, gathered, is_quantity, numbers, strip_to
from .errors import InvalidInput

_P = ParamSpec("_P")
_R = TypeVar("_R")


def integer(value: object) -> int | None:
    """A whole number of Python or numpy, or ``None``."""
    try:
        return None if isinstance(value, bool) else operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return None


def place(value: object, names: Sequence[str], what: str) -> int:
    """The place of a body from its place or name, or an error that says which there are."""
    if isinstance(value, str):
        if value in names:
            return names.index(value)
        raise InvalidInput(f"{what} is {value!r}; {suggestion(value, names, 'one')}")
    index = integer(value)
    if index is None or not 0 <= index < len(names):
        places = "0, the only body" if len(names) == 1 else f"0 to {len(names) - 1}, one of the {len(names)} bodies"
        raise InvalidInput(f"{what} is {value!r}; expected {places}")
    return index


def name_of(value: object) -> str | None:
    """A body's name: text that files and pictures can hold, or none."""
    if value is not None and not isinstance(value, str):
        raise InvalidInput(f"name is {value!r}; expected text")
    # Control characters, and halves of characters, which no encoding has.
    if value is not None and any(unicodedata.category(letter) in ("Cc", "Cs") for letter in value):
        raise InvalidInput(f"name is {value!r}; expected text without control characters")
    return value


def positive(value: Any, unit: str, what: str) -> Any:
    """A finite number or Quantity above zero, of a unit like this one where it has any."""
    try:
        value = gathered(value, what)
        number = np.asarray(getattr(value, "value", value))
        if number.ndim != 0 or number.dtype.kind not in "iuf" or not np.isfinite(number) or number <= 0:
            raise InvalidInput(f"{what} is {value!r}; expected")
    except ValueError as error:
        raise InvalidInput(f"{what} is {value!r}; expected a finite number above zero") from error
    if is_quantity(value):
        from astropy import units as u

        strip_to(value, u.Unit(unit), what)
    return value


def refuse_mixture(values: dict[str, Any]) -> bool:
    """Whether all of these have units; an error if only some have."""
    united = [name for name, value in values.items() if is_quantity(value)]
    plain = [name for name in values if name not in united]
    if united and plain:
        raise InvalidInput(
            f"{united[0]} has the unit {values[united[0]].unit}, but {plain[0]} has none; expected both or neither"
        )
    return bool(united)


def vectors(value: Any, what: str, one: bool = False) -> Any:
    """Finite vectors (..., 3), or one (3,), with their unit where they have one."""
    value = gathered(value, what)
    array = value if is_quantity(value) else numbers(value, what)
    if array.shape[-1:] != (3,) or (one and array.ndim != 1):
        raise InvalidInput(f"{what} has shape {array.shape}; expected {'(3,)' if one else '(..., 3)'}")
    if not np.isfinite(array).all():
        raise InvalidInput(f"{what} is {value!r}; expected finite numbers")
    return array


def directions(value: Any, what: str, one: bool = False) -> npt.NDArray[np.float64]:
    """Vectors of any length above zero and in any unit, as numbers."""
    array = vectors(value, what, one)
    plain: npt.NDArray[np.float64] = np.array(array.value if is_quantity(array) else array, dtype=np.float64)
    if not plain.any(axis=-1).all():
        raise InvalidInput(f"{what} is {value!r}; expected three numbers that are not all zero")
    return plain


def pole(value: Any, what: str) -> tuple[float, float]:
    """The longitude and latitude of a direction, radians."""
    expected = "expected (longitude, latitude) in radians, the latitude from -pi/2 to pi/2, or Quantities"
    try:
        longitude, latitude = value
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{what} is {value!r}; {expected}") from error
    lon = Units().number(longitude, "angle", f"longitude of {what}")
    lat = Units().number(latitude, "angle", f"latitude of {what}")
    if not -np.pi / 2 <= lat <= np.pi / 2:
        raise InvalidInput(f"{what} is ({longitude}, {latitude}); {expected}")
    return lon, lat


def suggestion(name: str, known: Iterable[str], wanted: str = "some") -> str:
    """What a misspelt name may have meant, and what there is."""
    known = list(known)
    close = difflib.get_close_matches(name, known, 1)
    return (f"did you mean {close[0]!r}? " if close else "") + f"expected {wanted} of {', '.join(known)}"


def refuse_unknown(given: Iterable[str], known: Iterable[str], owner: str) -> None:
    """An error for the first name that is none of the known ones."""
    known = list(known)
    for name in given:
        if name not in known:
            raise InvalidInput(f"{name!r} is no option of {owner}; {suggestion(name, known)}")


def options_of(function: Callable[..., Any]) -> list[str]:
    """The names of a function's arguments of its own."""
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return [name for name, p in inspect.signature(function).parameters.items() if p.kind in kinds and name != "self"]


def named_options(owner: str) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Have a function answer unknown keywords with the package's error instead of a TypeError."""

    def decorate(function: Callable[_P, _R]) -> Callable[_P, _R]:
        known = options_of(function)

        @functools.wraps(function)
        def call(*args: _P.args, **kwargs: _P.kwargs) -> _R:
            refuse_unknown(kwargs, known, owner)
            return function(*args, **kwargs)

        return call

    return decorate
