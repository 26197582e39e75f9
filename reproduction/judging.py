"""Verdicts on published numbers and statements: how one is reached, and the table of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Literal, get_args

from .publishing import table

__all__ = ["LIMIT", "WORDS", "Verdict", "Word", "claimed", "compared", "counts", "joint", "stated", "verdicts_table"]
__all__ += ["word"]

#: A number within its limit, or a statement that is true of our result; one that is not; a question that stays open.
Word = Literal["holds", "differs", "open"]
WORDS: tuple[Word, ...] = get_args(Word)
#: Joint standard errors within which a number holds.
LIMIT = 2.0


@dataclass(frozen=True, slots=True)
class Verdict:
    """A row of the table of verdicts.

    Attributes
    ----------
    system, quantity : str
    published, fitted : str
    difference : float or None
        The fitted value minus the published one, in joint standard errors.
    verdict : str
    why : str
        Where it differs or is open, the reason, or what is known.
    """

    system: str
    quantity: str
    published: str
    fitted: str
    difference: float | None
    verdict: Word
    why: str = ""


def word(holds: bool | None) -> Word:
    """Return the word of a verdict; ``None`` stands for an open question."""
    return "open" if holds is None else "holds" if holds else "differs"


def stated(value: float, error: float) -> str:
    """Write a value with its standard error to two digits of this."""
    digits = max(0, 1 - Decimal(f"{error:.1e}").adjusted())
    return f"{value:.{digits}f} +- {error:.{digits}f}"


def joint(*errors: float) -> float:
    """Return the standard error of a difference of independent numbers."""
    return math.hypot(*errors)


def compared(
    system: str, quantity: str, published: tuple[float, float], fitted: tuple[float, float], why: str = ""
) -> Verdict:
    """Compare a value with a published one; both have their standard errors. ``why`` is stated where they differ."""
    difference = (fitted[0] - published[0]) / joint(published[1], fitted[1])
    holds = abs(difference) <= LIMIT
    text = f"{published[0]:.10g} +- {published[1]:g}"
    return Verdict(system, quantity, text, stated(*fitted), difference, word(holds), "" if holds else why)


def claimed(system: str, quantity: str, published: str, fitted: str, holds: bool | None, why: str = "") -> Verdict:
    """Judge a published statement, which is no number with an error; ``why`` is stated in any case."""
    return Verdict(system, quantity, published, fitted, None, word(holds), why)


def counts(verdicts: Iterable[Any], words: Sequence[str] = WORDS) -> dict[str, int]:
    """Count the verdicts with each word."""
    reached = [verdict.verdict for verdict in verdicts]
    return {word: reached.count(word) for word in words}


def verdicts_table(rows: Iterable[Mapping[str, Any]], first: str = "system") -> str:
    """Return the table of verdicts in Markdown, from their numbers; ``first`` is the title of the first column."""
    columns = ("system", "quantity", "published", "fitted", "difference", "verdict", "why")
    cells = [
        ["" if row[name] is None else f"{row[name]:+.2f}" if name == "difference" else row[name] for name in columns]
        for row in rows
    ]
    return table([first, *columns[1:]], cells)
