"""Checks that many functions share: bodies, directions, angles, seeds and names of options."""

from __future__ import annotations

import inspect
import operator
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from ..errors import InvalidInput, caution
from ..typing import Floats
from .units import UNITLESS, as_quantity, is_quantity, numbers, similar_names

_T = TypeVar("_T")

_TOLERANCE = "integrator=fullbody.Verner98({}=...)"
#: Names that other programs and earlier versions use, with the names that they may mean here. The first of these whose
#: first word is an option of the function is suggested.
_SYNONYMS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("primary", "i"), ("about",)),
    **dict.fromkeys(("secondary", "j"), ("body",)),
    **dict.fromkeys(("t_end", "tend", "tmax", "t_max", "t_final", "end", "duration"), ("until",)),
    **dict.fromkeys(("t_eval", "times", "spacing", "saveat"), ("output", "time")),
    **dict.fromkeys(("dt", "h", "step_size", "timestep"), ("step", "output")),
    **dict.fromkeys(("t", "t0"), ("time",)),
    **{name: (_TOLERANCE.format(name),) for name in ("rtol", "atol")},
    **dict.fromkeys(("tol", "tolerance", "eps"), ("rtol", _TOLERANCE.format("rtol"))),
    **dict.fromkeys(("method", "solver"), ("integrator",)),
    **dict.fromkeys(("axes", "semiaxes"), ("semi_axes",)),
    **dict.fromkeys(("inc", "incl", "inclination"), ("i",)),
    **dict.fromkeys(("raan", "node", "Om"), ("Omega",)),
    **dict.fromkeys(("argp", "peri", "argument_of_periapsis"), ("omega",)),
    **dict.fromkeys(("ma", "M0", "mean_anomaly"), ("M", "mean_anomaly")),
    **dict.fromkeys(("ecc", "eccentricity"), ("e", "eccentricity")),
    **dict.fromkeys(("sma", "semimajor_axis", "semi_major_axis"), ("a", "semi_major_axis")),
    "GM": ("mu",),
    **dict.fromkeys(("r", "x", "pos"), ("position", "radius")),
    **dict.fromkeys(("v", "vel"), ("velocity",)),
    **dict.fromkeys(("q", "quat", "quaternion"), ("attitude",)),
    "angles": ("attitude, or State.from_tait_bryan(angles=...)",),
    "rotation": ("attitude, or State.from_scipy(rotation=...)",),
    **dict.fromkeys(("omega", "angular_velocity"), ("spin",)),
    "m": ("mass",),
    "rho": ("density",),
    "period": ("rotation_period",),
    **dict.fromkeys(("distance", "separation"), ("value", "distance", "semi_major_axis")),
    "value": ("distance",),
    **dict.fromkeys(("function", "func"), ("f",)),
}


def normal_form(text: Any) -> Any:
    """Return a text in the normal form NFC, since an accented letter may be one character or two; else the value."""
    return unicodedata.normalize("NFC", text) if isinstance(text, str) else text


def argument_names(parameters: Mapping[Any, _T]) -> dict[Any, _T]:
    """Return parameters by names in the normal form of Python's identifiers, NFKC; other names are refused."""
    names = {unicodedata.normalize("NFKC", k) if isinstance(k, str) else k: value for k, value in parameters.items()}
    for name in names:
        if not isinstance(name, str) or not name.isidentifier():
            expected = "expected one that an argument of a function may have"
            raise InvalidInput(f"parameters has the name {name!r}; {expected}")
    return names


def integer(value: object) -> int | None:
    """Return the value as an ``int`` if it is a whole number of Python or numpy, else ``None``."""
    try:
        return None if isinstance(value, bool | np.ma.MaskedArray) else operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        return None


def generator(rng: object) -> np.random.Generator:
    """Return the generator of an argument ``rng``: itself, or one with a whole number, zero or above, as its seed."""
    return rng if isinstance(rng, np.random.Generator) else np.random.default_rng(seed_of(rng))


def seed_of(rng: object) -> int:
    """Return the seed of an argument ``rng``: a whole number, zero or above, given or drawn from a numpy generator."""
    seed = int(rng.integers(2**63)) if isinstance(rng, np.random.Generator) else integer(rng)
    if seed is None or seed < 0:
        raise InvalidInput(f"rng is {rng!r}; expected a whole number, zero or above, or a numpy.random.Generator")
    return seed


def index_of(value: object, names: Sequence[str], what: str) -> int:
    """Return the index of a body from its index or name, or raise an error that lists the ``names`` of all."""
    if isinstance(value, str):
        value = normal_form(value)
        if value in names:
            return names.index(value)
        raise InvalidInput(f"{what} is {value!r}; {suggestion(str(value), names, 'one')}")
    index = integer(value)
    if index is None or not 0 <= index < len(names):
        indices = "0, the only body" if len(names) == 1 else f"0 to {len(names) - 1}, one of the {len(names)} bodies"
        raise InvalidInput(f"{what} is {value!r}; expected {indices}")
    return index


def sequence(value: Any, kind: type[_T], what: str, expected: str, members_expected: str) -> tuple[_T, ...]:
    """Return a sequence of objects of one kind, or raise an error that shows the first of another kind."""
    try:
        members = tuple(value)
    except TypeError as error:
        raise InvalidInput(f"{what} is {value!r}; expected {expected}") from error
    for member in members:
        if not isinstance(member, kind):
            raise InvalidInput(f"{what} has {member!r}; expected {members_expected}")
    return members


def names_of(value: Any, what: str) -> list[str]:
    """Return a list of names, or raise an error that shows an element that is not a name."""
    expected = "a list of names such as ['G', 'mass of Alpha']"
    if isinstance(value, str):
        raise InvalidInput(f"{what} is {value!r}, which is text; expected {expected}")
    return [normal_form(name) for name in sequence(value, str, what, expected, "names")]


def name_of(value: object) -> str | None:
    """Return a body's name in the form NFC, or ``None``; text that files and pictures cannot hold is refused."""
    if value is None:
        return None
    if not isinstance(value, str):
        raise InvalidInput(f"name is {value!r}; expected text")
    # Files and pictures cannot hold control characters (Cc) and unpaired surrogates (Cs).
    if any(unicodedata.category(letter) in ("Cc", "Cs") for letter in value):
        raise InvalidInput(f"name is {value!r}; expected text without control characters")
    return normal_form(value)


def refuse_mixture(values: dict[str, Any]) -> bool:
    """Return whether all of these values have units, and raise an error if only some have."""
    with_units = [name for name, value in values.items() if is_quantity(value)]
    unitless = [name for name in values if name not in with_units]
    if with_units and unitless:
        unit = f"{with_units[0]} has the unit {values[with_units[0]].unit}"
        raise InvalidInput(f"{unit}, but {unitless[0]} has none; expected both or neither")
    return bool(with_units)


def directions(value: Any, what: str, single: bool = False) -> Floats:
    """Return vectors (..., 3), or one (3,), of any length above zero in any unit, as numbers of the same length."""
    value = as_quantity(value, what)
    vectors = UNITLESS.numbers(getattr(value, "value", value), "number", what, (3,) if single else ("...", 3))
    if not vectors.any(axis=-1).all():
        raise InvalidInput(f"{what} is {value!r}; expected three numbers that are not all zero")
    return vectors


def warn_if_degrees(value: Any, what: str, turns: float = 2.0) -> None:
    """Warn of plain numbers that look like degrees: above ``turns`` in radians, up to 3600, with at most six decimals.

    Sums and differences of two angles within a turn stay below two turns. An angle that a program has computed, such as
    an integrated rotation or a mean anomaly, may be larger, but it has all its digits.
    """
    value = as_quantity(value, what, "angle")
    if is_quantity(value):
        return
    sizes = np.abs(numbers(value, what))
    beyond = sizes[sizes > 2.0 * np.pi * turns]
    largest = beyond.max(initial=0.0)
    if 0.0 < largest <= 3600.0 and (np.abs(beyond * 1e6 - np.round(beyond * 1e6)) < 1e-4).all():
        caution(
            f"{what} {'is' if np.ndim(value) == 0 else 'has values up to'} {largest:.6g} radians in size, "
            f"{largest / (2 * np.pi):.3g} turns; give degrees as a Quantity, or as text such as '{largest:.6g} deg'"
        )


def longitude_latitude(value: Any, what: str) -> tuple[float, float]:
    """Return a pair of longitude and latitude in radians."""
    expected = "expected (longitude, latitude) in radians, the latitude from -pi/2 to pi/2, or Quantities"
    try:
        longitude, latitude = value
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{what} is {value!r}; {expected}") from error
    lon = UNITLESS.number(longitude, "angle", f"longitude of {what}")
    lat = UNITLESS.number(latitude, "angle", f"latitude of {what}")
    if not -np.pi / 2 <= lat <= np.pi / 2:
        raise InvalidInput(f"{what} is ({longitude}, {latitude}); {expected}")
    warn_if_degrees(longitude, f"longitude of {what}")
    return lon, lat


def suggestion(name: str, names: Iterable[str], quantifier: str = "some") -> str:
    """Return the part of an error about an unknown name: the name that it may mean, and the list of all names."""
    names = list(names)
    synonyms = [synonym for synonym in _SYNONYMS.get(name, ()) if re.split(r"\W", synonym)[0] in names]
    similar = synonyms or similar_names(name, names)
    return (f"did you mean {similar[0]!r}? " if similar else "") + f"expected {quantifier} of {', '.join(names)}"


def refuse_unknown(names: Iterable[str], options: Iterable[str], owner: str) -> None:
    """Raise an error for the first name that is not an option of the ``owner``."""
    options = list(options)
    for name in names:
        if name not in options:
            raise InvalidInput(f"{name!r} is not an option of {owner}; {suggestion(name, options)}")


def options_of(function: Callable[..., Any]) -> list[str]:
    """Return the names of a function's arguments, without ``self``, ``cls``, ``*args`` and ``**kwargs``."""
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    parameters = inspect.signature(function).parameters.items()
    return [name for name, p in parameters if p.kind in kinds and name not in ("self", "cls")]
