"""Warnings of binaries that can be computed, but are probably a mistake."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..base.tables import number
from ..model.state import State
from ..motion.system import System
from .component import Component

#: The semi-major axis relative to the primary's longest semi-axis; only a few known binaries, beyond Neptune, are
#: wider.
_WIDE = 200.0


def of_binary(
    system: System, components: tuple[Component, Component], synchronous: bool, separation: float
) -> Iterator[str]:
    """Yield warnings about sizes and spins; :class:`fullbody.System` itself warns of densities."""
    units = system.context.units
    longest = max(system.context.bodies[0].semi_axes)
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


def too_round(start: State, eccentricity: float, forced: float, mu: float) -> str:
    """Return a warning of an osculating eccentricity below the forced one, with mu of the bodies' actual attraction."""
    r, v = start.position[1] - start.position[0], start.velocity[1] - start.velocity[0]
    free = np.linalg.norm(np.cross(v, np.cross(r, v)) / mu - r / np.linalg.norm(r))
    return (
        f"the eccentricity of {eccentricity:.3g} is osculating and below that of {forced:.3g} which the figures of the "
        f"bodies force at this distance; the distance will vary as on an ellipse of eccentricity {free:.3g}; expected "
        "elements='mean', with the eccentricity that the distance is to show"
    )
