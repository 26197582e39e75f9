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
    "INCREASED",
    "NOTICEABLE",
    "CaseNumbers",
    "angles",
    "case",
    "deviation_from_coplanar",
    "fine",
    "forces",
    "growth",
    "measure",
]

_Array = npt.NDArray[np.float64]

#: Shares of the total energy above which a rotational energy could be called noticeable.
NOTICEABLE = (0.01, 0.05, 0.1)
#: Shares of the largest spin above which a spin could be said to have increased.
INCREASED = (0.1, 0.25, 0.5)
#: Spacing of :func:`fine`: a hundredth of case 2's fastest oscillation.
_FINE = 0.01


@dataclass(frozen=True, slots=True)
class CaseNumbers:
    """Measurements of both bodies in a dimensionless case until t = 200, with G = 1."""

    #: Largest distances from the plane and in it.
    z_max: float
    xy_max: float
    #: Largest components of the force on A.
    z_force: float
    xy_force: float
    #: The ranges of phi, theta and psi in revolutions, the smaller one of both bodies.
    revolutions: tuple[float, ...]
    #: Largest of phi and theta.
    tilt: float
    #: Largest deviation of psi of A from a straight line.
    psi_deviation: float
    #: Largest change of the spin about z, and largest spin about x or y.
    spin_z_change: float
    transverse: float
    #: Share of the largest tenth of the spins about x and y that fall nearer to a closest approach than a quarter of
    #: the time between two of them.
    transverse_close: float
    #: When the rotational energy has grown by the shares ``NOTICEABLE`` of the total energy; NaN where it never does.
    noticeable: tuple[float, ...]
    #: When a spin about x or y first exceeds the shares ``INCREASED`` of its largest value.
    increased: tuple[float, ...]
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
    """Return the same motion with samples so close to each other that none of its peaks is missed."""
    return _fine_run(run.system, run[0])


def _fine_run(system: Any, state: Any) -> Run:
    run: Run = system.integrate(state, paper.CASES_END, output=_FINE)
    return run


def angles(run: Run) -> _Array:
    """Return the Tait-Bryan angles phi, theta, psi (K, N, 3) without jumps."""
    result = Rotation.from_quat(run.attitude.reshape(-1, 4), scalar_first=True).as_euler("ZYX")[:, ::-1]
    return np.asarray(np.unwrap(result.reshape(run.spin.shape), axis=0))


def forces(run: Run) -> _Array:
    """Return the force on A along a run (K, 3)."""
    return np.array([run.system.interactions(state).force[0] for state in run])


def measure(run: Run, fine_run: Run, seconds: float = 0.0) -> CaseNumbers:
    """Return the paper's quantities: errors and CPU time from the steps of a run, the others from its fine samples."""
    euler = angles(fine_run)
    force = np.abs(forces(fine_run))
    offsets = np.abs(fine_run.position)
    psi = euler[:, 0, 2]
    line = np.polynomial.Polynomial.fit(fine_run.time, psi, 1)
    rotational = fine_run.rotational_energy
    grown = (rotational - rotational[0]) / abs(fine_run.energy[0])
    momentum = run.angular_momentum
    transverse = np.abs(fine_run.spin[..., :2]).max(axis=(1, 2))
    return CaseNumbers(
        z_max=float(offsets[..., 2].max()),
        xy_max=float(offsets[..., :2].max()),
        z_force=float(force[:, 2].max()),
        xy_force=float(force[:, :2].max()),
        revolutions=tuple(float(x) for x in np.ptp(euler, axis=0).min(axis=0) / (2 * np.pi)),
        tilt=float(np.abs(euler[..., :2]).max()),
        psi_deviation=float(np.abs(psi - line(fine_run.time)).max()),
        spin_z_change=float(np.abs(fine_run.spin[..., 2] - fine_run.spin[0, :, 2]).max()),
        transverse=float(transverse.max()),
        transverse_close=_share_near_approaches(fine_run),
        noticeable=tuple(_first(fine_run.time, grown > share) for share in NOTICEABLE),
        increased=tuple(_first(fine_run.time, transverse > share * transverse.max()) for share in INCREASED),
        rotational_range=(float(rotational.min()), float(rotational.max())),
        translational_max=float(fine_run.translational_energy.max()),
        energy_step=float(np.abs(np.diff(run.energy) / run.energy[:-1]).max()),
        momentum_step=float(np.abs(np.diff(momentum, axis=0)).max()),
        cpu_seconds=seconds,
    )


def _first(times: _Array, true: npt.NDArray[np.bool_]) -> float:
    """Return the first time at which a condition is true; NaN if it never is."""
    return float(times[np.argmax(true)]) if true.any() else float("nan")


def _share_near_approaches(run: Run) -> float:
    """Return the share of the largest tenth of A's transverse spins that lie near a closest approach."""
    distance = np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1)
    spin = np.hypot(*run.spin[:, 0, :2].T)
    approaches = np.flatnonzero((distance[1:-1] < distance[:-2]) & (distance[1:-1] < distance[2:])) + 1
    if len(approaches) < 2:
        return float("nan")
    period = float(np.mean(np.diff(run.time[approaches])))
    largest = run.time[np.argsort(spin)[-len(run) // 10 :]]
    return float(np.mean(np.abs(largest[:, None] - run.time[approaches]).min(axis=1) < period / 4))


def growth(theta_0: float) -> float:
    """Return the largest transverse spin of case 2 with this initial tilt, over that with a tilt of pi/32."""
    reference, spin = (np.abs(_fine_run(*systems.case2(theta)).spin[..., :2]).max() for theta in (np.pi / 32, theta_0))
    return float(spin / reference)


def deviation_from_coplanar() -> float:
    """Return the largest distance of A in case 2 from its untilted motion, relative to that from the origin."""
    runs = [systems.case2(theta) for theta in (np.pi / 32, 0.0)]
    paths = [system.integrate(state, paper.CASES_END, output=0.5).position[:, 0] for system, state in runs]
    return float(np.linalg.norm(paths[0] - paths[1], axis=1).max() / np.linalg.norm(paths[1], axis=1).max())
