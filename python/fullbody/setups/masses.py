"""Masses, period and semi-major axis of a binary from the given values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.limits import POSITIVE
from ..base.units import Units
from ..errors import InvalidInput
from ..model.bodies import Body
from ..model.composite import Composite
from .component import Component


@dataclass(frozen=True)
class BinaryInput:
    """The given numbers, with ``None`` for missing ones."""

    G: float
    masses: tuple[float | None, float | None]
    total: float | None
    ratio: float | None
    period: float | None
    semi_major_axis: float | None


@dataclass(frozen=True)
class BinarySolution:
    """The numbers that follow from the given ones."""

    masses: tuple[float, float]
    period: float
    semi_major_axis: float


@dataclass(frozen=True)
class Mismatch:
    """Two values of one quantity, each with its origin."""

    what: str
    first: float
    of_first: str
    second: float
    of_second: str

    @property
    def relative(self) -> float:
        """The difference of the values relative to the second."""
        return abs(self.first - self.second) / abs(self.second)

    def __str__(self) -> str:
        return (
            f"{self.what} is {self.first:.6g} by {self.of_first} and {self.second:.6g} by {self.of_second}, "
            f"a difference of {100 * self.relative:.3g} %"
        )


def input_from(
    convert: Units,
    gravity: float,
    components: tuple[Component, Component],
    total_mass: Any,
    mass_ratio: Any,
    equal_density: bool,
    period: Any,
    semi_major_axis: Any,
) -> BinaryInput:
    """Convert the arguments of :func:`binary` to plain numbers in one set of units."""

    def unitless(value: Any, dimension: str, what: str) -> float | None:
        return None if value is None else convert.number(value, dimension, what, POSITIVE)

    volumes, masses = [], []
    for index, component in enumerate(components):
        called = component.name if component.name is not None else f"body {index}"
        if isinstance(component.shape, Composite):
            volume = _volume(component.shape, convert, called) if equal_density else np.nan
        else:
            volume = Body(component.shape, density=1.0, name=component.name)._core(convert, 0).volume
        density = unitless(component.density, "density", f"density of {called}")
        volumes.append(volume)
        masses.append(unitless(component.mass, "mass", f"mass of {called}") if density is None else density * volume)
    if equal_density and mass_ratio is not None:
        raise InvalidInput("both mass_ratio and equal_density are given; expected one of the two")
    ratio = volumes[1] / volumes[0] if equal_density else None
    if mass_ratio is not None:
        ratio = convert.number(mass_ratio, "number", "mass_ratio", POSITIVE)
    return BinaryInput(
        gravity,
        (masses[0], masses[1]),
        unitless(total_mass, "mass", "total_mass"),
        ratio,
        unitless(period, "time", "period"),
        unitless(semi_major_axis, "length", "semi_major_axis"),
    )


def _volume(composite: Composite, convert: Units, called: str) -> float:
    """Return the sum of the volumes of the parts of a composite, which all have one density."""
    densities = {part.density for part in composite.parts}
    if None in densities or len(densities) > 1:
        raise InvalidInput(
            f"equal_density is given, and {called} is a composite of parts without one density; expected mass_ratio"
        )
    mass = Body(composite)._core(convert, 0).mass
    return float(mass / convert.number(densities.pop(), "density", "density"))


def solve(quantities: BinaryInput) -> tuple[BinarySolution, list[Mismatch]]:
    """Solve for the missing numbers, and compare each two values of one quantity.

    Raises
    ------
    InvalidInput
        If the given numbers do not suffice.
    """
    mismatches: list[Mismatch] = []
    kepler = None
    if quantities.period is not None and quantities.semi_major_axis is not None:
        kepler = 4 * np.pi**2 * quantities.semi_major_axis**3 / (quantities.G * quantities.period**2)
    total = quantities.total if quantities.total is not None else kepler
    masses = _split(quantities, total, mismatches)
    mass = sum(masses)
    if quantities.period is not None:
        period = quantities.period
        axis = float(np.cbrt(quantities.G * mass * (period / (2 * np.pi)) ** 2))
        if quantities.semi_major_axis is not None:
            mismatches.append(
                Mismatch(
                    "the semi-major axis",
                    axis,
                    "the masses and the period",
                    quantities.semi_major_axis,
                    "semi_major_axis",
                )
            )
    elif quantities.semi_major_axis is not None:
        axis = quantities.semi_major_axis
        period = float(2 * np.pi * np.sqrt(axis**3 / (quantities.G * mass)))
    else:
        raise InvalidInput("neither period nor semi_major_axis is given; expected one of the two, or both")
    return BinarySolution(masses, period, axis), mismatches


def _split(quantities: BinaryInput, total: float | None, mismatches: list[Mismatch]) -> tuple[float, float]:
    first, second = quantities.masses
    if first is not None and second is not None:
        if quantities.total is not None:
            mismatches.append(
                Mismatch("the total mass", first + second, "the components", quantities.total, "total_mass")
            )
        if quantities.ratio is not None:
            mismatches.append(
                Mismatch("the mass ratio", second / first, "the components", quantities.ratio, "mass_ratio")
            )
        return first, second
    single = first if first is not None else second
    if single is not None and quantities.ratio is not None:
        both = (single, single * quantities.ratio) if second is None else (single / quantities.ratio, single)
        if quantities.total is not None:
            mismatches.append(
                Mismatch("the total mass", sum(both), "a component and the ratio", quantities.total, "total_mass")
            )
        return both
    if total is None:
        raise InvalidInput(
            "the masses are not given; expected both of the components, or total_mass (or period and semi_major_axis) "
            "with mass_ratio, equal_density=True or one component's mass"
        )
    if single is not None:
        other = total - single
        if other <= 0.0:
            raise InvalidInput(f"a component's mass is {single:.6g} of {total:.6g} in all; expected less")
        return (single, other) if second is None else (other, single)
    if quantities.ratio is None:
        raise InvalidInput(
            "how the total mass is shared is not given; expected mass_ratio, equal_density=True, or a component's mass "
            "or density"
        )
    return total / (1 + quantities.ratio), total * quantities.ratio / (1 + quantities.ratio)
