"""What a verdict on a published number is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal, get_args

__all__ = ["LIMIT", "TESTED", "WORDS", "Verdict", "compared", "counts", "joint", "stated"]

#: A number within its limit, or a statement that is true of our fit; one that is not; a question that stays open.
Word = Literal["holds", "differs", "open"]
WORDS: tuple[Word, ...] = get_args(Word)
#: Joint standard errors within which a number holds.
LIMIT = 2.0
#: The text on what agreement with a published orbit shows.
TESTED = (
    "The fits start from the published orbits. Agreement therefore tests how the files are read, frames, light time, "
    "derivatives and the minimum next to the published one, by a program that shares nothing with the authors'. It "
    "does not test whether there is a better minimum elsewhere, nor whether observations, errors and model are right: "
    "most of the observations are those of the publication, so that both results share their errors."
)


@dataclass(frozen=True, slots=True)
class Verdict:
    """A row of the table of verdicts.

    Attributes
    ----------
    system, quantity : str
    published, fitted : str
    difference : float or None
        Ours minus the published one, in joint standard errors.
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


def stated(value: float, error: float) -> str:
    """Write a value with its standard error to two digits of this."""
    digits = max(0, 1 - Decimal(f"{error:.1e}").adjusted())
    return f"{value:.{digits}f} +- {error:.{digits}f}"


def joint(*errors: float) -> float:
    """Return the standard error of a difference of independent numbers."""
    return math.hypot(*errors)


def compared(
    system: str, quantity: str, published: tuple[float, float], ours: tuple[float, float], why: str = ""
) -> Verdict:
    """Compare a value with a published one; both have their standard errors. ``why`` is kept where they differ."""
    apart = (ours[0] - published[0]) / joint(published[1], ours[1])
    holds = abs(apart) <= LIMIT
    return Verdict(
        system,
        quantity,
        f"{published[0]:.10g} +- {published[1]:g}",
        stated(*ours),
        apart,
        "holds" if holds else "differs",
        "" if holds else why,
    )


def counts(verdicts: Sequence[Verdict]) -> dict[str, int]:
    """Count the verdicts of each kind."""
    return {word: sum(row.verdict == word for row in verdicts) for word in WORDS}
