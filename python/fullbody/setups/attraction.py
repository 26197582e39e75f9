"""Circular orbits in the actual attraction of the bodies of a binary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..base import rotations
from ..errors import BodiesOverlap, NotConverged
from ..model.failures import explaining
from ..model.state import State, strip
from ..motion.system import System
from .masses import Found
from .start import Start


def circular_orbit(system: System, found: Found, start: Start, *, keep: str) -> tuple[Found, float]:
    """Compute period and semi-major axis of a circular orbit, and its mu: r^2 times the relative acceleration.

    If the primary turns relative to the secondary, mu is the mean over a turn, unless the bodies overlap in it. The one
    of "period" and "semi_major_axis" that is kept stays as found; the other follows.
    """
    primary, secondary = start.attitudes
    # Four attitudes at steps of an eighth turn cancel the equator's harmonics of the orders 2, 4 and 6.
    eighths = range(4 if start.primary_turns else 1)
    turned = [(rotations.product(primary, rotations.turn(2, np.pi / 4 * k)), secondary) for k in eighths]
    try:
        return _circular(system, found, start.direction, turned, keep)
    except BodiesOverlap:
        return _circular(system, found, start.direction, [start.attitudes], keep)


def _circular(system: System, found: Found, direction: Any, attitudes: Sequence[Any], keep: str) -> tuple[Found, float]:
    reduced = found.masses[0] * found.masses[1] / sum(found.masses)

    def mu_at(distance: float) -> float:
        """Return the mean of mu over the attitudes."""
        total = 0.0
        for pair in attitudes:
            core = strip(State([np.zeros(3), distance * direction], np.zeros((2, 3)), pair), system.context)
            with explaining(system.context, core, " at the start"):
                total += -float(system.context.core.interactions(core)[0][1] @ direction)
        return total / len(attitudes) / reduced * distance**2

    size = found.semi_major_axis
    if keep == "semi_major_axis":
        mu = mu_at(size)
        return replace(found, period=float(2 * np.pi * np.sqrt(size**3 / mu))), mu
    for _ in range(50):
        mu = mu_at(size)
        before, size = size, float(np.cbrt(mu * (found.period / (2 * np.pi)) ** 2))
        if abs(size - before) <= 1e-14 * size:
            return replace(found, semi_major_axis=size), mu
    raise NotConverged(f"no circular orbit of the period {found.period:.6g} was found in 50 steps")
