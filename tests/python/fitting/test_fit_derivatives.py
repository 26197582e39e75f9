"""The Jacobian of residuals, by the chain rule, agrees with finite differences of complete runs."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import observing
from fullbody.errors import InconsistentInput
from fullbody.fitting import Free
from fullbody.fitting.free import Parameters
from fullbody.fitting.problem import Problem
from support import body_list
from support.fits import QUICK, VIEW, central_differences, dimorphos, kw4, noisy, relative_errors, view


def test_jacobian_of_radar_agrees_with_differences_of_runs():
    start = {"mass": 2.353, "ratio": 0.0574, "a": 2.55, "c": 0.6735, "tilt": 0.06, "libration": 0.05}
    # The times lie before and after the epoch of the initial state.
    times = np.linspace(-30.0, 35.0, 14) * u.h
    # At 0.05 au ranges are rounded to 1 um. At 0.01 of that distance the rounding does not affect differences of runs.
    geometry = view(40.0, share=0.01)
    zero = np.zeros(14)
    values = {"range": zero * u.km, "range_rate": zero * u.cm / u.s, "sigma": (75 * u.m, 1 * u.cm / u.s)}
    data = [
        observing.RadarAstrometry(times, **values, body="Beta", about="Alpha", geometry=geometry),
        observing.RadarAstrometry(times[:4], range=zero[:4] * u.km, sigma=75 * u.m, body="Alpha", geometry=geometry),
    ]
    steps = {"mass": 3e-4, "ratio": 3e-4, "a": 2e-4, "c": 1e-3, "tilt": 1e-2, "libration": 2e-2}
    assert max(relative_errors(kw4, start, data, steps).values()) < 1e-6


def test_jacobian_of_light_curves_agrees_with_differences_of_runs():
    start = {"b": 0.87, "c": 0.66, "longitude": 310.0, "latitude": -80.0, "period": 11.92, "phase": 0.4}
    system, state = dimorphos(**start)
    geometry = view(30.0, sun=True)
    run = system.integrate(state, 26.0, dense=True)
    times = np.linspace(2.0, 24.0, 40) * u.h
    events = observing.mutual_events(run, geometry)
    contacts = [time for event in events for time in (event.begin, event.end, event.total_begin, event.total_end)]
    # Times near contacts are left out, since the brightness is not smooth there.
    near = [any(abs(time - contact) < 0.1 * u.h for contact in contacts if contact is not None) for time in times]
    times = times[~np.array(near)]
    data = observing.Photometry(times, np.zeros(len(times)), 0.01, geometry=geometry)
    steps = {"b": 1e-4, "c": 1e-4, "longitude": 1e-2, "latitude": 1e-2, "period": 1e-4, "phase": 1e-4}
    assert len(times) > 20
    assert max(relative_errors(dimorphos, start, [data], steps).values()) < 1e-6


def test_jacobian_of_astrometry_and_measured_values_agrees_with_differences_of_runs():
    start = {"mass": 2.353, "a": 2.55, "c": 0.6735, "tilt": 0.3, "libration": 0.1}
    times = np.linspace(5.0, 35.0, 10) * u.h
    zero = np.zeros(10) * u.mas
    options = {"body": "Beta", "about": "Alpha", "geometry": view(40.0, sun=True)}
    data = [
        observing.Astrometry(times, zero, zero, 0.1 * u.mas, 0.3, photocentre=True, **options),
        observing.Measured("mean distance", lambda run: run.elements().a.mean(), 2.5 * u.km, 1 * u.m, times),
    ]
    steps = {"mass": 3e-4, "a": 2e-4, "c": 1e-3, "tilt": 1e-2, "libration": 1e-2}
    assert max(relative_errors(kw4, start, data, steps).values()) < 1e-6


def test_the_time_of_the_initial_state_can_be_a_parameter():
    def setup(start_time):
        system, state = kw4()
        return system, state.replace(time=start_time)

    times = np.linspace(5.0, 35.0, 10) * u.h
    data = noisy(np.random.default_rng(0), *kw4(), times, 40.0)
    assert relative_errors(setup, {"start_time": 0.1}, [data], {"start_time": 3e-3})["start_time"] < 1e-6


def test_a_parameter_without_exact_derivatives_uses_differences_and_is_listed():

    def setup(radius, c):
        system, state = kw4(c=c)
        tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=0.1, lag=0.1 * u.h, radius=radius * u.km)
        return system.with_force(tide), state

    data = noisy(np.random.default_rng(0), *kw4(), np.linspace(5.0, 35.0, 10) * u.h, 40.0)
    problem = Problem(setup, Parameters({"radius": 0.8, "c": 0.67}), [data], None)
    jacobian = problem.jacobian(problem.point(problem.parameters.start))
    assert list(jacobian.differenced) == ["radius"]
    assert "radius" in jacobian.differenced["radius"]
    expected = central_differences(problem, problem.parameters.start, 0, 3e-2)
    np.testing.assert_allclose(jacobian.rows[:, 0], expected, atol=1e-4 * np.abs(expected).max())


def test_a_parameter_that_changes_a_setting_of_gravity_uses_differences():
    def setup(c, tolerance):
        system, state = kw4(c=c)
        return system.with_options(gravity_tolerance=tolerance), state

    data = noisy(np.random.default_rng(0), *kw4(), np.linspace(5.0, 35.0, 10) * u.h, 40.0)
    problem = Problem(setup, Parameters({"c": 0.67, "tolerance": 1e-12}), [data], QUICK)
    jacobian = problem.jacobian(problem.point(problem.parameters.start))
    assert jacobian.differenced == {
        "tolerance": "it changes settings gravity_tolerance, by which motions are not differentiated"
    }


def test_a_parameter_of_a_force_function_uses_differences():
    def setup(strength):
        system, state = kw4()
        force = fullbody.forces.Function(
            lambda time, state: np.array([[0.0] * 3, [strength * 1e9, 0.0, 0.0]]), name="push"
        )
        return system.with_force(force), state

    data = noisy(np.random.default_rng(0), *kw4(), np.linspace(1.0, 5.0, 6) * u.h, 40.0)
    problem = Problem(setup, Parameters({"strength": 1.0}), [data], fullbody.Verner65(rtol=1e-9, atol=1e-9))
    jacobian = problem.jacobian(problem.point(problem.parameters.start))
    assert "function of the force push" in jacobian.differenced["strength"]
    assert np.abs(jacobian.rows).max() > 1e-3


def test_observations_of_a_users_class_need_only_emission_and_pulls():
    class Distances:
        def emission(self, system):
            return [10.0, 20.0, 30.0] * u.h

        def pulls(self, run):
            separation = (run.position[:, 1] - run.position[:, 0]).to_value("km")
            return (2.5 - np.linalg.norm(separation, axis=1)) / 0.001

    steps = {"mass": 3e-4, "a": 2e-4}
    assert max(relative_errors(kw4, {"mass": 2.353, "a": 2.55}, Distances(), steps).values()) < 1e-6


@pytest.mark.parametrize("name", ["mass", "c"])
def test_derivatives_by_masses_and_positions_of_a_composites_parts_agree_with_differences(name):
    def setup(mass=1.0, c=0.3):
        parts = [fullbody.Part(fullbody.Sphere(0.2), mass=m, position=[x, 0, 0]) for m, x in ((mass, 0.2), (1.0, -c))]
        bodies = body_list(A=(fullbody.Composite(parts), None), B=(fullbody.PointMass(), 0.1))
        velocity, spin = [[0.0] * 3, [0.0, 1.0, 0.1]], [[0, 0, 0.3], [0] * 3]
        return fullbody.System(bodies, G=1.0), fullbody.State([[0.0] * 3, [2.0, 0, 0]], velocity, spin=spin)

    options = {"sigma": 0.01, "body": 1, "about": 0, "geometry": VIEW}
    data = observing.RadarAstrometry(np.linspace(1.0, 8.0, 6), range=np.zeros(6), **options)
    assert relative_errors(setup, {name: {"mass": 1.0, "c": 0.3}[name]}, data, {name: 1e-3})[name] < 1e-6


def test_derivatives_of_system_parameters_by_fitted_parameters_follow_from_the_setup():
    def setup(a, part_mass):
        egg = fullbody.Body(fullbody.Ellipsoid(a, 0.8, 0.6), density=2.0, name="egg")
        masses_and_positions = ((part_mass, 0.3), (3.0 - part_mass, -0.3))
        parts = [
            fullbody.Part(fullbody.Sphere(0.2), mass=mass, position=[x, 0.0, 0.0]) for mass, x in masses_and_positions
        ]
        system = fullbody.System([egg, fullbody.Body(fullbody.Composite(parts), name="pair")], G=1.0)
        return system, fullbody.State([[0.0] * 3, [9.0, 0.0, 0.0]], [[0.0] * 3] * 2)

    data = observing.RadarAstrometry([1.0], range=[0.0], sigma=0.01, body=1, about=0, geometry=VIEW)
    problem = Problem(setup, Parameters({"a": 1.0, "part_mass": 1.0}), [data], None)
    values = problem.parameters.start
    derivatives = problem._setup_differences.at(problem.make(values), values)
    expected = {
        "semi-axis a of egg": [1.0, 0.0],
        "mass of egg": [2.0 * 4.0 / 3.0 * np.pi * 0.8 * 0.6, 0.0],
        "mass of part 0 of pair": [0.0, 1.0],
        "mass of part 1 of pair": [0.0, -1.0],
    }
    assert not derivatives.undifferentiable
    assert derivatives.system.keys() == expected.keys()
    for name, row in expected.items():
        np.testing.assert_allclose(derivatives.system[name], row, rtol=1e-10, atol=0.0)


def test_observations_without_exact_derivatives_are_differenced_and_listed():
    class OnlyPulls:
        def emission(self, system):
            return [3.0]

        def pulls(self, run):
            return run.position[:, 1]

    def setup(distance):
        system = fullbody.System(body_list((fullbody.Sphere(1.0), 1.0), (fullbody.Sphere(0.5), 0.1)), G=1.0)
        return system, fullbody.State([[0.0] * 3, [distance, 0.0, 0.0]], [[0.0] * 3, [0.0, 0.5, 0.0]])

    far = observing.Geometry([0.0, 30.0], to_observer=[1e6, 0.0, 0.0], to_sun=[1e6, 4e5, 0.0], light_time=False)
    times = np.linspace(1.0, 20.0, 8)
    rough = observing.Photometry(times, np.zeros(8), 0.01, geometry=far, law=observing.Hapke(roughness="20 deg"))
    ranges = observing.RadarAstrometry(times, range=np.zeros(8), sigma=1e-3, body=1, about=0, geometry=far)
    observations = [rough, ranges, OnlyPulls()]
    problem = Problem(setup, Parameters({"distance": 4.0}), observations, None)
    jacobian = problem.jacobian(problem.point(np.array([4.0])))
    assert not jacobian.differenced
    assert list(jacobian.differenced_observations) == ["observations[0]", "observations[2]"]
    assert "roughness of the scattering law" in jacobian.differenced_observations["observations[0]"]
    assert "no derivatives of their own" in jacobian.differenced_observations["observations[2]"]
    expected = central_differences(problem, np.array([4.0]), 0, 1e-3)
    np.testing.assert_allclose(jacobian.rows[:, 0], expected, atol=1e-5 * np.abs(expected).max())
    with pytest.warns(InconsistentInput, match="stopped after 1 proposals"):
        fit = fullbody.fit(setup, {"distance": Free(4.0, prior=(4.1, 0.1))}, observations, proposals=1)
    assert fit.differenced_observations == jacobian.differenced_observations
    assert "observations[0] differenced" in repr(fit)
