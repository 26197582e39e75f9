"""What a verdict is, and how one is reached."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal, get_args

from . import paper

__all__ = ["WORDS", "Judge", "Verdict", "as_printed", "counts"]

#: Equal to the digits printed; a bound or a claim that holds; neither; not decided; CPU times.
Word = Literal["equal", "holds", "differs", "open", "faster", "slower"]
WORDS: tuple[Word, ...] = get_args(Word)


@dataclass(frozen=True, slots=True)
class Verdict:
    """A row of the table: a statement of the paper, the number computed here, and the verdict."""

    key: str
    where: str
    quantity: str
    printed: str
    #: The number computed here.
    ours: str
    verdict: Word
    #: The reading of the paper's words, where they leave it open. The limits are the report's own, chosen with the
    #: results in sight.
    counted: str
    #: The reason, where the number differs or the question is open; a remark where it holds.
    why: str
    #: The finding that tells more, by its name.
    see: str


class Judge:
    """Collects the verdicts."""

    def __init__(self) -> None:
        self.found: dict[str, tuple[str, Word, str, str, str]] = {}

    def verdicts(self) -> list[Verdict]:
        """Return all verdicts in the paper's order, one for each of its statements."""
        statements = paper.STATEMENTS
        return [Verdict(key, s.where, s.quantity, s.text, *self.found[key]) for key, s in statements.items()]

    def claim(
        self, key: str, ours: str, holds: bool, counted: str = "", *, why: str = "", note: str = "", see: str = ""
    ) -> None:
        """Add a statement; ``why`` it fails, or a ``note`` where it holds."""
        self.found[key] = (ours, "holds" if holds else "differs", counted, note if holds else why, see)

    def within(
        self,
        key: str,
        ours: str,
        value: float,
        low: float = -math.inf,
        high: float = math.inf,
        unit: str = "",
        **words: str,
    ) -> None:
        """Add a statement in words, counted as a value between limits, which the verdict shows."""
        limits = (f"above {low:g}", f"below {high:g}", f"{low:g} to {high:g}")
        counted = limits[0 if high == math.inf else 1 if low == -math.inf else 2]
        self.claim(key, ours, low < value < high, f"{counted} {unit}".strip(), **words)

    def bound(self, key: str, value: float, limit: float, **words: str) -> None:
        """Add a printed bound."""
        self.claim(key, f"{value:.1e}", value < limit, **words)

    def numbers(self, key: str, text: str, values: Sequence[float], *, why: str = "", see: str = "") -> None:
        """Add printed numbers, to their digits; ``text`` is what they stand in."""
        printed = re.findall(r"-?\d+\.\d+", paper.STATEMENTS[key].text)
        ours = [as_printed(value, number) for value, number in zip(values, printed, strict=True)]
        if ours == printed:
            self.found[key] = (text.format(*ours), "equal", "", "", "")
        else:
            self.found[key] = (text.format(*ours), "differs", "", why, see)

    def leave_open(self, key: str, ours: str, why: str) -> None:
        """Add a statement that cannot be decided."""
        self.found[key] = (ours, "open", "", why, "")

    def cpu(self, key: str, printed: float, ours: float) -> None:
        """Add a CPU time."""
        less = ours < printed
        ratio = float(f"{max(printed / ours, ours / printed):.1g}")
        text = f"{ours:.2g} s: about {ratio:g} times {'less' if less else 'more'}"
        self.found[key] = (text, "faster" if less else "slower", "", "Another machine, another program.", "")


def as_printed(value: float, printed: str) -> str:
    """Return a value rounded to the decimals of a printed number."""
    exponent = Decimal(printed).as_tuple().exponent
    assert isinstance(exponent, int)
    return f"{value:.{max(0, -exponent)}f}"


def counts(verdicts: Sequence[Verdict]) -> dict[str, int]:
    """Return the number of verdicts of each kind."""
    return {word: sum(verdict.verdict == word for verdict in verdicts) for word in WORDS}
