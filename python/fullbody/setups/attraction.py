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
from .masses import BinarySolution
from .start import Start


def circular_orbit(
    system: System, solution: BinarySolution, start: Start, *, keep: str
) -> tuple[BinarySolution, float]:
    """Compute period and semi-major axis of a circular orbit, and its mu: r^2 times the relative acceleration.

    If the primary turns relative to the secondary, mu is the mean over a turn, unless the bodies overlap in it. The one
    of "period" and "semi_major_axis" that is kept stays as found; the other follows.
    """
    primary, secondary = start.attitudes
    # Four attitudes at steps of an eighth turn cancel the equator's harmonics of the orders 2, 4 and 6.
    eighths = range(4 if start.primary_rotates else 1)
    attitudes_by_angle = [
        (rotations.product(primary, rotations.about_axis(2, np.pi / 4 * k)), secondary) for k in eighths
    ]
    try:
        return _circular(system, solution, start.direction, attitudes_by_angle, keep)
    except BodiesOverlap:
        return _circular(system, solution, start.direction, [start.attitudes], keep)


def _circular(
    system: System, solution: BinarySolution, direction: Any, attitudes: Sequence[Any], keep: str
) -> tuple[BinarySolution, float]:
    reduced = solution.masses[0] * solution.masses[1] / sum(solution.masses)

    def mu_at(distance: float) -> float:
        """Return the mean of mu over the attitudes."""
        total = 0.0
        for pair in attitudes:
            core = strip(State([np.zeros(3), distance * direction], np.zeros((2, 3)), pair), system.context)
            with explaining(system.context, core, " at the start"):
                total += -float(system.context.core.interactions(core)[0][1] @ direction)
        return total / len(attitudes) / reduced * distance**2

    size = solution.semi_major_axis
    if keep == "semi_major_axis":
        mu = mu_at(size)
        return replace(solution, period=float(2 * np.pi * np.sqrt(size**3 / mu))), mu
    for _ in range(50):
        mu = mu_at(size)
        previous, size = size, float(np.cbrt(mu * (solution.period / (2 * np.pi)) ** 2))
        if abs(size - previous) <= 1e-14 * size:
            return replace(solution, semi_major_axis=size), mu
    raise NotConverged(f"no circular orbit of the period {solution.period:.6g} was found in 50 steps")
