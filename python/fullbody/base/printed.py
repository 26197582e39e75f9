"""Quantities as papers print them: with a standard error, or as a sum such as ``"11 h 55.3 min"``.

The standard error of a text is kept beside the Quantity until it is computed with.
"""

from __future__ import annotations

import re
from math import hypot
from typing import Any

from ..errors import InvalidInput
from .unit_names import error_of, read, with_error

_DIGITS, _POWER = r"(?:\d+\.?\d*|\.\d+)", r"(?:[eE][+-]?\d+)"
_BESIDE = rf"\s*(?:±|\+/?-)\s*(?P<error>{_DIGITS}{_POWER}?)\s*"
#: A number with its error: ``(5.4 ± 0.4)e11``, ``5.4(4)e11`` (the error of the last digits) or ``5.4e11 ± 0.4e11``.
_WITH_ERROR = tuple(
    re.compile(pattern)
    for pattern in (
        rf"\(\s*(?P<value>[+-]?{_DIGITS}){_BESIDE}\)\s*(?P<power>{_POWER}?)",
        rf"(?P<value>[+-]?{_DIGITS})\((?P<error>{_DIGITS})\)(?P<power>{_POWER}?)",
        rf"(?P<value>[+-]?{_DIGITS}{_POWER}?){_BESIDE}(?P<power>)",
    )
)
#: A term of a sum: a number, its error if it has one, and a unit of one word.
_TERM = re.compile(
    rf"({_DIGITS}(?:\({_DIGITS}\)|{_BESIDE.replace('?P<error>', '')})?)\s*((?![eE][+-]?\d)[^\W\d]+|[°'\"])\s*"
)
#: Two numbers, the second of which astropy would take as a factor of the unit.
_TWO = re.compile(rf"[+-]?{_DIGITS}{_POWER}?(?:\s*[+-]|\s+(?!1\s*/)[\d.])")
_TIMES_TEN = re.compile(r"\s*(?:\u00d7|\bx|\*)\s*10\s*(?:\^|\*\*)?\s*([+-]?\d+)")


def printed(text: str, what: str) -> Any:
    """Return the Quantity of a text: a number with a unit, with its standard error, or a sum of such terms.

    A unit that is not known is a TypeError or a ValueError.
    """
    number = _TIMES_TEN.sub(r"e\1", text.strip().replace("\N{MINUS SIGN}", "-"))
    unsigned = number.removeprefix("-")
    terms = [match[0] for match in _TERM.finditer(unsigned)]
    if len(terms) < 2 or "".join(terms) != unsigned:
        return _quantity(number)
    parts = [_quantity(term) for term in terms]
    try:
        total = sum(parts[1:], parts[0]) * (1.0 if unsigned == number else -1.0)
    except ValueError as error:
        raise InvalidInput(f"{what} is {text!r}, a sum of terms that do not go together: {error}") from error
    errors = [error_of(part) * part.unit.to(total.unit) for part in parts if error_of(part) is not None]
    return with_error(total, hypot(*errors)) if errors else total


def _quantity(text: str) -> Any:
    """Return the Quantity of a text of one number."""
    from astropy import units as u

    for pattern in _WITH_ERROR:
        if (match := pattern.match(text)) is not None:
            value, error, power = match["value"], match["error"], match["power"]
            if pattern is _WITH_ERROR[1] and "." not in error:
                # The digits in brackets are those of the error at the place of the number's last digits.
                error += f"e-{len(value.partition('.')[2])}"
            unit = read(u.Unit, text[match.end() :].strip())
            return with_error(u.Quantity(float(value + power), unit), float(error) * float("1" + power))
    if _TWO.match(text):
        raise ValueError("there are two numbers before the unit")
    return read(u.Quantity, text)
