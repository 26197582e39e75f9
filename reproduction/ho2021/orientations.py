"""All orientations of Beta at the start, searched for the printed ranges of its spin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from fullbody import systems
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from scipy.stats import qmc

from .kw4 import spin_range
from .spin import COARSE, FAMILIES, PRINTED, ROUNDING, Scan, misfit, shared
from .starts import normal, rotated

__all__ = ["Minimum", "Search", "search"]

_Array = npt.NDArray[np.float64]

_SYSTEM, _STATE = systems.kw4_ho2021()
_NORMAL = normal(_STATE)


@dataclass(frozen=True, slots=True)
class Minimum:
    """A local minimum of the misfit over the orientations of Beta."""

    #: The paper's phi, theta, psi, degrees.
    angles: tuple[float, float, float]
    #: Angle of the rotation from the stated orientation, above zero in the sense of the orbital motion, and of its axis
    #: from the orbit's normal, degrees.
    turn: float
    off_normal: float
    #: Ranges of Beta's spin (3, 2), and their largest difference from the printed numbers, 1e-5 rad/s.
    ranges: _Array
    misfit: float


@dataclass(frozen=True, slots=True)
class Search:
    """The orientations whose spin comes nearest to the printed ranges."""

    #: How many, spread evenly over all there are, were tried before the best were refined.
    tried: int
    #: The best first.
    minima: list[Minimum]
    #: About the best one: the least and the largest turn that gives all six numbers as printed, and the farthest that
    #: the axis of such a turn lies from the orbit's normal, degrees; NaN where the best one does not give all six.
    turn: tuple[float, float]
    off_normal: float


def search(scans: list[Scan], tried: int, refined: int) -> Search:
    """Try orientations spread evenly, and refine the best of them and of the scans that turn Beta.

    Its spin goes along its own z-axis, as stated.
    """
    # Shoemake's uniform quaternions from evenly spread points.
    a, b, c = 2 * np.pi * qmc.Sobol(3, rng=1).random(tried).T
    low, high = np.sqrt(1 - a / (2 * np.pi)), np.sqrt(a / (2 * np.pi))
    quaternions = np.stack([low * np.sin(b), low * np.cos(b), high * np.sin(c), high * np.cos(c)], axis=1)
    everywhere = [Rotation.from_quat(q) for q in quaternions]
    misfits = shared(lambda attitude: misfit(_ranges(attitude, 0.1)), everywhere)
    guesses = [everywhere[k] for k in np.argsort(misfits)[:refined]]
    for scan in scans:
        if scan.name.startswith("Beta rotated"):
            best = FAMILIES[scan.name][3](_SYSTEM, _STATE, scan.best[0])
            guesses.append(Rotation.from_quat(best.attitude[1], scalar_first=True))
    minima = sorted(shared(_nearest, guesses), key=lambda minimum: minimum.misfit)
    if minima[0].misfit > ROUNDING:
        return Search(tried, minima, (float("nan"), float("nan")), float("nan"))
    about = Rotation.from_euler("ZYX", minima[0].angles[::-1], degrees=True)
    ends: list[Callable[[Rotation], float]] = [
        lambda attitude: _turn(attitude)[0],
        lambda attitude: -_turn(attitude)[0],
        lambda attitude: _turn(attitude)[1],
    ]
    most, least, off = shared(lambda of: _farthest(of, about), ends)
    return Search(tried, minima, (-least, most), off)


def _ranges(attitude: Rotation, spacing: float) -> _Array:
    return spin_range(_SYSTEM, rotated(_STATE, attitude), COARSE, spacing)


def _turn(attitude: Rotation) -> tuple[float, float]:
    """Return the angle from the stated orientation in the sense of the motion, its axis from the normal, degrees."""
    turn = attitude.as_rotvec(degrees=True)
    size, along = float(np.linalg.norm(turn)), float(turn @ _NORMAL)
    return float(np.copysign(size, along)), float(np.rad2deg(np.arccos(np.clip(abs(along) / size, 0.0, 1.0))))


def _nearest(guess: Rotation) -> Minimum:
    """Return the smallest of the largest differences from the printed numbers near a guess."""

    def margins(x: _Array) -> _Array:
        misses = (_ranges(Rotation.from_rotvec(x[:3]) * guess, 0.05) - PRINTED).ravel()
        return np.concatenate([x[3] - misses, x[3] + misses])

    # The fourth variable bounds all six differences, and is made small.
    first = [0.0, 0.0, 0.0, float(misfit(_ranges(guess, 0.05)))]
    attitude = Rotation.from_rotvec(_least(lambda x: float(x[3]), first, margins, 0.05)[:3]) * guess
    psi, theta, phi = (float(x) for x in attitude.as_euler("ZYX", degrees=True))
    ranges = _ranges(attitude, 0.02)
    return Minimum((phi, theta, psi), *_turn(attitude), ranges, float(misfit(ranges)))


def _farthest(of: Callable[[Rotation], float], about: Rotation) -> float:
    """Return the largest value of a function among the orientations about one that give all six printed numbers."""

    def margins(x: _Array) -> _Array:
        misses = _ranges(Rotation.from_rotvec(x) * about, 0.02) - PRINTED
        return np.asarray((ROUNDING - np.abs(misses)).ravel() / ROUNDING)

    return of(
        Rotation.from_rotvec(_least(lambda x: -of(Rotation.from_rotvec(x) * about), [0.0] * 3, margins, 3e-3)) * about
    )


def _least(
    target: Callable[[_Array], float], first: list[float], margins: Callable[[_Array], _Array], step: float
) -> _Array:
    """Minimise where no margin is negative; extremes of a spin change place, so derivatives do not help."""
    options = {"rhobeg": step, "tol": 1e-5, "maxiter": 200}
    constraints = {"type": "ineq", "fun": margins}
    return np.asarray(minimize(target, first, method="COBYLA", constraints=constraints, options=options).x)
