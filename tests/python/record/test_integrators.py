"""The family of integrators through Python: agreement, settings."""

import pickle

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody.errors import ChartSingularity, InvalidInput, PrecisionWarning
from fullbody.record import integrators
from support import angle_between, refused, worst

KW4 = fullbody.systems.kw4_ho2021("spheroid")
CASE1 = fullbody.systems.case1()

ADAPTIVE = {"DormandPrince54": 5, "Verner65": 6, "Verner76": 7, "Verner87": 8, "Verner98": 9}
SCHEMES = ("leapfrog", "ABA864", "ABA1064")


def family(step, rtol):
    """Every integrator there is, every scheme of the splitting."""
    made = [getattr(integrators, name)(rtol, rtol) for name in ADAPTIVE]
    made += [fullbody.LieGroupVariational(step)]
    made += [fullbody.SymplecticSplitting(step, scheme) for scheme in SCHEMES]
    assert {type(integrator).__name__ for integrator in made} == set(integrators.__all__)
    return made


def end(system, state, until, integrator):
    return system.integrate(state, until, output=[until], integrator=integrator)


# The error of a second-order method is of the order (step x rate)^2, times the phase run through; the others are better
# by far. Loose enough for each, tight enough to see a wrong stage.
@pytest.mark.parametrize(("system", "state", "step"), [(*KW4, 0.02), (*CASE1, 0.02)], ids=["kw4", "case1"])
@pytest.mark.parametrize("position", range(9))
def test_each_integrator_agrees_with_verner98(system, state, step, position):
    integrator = family(step, 1e-11)[position]
    expected = end(system, state, 30.0, fullbody.Verner98(1e-14, 1e-14))
    run = end(system, state, 30.0, integrator)
    second = isinstance(integrator, fullbody.LieGroupVariational) or getattr(integrator, "scheme", "") == "leapfrog"
    bound = 1e-3 if second else 1e-9
    assert worst(run.position, expected.position) < bound
    assert worst(run.velocity, expected.velocity) < bound
    # A free top of rate w turns by arcsin(w h) a step in the variational method: Alpha's 68 rad, times (w h)^2 / 6.
    angle = 0.5 * 68.2 * (2.273 * step) ** 2 / 6 if isinstance(integrator, fullbody.LieGroupVariational) else 0.0
    assert worst(run.attitude, expected.attitude, 1.0) < bound + angle
    assert worst(run.spin, expected.spin) < bound
    assert abs(run.energy_drift_orbital).max() < bound
    # Angular momentum is kept to round-off by the symplectic ones, exact in their steps.
    if not hasattr(integrator, "rtol"):
        assert run.angular_momentum_drift.max() < 1e-13


def test_steps_have_units():
    system, state = fullbody.systems.kw4_ho2021("spheroid", units=True)
    unitless, start = KW4
    for make in (fullbody.LieGroupVariational, fullbody.SymplecticSplitting):
        expected = unitless.integrate(start, 10.0, integrator=make(0.25))
        for step in (15 * u.min, 0.25 * u.h, 900 * u.s):
            run = system.integrate(state, 10 * u.h, integrator=make(step))
            assert run.statistics.steps == 40
            assert worst(run.position[-1].to_value(u.km), expected.position[-1]) < 1e-12
        with pytest.raises(InvalidInput, match=r"step has the unit km.*expected a unit such as s"):
            fullbody.Simulation(system, state, integrator=make(1 * u.km))
        with pytest.raises(InvalidInput, match=r"step has the unit h.*the system has no units"):
            fullbody.Simulation(unitless, start, integrator=make(1 * u.h))


@pytest.mark.parametrize("make", [fullbody.LieGroupVariational, fullbody.SymplecticSplitting])
def test_runs_of_more_steps_than_can_be_counted_are_refused(make):
    system, state = KW4
    with pytest.raises(InvalidInput, match=r"step is 1e-300; expected a longer one; until 1 takes 1.0e300"):
        system.integrate(state, 1.0, integrator=make(1e-300))


def test_bad_settings_are_refused():
    refused("the larger of rtol and atol is 0; expected a number above zero", lambda: fullbody.Verner65(0.0, 0.0))
    refused(r"scheme is 'yoshida'; expected 'ABA864', ", lambda: fullbody.SymplecticSplitting(0.1, "yoshida"))
    for integrator in (fullbody.Verner98, "Verner98", 1e-13):
        refused(r"integrator is .*; expected one of fullbody's", fullbody.Simulation, *CASE1, integrator=integrator)
    system, state = CASE1
    chart = system.with_options(attitude_chart="tait_bryan")
    for integrator in (fullbody.LieGroupVariational(0.1), fullbody.SymplecticSplitting(0.1)):
        with pytest.raises(InvalidInput, match=r"attitude_chart is the Tait-Bryan angles; expected .quaternion"):
            chart.integrate(state, 1.0, integrator=integrator)


@pytest.mark.parametrize("name", ADAPTIVE)
def test_tolerances_below_round_off_are_raised_with_a_warning(name):
    make = getattr(integrators, name)
    with pytest.warns(PrecisionWarning):
        floor = make(1e-17, 0.0).rtol
    # A few units in the last place of a double.
    assert 2.0**-53 < floor < 20 * 2.0**-53
    message = rf"rtol \+ atol is 1e-16, below .*; rtol is raised to {floor:g}"
    with pytest.warns(PrecisionWarning, match=message) as seen:
        raised = make(1e-16, 0.0)
    assert seen[0].filename == __file__
    assert raised.rtol == floor
    for atol in np.random.default_rng(7).uniform(0, floor, 50):
        with pytest.warns(PrecisionWarning):
            raised = make(0.0, float(atol))
        assert raised.rtol + raised.atol == pytest.approx(floor, rel=1e-15, abs=0.0)
        again = make(raised.rtol, raised.atol)
        assert again == raised
    run = end(*CASE1, 10.0, raised)
    assert abs(run.energy_drift).max() < 1e-14


def test_atol_alone_or_rtol_alone_is_enough():
    expected = end(*CASE1, 20.0, fullbody.Verner98(1e-14, 1e-14)).position
    for tolerances in ((1e-10, 0.0), (0.0, 1e-10)):
        assert worst(end(*CASE1, 20.0, fullbody.Verner98(*tolerances)).position, expected) < 1e-7


def test_integrators_are_rebuilt_from_their_text_and_pickles():
    for integrator in family(0.25, 1e-9):
        assert pickle.loads(pickle.dumps(integrator)) == integrator
        assert eval(repr(integrator), vars(integrators)) == integrator
        # A simulation's bytes hold a description of its integrator.
        assert pickle.loads(pickle.dumps(fullbody.Simulation(*CASE1, integrator=integrator))).integrator == integrator
        with pytest.raises((AttributeError, TypeError)):
            integrator.rtol = 1.0
    refused("integrator is 'Euler'; expected one of DormandPrince54, ", lambda: integrators.rebuild({"name": "Euler"}))


@pytest.mark.parametrize("offset", [4, 5, 8])
def test_angular_momentum_of_a_moving_barycentre_keeps_its_digits(offset):
    system, state = KW4
    share = np.array([body.mass for body in system.bodies]) / sum(body.mass for body in system.bodies)
    barycentric = state.replace(position=state.position - share @ state.position)
    moving = barycentric.replace(velocity=barycentric.velocity + np.array([1e5, -2e4, 3e4]))
    integrator = family(0.02, 1e-13)[offset]
    run = system.integrate(moving, 100.0, output=5.0, integrator=integrator)
    assert np.linalg.norm(run.position[-1, 0]) > 1e7
    expected = system.angular_momentum(barycentric)
    assert np.abs(run.angular_momentum - expected).max() < 1e-10 * np.linalg.norm(expected)
    assert run.angular_momentum_drift.max() < 1e-13


@pytest.mark.parametrize("shape", ["ellipsoid", "spheroid"])
def test_angles_and_quaternions_agree_over_100_hours(shape):
    runs = []
    for chart in ("quaternion", "tait_bryan"):
        system, state = fullbody.systems.kw4_ho2021(shape, attitude_chart=chart)
        runs.append(system.integrate(state, 100.0, output=10.0))
    quaternion, angles = runs
    for name in ("position", "velocity", "spin"):
        assert np.abs(getattr(angles, name) - getattr(quaternion, name)).max() < 2e-12
    for first, other in zip(quaternion, angles, strict=True):
        assert angle_between(first.rotation_matrix, other.rotation_matrix).max() < 2e-12
    assert np.abs(angles.energy_drift).max() < 1e-13
    # Another set of equations: identical results would mean that the option does nothing.
    assert (angles.position != quaternion.position).any()


def alone(chart):
    body = fullbody.Body(fullbody.Ellipsoid(3.0, 2.0, 1.0), mass=1.0, name="Kleopatra")
    return fullbody.System([body], G=1.0, attitude_chart=chart)


def test_the_pole_of_the_angles_is_an_error_with_body_and_time():
    # Theta is rate * t, which reaches the pole at t = pi / 2 / rate.
    rate = 0.25
    state = fullbody.State(position=[[0, 0, 0]], velocity=[[0, 0, 0]], spin=[[0, rate, 0]])
    system = alone("tait_bryan")
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


def test_an_error_at_the_pole_names_the_body():
    ball = fullbody.Sphere(1.0)
    bodies = [fullbody.Body(ball, mass=1.0, name="still"), fullbody.Body(ball, mass=1.0, name="turning")]
    system = fullbody.System(bodies, G=1e-6, attitude_chart="tait_bryan")
    state = fullbody.State([[0, 0, 0], [50, 0, 0]], np.zeros((2, 3)), spin=[[0.1, 0, 0], [0, -1.0, 0]], time=3.0)
    with pytest.raises(ChartSingularity) as caught:
        system.integrate(state, 100.0)
    assert caught.value.body == "turning"
    assert caught.value.time == pytest.approx(3.0 + np.pi / 2, abs=0.05)


def test_a_start_at_the_pole_is_an_error_and_one_near_it_is_not():
    state = fullbody.State.from_tait_bryan([[0, 0, 0]], [[0, 0, 0]], [[0, np.pi / 2, 0]], spin=[[0, 0, 1.0]], time=7.0)
    with pytest.raises(ChartSingularity, match="Kleopatra") as caught:
        alone("tait_bryan").integrate(state, 8.0)
    assert caught.value.time == pytest.approx(7.0)
    state = fullbody.State.from_tait_bryan([[0, 0, 0]], [[0, 0, 0]], [[0, np.deg2rad(85.0), 0]], spin=[[1.0, 0, 0]])
    ends = [alone(chart).integrate(state, 20.0, output=[20.0])[0] for chart in ("quaternion", "tait_bryan")]
    assert angle_between(ends[0].rotation_matrix, ends[1].rotation_matrix).max() < 1e-12
