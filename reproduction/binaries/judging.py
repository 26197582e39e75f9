"""What a verdict on a published number is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal, get_args

__all__ = ["LIMIT", "WORDS", "Verdict", "compared", "counts", "stated"]

#: A number within its limit, or a statement that is true of our fit; one that is not; a question that stays open.
Word = Literal["holds", "differs", "open"]
WORDS: tuple[Word, ...] = get_args(Word)
#: Published standard errors within which a number holds.
LIMIT = 2.0


@dataclass(frozen=True, slots=True)
class Verdict:
    """One row of the table.

    Attributes
    ----------
    system, quantity : str
    published, fitted : str
    difference : float or None
        Ours minus the published one, in published standard errors.
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


def compared(
    system: str, quantity: str, published: tuple[float, float], ours: tuple[float, float], why: str = ""
) -> Verdict:
    """Compare a value with a published one; both have their standard errors. ``why`` is kept where they differ."""
    apart = (ours[0] - published[0]) / published[1]
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
    return {word: sum(one.verdict == word for one in verdicts) for word in WORDS}
