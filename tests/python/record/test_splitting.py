"""The symplectic splitting: free rotors in many digits, and the suggested step."""

import fullbody
import mpmath
import numpy as np
import pytest
from fullbody.errors import NotConverged
from support import points, refused

AXES = (1.0, 0.8, 0.45)


def free_top(moments, spin, time):
    """Spin and attitude of a top that starts with the frame of space: Euler's equations by Taylor series, 25 digits."""
    sign = 1 if time > 0 else -1
    with mpmath.workdps(25):
        i1, i2, i3 = (mpmath.mpf(float(moment)) for moment in moments)

        def rates(_, y):
            a, b, c, w, x, y, z = y
            euler = [(i2 - i3) / i1 * b * c, (i3 - i1) / i2 * c * a, (i1 - i2) / i3 * a * b]
            product = [-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a]
            return [sign * rate for rate in euler] + [sign * rate / 2 for rate in product]

        end = mpmath.odefun(rates, 0, [*map(mpmath.mpf, spin), 1, 0, 0, 0], tol=mpmath.mpf("1e-21"))(abs(time))
        return np.array([float(value) for value in end])


# Spins on either side of the separatrix and near it, and times that take one piece or several.
@pytest.mark.parametrize(
    ("spin", "time"),
    [
        *(((0.004, 0.002, 0.03), 0.5), ((0.02, -0.01, 0.3), 0.25), ((1.0, 0.3, 0.2), 0.1), ((0.1, 0.2, 0.9), 0.35)),
        *(((0.5, -1.0, 0.4), 3.0), ((0.2, 0.1, -1.0), -2.0), ((0.01, 1.0, 0.004), 0.5)),
    ],
)
def test_a_free_top_rotates_exactly_to_the_last_digit(spin, time):
    body = fullbody.Body(fullbody.Ellipsoid(*AXES), mass=1.0)
    state = fullbody.State(position=[[0, 0, 0]], velocity=[[0, 0, 0]], spin=[spin])
    # One step, whose two drifts are half of it.
    integrator = fullbody.SymplecticSplitting(step=abs(time), scheme="leapfrog")
    run = fullbody.System([body], G=1.0).integrate(state, time, output=[time], integrator=integrator)
    assert run.statistics.steps == 1
    expected = free_top(body.inertia, spin, time)
    assert np.abs(run.spin[0, 0] - expected[:3]).max() < 4e-16 * np.linalg.norm(spin)
    assert np.abs(run.attitude[0, 0] - expected[3:]).max() < 5e-16
    back = fullbody.System([body], G=1.0).integrate(run[0], 0.0, output=[0.0], integrator=integrator)
    assert np.abs(back.attitude[0, 0] - [1, 0, 0, 0]).max() < 5e-16
    assert np.abs(back.spin[0, 0] - spin).max() < 4e-16 * np.linalg.norm(spin)


def largest(system, state, step, until=3000.0):
    run = system.integrate(state, until, output=5.0, integrator=fullbody.SymplecticSplitting(step=step))
    return abs(run.energy_drift_orbital).max()


@pytest.mark.parametrize(("shape", "bound"), [("spheroid", 1e-9), ("ellipsoid", 2e-8)])
def test_an_advised_step_keeps_the_energy_three_times_as_long_as_its_trial(shape, bound):
    system, state = fullbody.systems.kw4_ho2021(shape)
    advised = fullbody.SymplecticSplitting.suggest(system, state, energy_error=bound)
    # And does not waste much: a step half as long again does not do.
    assert largest(system, state, advised.step) < 1.5 * bound < largest(system, state, 1.5 * advised.step)


def test_a_step_in_resonance_with_a_rotor_is_not_advised():
    # Alpha turns by a quarter past Beta in 0.5965 h, and its torque is the same again after two steps: it turns at
    # 2.2728 rad/h, against the mean motion of 0.3608.
    system, state = fullbody.systems.kw4_ho2021("ellipsoid")
    step = np.pi / 2 / (2.2728 + 0.3608)
    assert largest(system, state, 0.997 * step, 1000.0) > 10 * largest(system, state, 1.1 * step, 1000.0)
    for bound in (1e-7, 3e-7):
        advised = fullbody.SymplecticSplitting.suggest(system, state, energy_error=bound, trial=500.0)
        assert abs(advised.step / step - 1) > 0.02
        assert largest(system, state, advised.step, 1000.0) < 2 * bound


def test_advice_has_units_and_another_scheme_and_ends_at_round_off():
    system, state = fullbody.systems.kw4_ho2021("spheroid", units=True)
    advised = fullbody.SymplecticSplitting.suggest(system, state, energy_error=1e-8, scheme="ABA1064", trial="20 day")
    assert advised.scheme == "ABA1064"
    assert advised.step.unit == "hour"
    system, state = fullbody.systems.case1()
    with pytest.raises(NotConverged, match=r"no step keeps .* below 1e-18 .* the least is"):
        fullbody.SymplecticSplitting.suggest(system, state, energy_error=1e-18, trial=5.0)


def test_impossible_advice_on_steps_is_refused():
    system, state = fullbody.systems.kw4()
    for bound in (0.0, 1.0, "small"):
        refused("energy_error", fullbody.SymplecticSplitting.suggest, system, state, energy_error=bound)
    alone = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)], G=1.0)
    refused("one body", lambda: fullbody.SymplecticSplitting.suggest(alone, fullbody.State([[0, 0, 0]], [[0, 0, 0]])))
    refused("scheme", lambda: fullbody.SymplecticSplitting.suggest(points(0.7, 0.3), state, scheme="ABA"))


@pytest.mark.filterwarnings("ignore:A and B start at .* times the speed of escape")
@pytest.mark.parametrize(
    ("velocity", "step"), [((0.0, 10.0, 0.0), 1.0), ((0.0, 1e3, 0.0), 0.01), ((0.0, -1e3, 0.0), 0.01)]
)
def test_a_fast_flyby_in_one_step_ends_as_by_verner98(velocity, step):
    # Kepler's equation overflows at the first guess.
    bodies = [fullbody.Body(fullbody.Sphere(1e-4), mass=m, name=n) for m, n in ((0.7, "A"), (0.3, "B"))]
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State([[0, 0, 0], [1, 0, 0]], [[0, 0, 0], velocity])
    run = system.integrate(state, step, integrator=fullbody.SymplecticSplitting(step, scheme="leapfrog"))
    expected = system.integrate(state, step, integrator=fullbody.Verner98(rtol=1e-13))
    travelled = np.linalg.norm(velocity) * step
    np.testing.assert_allclose(run.position[-1], expected.position[-1], rtol=0, atol=1e-12 * travelled)
    np.testing.assert_allclose(run.velocity[-1], expected.velocity[-1], rtol=0, atol=1e-12 * max(map(abs, velocity)))


@pytest.mark.filterwarnings("ignore:A and B start at .* times the speed of escape")
def test_a_step_over_hundreds_of_distances_is_exact_for_spheres():
    rng = np.random.default_rng(1)
    bodies = [fullbody.Body(fullbody.Sphere(1e-6), mass=m, name=n) for m, n in ((0.7, "A"), (0.3, "B"))]
    system = fullbody.System(bodies, G=1.0)
    for far in 10.0 ** rng.uniform(2.0, 3.0, 60):
        position, velocity = rng.normal(size=(2, 3))
        velocity *= far / np.linalg.norm(velocity)
        state = fullbody.State([[0, 0, 0], position / np.linalg.norm(position)], [[0, 0, 0], velocity])
        splitting = fullbody.SymplecticSplitting(1.0, scheme="leapfrog")
        ends = [system.integrate(state, 1.0, output="ends", integrator=i) for i in (splitting, fullbody.Verner98())]
        np.testing.assert_allclose(ends[0].position[-1], ends[1].position[-1], rtol=0, atol=1e-12 * far)


def test_a_body_at_the_barycentre_of_those_before_it_needs_another_order():
    positions, velocities = np.array([[[-1.0, 0, 0], [1.0, 0, 0], [0, 0, 0]], [[0, -1.0, 0], [0, 1.0, 0], [0, 0, 0]]])

    def start(order):
        bodies = [fullbody.Body(fullbody.Sphere(0.1), mass=1.0, name="ABC"[k]) for k in order]
        return fullbody.System(bodies, G=1.0), fullbody.State(positions[order], velocities[order])

    splitting = fullbody.SymplecticSplitting(step=1e-3)
    system, state = start([0, 1, 2])
    with pytest.raises(NotConverged, match=r"motion of C about the barycentre .*another order of the bodies"):
        system.integrate(state, 0.1, integrator=splitting)
    system, state = start([2, 0, 1])
    run, expected = (system.integrate(state, 0.1, integrator=i) for i in (splitting, fullbody.Verner98()))
    np.testing.assert_allclose(run.position[-1], expected.position[-1], rtol=0, atol=1e-11)
