"""The date of time zero, which is kept as text so that files hold it without loss."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

from ..errors import InvalidInput
from .units import need

_SCALES = ("tai", "tcb", "tcg", "tdb", "tt", "ut1", "utc")
_TEXT = re.compile(r"(\d{4}-\d\d-\d\d(?:T\d\d:\d\d(?::\d\d(?:\.\d+)?)?)?) ([A-Za-z0-9]{2,3})")


def to_text(epoch: Any) -> str:
    """Return an epoch as text such as ``"2022-09-26T00:00:00 TDB"``."""
    if isinstance(epoch, str):
        match = _TEXT.fullmatch(epoch.strip())
        if match is None or match[2].lower() not in _SCALES:
            raise InvalidInput(
                f"epoch is {epoch!r}; expected a date with its scale, such as '2022-09-26T00:00:00 TDB', or a Time"
            )
        return f"{match[1]} {match[2].upper()}"
    if not (hasattr(epoch, "scale") and hasattr(epoch, "jd1") and getattr(epoch, "isscalar", False)):
        raise InvalidInput(f"epoch is {epoch!r}; expected one astropy Time, or a text such as '2022-09-26 TDB'")
    return _text_of(epoch.scale, float(epoch.jd1), float(epoch.jd2))


@lru_cache(maxsize=256)
def _text_of(scale: str, jd1: float, jd2: float) -> str:
    """Return the text of a date, which astropy takes half a millisecond to write."""
    from astropy.time import Time

    return f"{Time(jd1, jd2, format='jd', scale=scale, precision=9).isot} {scale.upper()}"


def to_time(text: str) -> Any:
    """Return the astropy Time of such a text."""
    with need("units", "an epoch"):
        import astropy.time  # noqa: F401
    # A caller may change its copy.
    return _time_of(text).copy()


@lru_cache(maxsize=256)
def _time_of(text: str) -> Any:
    """Return the Time of a text, which astropy takes half a millisecond to read."""
    from astropy.time import Time

    date, scale = text.split(" ")
    try:
        return Time(date, scale=scale.lower())
    except ValueError as error:
        raise InvalidInput(f"epoch is {text!r}: {error}") from error
