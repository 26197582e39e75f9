"""Verdicts on the statements of the paper, and the rules by which they are reached."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal, get_args

from ..judging import word
from . import paper

__all__ = ["WORDS", "Judge", "Verdict", "as_printed"]

#: Equal to the digits printed; a bound or a claim that holds; neither; not decided; CPU times.
Word = Literal["equal", "holds", "differs", "open", "faster", "slower"]
WORDS: tuple[Word, ...] = get_args(Word)


@dataclass(frozen=True, slots=True)
class Verdict:
    """A row of the table: a statement of the paper, the number computed here, and the verdict."""

    key: str
    section: str
    quantity: str
    printed: str
    #: The number computed here.
    computed: str
    verdict: Word
    #: The interpretation of the paper's words, where they need one. Its limits were chosen for the report with the
    #: results known.
    interpretation: str
    #: The reason, where the number differs or the question is open; a remark where it holds.
    why: str
    #: The name of the finding with the details.
    finding: str


class Judge:
    """Collects the verdicts on the statements of the paper."""

    def __init__(self) -> None:
        self._parts: dict[str, tuple[str, Word, str, str, str]] = {}

    def verdicts(self) -> list[Verdict]:
        """Return all verdicts in the paper's order, one for each of its statements."""
        statements = paper.STATEMENTS
        return [Verdict(key, s.section, s.quantity, s.text, *self._parts[key]) for key, s in statements.items()]

    def claim(
        self,
        key: str,
        computed: str,
        holds: bool,
        interpretation: str = "",
        *,
        why: str = "",
        note: str = "",
        finding: str = "",
    ) -> None:
        """Judge a statement; ``why`` is stated if it differs, ``note`` if it holds."""
        self._parts[key] = (computed, word(holds), interpretation, note if holds else why, finding)

    def within(
        self,
        key: str,
        computed: str,
        value: float,
        low: float = -math.inf,
        high: float = math.inf,
        unit: str = "",
        **texts: str,
    ) -> None:
        """Judge a statement in words, interpreted as a value between limits, which the verdict shows."""
        limits = (f"above {low:g}", f"below {high:g}", f"{low:g} to {high:g}")
        interpretation = limits[0 if high == math.inf else 1 if low == -math.inf else 2]
        self.claim(key, computed, low < value < high, f"{interpretation} {unit}".strip(), **texts)

    def bound(self, key: str, value: float, limit: float, **texts: str) -> None:
        """Judge a printed upper bound."""
        self.claim(key, f"{value:.1e}", value < limit, **texts)

    def numbers(self, key: str, text: str, values: Sequence[float], *, why: str = "", finding: str = "") -> None:
        """Judge printed numbers to their digits; ``text`` is the format of the computed ones."""
        printed = re.findall(r"-?\d+\.\d+", paper.STATEMENTS[key].text)
        computed = [as_printed(value, number) for value, number in zip(values, printed, strict=True)]
        reasons: tuple[Word, str, str, str] = (
            ("equal", "", "", "") if computed == printed else ("differs", "", why, finding)
        )
        self._parts[key] = (text.format(*computed), *reasons)

    def leave_open(self, key: str, computed: str, why: str) -> None:
        """Add a statement that cannot be decided."""
        self._parts[key] = (computed, "open", "", why, "")

    def cpu(self, key: str, printed: float, computed: float) -> None:
        """Compare a CPU time with the printed one."""
        less = computed < printed
        ratio = float(f"{max(printed / computed, computed / printed):.1g}")
        text = f"{computed:.2g} s: about {ratio:g} times {'less' if less else 'more'}"
        self._parts[key] = (text, "faster" if less else "slower", "", "Another machine, another program.", "")


def as_printed(value: float, printed: str) -> str:
    """Return a value rounded to the decimals of a printed number."""
    exponent = Decimal(printed).as_tuple().exponent
    assert isinstance(exponent, int)
    return f"{value:.{max(0, -exponent)}f}"
