"""Beta's spin in the first 200 hours by start, and the starts that give the six numbers of the paper."""

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
from .starts import ORBIT, RATE, advanced, normal, rotated, start

__all__ = [
    "COARSE",
    "FAMILIES",
    "NEAR",
    "PRINTED",
    "ROUNDING",
    "Reading",
    "Scan",
    "in_threads",
    "misfit",
    "readings",
    "scan",
]

_Array = npt.NDArray[np.float64]

#: The printed ranges, 1e-5 rad/s, (3, 2), and half a unit of their last digit.
PRINTED = np.array([paper.SPIN[axis] for axis in "xyz"])
ROUNDING = 0.005
#: A start counts as near the printed ranges if no number differs by more than this, twice their rounding error.
NEAR = 2 * ROUNDING
#: The integrator of scans, for which four digits are enough.
COARSE = Verner98(1e-10, 1e-10)


def misfit(ranges: _Array) -> Any:
    """Return the largest difference of ranges (..., 3, 2) from the six printed numbers, 1e-5 rad/s."""
    return np.abs(ranges - PRINTED).max(axis=(-2, -1))


def in_threads(function: Callable[[Any], Any], arguments: Any) -> list[Any]:
    """Return the results of a function for some arguments, computed in threads, since runs release Python's lock."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(function, arguments))


def _about_normal(state: State, degrees: float) -> State:
    return rotated(state, Rotation.from_rotvec(degrees * normal(state), degrees=True))


def _about_pole(state: State, degrees: float) -> State:
    return rotated(state, Rotation.from_euler("z", degrees, degrees=True))


#: Families of starts by name: unit of the parameter, its stated value, half of its scanned range, and the start.
FAMILIES: dict[str, tuple[str, float, float, Callable[[System, State, float], State]]] = {
    "all but Beta's attitude and spin ahead by": ("h", 0.0, 4.5, advanced),
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
    def near_range(self) -> tuple[float, float]:
        """The parameters between which no number differs by more than ``NEAR``; NaN if there are none."""
        misfits = misfit(self.ranges)
        inside = np.flatnonzero(misfits <= NEAR)
        if not len(inside):
            return float("nan"), float("nan")
        # Each end lies between the last parameter inside and the first one outside.
        ends = [
            sorted((k, k + step), key=lambda i: float(misfits[i])) for k, step in ((inside[0], -1), (inside[-1], 1))
        ]
        low, high = (float(np.interp(NEAR, misfits[pair], self.values[pair])) for pair in ends)
        return low, high


def scan(name: str, steps: int = 18) -> Scan:
    """Return Beta's spin along one of the ``FAMILIES``: ``steps`` to either side, then finer steps about the best."""
    system, state = systems.kw4_ho2021()
    unit, stated, half_range, changed_start = FAMILIES[name]

    def ranges(values: _Array) -> _Array:
        return np.array(in_threads(lambda x: spin_range(system, changed_start(system, state, x), COARSE), values))

    step = half_range / steps
    values = stated + step * np.arange(-steps, steps + 1, dtype=np.float64)
    result = Scan(name, unit, stated, values, ranges(values))
    for _ in range(2):
        step /= 5
        finer = result.best[0] + step * np.array([-4, -3, -2, -1, 1, 2, 3, 4])
        values = np.concatenate([result.values, finer])
        all_ranges, order = np.concatenate([result.ranges, ranges(finer)]), np.argsort(values)
        result = Scan(name, unit, stated, values[order], all_ranges[order])
    return result


@dataclass(frozen=True, slots=True)
class Reading:
    """A start that could have been meant or run by mistake: its spin in 1e-5 rad/s, and elements of its year, km."""

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
    hour_later = system.integrate(state, 1.0, output=[1.0])[-1]
    results = {
        "as stated": state,
        "Beta at the best orientation": rotated(state, Rotation.from_euler("ZYX", best[::-1], degrees=True)),
        f"Beta rotated about the orbit's normal by an hour of mean motion, {-hour:.2f} deg": _about_normal(
            state, -hour
        ),
        f"the same by its spin rate taken as an angle, {RATE} rad, {-rate:.2f} deg": _about_normal(state, -rate),
        f"Beta rotated by that angle about its own pole, psi = {rate:.2f} deg": _about_pole(state, rate),
        "all but Beta's attitude and spin an hour later": advanced(system, state, 1.0),
        "positions and velocities alone an hour later": advanced(system, state, 1.0, alpha=False),
        f"mean anomaly of an hour, {hour:.2f} deg": start(state, system.mu(), M=hour),
        "Beta's attitude alone an hour later": state.replace(attitude=[state.attitude[0], hour_later.attitude[1]]),
    }

    def measure(name: str) -> Reading:
        ranges = spin_range(system, results[name])
        year = system.integrate(results[name], paper.YEAR_HOURS, integrator=COARSE)
        orbit = year.elements()
        mean = np.trapezoid(orbit.a, year.time) / np.ptp(year.time)
        return Reading(name, ranges, float(misfit(ranges)), float(mean), float(orbit.e.max()))

    return in_threads(measure, results)
