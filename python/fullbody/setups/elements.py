"""Starts of a binary in the actual attraction of its bodies, by mean elements, and by osculating ones."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..base import rotations
from ..base.units import without_unit
from ..errors import BodiesOverlap, FullbodyError, NotConverged
from ..model.composite import Composite
from ..model.failures import explaining
from ..model.polyhedron import Polyhedron
from ..model.state import State, strip
from ..model.stokes import StokesCoefficients
from ..motion.system import System
from ..observables import mutual_period
from ..orbit.elements import KeplerElements
from ..record.integrators import Verner98
from .masses import BinarySolution
from .start import Start

#: The mean is measured over 16 to 64 revolutions, to contain 5 librations of a locked body if possible.
_REVOLUTIONS, _MOST_REVOLUTIONS, _LIBRATIONS = 16, 64, 5
#: Samples per revolution; relative errors of the period that end the search, and above which there is a warning.
_SAMPLES, _CONVERGED, _IRREGULAR = 32, 1e-9, 1e-6
#: The mean is then compared with that over 2 and 4 times as many revolutions, to this relative error. Of 120 random
#: orbits of e < 0.1 about bodies with tilts below 0.1 radians 117 keep it to 3e-5; the others are irregular.
_LONGER, _DRIFT = (2, 4), 1e-4
#: Tolerances of the runs for the search and for the comparison.
_TOLERANCE, _ROUGH_TOLERANCE = 1e-11, 1e-8
#: Samples per revolution for the comparison.
_ROUGH_SAMPLES = 12
_TRIALS = 6


def mean_start(
    system: System, solution: BinarySolution, start: Start, has_period: bool, start_period: float | None
) -> tuple[State, str | None]:
    """Return a start in the bodies' actual attraction, and a warning if it does not keep a mean period that is given.

    The result, which takes tenths of a second, is cached for equal arguments.
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
        circle, mu = _circular_orbit(system, solution, start, fixed="semi_major_axis")
        return start.state(circle.semi_major_axis, mu, circle.period), None

    def start_of_period(period: float) -> State:
        circle, mu = _circular_orbit(system, replace(solution, period=period), start, fixed="period")
        return start.state(circle.semi_major_axis, mu, solution.period)

    if start_period is not None:
        return start_of_period(start_period), None
    return start_with_period(system, solution.period, start_of_period, start.locked)


def osculating_start(
    system: System, solution: BinarySolution, start: Start, warn_above: float
) -> tuple[State, str | None]:
    """Return the start of a Kepler orbit, and a warning if the bodies' figures force a larger eccentricity."""
    kepler = system.context.G * sum(solution.masses)
    state = start.state(solution.semi_major_axis, kepler, solution.period)
    # The attraction is that at the distance of the start, where the bodies do not overlap.
    at_start = replace(solution, semi_major_axis=float(np.linalg.norm(start.separation)))
    _, mu = _circular_orbit(system, at_start, start, fixed="semi_major_axis")
    forced, eccentricity = abs(mu / kepler - 1.0), start.orbit.eccentricity
    if forced - eccentricity <= warn_above:
        return state, None
    r, v = state.position[1] - state.position[0], state.velocity[1] - state.velocity[0]
    free = KeplerElements.from_cartesian(r, v, mu).e
    return state, (
        f"the eccentricity of {eccentricity:.3g} is osculating and below that of {forced:.3g} which the figures of the "
        f"bodies force at this distance; the distance will vary as on an ellipse of eccentricity {free:.3g}; expected "
        "elements='mean', with the eccentricity that the distance is to show"
    )


def _circular_orbit(
    system: System, solution: BinarySolution, start: Start, *, fixed: str
) -> tuple[BinarySolution, float]:
    """Compute period and semi-major axis of a circular orbit, and its mu: r^2 times the relative acceleration.

    If the primary rotates relative to the secondary, mu is the mean over a rotation, unless the bodies overlap in it.
    The ``fixed`` one of "period" and "semi_major_axis" is that of the solution, from which the other follows.
    """
    primary, secondary = start.attitudes
    # Four attitudes at steps of 45 degrees cancel the equator's harmonics of the orders 2, 4 and 6.
    eighths = range(4 if start.primary_rotates else 1)
    attitudes_by_angle = [
        (rotations.product(primary, rotations.about_axis(2, np.pi / 4 * k)), secondary) for k in eighths
    ]
    try:
        return _circular(system, solution, start.direction, attitudes_by_angle, fixed)
    except BodiesOverlap:
        return _circular(system, solution, start.direction, [start.attitudes], fixed)


def _circular(
    system: System, solution: BinarySolution, direction: Any, attitudes: Sequence[Any], fixed: str
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
    if fixed == "semi_major_axis":
        mu = mu_at(size)
        return replace(solution, period=float(2 * np.pi * np.sqrt(size**3 / mu))), mu
    for _ in range(50):
        mu = mu_at(size)
        previous, size = size, float(np.cbrt(mu * (solution.period / (2 * np.pi)) ** 2))
        if abs(size - previous) <= 1e-14 * size:
            return replace(solution, semi_major_axis=size), mu
    raise NotConverged(f"no circular orbit of the period {solution.period:.6g} was found in 50 steps")


def start_with_period(
    system: System, period: float, start: Callable[[float], State], locked: Sequence[int]
) -> tuple[State, str | None]:
    """Find the start whose run has a mean sidereal period, and a warning if longer runs do not keep it.

    The period is measured over some revolutions and then compared over more. The comparison is necessary, since
    adjusting one number of the start can give even an irregular motion any mean over one length. The function ``start``
    makes a start from a period, with which the mean period of its run changes almost in proportion; the bodies that are
    ``locked`` rotate with the orbit, and may librate.
    """
    best = start(period)
    if _of_points(system):
        return best, None
    gravity = system.options["gravity"]
    # Both exact methods give the same results; the focal rule is the faster one.
    method = {"gravity": "focal", "order": None} if gravity == "surface" else {}
    rough = system.with_options(attitude_chart="quaternion", gravity_tolerance=_TOLERANCE, **method)
    revolutions = _revolutions(system, locked)
    target, state, slope = period, best, 1.0
    smallest, last = np.inf, (0.0, 0.0)
    try:
        for trial in range(_TRIALS):
            error = _errors(rough, state, period, (revolutions,))[0]
            if abs(error) < abs(smallest):
                best, smallest = state, error
            if abs(smallest) <= _CONVERGED:
                break
            if trial > 0 and target != last[0]:
                secant = (error - last[1]) / (target - last[0]) * period
                slope = secant if 0.5 < secant < 2.0 else 1.0
            last = (target, error)
            target -= error / slope * period
            state = start(target)
    except FullbodyError as failure:
        if not np.isfinite(smallest):
            return best, f"{revolutions} revolutions, to measure the mean period in, cannot be run: {_reason(failure)}"
    if abs(smallest) > _IRREGULAR:
        return best, (
            f"the mean period over {revolutions} revolutions differs from the period given by {smallest:.1e} of it; "
            "the motion is too irregular for a start to have it"
        )
    return best, drift_warning(rough, best, period, revolutions)


def drift_warning(system: System, start: State, period: float, revolutions: int) -> str | None:
    """Return a warning if the mean period over more revolutions differs from the one over these."""
    lengths = [revolutions * times for times in _LONGER]
    stated = f"the mean period is the one given over {revolutions} revolutions"
    try:
        errors = _errors(system, start, period, lengths, _ROUGH_TOLERANCE, _ROUGH_SAMPLES)
    except FullbodyError as failure:
        return f"{stated}; {lengths[-1]}, to see whether it lasts in, cannot be run: {_reason(failure)}"
    if max(map(abs, errors)) <= _DRIFT:
        return None
    text = " and ".join(f"{error:+.1e} of it over {length}" for error, length in zip(errors, lengths, strict=True))
    return f"{stated} and differs by {text}; the motion is irregular, and no mean period lasts"


def _reason(error: FullbodyError) -> str:
    return f"{' and '.join(error.bodies)} meet in them" if isinstance(error, BodiesOverlap) else str(error)


def _errors(
    system: System,
    start: State,
    period: float,
    lengths: Sequence[int],
    tolerance: float = _TOLERANCE,
    samples: int = _SAMPLES,
) -> list[float]:
    """Return the relative errors of the mean sidereal periods over each of these numbers of revolutions."""
    integrator = Verner98(rtol=tolerance, atol=tolerance)
    run = system.integrate(start, lengths[-1] * period, output=period / samples, integrator=integrator)
    means = [mutual_period(run[: length * samples + 1]).mean for length in lengths]
    return [float(without_unit(mean)) / period - 1.0 for mean in means]


def _revolutions(system: System, locked: Sequence[int]) -> int:
    """Return a number of revolutions that contains some free librations of the slowest locked body."""
    slowest = np.inf
    for index in locked:
        a, b, _ = system.context.bodies[index].semi_axes
        if a != b:
            slowest = min(slowest, float(np.sqrt(3 * abs(a**2 - b**2) / (a**2 + b**2))))
    return int(np.clip(np.ceil(_LIBRATIONS / slowest), _REVOLUTIONS, _MOST_REVOLUTIONS))


def _of_points(system: System) -> bool:
    """Return whether the bodies attract as points do, so that a Kepler orbit is exact."""
    points = system.options["gravity"] == "point"
    return points or all(
        len(set(core.semi_axes)) == 1 and not isinstance(body.shape, Composite | Polyhedron | StokesCoefficients)
        for body, core in zip(system.bodies, system.context.bodies, strict=True)
    )
