"""Brouwer's law: with round-off errors alone the energy walks at random and does not drift."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import PrecisionWarning
from support import inertia, refused

#: Half the spacing of doubles at one.
UNIT = 2.0**-53
TO_ROUNDOFF = fullbody.Verner98.to_roundoff()


def left_by_rounding(system, state, integrator, span):
    """Root mean square that rounding leaves in the energy of a step; and the steps in a unit of time.

    The increments of all quantities are off by UNIT / sqrt(3) of their size, and the energy by that times its
    derivative. Forces and torques are taken as exact, so that this is the least there can be.
    """
    run = system.integrate(state, span, integrator=integrator)
    masses = np.array([body.mass for body in system.bodies])
    moments = np.array([inertia(body.mass, body.shape.semi_axes or (0, 0, 0)) for body in system.bodies])
    sizes = np.diff(run.time)
    squares = []
    for k in np.linspace(0, len(sizes) - 1, 200).astype(int):
        state = run[k]
        acting = system.interactions(state)
        velocity = state.velocity - masses @ state.velocity / masses.sum()
        momentum = moments * state.spin
        turning = acting.torque - np.cross(state.spin, momentum)
        angle = np.linalg.norm(acting.torque, axis=1) * np.linalg.norm(state.spin, axis=1)
        parts = (velocity * acting.force, velocity * acting.force, state.spin * turning, angle)
        squares.append(sizes[k] ** 2 * sum((part**2).sum() for part in parts))
    return UNIT / np.sqrt(3) * np.sqrt(np.mean(squares)), run.statistics.steps / span


def orbital(system, state):
    energy = system.energy(state)
    return abs(energy.translational + energy.potential)


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


def walks(integrator, steps):
    """Errors of the energy after so many steps of the paper's case 1, over that of the orbit, and what rounding leaves.

    It is run from random moments on: two flat spheroids close to each other.
    """
    errors, left = [], []
    system, first = fullbody.systems.case1()
    for moment in np.random.default_rng(21).uniform(0.0, 200.0, 3):
        state = system.integrate(first, moment, output=[moment])[0].replace(time=0.0)
        error, rate = left_by_rounding(system, state, integrator, 20.0)
        span = steps / rate
        times = span * (np.linspace(0.5, 1.0, 16, endpoint=False) + 1 / 32)
        errors.append(system.integrate(state, span, output=times, integrator=integrator).energy_drift_orbital)
        left.append(error * np.sqrt(0.75 * steps) / orbital(system, state))
    return rms(errors), rms(left)


def test_energy_of_rotating_bodies_walks_at_random():
    errors, left = walks(TO_ROUNDOFF, 3e4)
    assert 0.3 < errors / left < 20.0
    drifting, least = walks(fullbody.Verner98(), 3e4)
    assert drifting > 100.0 * least
    assert drifting > 30.0 * errors


@pytest.mark.parametrize("shape", ["ellipsoid", "spheroid"])
def test_energy_of_1999_kw4_walks_at_random(shape):
    # The energy of Alpha's spin hides what is below 1e-14 of the orbit's.
    system, state = fullbody.systems.kw4_ho2021(shape)
    run = system.integrate(state, 2500.0, output=np.linspace(1250.0, 2500.0, 64), integrator=TO_ROUNDOFF)
    assert run.statistics.steps > 5e4
    seen = 2 * UNIT * system.energy(state).total / orbital(system, state)
    assert abs(run.energy_drift_orbital).max() < 3 * seen


def test_exact_steps_are_named_and_compared():
    tightest = fullbody.Verner98.to_roundoff()
    assert tightest == fullbody.Verner98(0.0, 0.0) == fullbody.Verner98(rtol=0, atol=0)
    assert tightest != fullbody.Verner98()
    assert repr(tightest) == "Verner98.to_roundoff()"
    assert eval(repr(tightest), vars(fullbody)) == tightest
    with pytest.warns(PrecisionWarning, match=r"raised to .*; Verner98\.to_roundoff\(\) takes shorter steps"):
        fullbody.Verner98(1e-17, 0.0)
    for kind in (fullbody.Verner87, fullbody.DormandPrince54):
        assert not hasattr(kind, "to_roundoff")
        refused("the larger of rtol and atol is 0; expected a number above zero", lambda kind=kind: kind(0.0, 0.0))
