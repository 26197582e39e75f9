"""Dates: the date of time zero, stored as text so that files hold it without loss, and dates of observations."""

from __future__ import annotations

import re
from datetime import datetime
from functools import lru_cache
from typing import Any

import numpy as np

from ..errors import InvalidInput
from .foreign import are_dates, shown
from .units import need

_SCALES = ("tai", "tcb", "tcg", "tdb", "tt", "ut1", "utc")
_DAY = re.compile(r"\d{4}-\d\d-\d\d")
_TEXT = re.compile(r"(\d{4}-\d\d-\d\d)(?:[T ](\d\d:\d\d(?::\d\d(?:\.\d+)?)?))?(?: ([A-Za-z0-9]{2,3})|(Z))")
#: The spacing of a column's numbers, in s, above which they are too coarse for dates.
_COARSE = 1.0


def to_text(epoch: Any, what: str = "epoch") -> str:
    """Return a date as text such as ``"2022-09-26T00:00:00 TDB"``."""
    if isinstance(epoch, str):
        match = _TEXT.fullmatch(epoch.strip())
        if match is None or (match[3] or "utc").lower() not in _SCALES:
            expected = "expected a date with its time scale, such as '2022-09-26T00:00:00 TDB', or a Time"
            raise InvalidInput(f"{what} is {epoch!r}; {expected}")
        return f"{match[1]}{f'T{match[2]}' if match[2] else ''} {(match[3] or 'utc').upper()}"
    epoch = dates(epoch, what)
    if not (are_dates(epoch) and getattr(epoch, "isscalar", False)):
        raise InvalidInput(f"{what} is {shown(epoch)}; expected one astropy Time, or a text such as '2022-09-26 TDB'")
    return _text_of(epoch.scale, float(epoch.jd1), float(epoch.jd2))


@lru_cache(maxsize=256)
def _text_of(scale: str, jd1: float, jd2: float) -> str:
    """Return the text of a date, which astropy takes half a millisecond to write."""
    from astropy.time import Time

    return f"{Time(jd1, jd2, format='jd', scale=scale, precision=9).isot} {scale.upper()}"


def to_time(text: str, what: str = "epoch") -> Any:
    """Return the astropy Time of such a text."""
    with need("units", "a date"):
        import astropy.time  # noqa: F401
    try:
        # A caller may change its copy.
        return _time_of(text).copy()
    except ValueError as error:
        raise InvalidInput(f"{what} is {text!r}: {error}") from error


@lru_cache(maxsize=256)
def _time_of(text: str) -> Any:
    """Return the Time of a text, which astropy takes half a millisecond to read."""
    from astropy.time import Time

    day, scale = text.split(" ")
    return Time(day, scale=scale.lower())


def date(value: Any, what: str) -> Any:
    """Return one date of any kind as a ``Time`` of the scale TDB."""
    return to_time(to_text(value, what), what).tdb


def dates(value: Any, what: str, scale: str = "utc") -> Any:
    """Return dates of any kind as one ``Time``, and values that are not dates unchanged.

    Dates are a ``Time`` or a list of them, texts with their time scale, and dates of Python, numpy and pandas, which
    have the ``scale`` unless they have a time zone.
    """
    if are_dates(value):
        return value
    array = value.to_numpy() if hasattr(value, "to_numpy") else value
    kind = getattr(getattr(array, "dtype", None), "kind", "")
    parts = array.ravel().tolist() if kind in ("O", "U", "T") else array if isinstance(array, list | tuple) else [array]
    entries: Any = parts
    if kind == "M":
        entries = np.asarray(array, dtype="datetime64[ns]").ravel()
    elif all(isinstance(part, str) or are_dates(part) for part in parts):
        if not any(are_dates(part) or _DAY.match(part.strip()) for part in parts):
            return value
        entries = [part if are_dates(part) else to_time(to_text(part, what), what) for part in parts]
    elif not all(isinstance(part, datetime | np.datetime64) for part in parts):
        return value
    with need("units", "dates"):
        from astropy.time import Time

    try:
        times = Time(entries, scale=None if are_dates(entries[0]) else scale)
    except (ValueError, TypeError) as error:
        raise InvalidInput(f"{what} is {shown(value)}, which cannot be read as dates: {error}") from error
    return times.reshape(np.shape(array)) if np.ndim(array) != 1 else times


def refuse_coarse(value: Any, seconds: Any, what: str) -> None:
    """Raise an error for times as numbers whose type rounds them to more than a second, or makes several of them equal.

    The numbers are those that were given, before a conversion to floats of 64 bits; ``seconds`` is a function that
    returns the time in s between two of them, without which only equal times of a short type count.
    """
    numbers = np.ravel(np.asarray(getattr(value, "value", value)))
    kind = numbers.dtype.kind
    if kind not in ("f" if seconds is None else "fiu") or not numbers.size or numbers.dtype == np.float64:
        return
    largest = numbers[np.nanargmax(np.abs(numbers))]
    following = np.nextafter(largest, type(largest)(np.inf)) if kind == "f" else largest + 1
    spacing, distinct = float(following) - float(largest), np.unique(numbers).astype(np.float64)
    rounded = kind == "f" and numbers.size > 1 and (len(distinct) == 1 or np.diff(distinct).min() < 4 * spacing)
    if rounded or (seconds is not None and seconds(float(largest), float(following)) > _COARSE):
        raise InvalidInput(
            f"{what} are numbers of the type {numbers.dtype}, which near {largest} are {spacing:.3g} apart; expected "
            "float64, in which the data have to be read"
        )
