"""Numbers and symbols of plain text as HTML: 1.2e-13, omega_z, theta, m^3."""

from __future__ import annotations

import re
from html import escape

__all__ = ["typeset"]

GREEK = {"omega": "ω", "Omega": "Ω", "theta": "θ", "phi": "φ", "psi": "ψ", "mu": "μ", "kappa": "κ", "pi": "π"}
_SYMBOL = re.compile(rf"\b({'|'.join(GREEK)})(?:_([xyz0]))?\b|\b(F)_([xyz])\b")
_POWER_OF_TEN = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]?)0*(\d+)\b")
_UNIT_POWER = re.compile(r"\b(k?m|s|h)\^(-?\d)")


def typeset(text: str) -> str:
    """Return plain text as HTML with powers of ten, Greek letters, indices, exponents of units and errors typeset.

    Parameters
    ----------
    text : str
        Plain text; characters that HTML reserves are escaped.

    Returns
    -------
    str

    Examples
    --------
    >>> from reproduction.typesetting import typeset
    >>> typeset("omega_z < 1e-5 rad/s")
    '<i>ω</i><sub>z</sub> &lt; 10<sup>−5</sup> rad/s'
    >>> typeset("2.5e3 m^3")
    '2.5 × 10<sup>3</sup> m<sup>3</sup>'
    >>> typeset("5.84 +- 0.29")
    '5.84 ± 0.29'
    """

    def power(match: re.Match[str]) -> str:
        number, sign, exponent = match.groups()
        if float(number) == 0.0:
            return "0"
        factor = "" if number == "1" else f"{number} × "  # noqa: RUF001
        return f"{factor}10<sup>{'−' if sign == '-' else ''}{exponent}</sup>"  # noqa: RUF001

    def symbol(match: re.Match[str]) -> str:
        name, index = match.group(1) or match.group(3), match.group(2) or match.group(4)
        return f"<i>{GREEK.get(name, name)}</i>" + (f"<sub>{index}</sub>" if index else "")

    text = _SYMBOL.sub(symbol, _POWER_OF_TEN.sub(power, escape(text))).replace("+-", "±")
    return _UNIT_POWER.sub(r"\1<sup>\2</sup>", text)
