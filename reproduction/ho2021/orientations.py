"""The search for initial orientations of Beta that give the printed ranges of its spin."""

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
from .spin import COARSE, FAMILIES, PRINTED, ROUNDING, Scan, in_threads, misfit
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
    #: The angle of the rotation from the stated orientation, positive in the sense of the orbital motion, and the angle
    #: of its axis from the orbit's normal, degrees.
    rotation: float
    axis_tilt: float
    #: Ranges of Beta's spin (3, 2), and their largest difference from the printed numbers, 1e-5 rad/s.
    ranges: _Array
    misfit: float


@dataclass(frozen=True, slots=True)
class Search:
    """The orientations whose spin comes nearest to the printed ranges."""

    #: The number of evenly spread orientations that were tried.
    count: int
    #: The refined minima, the best one first.
    minima: list[Minimum]
    #: The smallest and the largest rotation about the best minimum with which all six numbers are as printed, and the
    #: largest angle of the axis of such a rotation from the orbit's normal, degrees; NaN if the best one does not give
    #: all six.
    rotation_range: tuple[float, float]
    largest_tilt: float


def search(scans: list[Scan], count: int, refined: int) -> Search:
    """Try ``count`` evenly spread orientations, and refine the best of them and of the scans that rotate Beta.

    The spin of Beta is along its z-axis, as stated.
    """
    # Uniform quaternions from evenly spread points (Shoemake 1992).
    a, b, c = 2 * np.pi * qmc.Sobol(3, rng=1).random(count).T
    low, high = np.sqrt(1 - a / (2 * np.pi)), np.sqrt(a / (2 * np.pi))
    quaternions = np.stack([low * np.sin(b), low * np.cos(b), high * np.sin(c), high * np.cos(c)], axis=1)
    orientations = [Rotation.from_quat(q) for q in quaternions]
    misfits = in_threads(lambda attitude: misfit(_ranges(attitude, 0.1)), orientations)
    guesses = [orientations[k] for k in np.argsort(misfits)[:refined]]
    for scan in scans:
        if scan.name.startswith("Beta rotated"):
            best = FAMILIES[scan.name][3](_SYSTEM, _STATE, scan.best[0])
            guesses.append(Rotation.from_quat(best.attitude[1], scalar_first=True))
    minima = sorted(in_threads(_local_minimum, guesses), key=lambda minimum: minimum.misfit)
    if minima[0].misfit > ROUNDING:
        return Search(count, minima, (float("nan"), float("nan")), float("nan"))
    best_orientation = Rotation.from_euler("ZYX", minima[0].angles[::-1], degrees=True)
    functions: list[Callable[[Rotation], float]] = [
        lambda attitude: _rotation(attitude)[0],
        lambda attitude: -_rotation(attitude)[0],
        lambda attitude: _rotation(attitude)[1],
    ]
    largest, smallest, tilt = in_threads(lambda function: _largest(function, best_orientation), functions)
    return Search(count, minima, (-smallest, largest), tilt)


def _ranges(attitude: Rotation, spacing: float) -> _Array:
    return spin_range(_SYSTEM, rotated(_STATE, attitude), COARSE, spacing)


def _rotation(attitude: Rotation) -> tuple[float, float]:
    """Return the angle of the rotation from the stated orientation, and that of its axis from the normal, degrees."""
    vector = attitude.as_rotvec(degrees=True)
    angle, component = float(np.linalg.norm(vector)), float(vector @ _NORMAL)
    return float(np.copysign(angle, component)), float(np.rad2deg(np.arccos(np.clip(abs(component) / angle, 0.0, 1.0))))


def _local_minimum(guess: Rotation) -> Minimum:
    """Return the minimum of the largest difference from the printed numbers near a guess."""

    def margins(x: _Array) -> _Array:
        differences = (_ranges(Rotation.from_rotvec(x[:3]) * guess, 0.05) - PRINTED).ravel()
        return np.concatenate([x[3] - differences, x[3] + differences])

    # The fourth variable bounds all six differences, and is made small.
    first = [0.0, 0.0, 0.0, float(misfit(_ranges(guess, 0.05)))]
    attitude = Rotation.from_rotvec(_minimized(lambda x: float(x[3]), first, margins, 0.05)[:3]) * guess
    psi, theta, phi = (float(x) for x in attitude.as_euler("ZYX", degrees=True))
    ranges = _ranges(attitude, 0.02)
    return Minimum((phi, theta, psi), *_rotation(attitude), ranges, float(misfit(ranges)))


def _largest(function: Callable[[Rotation], float], centre: Rotation) -> float:
    """Return the largest value of a function near an orientation, where all six printed numbers are reproduced."""

    def margins(x: _Array) -> _Array:
        differences = _ranges(Rotation.from_rotvec(x) * centre, 0.02) - PRINTED
        return np.asarray((ROUNDING - np.abs(differences)).ravel() / ROUNDING)

    best = _minimized(lambda x: -function(Rotation.from_rotvec(x) * centre), [0.0] * 3, margins, 3e-3)
    return function(Rotation.from_rotvec(best) * centre)


def _minimized(
    target: Callable[[_Array], float], first: list[float], margins: Callable[[_Array], _Array], step: float
) -> _Array:
    """Return the minimum where no margin is negative; ranges of a spin have no derivatives where their ends change."""
    options = {"rhobeg": step, "tol": 1e-5, "maxiter": 200}
    constraints = {"type": "ineq", "fun": margins}
    return np.asarray(minimize(target, first, method="COBYLA", constraints=constraints, options=options).x)
