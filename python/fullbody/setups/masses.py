"""Masses, period and semi-major axis of a pair from what is known of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InvalidInput


@dataclass(frozen=True)
class Known:
    """What is given; ``None`` for what is not."""

    G: float
    masses: tuple[float | None, float | None]
    total: float | None
    ratio: float | None
    period: float | None
    semi_major_axis: float | None


@dataclass(frozen=True)
class Found:
    """What follows."""

    masses: tuple[float, float]
    period: float
    semi_major_axis: float


@dataclass(frozen=True)
class Mismatch:
    """Two values of one quantity."""

    what: str
    first: float
    of_first: str
    second: float
    of_second: str

    @property
    def relative(self) -> float:
        """Their difference relative to the second."""
        return abs(self.first - self.second) / abs(self.second)

    def __str__(self) -> str:
        return (
            f"{self.what} is {self.first:.6g} by {self.of_first} and {self.second:.6g} by {self.of_second}, "
            f"a difference of {100 * self.relative:.3g} %"
        )


def solve(known: Known) -> tuple[Found, list[Mismatch]]:
    """What follows from what is given, and where it is given twice and differs.

    Raises
    ------
    InvalidInput
        For too little.
    """
    mismatches: list[Mismatch] = []
    kepler = None
    if known.period is not None and known.semi_major_axis is not None:
        kepler = 4 * np.pi**2 * known.semi_major_axis**3 / (known.G * known.period**2)
    total = known.total if known.total is not None else kepler
    masses = _split(known, total, mismatches)
    both = sum(masses)
    if known.period is not None:
        period = known.period
        axis = float(np.cbrt(known.G * both * (period / (2 * np.pi)) ** 2))
        if known.semi_major_axis is not None:
            mismatches.append(
                Mismatch(
                    "the semi-major axis", axis, "the masses and the period", known.semi_major_axis, "semi_major_axis"
                )
            )
    elif known.semi_major_axis is not None:
        axis = known.semi_major_axis
        period = float(2 * np.pi * np.sqrt(axis**3 / (known.G * both)))
    else:
        raise InvalidInput("neither period nor semi_major_axis is given; expected one of the two, or both")
    return Found(masses, period, axis), mismatches


def _split(known: Known, total: float | None, mismatches: list[Mismatch]) -> tuple[float, float]:
    first, second = known.masses
    if first is not None and second is not None:
        if known.total is not None:
            mismatches.append(Mismatch("the total mass", first + second, "the components", known.total, "total_mass"))
        if known.ratio is not None:
            mismatches.append(Mismatch("the mass ratio", second / first, "the components", known.ratio, "mass_ratio"))
        return first, second
    one = first if first is not None else second
    if one is not None and known.ratio is not None:
        pair = (one, one * known.ratio) if second is None else (one / known.ratio, one)
        if known.total is not None:
            mismatches.append(
                Mismatch("the total mass", sum(pair), "a component and the ratio", known.total, "total_mass")
            )
        return pair
    if total is None:
        raise InvalidInput(
            "the masses are not given; expected both of the components, or total_mass (or period and semi_major_axis) "
            "with mass_ratio, equal_density=True or one component's mass"
        )
    if one is not None:
        other = total - one
        if other <= 0.0:
            raise InvalidInput(f"a component's mass is {one:.6g} of {total:.6g} in all; expected less")
        return (one, other) if second is None else (other, one)
    if known.ratio is None:
        raise InvalidInput(
            "how the total mass is shared is not given; expected mass_ratio, equal_density=True, or a component's mass "
            "or density"
        )
    return total / (1 + known.ratio), total * known.ratio / (1 + known.ratio)
