"""The motion along z in case 1, which is zero by symmetry, for several kinds of arithmetic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from fullbody import Run, State, System, systems
from scipy.integrate import solve_ivp

from . import paper
from .drawing import windows

__all__ = ["NOISE", "WINDOW", "Motion", "separation_ranges", "z_motion"]

_Array = npt.NDArray[np.float64]

#: The size of the motion along z that the paper shows: eleven orders below the orbit's.
NOISE = 1e-11
#: The motion is given by its largest in windows of this length.
WINDOW = 25.0


@dataclass(frozen=True, slots=True)
class Motion:
    """The largest abs(z) of body A in windows of time, by their middles."""

    time: _Array
    z: _Array


def z_motion(until: float = paper.CASES_LONG_END) -> tuple[dict[str, Motion], Run]:
    """Return case 1's motion along z by kind of arithmetic, and the run by the default integrator.

    ``"double"`` is SciPy's DOP853 in plain double precision; ``"symmetric"`` the same with the rates made exactly
    symmetric under the rotation by 180 degrees about z that exchanges the bodies, so that z stays zero by construction;
    ``"compensated"`` the default integrator here, whose sums carry their round-off along; ``"seeded"`` that integrator
    with A and B moved apart along z by the size of the motion that the paper shows.
    """
    system, state = systems.case1()
    curves = {}
    for name, seed in (("compensated", 0.0), ("seeded", NOISE)):
        start = state.replace(position=np.add(state.position, [[0, 0, seed], [0, 0, -seed]]))
        run = system.integrate(start, until, output=1.0)
        curves[name] = _motion(run.time, run.position[:, 0, 2])
        if seed == 0.0:
            unseeded = run
    for name in ("double", "symmetric"):
        curves[name] = _motion(*dop853(system, state, until, name == "symmetric"))
    return curves, unseeded


def _motion(times: _Array, z: _Array) -> Motion:
    middle, _, high = windows(times, np.abs(z), WINDOW)
    return Motion(middle, high)


def dop853(system: System, state: State, until: float, symmetric: bool) -> tuple[_Array, _Array]:
    """Return times and z of A by an independent integrator; its rates are written out here in plain doubles."""
    mass = np.array([body.mass for body in system.bodies])[:, None]
    inertia = np.array([body.inertia for body in system.bodies])
    half_rotation = np.array([-1.0, -1.0, 1.0])

    def rates(_: float, y: _Array) -> _Array:
        r, v, q, spin = y[:6].reshape(2, 3), y[6:12].reshape(2, 3), y[12:20].reshape(2, 4), y[20:].reshape(2, 3)
        if symmetric:
            # B is A rotated by 180 degrees about z: its quaternion is the product with that rotation, its spin is A's.
            r, v = np.array([r[0], half_rotation * r[0]]), np.array([v[0], half_rotation * v[0]])
            w, i, j, k = q[0]
            q, spin = np.array([q[0], (-k, -j, i, w)]), np.array([spin[0], spin[0]])
        q = q / np.linalg.norm(q, axis=1)[:, None]
        interactions = system.interactions(State(position=r, velocity=v, attitude=q, spin=spin))
        spin_rates = (np.asarray(interactions.torque) - np.cross(spin, inertia * spin)) / inertia
        acceleration = np.asarray(interactions.force) / mass
        if symmetric:
            # The mean of A's acceleration and that of B rotated back; along z they are opposite, so that it is zero.
            mean = 0.5 * (acceleration[0] + half_rotation * acceleration[1])
            acceleration = np.array([mean, half_rotation * mean])
        w, i, j, k = q.T
        a, b, c = spin.T
        quaternion_rates = 0.5 * np.stack(
            [-i * a - j * b - k * c, w * a + j * c - k * b, w * b + k * a - i * c, w * c + i * b - j * a], axis=1
        )
        return np.concatenate([v.ravel(), acceleration.ravel(), quaternion_rates.ravel(), spin_rates.ravel()])

    start = np.concatenate(
        [np.asarray(x).ravel() for x in (state.position, state.velocity, state.attitude, state.spin)]
    )
    solved = solve_ivp(rates, (0.0, until), start, method="DOP853", rtol=1e-12, atol=1e-13)
    return solved.t, solved.y[2]


def separation_ranges(run: Run) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the range of case 1's separation until t = 200 and in the last 200 of a run to t = 2200."""
    distance = np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1)
    first, last = distance[run.time <= paper.CASES_END], distance[run.time >= run.time[-1] - paper.CASES_END]
    return (float(first.min()), float(first.max())), (float(last.min()), float(last.max()))
