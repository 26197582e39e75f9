"""The paper's dimensionless cases 1 and 2 in numbers."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from fullbody import Run, systems
from scipy.spatial.transform import Rotation

from . import paper

__all__ = [
    "NOTICEABLE",
    "RISEN",
    "CaseNumbers",
    "angles",
    "case",
    "fine",
    "forces",
    "from_coplanar",
    "growth",
    "measure",
]

_Array = npt.NDArray[np.float64]

#: Shares of the total energy from which on a rotational energy could be called noticeable.
NOTICEABLE = (0.01, 0.05, 0.1)
#: Shares of its largest from which on a spin could be said to have started to increase.
RISEN = (0.1, 0.25, 0.5)
#: Spacing of :func:`fine`: a hundredth of case 2's fastest oscillation.
_FINE = 0.01


@dataclass(frozen=True, slots=True)
class CaseNumbers:
    """What a dimensionless case gives until t = 200, of both bodies; G = 1."""

    #: Largest distances from the plane and in it.
    z_max: float
    xy_max: float
    #: Largest components of the force on A.
    z_force: float
    xy_force: float
    #: Range of phi, theta, psi in turns, the smaller of the two bodies'.
    turns: tuple[float, ...]
    #: Largest of phi and theta.
    tilt: float
    #: Largest deviation of psi of A from a straight line.
    psi_bend: float
    #: Largest change of the spin about z, and largest spin about x or y.
    spin_z_change: float
    transverse: float
    #: Share of the largest tenth of the spins about x and y that fall nearer to a closest approach than a quarter of
    #: the time between two of them.
    transverse_close: float
    #: When the rotational energy has grown by the shares ``NOTICEABLE`` of the total energy; NaN where it never does.
    noticeable: tuple[float, ...]
    #: When a spin about x or y first passes the shares ``RISEN`` of the largest there will be.
    risen: tuple[float, ...]
    #: Smallest and largest rotational energy, and largest translational energy.
    rotational_range: tuple[float, float]
    translational_max: float
    #: Errors from step to step as the paper takes them: relative, absolute.
    energy_step: float
    momentum_step: float
    cpu_seconds: float


def case(number: int, theta_0: float | None = None, **options: Any) -> tuple[Run, float]:
    """Run case 1 or 2 until t = 200 by the paper's surface integrals; return it and its CPU time in seconds."""
    build = {1: systems.case1, 2: systems.case2}[number]
    system, state = build(**({} if theta_0 is None else {"theta_0": theta_0}), **{"gravity": "surface", **options})
    started = time.process_time()
    run = system.integrate(state, paper.CASES_END)
    return run, time.process_time() - started


def fine(run: Run) -> Run:
    """Return the same motion sampled so closely that no peak falls between samples."""
    return _finely(run.system, run[0])


def _finely(system: Any, state: Any) -> Run:
    run: Run = system.integrate(state, paper.CASES_END, output=_FINE)
    return run


def angles(run: Run) -> _Array:
    """Return the Tait-Bryan angles phi, theta, psi (K, N, 3) without jumps."""
    result = Rotation.from_quat(run.attitude.reshape(-1, 4), scalar_first=True).as_euler("ZYX")[:, ::-1]
    return np.asarray(np.unwrap(result.reshape(run.spin.shape), axis=0))


def forces(run: Run) -> _Array:
    """Return the force on A along a run (K, 3)."""
    return np.array([run.system.interactions(state).force[0] for state in run])


def measure(run: Run, drawn: Run, seconds: float = 0.0) -> CaseNumbers:
    """Return the paper's quantities: errors and cost of a run's steps, the rest of its :func:`fine` twin."""
    euler = angles(drawn)
    force = np.abs(forces(drawn))
    offsets = np.abs(drawn.position)
    psi = euler[:, 0, 2]
    line = np.polynomial.Polynomial.fit(drawn.time, psi, 1)
    rotational = drawn.rotational_energy
    grown = (rotational - rotational[0]) / abs(drawn.energy[0])
    momentum = run.angular_momentum
    transverse = np.abs(drawn.spin[..., :2]).max(axis=(1, 2))
    return CaseNumbers(
        z_max=float(offsets[..., 2].max()),
        xy_max=float(offsets[..., :2].max()),
        z_force=float(force[:, 2].max()),
        xy_force=float(force[:, :2].max()),
        turns=tuple(float(x) for x in np.ptp(euler, axis=0).min(axis=0) / (2 * np.pi)),
        tilt=float(np.abs(euler[..., :2]).max()),
        psi_bend=float(np.abs(psi - line(drawn.time)).max()),
        spin_z_change=float(np.abs(drawn.spin[..., 2] - drawn.spin[0, :, 2]).max()),
        transverse=float(transverse.max()),
        transverse_close=_near_approaches(drawn),
        noticeable=tuple(_first(drawn.time, grown > share) for share in NOTICEABLE),
        risen=tuple(_first(drawn.time, transverse > share * transverse.max()) for share in RISEN),
        rotational_range=(float(rotational.min()), float(rotational.max())),
        translational_max=float(drawn.translational_energy.max()),
        energy_step=float(np.abs(np.diff(run.energy) / run.energy[:-1]).max()),
        momentum_step=float(np.abs(np.diff(momentum, axis=0)).max()),
        cpu_seconds=seconds,
    )


def _first(times: _Array, true: npt.NDArray[np.bool_]) -> float:
    """Return the first time of those at which something is true; NaN where it never is."""
    return float(times[np.argmax(true)]) if true.any() else float("nan")


def _near_approaches(run: Run) -> float:
    """Return the share of the largest tenth of A's transverse spins that lie near a closest approach."""
    distance = np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1)
    spin = np.hypot(*run.spin[:, 0, :2].T)
    inner = np.flatnonzero((distance[1:-1] < distance[:-2]) & (distance[1:-1] < distance[2:])) + 1
    if len(inner) < 2:
        return float("nan")
    period = float(np.mean(np.diff(run.time[inner])))
    largest = run.time[np.argsort(spin)[-len(run) // 10 :]]
    return float(np.mean(np.abs(largest[:, None] - run.time[inner]).min(axis=1) < period / 4))


def growth(theta_0: float) -> float:
    """Return the growth of case 2's transverse spin when it starts with this tilt in place of pi/32."""
    small, large = (np.abs(_finely(*systems.case2(theta)).spin[..., :2]).max() for theta in (np.pi / 32, theta_0))
    return float(large / small)


def from_coplanar() -> float:
    """Return the largest distance of case 2's A from where it is untilted, relative to that from the origin."""
    runs = [systems.case2(theta) for theta in (np.pi / 32, 0.0)]
    paths = [system.integrate(state, paper.CASES_END, output=0.5).position[:, 0] for system, state in runs]
    return float(np.linalg.norm(paths[0] - paths[1], axis=1).max() / np.linalg.norm(paths[1], axis=1).max())
