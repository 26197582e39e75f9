"""The date of time zero, which is kept as text so that files hold it without loss."""

from __future__ import annotations

import re
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
    if not (hasattr(epoch, "scale") and hasattr(epoch, "isot") and getattr(epoch, "isscalar", False)):
        raise InvalidInput(f"epoch is {epoch!r}; expected one astropy Time, or a text such as '2022-09-26 TDB'")
    exact = epoch.copy()
    exact.precision = 9
    return f"{exact.isot} {exact.scale.upper()}"


def to_time(text: str) -> Any:
    """Return the astropy Time of such a text."""
    with need("units", "an epoch"):
        from astropy.time import Time

    date, scale = text.split(" ")
    try:
        return Time(date, scale=scale.lower())
    except ValueError as error:
        raise InvalidInput(f"epoch is {text!r}: {error}") from error
