"""Starts of orbits whose mean period is a given one, in the bodies' actual attraction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..base import rotations
from ..errors import BodiesOverlap, FullbodyError, NotConverged
from ..model.state import State
from ..motion.simulation import System
from .masses import Found

#: Revolutions that a period is measured in, at least and at most, and librations of a locked body that they hold.
REVOLUTIONS, MOST, LIBRATIONS = 16, 64, 5
#: Samples in each, how well the period is to be met, and what is worth a word.
SAMPLES, ENOUGH, WORTH_A_WORD = 32, 1e-9, 1e-6
#: Over how many times as many revolutions the mean is to last, and how well. Of 120 random orbits of e < 0.1 about
#: bodies with tilts below 0.1 radians 117 keep it to 3e-5; the others are irregular.
LONGER, LASTING = (2, 4), 1e-4
_LOOSE = 1e-11
_TRIALS = 6


def in_attraction(
    system: System, found: Found, by_period: bool, direction: Any, attitudes: Any, turning: bool
) -> tuple[Found, float]:
    """Semi-major axis and period of a circular orbit in the actual attraction, and the mu that stands for it.

    Of a primary that turns beneath the secondary it is the mean over a turn, unless the bodies overlap in one.
    """
    # Four turns by an eighth cancel the equator's harmonics of the orders 2, 4 and 6.
    turned = [rotations.product(attitudes[0], rotations.turn(2, np.pi / 4 * k)) for k in range(4 if turning else 1)]
    try:
        return _circular(system, found, by_period, direction, [(q, attitudes[1]) for q in turned])
    except BodiesOverlap:
        return _circular(system, found, by_period, direction, [attitudes])


def _circular(
    system: System, found: Found, by_period: bool, direction: Any, poses: Sequence[Any]
) -> tuple[Found, float]:
    reduced = found.masses[0] * found.masses[1] / sum(found.masses)

    def attraction(size: float) -> float:
        """Mu at a distance."""
        total = 0.0
        for pose in poses:
            core = State([np.zeros(3), size * direction], np.zeros((2, 3)), pose)._core
            with system._explaining(lambda core=core: core, " at the start"):  # type: ignore[misc]
                total += -float(system._core.interactions(core)[0][1] @ direction)
        return total / len(poses) / reduced * size**2

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


class Kept(NamedTuple):
    """A start, and what is to be said of it where its run has not the period."""

    state: State
    doubt: str | None


def kept(system: System, period: float, start: Callable[[float], State], locked: Sequence[int]) -> Kept:
    """The start whose run has a mean sidereal period, of starts (in plain numbers) made for one.

    It is made over some revolutions, and looked at over more: the start has few numbers to turn, and would have a mean
    of any motion over one length.

    Parameters
    ----------
    start
        Makes one; its run's period changes almost one to one with that it is made for.
    locked
        Places of the bodies that turn with the orbit, and may librate.
    """
    best = start(period)
    if _of_points(system):
        return Kept(best, None)
    gravity = system.options["gravity"]
    # Both of the exact methods give the same; the focal rule is the faster one.
    method = {"gravity": "focal", "order": None} if gravity == "surface" else {}
    loose = system.with_options(attitude_chart="quaternion", gravity_tolerance=_LOOSE, **method)
    revolutions = _revolutions(system, locked)
    made, state, slope = period, best, 1.0
    off, last = np.inf, (0.0, 0.0)
    try:
        for trial in range(_TRIALS):
            missed = _missed(loose, state, period, (revolutions,))[0]
            if abs(missed) < abs(off):
                best, off = state, missed
            if abs(off) <= ENOUGH:
                break
            if trial > 0 and made != last[0]:
                secant = (missed - last[1]) / (made - last[0]) * period
                slope = secant if 0.5 < secant < 2.0 else 1.0
            last = (made, missed)
            made -= missed / slope * period
            state = start(made)
    except FullbodyError as error:
        if not np.isfinite(off):
            return Kept(best, f"{revolutions} revolutions, to measure the mean period in, cannot be run: {_why(error)}")
    if abs(off) > WORTH_A_WORD:
        return Kept(
            best,
            f"the mean period over {revolutions} revolutions differs from the period given by {off:.1e} of it; "
            "the motion is too irregular for a start to have it",
        )
    return Kept(best, _passing(loose, best, period, revolutions))


def _passing(system: System, start: State, period: float, revolutions: int) -> str | None:
    """What is to be said of a mean over some revolutions that is another one over more."""
    lengths = [revolutions * times for times in LONGER]
    held = f"the mean period is the one given over {revolutions} revolutions"
    try:
        missed = _missed(system, start, period, lengths)
    except FullbodyError as error:
        return f"{held}; {lengths[-1]}, to see whether it lasts in, cannot be run: {_why(error)}"
    if max(map(abs, missed)) <= LASTING:
        return None
    later = " and ".join(f"{off:+.1e} of it over {length}" for off, length in zip(missed, lengths, strict=True))
    return f"{held} and differs by {later}; the motion is irregular, and no mean period lasts"


def _why(error: FullbodyError) -> str:
    return f"{' and '.join(error.bodies)} meet in them" if isinstance(error, BodiesOverlap) else str(error)


def _missed(system: System, start: State, period: float, lengths: Sequence[int]) -> list[float]:
    """How far off a period the mean sidereal periods over some numbers of revolutions are, relative to it."""
    from ..observables import mutual_period
    from ..record.integrators import Verner98

    run = system.integrate(start, lengths[-1] * period, period / SAMPLES, integrator=Verner98(rtol=_LOOSE, atol=_LOOSE))
    means = [mutual_period(run[: length * SAMPLES + 1]).mean for length in lengths]
    return [float(getattr(mean, "value", mean)) / period - 1.0 for mean in means]


def _revolutions(system: System, locked: Sequence[int]) -> int:
    """As many as hold some free librations of the slowest locked body: a nearly round equator swings slowly."""
    slowest = np.inf
    for place in locked:
        a, b, _ = _axes(system, place)
        if a != b:
            slowest = min(slowest, float(np.sqrt(3 * abs(a**2 - b**2) / (a**2 + b**2))))
    return int(np.clip(np.ceil(LIBRATIONS / slowest), REVOLUTIONS, MOST))


def _of_points(system: System) -> bool:
    """Whether the bodies attract as points do, so that a Kepler orbit is exact."""
    spheres = all(len(set(_axes(system, place))) <= 1 for place in range(len(system)))
    return spheres or system.options["gravity"] == "point"


def _axes(system: System, place: int) -> list[float]:
    """Semi-axes in plain numbers."""
    return [system._units.number(axis, "length", "semi-axis") for axis in system.bodies[place].shape._lengths or ()]
