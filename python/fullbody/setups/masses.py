"""Masses, period and semi-major axis of a binary from published values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.kinds import Number
from ..base.limits import POSITIVE, Limits
from ..base.units import Units
from ..errors import InvalidInput, caution
from ..model.bodies import Body
from ..model.composite import Composite
from ..model.stokes import StokesCoefficients
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
class BinarySolution:
    """Masses, period and semi-major axis of a binary, in a system's units."""

    masses: tuple[float, float]
    period: float
    semi_major_axis: float


def solve(
    components: tuple[Component, Component], numbers: Mapping[str, Any], equal_density: bool, G: float, convert: Units
) -> BinarySolution:
    """Solve for the missing numbers of a binary, if the given ones suffice.

    Where two values of one quantity differ by more than the relative limits among the ``numbers``, there is a warning
    or an error.
    """
    amounts = [_mass_and_volume(component, k, equal_density, G, convert) for k, component in enumerate(components)]
    ratio, total, mu = (numbers[name] for name in ("mass_ratio", "total_mass", "GM"))
    if equal_density and ratio is not None:
        raise InvalidInput("both mass_ratio and equal_density are given; expected one of the two")
    if total is not None and mu is not None:
        raise InvalidInput("both total_mass and GM are given; expected one of the two")
    ratio = amounts[1][1] / amounts[0][1] if equal_density else ratio
    total = total if mu is None else mu / G
    period, axis = numbers["period"], numbers["semi_major_axis"]
    limits = numbers["mismatch_warning"], numbers["mismatch_error"]
    implied = total
    if total is None and period is not None and axis is not None:
        implied = 4 * np.pi**2 * axis**3 / (G * period**2)
    masses = _split((amounts[0][0], amounts[1][0]), total, ratio, implied, limits)
    if period is not None:
        by_period = float(np.cbrt(G * sum(masses) * (period / (2 * np.pi)) ** 2))
        _compare("the semi-major axis", by_period, "the masses and the period", axis, "semi_major_axis", limits)
        axis = by_period
    elif axis is not None:
        period = float(2 * np.pi * np.sqrt(axis**3 / (G * sum(masses))))
    else:
        raise InvalidInput("neither period nor semi_major_axis is given; expected one of the two, or both")
    return BinarySolution(masses, period, axis)


def _mass_and_volume(
    component: Component, index: int, equal_density: bool, G: float, convert: Units
) -> tuple[float | None, float]:
    """Return the mass of a component, ``None`` without one, and its volume, NaN where that is not needed."""
    called = component.name if component.name is not None else f"body {index}"
    if isinstance(component.shape, Composite | StokesCoefficients):
        volume = _volume(component.shape, convert, called) if equal_density else np.nan
    else:
        volume = Body(component.shape, density=1.0, name=component.name)._core(convert, 0).volume
    numbers = component._unitless(convert, of=called)
    mass, density = numbers["mass"] if component.GM is None else numbers["GM"] / G, numbers["density"]
    return (mass if density is None else density * volume), volume


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


def _split(
    masses: tuple[float | None, float | None],
    total: float | None,
    ratio: float | None,
    implied: float | None,
    limits: tuple[float, float],
) -> tuple[float, float]:
    """Return both masses: those of the components have priority over a total mass, and that over the implied one."""
    first, second = masses
    if first is not None and second is not None:
        _compare("the total mass", first + second, "the components", total, "total_mass", limits)
        _compare("the mass ratio", second / first, "the components", ratio, "mass_ratio", limits)
        return first, second
    mass = first if first is not None else second
    if mass is not None and ratio is not None:
        pair = (mass, mass * ratio) if second is None else (mass / ratio, mass)
        _compare("the total mass", sum(pair), "a component and the ratio", total, "total_mass", limits)
        return pair
    if implied is None:
        raise InvalidInput(
            "the masses are not given; expected both of the components, or total_mass (or period and semi_major_axis) "
            "with mass_ratio, equal_density=True or one component's mass"
        )
    if mass is not None:
        if mass >= implied:
            raise InvalidInput(f"a component's mass is {mass:.6g} of {implied:.6g} in all; expected less")
        return (mass, implied - mass) if second is None else (implied - mass, mass)
    if ratio is None:
        expected = "expected mass_ratio, equal_density=True, or a component's mass or density"
        raise InvalidInput(f"how the total mass is shared is not given; {expected}")
    return implied / (1 + ratio), implied * ratio / (1 + ratio)


def _compare(
    what: str, first: float, of_first: str, second: float | None, of_second: str, limits: tuple[float, float]
) -> None:
    """Warn or raise an error if two values of one quantity, of which the first is used, differ too much."""
    if second is None:
        return
    relative, (warn_above, refuse_above) = abs(first - second) / abs(second), limits
    values = f"{what} is {first:.6g} by {of_first} and {second:.6g} by {of_second}"
    text = f"{values}, a difference of {100 * relative:.3g} %"
    if relative > refuse_above:
        raise InvalidInput(f"{text}; expected agreement to mismatch_error={refuse_above:g}")
    if relative > warn_above:
        caution(f"{text}; the former is taken")
