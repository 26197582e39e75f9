"""The paper's angles as the integrated attitude: equal to the quaternions, and an error at their pole."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import ChartSingularity
from support import angle_between


@pytest.mark.parametrize("shape", ["ellipsoid", "spheroid"])
def test_angles_and_quaternions_agree_over_100_hours(shape):
    runs = []
    for chart in ("quaternion", "tait_bryan"):
        system, state = fullbody.systems.kw4_ho2021(shape, attitude_chart=chart)
        runs.append(system.integrate(state, 100.0, output=10.0))
    quaternion, angles = runs
    assert np.abs(angles.position - quaternion.position).max() < 2e-12
    assert np.abs(angles.velocity - quaternion.velocity).max() < 2e-12
    assert np.abs(angles.spin - quaternion.spin).max() < 2e-12
    for one, other in zip(quaternion, angles, strict=True):
        assert angle_between(one.rotation_matrix, other.rotation_matrix).max() < 2e-12
    assert np.abs(angles.energy_drift).max() < 1e-13
    # Another set of equations: identical results would mean that the option does nothing.
    assert (angles.position != quaternion.position).any()


def test_the_pole_of_the_angles_is_an_error_with_body_and_time():
    """Theta is rate * t, which reaches the pole at t = pi / 2 / rate."""
    rate = 0.25
    body = fullbody.Body(fullbody.Ellipsoid(3.0, 2.0, 1.0), mass=1.0, name="Kleopatra")
    state = fullbody.State(position=[[0, 0, 0]], velocity=[[0, 0, 0]], spin=[[0, rate, 0]])
    system = fullbody.System([body], G=1.0, attitude_chart="tait_bryan")
    with pytest.raises(ChartSingularity, match="Kleopatra") as caught:
        system.integrate(state, 100.0)
    error = caught.value
    assert isinstance(error, fullbody.FullbodyError)
    assert isinstance(error, RuntimeError)
    assert error.body == "Kleopatra"
    assert error.time == pytest.approx(np.pi / 2 / rate, rel=0.01)
    assert f"{error.time:.3f}"[:4] in str(error)
    # The run until there is kept, and right.
    assert error.run.time[0] == 0.0
    assert error.run.time[-1] <= error.time
    assert error.run[-1].tait_bryan[0, 1] == pytest.approx(rate * error.run.time[-1], abs=1e-11)
    # Quaternions pass.
    free = system.with_options(attitude_chart="quaternion").integrate(state, 100.0, output=[100.0])
    assert free.spin[0, 0] == pytest.approx([0, rate, 0], abs=1e-14)


def test_pole_in_a_system_names_the_right_body():
    ball = fullbody.Sphere(1.0)
    bodies = [fullbody.Body(ball, mass=1.0, name="still"), fullbody.Body(ball, mass=1.0, name="turning")]
    system = fullbody.System(bodies, G=1e-6, attitude_chart="tait_bryan")
    state = fullbody.State(
        position=[[0, 0, 0], [50, 0, 0]], velocity=np.zeros((2, 3)), spin=[[0.1, 0, 0], [0, -1.0, 0]], time=3.0
    )
    with pytest.raises(ChartSingularity) as caught:
        system.integrate(state, 100.0)
    assert caught.value.body == "turning"
    assert caught.value.time == pytest.approx(3.0 + np.pi / 2, abs=0.05)


def test_start_at_the_pole_is_an_error():
    body = fullbody.Body(fullbody.Ellipsoid(3.0, 2.0, 1.0), mass=1.0, name="Kleopatra")
    state = fullbody.State.from_tait_bryan([[0, 0, 0]], [[0, 0, 0]], [[0, np.pi / 2, 0]], spin=[[0, 0, 1.0]], time=7.0)
    system = fullbody.System([body], G=1.0, attitude_chart="tait_bryan")
    with pytest.raises(ChartSingularity, match="Kleopatra") as caught:
        system.integrate(state, 8.0)
    assert caught.value.time == pytest.approx(7.0)


def test_near_the_pole_but_not_at_it_is_fine():
    body = fullbody.Body(fullbody.Ellipsoid(3.0, 2.0, 1.0), mass=1.0)
    theta = np.deg2rad(85.0)
    state = fullbody.State.from_tait_bryan([[0, 0, 0]], [[0, 0, 0]], [[0, theta, 0]], spin=[[1.0, 0, 0]])
    ends = [
        fullbody.System([body], G=1.0, attitude_chart=chart).integrate(state, 20.0, output=[20.0])[0]
        for chart in ("quaternion", "tait_bryan")
    ]
    assert angle_between(ends[0].rotation_matrix, ends[1].rotation_matrix).max() < 1e-12
