"""The paper's dimensionless cases 1 and 2 in numbers, and the motion along z that should not be there."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from fullbody import systems
from fullbody.run import Run

from . import paper

__all__ = [
    "CaseNumbers",
    "Motion",
    "angles",
    "case",
    "fine",
    "from_coplanar",
    "growth",
    "late_separation",
    "measure",
    "z_motion",
]

_Array = npt.NDArray[np.float64]

#: Rotational energy counts as noticeable from this share of the total on.
NOTICEABLE = 0.05
#: A spin counts as risen from these shares of its largest on, the middle one deciding.
RISEN = (0.1, 0.25, 0.5)
#: Spacing of :func:`fine`: a hundredth of case 2's fastest oscillation.
_FINE = 0.01
#: The size of the paper's motion along z: eleven orders below the orbit's.
NOISE = 1e-11


@dataclass(frozen=True, slots=True)
class CaseNumbers:
    """What a dimensionless case gives until t = 200; G = 1.

    Attributes
    ----------
    z_max, xy_max : float
        Largest distances from the plane and in it.
    z_force, xy_force : float
        Largest components of the force on A.
    turns : tuple
        Range of phi, theta, psi in turns, the smaller of the two bodies'.
    tilt, theta : float
        Largest of phi and theta, and of theta alone, of both bodies.
    psi_bend : float
        Largest departure of psi of A from a straight line.
    spin_z_change : float
        Largest change of the spin about z, both bodies.
    transverse : float
        Largest spin about x or y.
    transverse_close : float
        Share of the largest tenth of the spins about x and y that fall nearer to a closest approach than a quarter of
        the time between two of them.
    rotational_from : float
        When the rotational energy passes ``NOTICEABLE`` of the total energy.
    rise : tuple
        When a spin first passes the shares ``RISEN`` of its later largest.
    rotational_range : tuple
        Smallest and largest rotational energy.
    translational_max : float
    energy_step, momentum_step : float
        Errors from step to step as the paper takes them: relative, absolute.
    energy_drift, momentum_drift : float
        From the start; relative, and relative to the length.
    evaluations : int
    cpu_seconds : float
    """

    z_max: float
    xy_max: float
    z_force: float
    xy_force: float
    turns: tuple[float, ...]
    tilt: float
    theta: float
    psi_bend: float
    spin_z_change: float
    transverse: float
    transverse_close: float
    rotational_from: float
    rise: tuple[float, ...]
    rotational_range: tuple[float, float]
    translational_max: float
    energy_step: float
    momentum_step: float
    energy_drift: float
    momentum_drift: float
    evaluations: int
    cpu_seconds: float


@dataclass(frozen=True, slots=True)
class Motion:
    """|z| of body A along a run, the largest in windows of time, by kind of arithmetic."""

    time: _Array
    z: _Array


def case(number: int, theta_0: float | None = None, **options: Any) -> tuple[Run, float]:
    """Case 1 or 2 until t = 200 by the paper's surface integrals, and its CPU time in seconds."""
    build = {1: systems.case1, 2: systems.case2}[number]
    system, state = build(**({} if theta_0 is None else {"theta_0": theta_0}), **{"gravity": "surface", **options})
    started = time.process_time()
    run = system.integrate(state, paper.CASES_END)
    return run, time.process_time() - started


def fine(run: Run) -> Run:
    """The same motion sampled so closely that no peak falls between samples."""
    return _finely(run.system, run[0])


def _finely(system: Any, state: Any) -> Run:
    run: Run = system.integrate(state, paper.CASES_END, output=_FINE)
    return run


def angles(run: Run) -> _Array:
    """Tait-Bryan angles (K, N, 3) without jumps."""
    return np.asarray(np.unwrap(np.array([state.tait_bryan for state in run]), axis=0))


def forces(run: Run) -> _Array:
    """Force on A along a run (K, 3)."""
    return np.array([run.system.interactions(state).force[0] for state in run])


def measure(run: Run, drawn: Run, seconds: float = 0.0) -> CaseNumbers:
    """The quantities of which the paper speaks: errors and cost of a run's steps, the rest of its :func:`fine` twin."""
    turned = angles(drawn)
    force = np.abs(forces(drawn))
    place = np.abs(drawn.position)
    psi = turned[:, 0, 2]
    line = np.polynomial.Polynomial.fit(drawn.time, psi, 1)
    rotational = drawn.rotational_energy
    noticeable = rotational - rotational[0] > NOTICEABLE * abs(drawn.energy[0])
    momentum = run.angular_momentum
    transverse = np.abs(drawn.spin[..., :2]).max(axis=(1, 2))
    return CaseNumbers(
        z_max=float(place[..., 2].max()),
        xy_max=float(place[..., :2].max()),
        z_force=float(force[:, 2].max()),
        xy_force=float(force[:, :2].max()),
        turns=tuple(float(x) for x in np.ptp(turned, axis=0).min(axis=0) / (2 * np.pi)),
        tilt=float(np.abs(turned[..., :2]).max()),
        theta=float(np.abs(turned[..., 1]).max()),
        psi_bend=float(np.abs(psi - line(drawn.time)).max()),
        spin_z_change=float(np.abs(drawn.spin[..., 2] - drawn.spin[0, :, 2]).max()),
        transverse=float(transverse.max()),
        transverse_close=_near_approaches(drawn),
        rotational_from=float(drawn.time[np.argmax(noticeable)]) if noticeable.any() else float("nan"),
        rise=tuple(float(drawn.time[np.argmax(transverse > share * transverse.max())]) for share in RISEN),
        rotational_range=(float(rotational.min()), float(rotational.max())),
        translational_max=float(drawn.translational_energy.max()),
        energy_step=float(np.abs(np.diff(run.energy) / run.energy[:-1]).max()),
        momentum_step=float(np.abs(np.diff(momentum, axis=0)).max()),
        energy_drift=float(np.abs(run.energy_drift).max()),
        momentum_drift=float(run.angular_momentum_drift.max()),
        evaluations=run.statistics.evaluations,
        cpu_seconds=seconds,
    )


def _near_approaches(run: Run) -> float:
    """Share of the largest tenth of A's transverse spins that lie near a closest approach."""
    distance = np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1)
    spin = np.hypot(*run.spin[:, 0, :2].T)
    inner = np.flatnonzero((distance[1:-1] < distance[:-2]) & (distance[1:-1] < distance[2:])) + 1
    if len(inner) < 2:
        return float("nan")
    period = float(np.mean(np.diff(run.time[inner])))
    largest = run.time[np.argsort(spin)[-len(run) // 10 :]]
    return float(np.mean(np.abs(largest[:, None] - run.time[inner]).min(axis=1) < period / 4))


def growth(theta_0: float) -> float:
    """Growth of case 2's transverse spin when it starts with this tilt in place of pi/32."""
    small, large = (np.abs(_finely(*systems.case2(theta)).spin[..., :2]).max() for theta in (np.pi / 32, theta_0))
    return float(large / small)


def from_coplanar() -> float:
    """Largest distance of case 2's A from its place when nothing is tilted, relative to that from the origin."""
    runs = [systems.case2(theta) for theta in (np.pi / 32, 0.0)]
    places = [system.integrate(state, paper.CASES_END, output=0.5).position[:, 0] for system, state in runs]
    return float(np.linalg.norm(places[0] - places[1], axis=1).max() / np.linalg.norm(places[1], axis=1).max())


def late_separation(run: Run) -> tuple[tuple[float, float], tuple[float, float]]:
    """Range of case 1's separation until t = 200 and in the last 200 of a run to t = 2200."""
    distance = np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1)
    first, last = distance[run.time <= paper.CASES_END], distance[run.time >= run.time[-1] - paper.CASES_END]
    return (float(first.min()), float(first.max())), (float(last.min()), float(last.max()))


def z_motion(until: float = paper.CASES_LATE) -> tuple[dict[str, Motion], Run]:
    """Case 1's motion along z by kind of arithmetic, and the run by the default integrator.

    ``"double"`` is SciPy's DOP853 in plain double precision; ``"symmetric"`` the same with the rates made exactly
    symmetric under the half turn about z that swaps the bodies, so that z stays zero by construction;
    ``"compensated"`` the default integrator here, whose sums carry their round-off along; ``"seeded"`` that integrator
    with A and B moved apart along z by the size of the motion that the paper shows.
    """
    system, state = systems.case1()
    curves = {}
    for name, seed in (("compensated", 0.0), ("seeded", NOISE)):
        start = state.replace(position=np.add(state.position, [[0, 0, seed], [0, 0, -seed]]))
        run = system.integrate(start, until, output=1.0)
        curves[name] = _windows(run.time, run.position[:, 0, 2])
        if seed == 0.0:
            unseeded = run
    for name in ("double", "symmetric"):
        curves[name] = _windows(*_dop853(system, state, until, name == "symmetric"))
    return curves, unseeded


def _windows(times: _Array, z: _Array, width: float = 25.0) -> Motion:
    starts = np.unique(np.searchsorted(times, np.arange(times[0], times[-1], width)))
    return Motion(times[starts] + 0.5 * width, np.maximum.reduceat(np.abs(z), starts))


def _dop853(system: Any, state: Any, until: float, symmetric: bool) -> tuple[_Array, _Array]:
    """Times and z of A by an independent integrator; its rates are written out here in plain doubles."""
    from fullbody.state import State
    from scipy.integrate import solve_ivp

    mass = np.array([body.mass for body in system.bodies])[:, None]
    inertia = np.array([body.inertia for body in system.bodies])
    half_turn = np.array([-1.0, -1.0, 1.0])

    def rates(_: float, y: _Array) -> _Array:
        r, v, q, spin = y[:6].reshape(2, 3), y[6:12].reshape(2, 3), y[12:20].reshape(2, 4), y[20:].reshape(2, 3)
        if symmetric:
            # B is A turned by half a turn about z: (w, x, y, z) of the product with that turn; its own spin is A's.
            r, v = np.array([r[0], half_turn * r[0]]), np.array([v[0], half_turn * v[0]])
            w, i, j, k = q[0]
            q, spin = np.array([q[0], (-k, -j, i, w)]), np.array([spin[0], spin[0]])
        q = q / np.linalg.norm(q, axis=1)[:, None]
        acting = system.interactions(State(position=r, velocity=v, attitude=q, spin=spin))
        turning = (np.asarray(acting.torque) - np.cross(spin, inertia * spin)) / inertia
        acceleration = np.asarray(acting.force) / mass
        if symmetric:
            # The mean of A's own and B's turned back: exactly opposite along z, so zero.
            pull = 0.5 * (acceleration[0] + half_turn * acceleration[1])
            acceleration = np.array([pull, half_turn * pull])
        w, i, j, k = q.T
        a, b, c = spin.T
        turned = 0.5 * np.stack(
            [-i * a - j * b - k * c, w * a + j * c - k * b, w * b + k * a - i * c, w * c + i * b - j * a], axis=1
        )
        return np.concatenate([v.ravel(), acceleration.ravel(), turned.ravel(), turning.ravel()])

    start = np.concatenate(
        [np.asarray(x).ravel() for x in (state.position, state.velocity, state.attitude, state.spin)]
    )
    solved = solve_ivp(rates, (0.0, until), start, method="DOP853", rtol=1e-12, atol=1e-13)
    return solved.t, solved.y[2]
