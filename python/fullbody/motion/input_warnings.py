"""Warnings about bodies and starts that can be integrated but are probably mistakes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .. import _core
from ..base.unit_names import unit_named
from ..base.units import Units
from ..model.context import Context
from ..model.force import KINDS

#: The least and the greatest density of a body, in kg/m3, that cause no warning.
_DENSITIES = (100.0, 30000.0)


def body_warnings(context: Context) -> Iterator[str]:
    """Return warnings about the bodies of a system."""
    for name, body in zip(context.names, context.bodies, strict=True):
        yield from _of_density(context.units, name, body)
        yield from _of_cancelling(name, body, context.core.settings["gravity_tolerance"])


def _of_density(units: Units, name: str, body: _core.Body) -> Iterator[str]:
    """Return a warning about an implausible density, as from a wrong unit of size or mass."""
    if not units.defined or body.volume == 0.0:
        return
    density = float(units.attach(body.mass / body.volume, "density").to_value(unit_named("kg / m3")))
    if not _DENSITIES[0] <= density <= _DENSITIES[1]:
        expected = f"expected {_DENSITIES[0]:g} to {_DENSITIES[1]:g}: check the units of its size and mass"
        yield f"{name} has a density of {density:.3g} kg/m3; {expected}"


def _of_cancelling(name: str, body: _core.Body, tolerance: float) -> Iterator[str]:
    """Return a warning about parts that cancel so far that the sum's rounding error is far above the tolerance."""
    masses = np.array([mass for _, mass, *_ in body.input_parts] or [1.0])
    least, largest = int(np.argmin(masses)), int(np.argmax(masses))
    lost = float(np.finfo(float).eps * np.abs(masses).sum() / np.sum(masses))
    if masses[least] < 0.0 and lost > 100.0 * tolerance:
        yield (
            f"parts {largest} and {least} of {name}, of {masses[largest]:g} and {masses[least]:g} in mass, nearly"
            f" cancel: rounding leaves forces uncertain by {lost:.0e} of their size; gravity_tolerance is {tolerance:g}"
        )


def start_warnings(context: Context, start: _core.State, tolerance: float | None) -> Iterator[str]:
    """Return warnings about a start; the tolerance is the sum of the integrator's, ``None`` for fixed steps."""
    fast, far = context.core.start_warnings(start, tolerance)
    if fast is not None:
        yield _unbound(context, *fast)
    if far is not None:
        yield _far(context, *far, tolerance=tolerance)
    for described in context.core.forces:
        yield from KINDS[described["kind"]]._input_warnings(described, start, context)


def _unbound(context: Context, body: int, speed: float, escape: float, limit: float) -> str:
    """Return the warning that a body is much faster than its speed of escape and cannot be bound."""
    fast, held = (context.units.text(value, "velocity", 4) for value in (speed, escape))
    who = f"{' and '.join(context.names)} start" if len(context) == 2 else f"{context.names[body]} starts"
    whom = "each other" if len(context) == 2 else "the barycentre of the others"
    return (
        f"{who} at {fast} relative to {whom}, {speed / escape:.3g} times the speed of escape there, "
        f"{held}; expected at most {limit:g} times, unless a fast flyby is meant: check the units of the velocities, "
        "of the masses and of G"
    )


def _far(
    context: Context, pair: tuple[int, int], apart: float, heavy: int, *sizes: float, tolerance: float | None
) -> str:
    """Return the warning that bodies near each other are far from the barycentre, the origin of the integration."""
    distance, rounding, enough, limit = sizes

    digits, who = ((distance, 4), (apart, 4), (rounding, 2)), context.names[heavy]
    far, near, least = (context.units.text(value, "length", count) for value, count in digits)
    follows = "Every step loses that much"
    remedy = f"{who} as a fullbody.forces.ThirdBody on a prescribed path, which costs no digits"
    if tolerance is not None:
        follows = "A step cannot be more exact than that: with smaller tolerances steps grow ever shorter, and the run "
        follows += "may never end"
        remedy += f", or rtol and atol of {enough:g} or more"
    return (
        f"{who} is {far} from {' and '.join(context.names[index] for index in sorted(pair))}, which are "
        f"{near} apart, and so heavy that the barycentre, which positions are counted from, is far from these "
        f"two: their coordinates round at {least}, {rounding / apart:.2g} of their distance. "
        f"{follows}; expected bodies within {limit:g} such distances, or {remedy}"
    )
