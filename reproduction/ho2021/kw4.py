"""The year of 1999 KW4 in numbers: the quantities of section 4 of the paper, measured on a run of ``fullbody kw4``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from fullbody import Run
from fullbody.base.units import without_unit
from fullbody.commands import kw4
from fullbody.commands.kw4 import METHODS, SHAPES, Shape, run_year, spin_range

__all__ = [
    "METHODS",
    "SHAPES",
    "Numbers",
    "Shape",
    "between_maxima",
    "drift",
    "inclination_to_first",
    "measure",
    "momentum_of_samples",
    "run_year",
    "slow_maxima",
    "spin_range",
    "without_unit",
]

_Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Numbers:
    """Measures of a year of 1999 KW4; lengths in km, times in hours, spins in 1e-5 rad/s.

    ``inclination_period`` is the time between maxima of the inclination to the first orbit's plane, and
    ``inclination_return`` the time at which the inclination to the xy-plane is largest again. The ending ``_step``
    marks errors from step to step as in the paper, for the angular momentum by component from
    :func:`momentum_of_samples`; the ending ``_drift`` marks errors since the start.
    """

    e_max: float
    e_mean: float
    a_min: float
    a_max: float
    a_mean: float
    period: float
    inclination_period: float
    inclination_return: float
    spin_x: tuple[float, float]
    spin_y: tuple[float, float]
    spin_z: tuple[float, float]
    energy_step: float
    energy_drift: float
    energy_drift_orbital: float
    angular_momentum_step: float
    angular_momentum_drift: float
    steps: int
    evaluations: int
    cpu_seconds: float


def measure(run: Run, seconds: float = 0.0) -> Numbers:
    """Measure the quantities that the paper prints, on a run in km, hour, kg, with or without Quantities."""
    hours, energy = without_unit(run.time), without_unit(run.energy)
    momentum = momentum_of_samples(run)
    maxima = slow_maxima(hours, without_unit(run.elements().i))
    return Numbers(
        **kw4.measure(run, seconds),
        inclination_period=between_maxima(hours, inclination_to_first(run)),
        inclination_return=float(maxima[0]) if len(maxima) else float("nan"),
        energy_step=float(np.max(np.abs(np.diff(energy) / energy[:-1]))),
        angular_momentum_step=float(np.max(np.abs(np.diff(momentum, axis=0) / momentum[:-1]))),
    )


def momentum_of_samples(run: Run) -> _Array:
    """Return the angular momentum about the origin from the bodies' recorded positions, as plain numbers (K, 3).

    It is the sum of r x m v + R I w, as computed from a table of positions, velocities, attitudes and spins. The
    ``angular_momentum`` of a run treats the part of the barycentre separately.
    """
    from scipy.spatial.transform import Rotation

    position, velocity, spin = (without_unit(x) for x in (run.position, run.velocity, run.spin))
    total = np.zeros((len(run), 3))
    for k, body in enumerate(run.system.bodies):
        rotations = Rotation.from_quat(run.attitude[:, k], scalar_first=True)
        total += without_unit(body.mass) * np.cross(position[:, k], velocity[:, k])
        total += rotations.apply(without_unit(body.inertia) * spin[:, k])
    return total


def drift(momentum: _Array) -> _Array:
    """Return the length of the change of angular momenta (K, 3) since the start, relative to the length there (K,)."""
    return np.asarray(np.linalg.norm(momentum - momentum[0], axis=1) / np.linalg.norm(momentum[0]))


def inclination_to_first(run: Run) -> _Array:
    """Return the angle between the orbit's normal and that at the start, degrees (K,)."""
    r, v = without_unit(run.position), without_unit(run.velocity)
    normal = np.cross(r[:, 1] - r[:, 0], v[:, 1] - v[:, 0])
    sine = np.linalg.norm(np.cross(normal, normal[0]), axis=1)
    return np.asarray(np.rad2deg(np.arctan2(sine, normal @ normal[0])))


def slow_maxima(hours: _Array, values: _Array, smoothing: float = 200.0) -> _Array:
    """Return the times of the maxima of a slow oscillation, averaged over ``smoothing`` hours, which is many orbits."""
    regular = np.arange(hours[0], hours[-1], 1.0)
    width = int(smoothing)
    if len(regular) < 4 * width:
        return np.zeros(0)
    smooth = np.convolve(np.interp(regular, hours, values), np.ones(width) / width, mode="valid")
    middle = regular[: len(smooth)] + 0.5 * (width - 1)
    rising = np.diff(smooth) > 0
    high = smooth[1:-1] > 0.5 * (smooth.min() + smooth.max())
    maxima = middle[1:-1][rising[:-1] & ~rising[1:] & high]
    # The ripples of a maximum count as one, whose time is their middle.
    groups = np.split(maxima, np.flatnonzero(np.diff(maxima) > 5 * smoothing) + 1)
    return np.array([0.5 * (group[0] + group[-1]) for group in groups if len(group)])


def between_maxima(hours: _Array, values: _Array) -> float:
    """Return the time between the first two maxima of a slow oscillation; NaN if there are not two."""
    maxima = slow_maxima(hours, values)
    return float(maxima[1] - maxima[0]) if len(maxima) > 1 else float("nan")
