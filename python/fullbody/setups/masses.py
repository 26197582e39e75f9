"""Masses, period and semi-major axis of a binary from the given values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.kinds import Number
from ..base.limits import POSITIVE, Limits
from ..base.units import Units
from ..errors import InvalidInput
from ..model.bodies import Body
from ..model.composite import Composite
from ..model.stokes import StokesCoefficients
from .component import KINDS as OF_COMPONENTS
from .component import Component

_TOLERANCE = Number(limits=Limits(least=0.0, infinite=True, text="a number, zero or above"))
#: The kinds of the numbers among the arguments of :func:`binary`.
KINDS = {
    "total_mass": Number("mass", POSITIVE),
    "GM": Number("mu", POSITIVE),
    "mass_ratio": Number(limits=POSITIVE),
    "period": Number("time", POSITIVE),
    "start_period": Number("time"),
    "semi_major_axis": Number("length", POSITIVE),
    "eccentricity": Number(limits=Limits(least=0.0, below=1.0)),
    "argument_of_periapsis": Number("angle"),
    "mean_anomaly": Number("angle"),
    "libration": Number("angle", Limits(-2 * np.pi, 2 * np.pi, text="radians, a turn at most, or a Quantity")),
    "mismatch_warning": _TOLERANCE,
    "mismatch_error": _TOLERANCE,
}
_OPTIONAL = ("total_mass", "GM", "mass_ratio", "period", "start_period", "semi_major_axis")


def numbers_of(arguments: Mapping[str, Any], units: Units) -> dict[str, Any]:
    """Return the numbers among the arguments of :func:`binary` in a system's units; ``None`` for missing ones."""
    missing = [name for name in _OPTIONAL if arguments[name] is None]
    return {
        name: None if name in missing else kind.unitless(arguments[name], name, units) for name, kind in KINDS.items()
    }


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
    numbers: Mapping[str, Any],
    equal_density: bool,
) -> BinaryInput:
    """Return the masses of components and the numbers among the arguments of :func:`binary` in a system's units."""
    volumes, masses = [], []
    for index, component in enumerate(components):
        called = component.name if component.name is not None else f"body {index}"
        if isinstance(component.shape, Composite | StokesCoefficients):
            volume = _volume(component.shape, convert, called) if equal_density else np.nan
        else:
            volume = Body(component.shape, density=1.0, name=component.name)._core(convert, 0).volume
        mass, density, mu = (
            None if value is None else OF_COMPONENTS[name].unitless(value, f"{name} of {called}", convert)
            for name, value in ((name, getattr(component, name)) for name in ("mass", "density", "GM"))
        )
        volumes.append(volume)
        mass = mass if mu is None else mu / gravity
        masses.append(mass if density is None else density * volume)
    ratio = numbers["mass_ratio"]
    if equal_density and ratio is not None:
        raise InvalidInput("both mass_ratio and equal_density are given; expected one of the two")
    if equal_density:
        ratio = volumes[1] / volumes[0]
    total, mu = numbers["total_mass"], numbers["GM"]
    if total is not None and mu is not None:
        raise InvalidInput("both total_mass and GM are given; expected one of the two")
    total = total if mu is None else mu / gravity
    return BinaryInput(gravity, (masses[0], masses[1]), total, ratio, numbers["period"], numbers["semi_major_axis"])


def _volume(composite: Composite | StokesCoefficients, convert: Units, called: str) -> float:
    """Return the sum of the volumes of the parts of a composite, which all have one density."""
    if isinstance(composite, StokesCoefficients):
        raise InvalidInput(f"equal_density is given, and {called} has no volume; expected mass_ratio")
    densities = {part.density for part in composite.parts}
    if None in densities or len(densities) > 1:
        which = f"{called} is a composite of parts without one density"
        raise InvalidInput(f"equal_density is given, and {which}; expected mass_ratio")
    mass = Body(composite)._core(convert, 0).mass
    return float(mass / convert.number(densities.pop(), "density", "density"))


def solve(inputs: BinaryInput) -> tuple[BinarySolution, list[Mismatch]]:
    """Solve for the missing numbers, if the given ones suffice, and compare each two values of one quantity."""
    mismatches: list[Mismatch] = []
    kepler = None
    if inputs.period is not None and inputs.semi_major_axis is not None:
        kepler = 4 * np.pi**2 * inputs.semi_major_axis**3 / (inputs.G * inputs.period**2)
    total = inputs.total if inputs.total is not None else kepler
    masses = _split(inputs, total, mismatches)
    mass = sum(masses)
    if inputs.period is not None:
        period = inputs.period
        axis = float(np.cbrt(inputs.G * mass * (period / (2 * np.pi)) ** 2))
        if inputs.semi_major_axis is not None:
            by_axis = inputs.semi_major_axis, "semi_major_axis"
            mismatches.append(Mismatch("the semi-major axis", axis, "the masses and the period", *by_axis))
    elif inputs.semi_major_axis is not None:
        axis = inputs.semi_major_axis
        period = float(2 * np.pi * np.sqrt(axis**3 / (inputs.G * mass)))
    else:
        raise InvalidInput("neither period nor semi_major_axis is given; expected one of the two, or both")
    return BinarySolution(masses, period, axis), mismatches


def _split(inputs: BinaryInput, total: float | None, mismatches: list[Mismatch]) -> tuple[float, float]:
    first, second = inputs.masses
    if first is not None and second is not None:
        if inputs.total is not None:
            mismatches.append(Mismatch("the total mass", first + second, "the components", inputs.total, "total_mass"))
        if inputs.ratio is not None:
            mismatches.append(Mismatch("the mass ratio", second / first, "the components", inputs.ratio, "mass_ratio"))
        return first, second
    mass = first if first is not None else second
    if mass is not None and inputs.ratio is not None:
        both = (mass, mass * inputs.ratio) if second is None else (mass / inputs.ratio, mass)
        if inputs.total is not None:
            by_total = inputs.total, "total_mass"
            mismatches.append(Mismatch("the total mass", sum(both), "a component and the ratio", *by_total))
        return both
    if total is None:
        raise InvalidInput(
            "the masses are not given; expected both of the components, or total_mass (or period and semi_major_axis) "
            "with mass_ratio, equal_density=True or one component's mass"
        )
    if mass is not None:
        if mass >= total:
            raise InvalidInput(f"a component's mass is {mass:.6g} of {total:.6g} in all; expected less")
        return (mass, total - mass) if second is None else (total - mass, mass)
    if inputs.ratio is None:
        expected = "expected mass_ratio, equal_density=True, or a component's mass or density"
        raise InvalidInput(f"how the total mass is shared is not given; {expected}")
    return total / (1 + inputs.ratio), total * inputs.ratio / (1 + inputs.ratio)
