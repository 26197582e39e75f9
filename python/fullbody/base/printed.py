"""Quantities as papers print them: with a standard error, or as a sum such as ``"11 h 55.3 min"``.

The Quantity keeps its standard error only until something is computed from it.
"""

from __future__ import annotations

import re
from math import hypot
from typing import Any

from ..errors import InvalidInput
from .unit_names import error_of, read, with_error

#: A number without its exponent, the exponent, and a standard error after its sign.
_DIGITS, _EXPONENT = r"(?:\d+\.?\d*|\.\d+)", r"(?:[eE][+-]?\d+)"
_PLUS_MINUS = rf"\s*(?:±|\+/?-)\s*(?P<error>{_DIGITS}{_EXPONENT}?)\s*"
#: A number with its error in the last digits: ``5.4(4)e11``.
_ERROR_OF_DIGITS = re.compile(rf"(?P<value>[+-]?{_DIGITS})\((?P<error>{_DIGITS})\)(?P<exponent>{_EXPONENT}?)")
#: A number with its error: as above, ``(5.4 ± 0.4)e11`` or ``5.4e11 ± 0.4e11``.
_WITH_ERROR = (
    re.compile(rf"\(\s*(?P<value>[+-]?{_DIGITS}){_PLUS_MINUS}\)\s*(?P<exponent>{_EXPONENT}?)"),
    _ERROR_OF_DIGITS,
    re.compile(rf"(?P<value>[+-]?{_DIGITS}{_EXPONENT}?){_PLUS_MINUS}(?P<exponent>)"),
)
#: A term of a sum: a number, its error if it has one, and a unit of one word.
_TERM = re.compile(
    rf"({_DIGITS}(?:\({_DIGITS}\)|{_PLUS_MINUS.replace('?P<error>', '')})?)\s*((?![eE][+-]?\d)[^\W\d]+)\s*"
)
#: Two numbers before the unit, the second of which astropy would take as a factor of the unit.
_TWO_NUMBERS = re.compile(rf"[+-]?{_DIGITS}{_EXPONENT}?(?:\s*[+-]|\s+(?!1\s*/)[\d.])")
#: A number after a unit, which astropy would take as a power of the unit.
_NUMBER_AFTER_UNIT = re.compile(r"[^\W\d]\s+(?!1\s*/)\.?\d")
#: Signs of angles as words, since astropy does not know quotes as minutes and seconds of arc.
_ANGLES = str.maketrans(
    {"°": " deg ", "'": " arcmin ", "\N{PRIME}": " arcmin ", '"': " arcsec ", "\N{DOUBLE PRIME}": " arcsec "}
)
#: A power of ten that is not written as an exponent: ``x 10^11``.
_TIMES_TEN = re.compile(r"\s*(?:\u00d7|\bx|\*)\s*10\s*(?:\^|\*\*)?\s*([+-]?\d+)")


def printed(text: str, what: str) -> Any:
    """Return the Quantity of a text: a number with a unit, with its standard error, or a sum of such terms.

    A unit that is not known raises a TypeError or a ValueError; ``what`` names the argument in errors.
    """
    number = _TIMES_TEN.sub(r"e\1", text.replace("\N{MINUS SIGN}", "-").translate(_ANGLES).strip())
    unsigned = number.removeprefix("-") if number.startswith("-") else number.removeprefix("+")
    terms = [match[0] for match in _TERM.finditer(unsigned)]
    if len(terms) < 2 or "".join(terms) != unsigned:
        return _quantity(number)
    parts = [_quantity(term) for term in terms]
    try:
        total = sum(parts[1:], parts[0]) * (-1.0 if number.startswith("-") else 1.0)
    except ValueError as error:
        raise InvalidInput(f"{what} is {text!r}, a sum of terms that do not go together: {error}") from error
    errors = [error_of(part) * part.unit.to(total.unit) for part in parts if error_of(part) is not None]
    return with_error(total, hypot(*errors)) if errors else total


def _quantity(text: str) -> Any:
    """Return the Quantity of a text of one number."""
    from astropy import units as u

    if _NUMBER_AFTER_UNIT.search(text):
        raise ValueError("there is a number after the unit")
    for pattern in _WITH_ERROR:
        if (match := pattern.match(text)) is not None:
            value, error, exponent = match["value"], match["error"], match["exponent"]
            if pattern is _ERROR_OF_DIGITS and "." not in error:
                # Without a decimal point the error in brackets counts units of the number's last digit.
                error += f"e-{len(value.partition('.')[2])}"
            unit = read(u.Unit, text[match.end() :].strip())
            return with_error(u.Quantity(float(value + exponent), unit), float(error) * float("1" + exponent))
    if _TWO_NUMBERS.match(text):
        raise ValueError("there are two numbers before the unit")
    return read(u.Quantity, text)
