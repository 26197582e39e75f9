"""Binaries that can be computed, but are probably a mistake."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..base.tables import number
from ..model.state import State
from ..motion.simulation import System
from .component import Component

#: Semi-major axes by the primary's longest semi-axis; of the known binaries only a few beyond Neptune are wider.
_WIDE = 200.0
#: The bulk densities of known bodies lie between these, kg/m^3.
_DENSITIES = (100.0, 20000.0)


def of_binary(
    system: System, components: tuple[Component, Component], synchronous: bool, separation: float
) -> Iterator[str]:
    """Warnings about sizes, spins and densities."""
    units = system._units
    longest = max(system.bodies[0]._semi_axes(units) or ())
    if separation > _WIDE * longest:
        far, size = (number(units.attach(np.float64(value), "length"), 4) for value in (separation, longest))
        yield (
            f"the semi-major axis, {far}, is {separation / longest:.4g} times the longest semi-axis of the primary "
            f"{system.names[0]!r}, {size}; expected at most {_WIDE:g} times: check the units of the sizes, of the "
            "masses and of the period or the semi-major axis"
        )
    for k, (name, component) in enumerate(zip(system.names, components, strict=True)):
        called = f"{('primary', 'secondary')[k]} {name!r}"
        if component.rotation_period is None and not (synchronous and k == 1):
            yield (
                f"the {called} has no rotation_period and starts without rotation; expected one, infinite if that is "
                "meant"
            )
        if units.known:
            from astropy import units as u

            body = system.bodies[k]._core(units, k)
            density = (body.mass / body.volume * units.unit("density")).to_value(u.kg / u.m**3)
            low, high = _DENSITIES
            if not low <= density <= high:
                yield f"the density of the {called} follows as {density:.4g} kg/m^3; expected {low:g} to {high:g}"


def too_round(start: State, given: float, forced: float, mu: float) -> str:
    """A warning of an osculating eccentricity below the forced one; mu is that of the bodies' actual attraction."""
    r, v = start.position[1] - start.position[0], start.velocity[1] - start.velocity[0]
    free = np.linalg.norm(np.cross(v, np.cross(r, v)) / mu - r / np.linalg.norm(r))
    return (
        f"the eccentricity of {given:.3g} is osculating and below that of {forced:.3g} which the figures of the bodies "
        f"force at this distance; the distance will vary as on an ellipse of eccentricity {free:.3g}; expected "
        "elements='mean', with the eccentricity that the distance is to show"
    )
