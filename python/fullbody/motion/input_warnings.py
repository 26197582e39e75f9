"""Warnings about bodies and starts that can be integrated but are probably mistakes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import fullbody._core as _core

from ..base.unit_names import unit_named
from ..model.context import Context
from ..model.force import KINDS

#: The least and the greatest density of a body, in kg/m3, that cause no warning.
_DENSITIES = (100.0, 30000.0)


def body_warnings(context: Context) -> Iterator[str]:
    """Yield warnings about implausible densities of bodies, and about composites whose parts nearly cancel."""
    tolerance = context.core.settings["gravity_tolerance"]
    for name, body in zip(context.names, context.bodies, strict=True):
        if context.units.defined and body.volume != 0.0:
            density = context.units.attach(body.mass / body.volume, "density").to_value(unit_named("kg / m3"))
            if not _DENSITIES[0] <= density <= _DENSITIES[1]:
                expected = f"expected {_DENSITIES[0]:g} to {_DENSITIES[1]:g}: check the units of its size and mass"
                yield f"{name} has a density of {density:.3g} kg/m3; {expected}"
        masses = np.array([mass for _, mass, *_ in body.input_parts] or [1.0])
        least, largest = int(np.argmin(masses)), int(np.argmax(masses))
        rounding = float(np.finfo(float).eps * np.abs(masses).sum() / np.sum(masses))
        if masses[least] < 0.0 and rounding > 100.0 * tolerance:
            yield (
                f"parts {largest} and {least} of {name}, of {masses[largest]:g} and {masses[least]:g} in mass, nearly "
                f"cancel: rounding leaves forces uncertain by {rounding:.0e} of their size; gravity_tolerance is "
                f"{tolerance:g}"
            )


def start_warnings(context: Context, start: _core.State, tolerance: float | None) -> Iterator[str]:
    """Return warnings about a start; the tolerance is the sum of the integrator's, ``None`` for fixed steps."""
    unbound, distant = context.core.start_warnings(start, tolerance)
    if unbound is not None:
        yield _unbound(context, *unbound)
    if distant is not None:
        yield _distant(context, *distant, tolerance=tolerance)
    for described in context.core.forces:
        yield from KINDS[described["kind"]]._input_warnings(described, start, context)


def _unbound(context: Context, body: int, speed: float, escape: float, limit: float) -> str:
    """Return the warning that a body is much faster than its speed of escape and cannot be bound."""
    speeds = [context.units.text(value, "velocity", 4) for value in (speed, escape)]
    subject, reference = f"{context.names[body]} starts", "the barycentre of the others"
    if len(context) == 2:
        subject, reference = f"{' and '.join(context.names)} start", "each other"
    return (
        f"{subject} at {speeds[0]} relative to {reference}, {speed / escape:.3g} times the speed of escape there, "
        f"{speeds[1]}; expected at most {limit:g} times, unless a fast flyby is meant: check the units of the "
        "velocities, of the masses and of G"
    )


def _distant(
    context: Context, pair: tuple[int, int], apart: float, heavy: int, *sizes: float, tolerance: float | None
) -> str:
    """Return the warning that bodies near each other are far from the barycentre, the origin of the integration."""
    distance, rounding, advised, limit = sizes
    name, text = context.names[heavy], context.units.text
    consequence = "Every step loses that much"
    remedy = f"{name} as a fullbody.forces.ThirdBody on a prescribed path, which costs no digits"
    if tolerance is not None:
        consequence = "A step cannot be more exact than that: with smaller tolerances steps grow ever shorter, and the "
        consequence += "run may never end"
        remedy += f", or rtol and atol of {advised:g} or more"
    return (
        f"{name} is {text(distance, 'length', 4)} from {' and '.join(context.names[k] for k in sorted(pair))}, which "
        f"are {text(apart, 'length', 4)} apart, and so heavy that the barycentre, which positions are counted from, is "
        f"far from these two: their coordinates round at {text(rounding, 'length', 2)}, {rounding / apart:.2g} of "
        f"their distance. {consequence}; expected bodies within {limit:g} such distances, or {remedy}"
    )
