"""Starts of a binary by the mean elements of its orbit, and by osculating ones."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..model.state import State
from ..motion.system import System
from .masses import BinarySolution
from .mean_period import circular_orbit, start_with_period
from .start import Start


def mean_start(
    system: System, solution: BinarySolution, start: Start, has_period: bool, start_period: float | None
) -> tuple[State, str | None]:
    """Return a start in the bodies' actual attraction, and a warning if it does not keep a mean period that is given.

    The result, which takes tenths of a second, is kept for equal arguments.
    """
    arguments = system, solution, start, has_period, start_period
    try:
        packed = pickle.dumps(arguments)
    except (pickle.PicklingError, AttributeError, TypeError):
        # A force may be a function that has no name.
        return _mean_start(*arguments)
    return _packed_mean_start(packed)


@lru_cache(maxsize=64)
def _packed_mean_start(packed: bytes) -> tuple[State, str | None]:
    return _mean_start(*pickle.loads(packed))


def _mean_start(
    system: System, solution: BinarySolution, start: Start, has_period: bool, start_period: float | None
) -> tuple[State, str | None]:
    if not has_period:
        circle, mu = circular_orbit(system, solution, start, keep="semi_major_axis")
        return start.state(circle.semi_major_axis, mu, circle.period), None

    def made_for(period: float) -> State:
        circle, mu = circular_orbit(system, replace(solution, period=period), start, keep="period")
        return start.state(circle.semi_major_axis, mu, solution.period)

    if start_period is not None:
        return made_for(start_period), None
    return start_with_period(system, solution.period, made_for, start.locked)


def osculating_start(
    system: System, solution: BinarySolution, start: Start, warn_above: float
) -> tuple[State, str | None]:
    """Return the start of a Kepler orbit, and a warning if the bodies' figures force a larger eccentricity."""
    kepler = system.context.G * sum(solution.masses)
    state = start.state(solution.semi_major_axis, kepler, solution.period)
    # The attraction is that at the distance of the start, where the bodies do not overlap.
    there = replace(solution, semi_major_axis=float(np.linalg.norm(start.separation)))
    _, mu = circular_orbit(system, there, start, keep="semi_major_axis")
    forced, eccentricity = abs(mu / kepler - 1.0), start.orbit.eccentricity
    if forced - eccentricity <= warn_above:
        return state, None
    r, v = state.position[1] - state.position[0], state.velocity[1] - state.velocity[0]
    free = np.linalg.norm(np.cross(v, np.cross(r, v)) / mu - r / np.linalg.norm(r))
    return state, (
        f"the eccentricity of {eccentricity:.3g} is osculating and below that of {forced:.3g} which the figures of the "
        f"bodies force at this distance; the distance will vary as on an ellipse of eccentricity {free:.3g}; expected "
        "elements='mean', with the eccentricity that the distance is to show"
    )
