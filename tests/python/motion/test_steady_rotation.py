"""A body alone that rotates about a principal axis: runs of decades in one step, beside those in many steps."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from mpmath import mp, mpf

BODY = fullbody.Body(fullbody.Ellipsoid(45.0, 38.0, 33.0), mass=2.0, name="Alone")
INERTIA = 2.0 / 5.0 * np.array([38.0**2 + 33.0**2, 45.0**2 + 33.0**2, 45.0**2 + 38.0**2])
#: An event that never happens, with which a run is integrated in steps.
STEPWISE = {"events": [fullbody.events.Function(lambda *_: 1.0)]}


def state(spin, attitude=(0.5, -0.5, 0.5, 0.5)):
    moving = {"position": [[1.0, 2.0, 3.0]], "velocity": [[0.1, 0.2, -0.3]]}
    return fullbody.State(**moving, attitude=[attitude], spin=[spin])


def yorp(torque):
    return fullbody.forces.Yorp(on="Alone", along=torque, pole=[0.0, 0.0, 1.0])


def closed_and_stepwise(forces, spin, duration):
    system = fullbody.System([BODY], G=1.0, forces=forces)
    names = [name for name in system.parameters if not name.startswith("across")]
    options = {"duration": duration, "output": [0.3 * duration, duration], "derivatives": names}
    return (system.integrate(state(spin), **options, **extra) for extra in ({}, STEPWISE))


def test_fifty_years_take_one_step_and_keep_the_phase():
    hours, rate = 50 * 8766.0, 2.0 * np.pi / 8.40060
    run = fullbody.System([BODY], G=1.0).integrate(state([0.0, 0.0, rate], (1.0, 0.0, 0.0, 0.0)), hours, output="ends")
    with mp.workdps(40):
        phase = float(mp.fmod(mpf(rate) * mpf(hours), 2 * mp.pi))
    x, y = run[-1].rotation_matrix[0][:2, 0]
    assert run.statistics.steps == 1
    assert abs((np.arctan2(y, x) - phase + np.pi) % (2.0 * np.pi) - np.pi) < 1e-10


@pytest.mark.parametrize("axis", [0, 2])
@pytest.mark.parametrize("duration", [200.0, -200.0])
def test_motion_and_derivatives_are_those_of_many_steps(axis, duration):
    spin = 1e-13 * np.array([1.0, 2.0, -1.0])
    spin[axis] = -0.75
    closed, stepwise = closed_and_stepwise([], spin, duration)
    assert closed.statistics.steps == 1 < stepwise.statistics.steps
    for name in ("position", "velocity", "attitude", "spin", "energy", "angular_momentum"):
        expected = getattr(stepwise, name)
        scale = max(1.0, abs(expected).max())
        np.testing.assert_allclose(getattr(closed, name), expected, rtol=0.0, atol=1e-14 * scale)
    np.testing.assert_allclose(closed.transition, stepwise.transition, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_torque_along_the_spin_acts_as_in_many_steps(sign):
    torque = 1e-11 * INERTIA[2]
    closed, stepwise = closed_and_stepwise([yorp(sign * torque)], [0.0, 0.0, sign * 0.75], 200.0)
    assert closed.statistics.steps == 1 < stepwise.statistics.steps
    for name in ("attitude", "spin", "energy", "work", "angular_impulse"):
        result, expected = (run.arrays.get(name, getattr(run, name)) for run in (closed, stepwise))
        if isinstance(result, dict):
            result, expected = result["YORP on Alone"], expected["YORP on Alone"]
        np.testing.assert_allclose(result, expected, rtol=1e-12, atol=1e-14)
    for name, result in closed.sensitivity.items():
        np.testing.assert_allclose(result, stepwise.sensitivity[name], rtol=1e-10, atol=1e-14, err_msg=name)
    np.testing.assert_allclose(closed.transition, stepwise.transition, rtol=1e-9, atol=1e-9)


def test_the_angle_under_a_torque_is_quadratic_in_time():
    rate, change, time = 0.75, 2e-12, 3e5
    system = fullbody.System([BODY], G=1.0, forces=[yorp(change * INERTIA[2])])
    run = system.integrate(state([0.0, 0.0, rate], (1.0, 0.0, 0.0, 0.0)), time, output="ends")
    with mp.workdps(40):
        angle = float(mp.fmod(mpf(rate) * time + mpf(change) * mpf(time) ** 2 / 2, 2 * mp.pi))
    x, y = run[-1].rotation_matrix[0][:2, 0]
    assert abs((np.arctan2(y, x) - angle + np.pi) % (2.0 * np.pi) - np.pi) < 1e-9
    assert run.spin[-1, 0, 2] == pytest.approx(rate + change * time, rel=1e-14)


@pytest.mark.parametrize(
    ("spin", "options"),
    [
        ([0.0, 0.75, 0.0], {}),
        ([1e-6, 0.0, 0.75], {}),
        ([0.0, 0.0, 0.75], {"integrator": fullbody.SymplecticSplitting(step=1.0)}),
        ([0.0, 0.0, 0.75], {"chaos": True}),
    ],
    ids=["intermediate axis", "wobble", "fixed steps", "chaos"],
)
def test_runs_with_forces_or_events_are_integrated_in_steps(spin, options):
    run = fullbody.System([BODY], G=1.0).integrate(state(spin), 20.0, **options)
    assert run.statistics.steps > 10


def test_the_continuous_solution_is_exact_and_small():
    system = fullbody.System([BODY], G=1.0)
    run = system.integrate(state([0.0, 0.0, 0.75]), 1e6, dense=True)
    times = np.array([0.0, 12.5, 7e5, 1e6])
    angle = 0.75 * times
    result = run(times)
    expected = fullbody.base.rotations.products(
        np.array([0.5, -0.5, 0.5, 0.5]), np.stack([np.cos(angle / 2), 0 * angle, 0 * angle, np.sin(angle / 2)], axis=1)
    )
    np.testing.assert_allclose(result.attitude[:, 0], expected, atol=1e-9)
    moved = result.position[:, 0] - np.outer(times, [0.1, 0.2, -0.3])
    np.testing.assert_allclose(moved, np.tile([1.0, 2.0, 3.0], (4, 1)), atol=1e-9)
    assert run.dense.core.bytes < 1e4


def test_particles_fly_about_a_body_in_closed_form_as_in_steps():
    system = fullbody.System([BODY], G=1e4)
    start = state([0.0, 0.0, 0.75])
    particles = fullbody.Particles([[61.0, 7.0, 11.0]], [[1.1, 20.2, 1.7]])
    runs = [system.integrate(start, 50.0, dense=True, **extra) for extra in ({}, STEPWISE)]
    flights = [run.fly(particles, 50.0, output="ends") for run in runs]
    np.testing.assert_allclose(flights[0].position[-1], flights[1].position[-1], rtol=1e-9)


def test_a_state_rotates_about_a_pole():
    result = fullbody.State.rotating(BODY, 272 * u.deg, 52 * u.deg, 8.4 * u.h, 30 * u.deg)
    pole = result.rotation_matrix[0] @ result.spin[0]
    np.testing.assert_allclose(fullbody.frames.pole_angles(pole.value), np.radians([272.0, 52.0]), rtol=1e-14)
    assert np.linalg.norm(pole).to_value("rad / h") == pytest.approx(2 * np.pi / 8.4, rel=1e-14)
    np.testing.assert_allclose(result.attitude[0], fullbody.frames.attitude(272 * u.deg, 52 * u.deg, 30 * u.deg))


@pytest.mark.parametrize("axis", ["z", "principal"])
def test_a_state_rotates_about_an_axis(axis):
    corners = np.array([[3, 0, 0.5], [-3, 0, -0.5], [0, 2, 0], [0, -2, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    faces = [[a, b, c] for a in (0, 1) for b, c in ((2, 4), (4, 3), (3, 5), (5, 2))]
    faces = [face if k < 4 else face[::-1] for k, face in enumerate(faces)]
    body = fullbody.Body(fullbody.Polyhedron(corners, faces), mass=1.0)
    result = fullbody.State.rotating(body, 1.0, 0.5, 3.0, 0.2, axis=axis)
    spin, along = result.spin[0], fullbody.base.rotations.matrices(body.working_frame.attitude)[:, 2]
    direction = result.rotation_matrix[0] @ spin / np.linalg.norm(spin)
    np.testing.assert_allclose(direction, fullbody.frames.pole_vector(1.0, 0.5), atol=1e-14)
    assert np.count_nonzero(np.abs(spin) > 1e-14) == (1 if axis == "principal" else 2)
    assert (spin @ along) / np.linalg.norm(spin) == pytest.approx(1.0, abs=1e-14 if axis == "z" else 0.05)
