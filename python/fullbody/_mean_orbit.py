"""Starts of orbits whose mean period is a given one, in the bodies' actual attraction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from . import _rotation
from ._masses import Found
from .errors import FullbodyError, NotConverged
from .state import State
from .system import System

#: Revolutions that a period is measured in, samples in each, and how well it is to be met.
REVOLUTIONS, SAMPLES, ENOUGH = 16, 32, 1e-10
_LOOSE = 1e-11


def in_attraction(
    system: System, found: Found, by_period: bool, direction: Any, attitudes: Any, turning: bool
) -> tuple[Found, float]:
    """Semi-major axis and period in the actual attraction, and the mu that stands for it."""
    first = [attitudes[0]]
    if turning:
        # Quarter turns of an eighth average all that an ellipsoid's equator does to the sixth degree.
        first = [_rotation.product(attitudes[0], _rotation.turn(2, np.pi / 4 * k)) for k in range(4)]
    reduced = found.masses[0] * found.masses[1] / sum(found.masses)

    def attraction(size: float) -> float:
        """Mu at a distance."""
        total = 0.0
        for q in first:
            state = State([np.zeros(3), size * direction], np.zeros((2, 3)), [q, attitudes[1]])
            force = system._core.interactions(state._core)[0]
            total += -float(force[1] @ direction)
        return total / len(first) / reduced * size**2

    size = found.semi_major_axis
    if not by_period:
        mu = attraction(size)
        return replace(found, period=float(2 * np.pi * np.sqrt(size**3 / mu))), mu
    for _ in range(50):
        mu = attraction(size)
        before, size = size, float(np.cbrt(mu * (found.period / (2 * np.pi)) ** 2))
        if abs(size - before) <= 1e-14 * size:
            return replace(found, semi_major_axis=size), mu
    raise NotConverged(f"no circular orbit of the period {found.period:.6g} was found in 50 steps")


def kept(system: System, period: float, start: Callable[[float], State]) -> State:
    """The start whose run has a mean sidereal period, of starts (in plain numbers) made for one.

    Where the revolutions cannot be run, that made for the period itself.
    """
    first = start(period)
    if _of_points(system):
        return first
    gravity = system.options["gravity"]
    # Both of the exact methods give the same; the focal rule is the faster one.
    method = {"gravity": "focal", "order": None} if gravity == "surface" else {}
    loose = system.with_options(attitude_chart="quaternion", gravity_tolerance=_LOOSE, **method)
    try:
        off = measured(loose, first, period) - period
        if abs(off) <= ENOUGH * period:
            return first
        target = period - off
        again = measured(loose, start(target), period) - period
        # The secant through both: what a period made for gives changes almost one to one.
        slope = (off - again) / off
        if not 0.5 < slope < 2.0:
            return first
        return start(target - again / slope)
    except FullbodyError:
        return first


def measured(system: System, start: State, period: float) -> float:
    """The mean sidereal period of a run.

    The slope of the longitude under a Hann window to the third power, which leaves of a periodic term of k periods in
    the run about k^-7 (Laskar 1993, Physica D 67, 257).
    """
    from .integrators import Verner98
    from .observables import _signal as signal
    from .observables._view import View

    run = system.integrate(start, REVOLUTIONS * period, period / SAMPLES, integrator=Verner98(rtol=_LOOSE, atol=_LOOSE))
    view = View(run, 1, 0, SAMPLES, "a mutual period", whole=True)
    return float(2 * np.pi / signal.slope(view.time, view.longitude[0], power=3))


def _of_points(system: System) -> bool:
    """Whether the bodies attract as points do, so that a Kepler orbit is exact."""
    shapes = [body.shape.semi_axes for body in system.bodies]
    spheres = all(axes is None or axes[0] == axes[1] == axes[2] for axes in shapes)
    return spheres or system.options["gravity"] == "point"
