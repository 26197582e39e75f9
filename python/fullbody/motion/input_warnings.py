"""Warnings about bodies and starts that can be integrated but are probably mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..base import tables
from ..base.units import unit_named

if TYPE_CHECKING:
    from .. import _core
    from ..base.units import Units
    from .system import System

__all__ = ["density_warning", "start_warnings"]

#: The least and the greatest density of a body, in kg/m3, that cause no warning.
_DENSITIES = (100.0, 30000.0)


def density_warning(units: Units, body: _core.Body, name: str) -> str | None:
    """Return a warning about an implausible density, as from a wrong unit of size or mass, or ``None``."""
    if not units.known or body.volume == 0.0:
        return None
    density = float(units.attach(body.mass / body.volume, "density").to_value(unit_named("kg / m3")))
    if _DENSITIES[0] <= density <= _DENSITIES[1]:
        return None
    expected = f"expected {_DENSITIES[0]:g} to {_DENSITIES[1]:g}: check the units of its size and mass"
    return f"{name} has a density of {density:.3g} kg/m3; {expected}"


def start_warnings(system: System, start: _core.State, tolerance: float | None) -> Iterator[str]:
    """Return warnings about a start.

    Parameters
    ----------
    tolerance
        The sum of the integrator's tolerances, relative to the distance of the nearest body; ``None`` for fixed steps.
    """
    fast, far = system._core.start_warnings(start, tolerance)
    if fast is not None:
        yield _unbound(system, *fast)
    if far is not None:
        yield _far(system, *far, tolerance)
    for force, described in zip(system.forces, system._core.forces, strict=True):
        yield from force._input_warnings(described, system.names, start, system._units)


def _unbound(system: System, body: int, speed: float, escape: float, limit: float) -> str:
    """Return the warning that a body is much faster than its speed of escape and cannot be bound."""
    fast, held = (tables.number(system._units.attach(np.float64(value), "velocity"), 4) for value in (speed, escape))
    who = f"{' and '.join(system.names)} start" if len(system) == 2 else f"{system.names[body]} starts"
    whom = "each other" if len(system) == 2 else "the barycentre of the others"
    return (
        f"{who} at {fast} relative to {whom}, {speed / escape:.3g} times the speed of escape there, "
        f"{held}; expected at most {limit:g} times, unless a fast flyby is meant: check the units of the velocities, "
        "of the masses and of G"
    )


def _far(
    system: System,
    pair: tuple[int, int],
    apart: float,
    heavy: int,
    distance: float,
    rounding: float,
    enough: float,
    limit: float,
    tolerance: float | None,
) -> str:
    """Return the warning that bodies near each other are far from the barycentre, the origin of the integration."""

    def length(value: float, digits: int = 4) -> str:
        return tables.number(system._units.attach(np.float64(value), "length"), digits)

    if tolerance is None:
        follows = "Every step loses that much"
    else:
        follows = (
            "A step cannot be more exact than that: with smaller tolerances steps grow ever shorter, and the run may "
            "never end"
        )
    who = system.names[heavy]
    instead = f"{who} as a fullbody.forces.ThirdBody on a prescribed path, which costs no digits"
    remedy = instead if tolerance is None else f"{instead}, or rtol and atol of {enough:g} or more"
    return (
        f"{who} is {length(distance)} from {' and '.join(system.names[place] for place in sorted(pair))}, which are "
        f"{length(apart)} apart, and so heavy that the barycentre, which positions are counted from, is far from these "
        f"two: their coordinates round at {length(rounding, 2)}, {rounding / apart:.2g} of their distance. "
        f"{follows}; expected bodies within {limit:g} such distances, or {remedy}"
    )
