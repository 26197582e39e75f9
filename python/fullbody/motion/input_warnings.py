"""Warnings about bodies and starts that can be integrated but are probably mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..base import tables
from ..base.units import unit_named
from ..model.force import KINDS

if TYPE_CHECKING:
    from .. import _core
    from ..base.units import Units
    from ..model.context import Context

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


def start_warnings(context: Context, start: _core.State, tolerance: float | None) -> Iterator[str]:
    """Return warnings about a start.

    Parameters
    ----------
    tolerance
        The sum of the integrator's tolerances, relative to the distance of the nearest body; ``None`` for fixed steps.
    """
    fast, far = context.core.start_warnings(start, tolerance)
    if fast is not None:
        yield _unbound(context, *fast)
    if far is not None:
        yield _far(context, *far, tolerance)
    for described in context.core.forces:
        yield from KINDS[described["kind"]]._input_warnings(described, start, context)


def _unbound(context: Context, body: int, speed: float, escape: float, limit: float) -> str:
    """Return the warning that a body is much faster than its speed of escape and cannot be bound."""
    fast, held = (tables.number(context.units.attach(np.float64(value), "velocity"), 4) for value in (speed, escape))
    who = f"{' and '.join(context.names)} start" if len(context) == 2 else f"{context.names[body]} starts"
    whom = "each other" if len(context) == 2 else "the barycentre of the others"
    return (
        f"{who} at {fast} relative to {whom}, {speed / escape:.3g} times the speed of escape there, "
        f"{held}; expected at most {limit:g} times, unless a fast flyby is meant: check the units of the velocities, "
        "of the masses and of G"
    )


def _far(
    context: Context,
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
        return tables.number(context.units.attach(np.float64(value), "length"), digits)

    if tolerance is None:
        follows = "Every step loses that much"
    else:
        follows = (
            "A step cannot be more exact than that: with smaller tolerances steps grow ever shorter, and the run may "
            "never end"
        )
    who = context.names[heavy]
    instead = f"{who} as a fullbody.forces.ThirdBody on a prescribed path, which costs no digits"
    remedy = instead if tolerance is None else f"{instead}, or rtol and atol of {enough:g} or more"
    return (
        f"{who} is {length(distance)} from {' and '.join(context.names[place] for place in sorted(pair))}, which are "
        f"{length(apart)} apart, and so heavy that the barycentre, which positions are counted from, is far from these "
        f"two: their coordinates round at {length(rounding, 2)}, {rounding / apart:.2g} of their distance. "
        f"{follows}; expected bodies within {limit:g} such distances, or {remedy}"
    )
