"""Beta's spin in the first 200 hours, by start: which starts give the six numbers that the paper prints."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from fullbody import State, System, Verner98, systems
from scipy.spatial.transform import Rotation

from . import paper
from .kw4 import spin_range
from .starts import ORBIT, RATE, ahead, normal, rotated, start

__all__ = [
    "COARSE",
    "FAMILIES",
    "NEAR",
    "PRINTED",
    "ROUNDING",
    "Reading",
    "Scan",
    "misfit",
    "readings",
    "scan",
    "shared",
]

_Array = npt.NDArray[np.float64]

#: The printed ranges, 1e-5 rad/s, (3, 2), and half a unit of their last digit.
PRINTED = np.array([paper.SPIN[axis] for axis in "xyz"])
ROUNDING = 0.005
#: A start counts as near to the printed ranges where no number is farther off than this: twice their rounding.
NEAR = 2 * ROUNDING
#: Four digits are enough here.
COARSE = Verner98(1e-10, 1e-10)


def misfit(ranges: _Array) -> Any:
    """Return the largest difference of ranges (..., 3, 2) from the six printed numbers, 1e-5 rad/s."""
    return np.abs(ranges - PRINTED).max(axis=(-2, -1))


def shared(work: Callable[[Any], Any], over: Any) -> list[Any]:
    """Return the results of one function for many arguments, in order; integration leaves Python's lock alone."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(work, over))


def _about_normal(state: State, degrees: float) -> State:
    return rotated(state, Rotation.from_rotvec(degrees * normal(state), degrees=True))


def _about_pole(state: State, degrees: float) -> State:
    return rotated(state, Rotation.from_euler("z", degrees, degrees=True))


#: Families of starts by name: unit of the parameter, its stated value, how far it is scanned to either side, the start.
FAMILIES: dict[str, tuple[str, float, float, Callable[[System, State, float], State]]] = {
    "all but Beta's attitude and spin ahead by": ("h", 0.0, 4.5, ahead),
    "Beta rotated about the orbit's normal by": ("deg", 0.0, 90.0, lambda _, state, x: _about_normal(state, x)),
    "Beta rotated about its own pole by": ("deg", 0.0, 90.0, lambda _, state, x: _about_pole(state, x)),
    "Beta's rate of spin": ("rad/h", RATE, 0.05, lambda system, state, x: start(state, system.mu(), spin=x)),
}


@dataclass(frozen=True, slots=True)
class Scan:
    """Ranges of Beta's spin (K, 3, 2), 1e-5 rad/s, along a family of starts, closer together near the best."""

    name: str
    unit: str
    stated: float
    values: _Array
    ranges: _Array

    @property
    def best(self) -> tuple[float, float]:
        """Parameter of the smallest misfit, and that misfit."""
        misfits = misfit(self.ranges)
        k = int(np.argmin(misfits))
        return float(self.values[k]), float(misfits[k])

    @property
    def near(self) -> tuple[float, float]:
        """The parameters between which no number is farther off than ``NEAR``; NaN where none is that near."""
        misfits = misfit(self.ranges)
        inside = np.flatnonzero(misfits <= NEAR)
        if not len(inside):
            return float("nan"), float("nan")
        # At either end, between the last one inside and the first one outside.
        ends = [
            sorted((k, k + step), key=lambda i: float(misfits[i])) for k, step in ((inside[0], -1), (inside[-1], 1))
        ]
        low, high = (float(np.interp(NEAR, misfits[pair], self.values[pair])) for pair in ends)
        return low, high


def scan(name: str, steps: int = 18) -> Scan:
    """Return Beta's spin along one of the ``FAMILIES``: ``steps`` to either side, then finer about the best."""
    system, state = systems.kw4_ho2021()
    unit, stated, reach, make = FAMILIES[name]

    def ranges(values: _Array) -> _Array:
        return np.array(shared(lambda x: spin_range(system, make(system, state, x), COARSE), values))

    step = reach / steps
    values = stated + step * np.arange(-steps, steps + 1, dtype=np.float64)
    result = Scan(name, unit, stated, values, ranges(values))
    for _ in range(2):
        step /= 5
        near = result.best[0] + step * np.array([-4, -3, -2, -1, 1, 2, 3, 4])
        values = np.concatenate([result.values, near])
        both, order = np.concatenate([result.ranges, ranges(near)]), np.argsort(values)
        result = Scan(name, unit, stated, values[order], both[order])
    return result


@dataclass(frozen=True, slots=True)
class Reading:
    """A start that somebody could have meant or run by mistake; its spin, 1e-5 rad/s, and its year, km."""

    name: str
    ranges: _Array
    misfit: float
    a_mean: float
    e_max: float


def readings(best: tuple[float, float, float]) -> list[Reading]:
    """Return the stated start, Beta's best orientation (phi, theta, psi in degrees), and slips that come near it."""
    system, state = systems.kw4_ho2021()
    hour = float(np.rad2deg(np.sqrt(system.mu() / ORBIT["a"] ** 3)))
    rate = float(np.rad2deg(RATE))
    later = system.integrate(state, 1.0, output=[1.0])[-1]
    results = {
        "as stated": state,
        "Beta at the best orientation": rotated(state, Rotation.from_euler("ZYX", best[::-1], degrees=True)),
        f"Beta rotated about the orbit's normal by an hour of mean motion, {-hour:.2f} deg": _about_normal(
            state, -hour
        ),
        f"the same by its spin rate taken as an angle, {RATE} rad, {-rate:.2f} deg": _about_normal(state, -rate),
        f"Beta rotated by that angle about its own pole, psi = {rate:.2f} deg": _about_pole(state, rate),
        "all but Beta's attitude and spin an hour later": ahead(system, state, 1.0),
        "positions and velocities alone an hour later": ahead(system, state, 1.0, alpha=False),
        f"mean anomaly of an hour, {hour:.2f} deg": start(state, system.mu(), M=hour),
        "Beta's attitude alone an hour later": state.replace(attitude=[state.attitude[0], later.attitude[1]]),
    }

    def measure(name: str) -> Reading:
        ranges = spin_range(system, results[name])
        year = system.integrate(results[name], paper.YEAR_HOURS, integrator=COARSE)
        orbit = year.elements()
        mean = np.trapezoid(orbit.a, year.time) / np.ptp(year.time)
        return Reading(name, ranges, float(misfit(ranges)), float(mean), float(orbit.e.max()))

    return shared(measure, results)
