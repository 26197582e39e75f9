"""Limits of numbers, which errors put into words: "a finite number above zero", "a number from 0 to below 1"."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi
from typing import Any

#: The sizes between which numbers lie whose squares are formed: far from where doubles end.
SMALLEST, LARGEST = 1e-60, 1e60


@dataclass(frozen=True, slots=True)
class Limits:
    """The finite numbers that an argument may be.

    The bounds ``least`` and ``most`` are allowed themselves, ``above`` and ``below`` are not; ``nonzero`` refuses zero,
    and ``infinite`` allows infinity. The ``text`` says what is expected; by default it follows from the bounds.
    """

    least: float = -inf
    most: float = inf
    above: float = -inf
    below: float = inf
    nonzero: bool = False
    infinite: bool = False
    text: str = ""

    def contain(self, values: Any) -> Any:
        """Return for each of the values whether it is finite and within the limits."""
        holds = (values >= self.least) & (values <= self.most)
        if not self.infinite:
            holds &= (abs(values) < inf) & (values > self.above) & (values < self.below)
        return holds & (values != 0.0) if self.nonzero else holds

    def expected(self, plural: bool = False) -> str:
        """Return what is expected in words, for one number or for many."""
        if self.text:
            return self.text
        low, high = max(self.least, self.above), min(self.most, self.below)
        noun = "numbers" if plural else "number"
        if -inf < low and high < inf:
            first = f"from {low:g} to" if self.least == low else f"above {low:g} and"
            last = (
                f" below {high:g}" if self.below == high else f" {high:g}" if self.least == low else f" up to {high:g}"
            )
            return f"{noun if plural else f'a {noun}'} {first}{last}"
        finite = f"finite {noun}" if plural else f"a finite {noun}"
        if self.nonzero:
            return f"{finite} that {'are' if plural else 'is'} not zero"
        if low > -inf:
            edge = "zero" if low == 0.0 else f"{low:g}"
            return f"{finite} above {edge}" if self.above == low else f"{finite}, {edge} or above"
        if high < inf:
            return f"{finite} below {high:g}" if self.below == high else f"{finite}, {high:g} or below"
        return finite


FINITE = Limits()
POSITIVE = Limits(above=0.0)
NOT_NEGATIVE = Limits(least=0.0)
NONZERO = Limits(nonzero=True)
FRACTION = Limits(least=0.0, most=1.0)
#: A little more than a right angle is one that was computed with rounding errors.
LATITUDE = Limits(least=-pi / 2 * (1.0 + 1e-12), most=pi / 2 * (1.0 + 1e-12), text="angles from -pi/2 to pi/2")
