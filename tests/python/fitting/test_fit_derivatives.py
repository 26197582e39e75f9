"""The derivatives of residuals, by the chain rule, against differences of complete runs."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import observing
from fullbody.fitting.free import Parameters
from fullbody.fitting.problem import Problem
from support import body_list
from support.fits import QUICK, VIEW, dimorphos, kw4, noisy, view
from support.flows import central_of_state


def differences(problem, values, k, step):
    """Derivatives of fourth order of all rows, by complete runs."""
    return central_of_state(lambda by: problem.point(values + by * np.eye(len(values))[k]).rows, step)


def compared(setup, start, observations, steps):
    """The largest deviation of each parameter's derivatives from differences, over the largest derivative."""
    problem = Problem(setup, Parameters(start), observations, fullbody.Verner98())
    values = problem.parameters.start
    slopes = problem.jacobian(problem.point(values))
    assert not slopes.differenced
    found = {}
    for k, name in enumerate(start):
        expected = differences(problem, values, k, steps[name])
        assert np.abs(expected).max() > 0.1 / steps[name] * 1e-6
        found[name] = float(np.abs(slopes.rows[:, k] - expected).max() / np.abs(expected).max())
    return found


def test_jacobian_of_radar_is_that_of_complete_runs():
    start = {"mass": 2.353, "ratio": 0.0574, "a": 2.55, "c": 0.6735, "tilt": 0.06, "libration": 0.05}
    # Before and after the epoch of the state.
    times = np.linspace(-30.0, 35.0, 14) * u.h
    # At 0.05 au ranges are rounded to 1 um, which differences of runs would have a part in.
    geometry = view(40.0, share=0.01)
    zero = np.zeros(14)
    both = {"range": zero * u.km, "range_rate": zero * u.cm / u.s, "sigma": (75 * u.m, 1 * u.cm / u.s)}
    data = [
        observing.RadarAstrometry(times, **both, body="Beta", about="Alpha", geometry=geometry),
        observing.RadarAstrometry(times[:4], range=zero[:4] * u.km, sigma=75 * u.m, body="Alpha", geometry=geometry),
    ]
    steps = {"mass": 3e-4, "ratio": 3e-4, "a": 2e-4, "c": 1e-3, "tilt": 1e-2, "libration": 2e-2}
    assert max(compared(kw4, start, data, steps).values()) < 1e-6


def test_jacobian_of_light_curves_is_that_of_complete_runs():
    start = {"b": 0.87, "c": 0.66, "longitude": 310.0, "latitude": -80.0, "period": 11.92, "phase": 0.4}
    # Away from contacts, where light is not smooth.
    system, state = dimorphos(**start)
    geometry = view(30.0, sun=True)
    run = system.integrate(state, 26.0, dense=True)
    times = np.linspace(2.0, 24.0, 40) * u.h
    found = observing.mutual_events(run, geometry)
    contacts = [time for event in found for time in (event.begin, event.end, event.total_begin, event.total_end)]
    near = [any(abs(time - contact) < 0.1 * u.h for contact in contacts if contact is not None) for time in times]
    times = times[~np.array(near)]
    data = observing.Photometry(times, np.zeros(len(times)), 0.01, geometry=geometry)
    steps = {"b": 1e-4, "c": 1e-4, "longitude": 1e-2, "latitude": 1e-2, "period": 1e-4, "phase": 1e-4}
    assert len(times) > 20
    assert max(compared(dimorphos, start, [data], steps).values()) < 1e-6


def test_jacobian_of_astrometry_and_measured_values_is_that_of_complete_runs():
    start = {"mass": 2.353, "a": 2.55, "c": 0.6735, "tilt": 0.3, "libration": 0.1}
    times = np.linspace(5.0, 35.0, 10) * u.h
    zero = np.zeros(10) * u.mas
    options = {"body": "Beta", "about": "Alpha", "geometry": view(40.0, sun=True)}
    data = [
        observing.Astrometry(times, zero, zero, 0.1 * u.mas, 0.3, photocentre=True, **options),
        observing.Measured("mean distance", lambda run: run.elements().a.mean(), 2.5 * u.km, 1 * u.m, times),
    ]
    steps = {"mass": 3e-4, "a": 2e-4, "c": 1e-3, "tilt": 1e-2, "libration": 1e-2}
    assert max(compared(kw4, start, data, steps).values()) < 1e-6


def test_a_start_that_moves_in_time_is_differentiated():
    def setup(late):
        system, state = kw4()
        return system, state.replace(time=late)

    times = np.linspace(5.0, 35.0, 10) * u.h
    data = noisy(np.random.default_rng(0), *kw4(), times, 40.0)
    assert compared(setup, {"late": 0.1}, [data], {"late": 3e-3})["late"] < 1e-6


def test_what_runs_cannot_be_differentiated_by_is_differenced_and_named():

    def setup(radius, c):
        system, state = kw4(c=c)
        tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=0.1, lag=0.1 * u.h, radius=radius * u.km)
        return system.with_force(tide), state

    data = noisy(np.random.default_rng(0), *kw4(), np.linspace(5.0, 35.0, 10) * u.h, 40.0)
    problem = Problem(setup, Parameters({"radius": 0.8, "c": 0.67}), [data], None)
    slopes = problem.jacobian(problem.point(problem.parameters.start))
    assert list(slopes.differenced) == ["radius"]
    assert "radius" in slopes.differenced["radius"]
    expected = differences(problem, problem.parameters.start, 0, 3e-2)
    np.testing.assert_allclose(slopes.rows[:, 0], expected, atol=1e-4 * np.abs(expected).max())


def test_a_setup_that_changes_a_method_of_gravity_is_differenced():
    def setup(c, tolerance):
        system, state = kw4(c=c)
        return system.with_options(gravity_tolerance=tolerance), state

    data = noisy(np.random.default_rng(0), *kw4(), np.linspace(5.0, 35.0, 10) * u.h, 40.0)
    problem = Problem(setup, Parameters({"c": 0.67, "tolerance": 1e-12}), [data], QUICK)
    slopes = problem.jacobian(problem.point(problem.parameters.start))
    assert slopes.differenced == {
        "tolerance": "it changes settings gravity_tolerance, by which motions are not differentiated"
    }


def test_forces_of_functions_that_take_a_parameter_are_not_overlooked():
    def setup(push):
        system, state = kw4()
        force = fullbody.forces.Function(lambda time, state: np.array([[0.0] * 3, [push * 1e9, 0.0, 0.0]]), name="push")
        return system.with_force(force), state

    data = noisy(np.random.default_rng(0), *kw4(), np.linspace(1.0, 5.0, 6) * u.h, 40.0)
    problem = Problem(setup, Parameters({"push": 1.0}), [data], fullbody.Verner65(rtol=1e-9, atol=1e-9))
    slopes = problem.jacobian(problem.point(problem.parameters.start))
    assert "function of the force push" in slopes.differenced["push"]
    assert np.abs(slopes.rows).max() > 1e-3


def test_observations_of_a_users_class_need_two_methods():
    class Distances:
        def emission(self, system):
            return [10.0, 20.0, 30.0] * u.h

        def pulls(self, run):
            apart = (run.position[:, 1] - run.position[:, 0]).to_value("km")
            return (2.5 - np.linalg.norm(apart, axis=1)) / 0.001

    steps = {"mass": 3e-4, "a": 2e-4}
    assert max(compared(kw4, {"mass": 2.353, "a": 2.55}, Distances(), steps).values()) < 1e-6


@pytest.mark.parametrize("name", ["mass", "c"])
def test_composites_are_differentiated_by_their_parts(name):
    def setup(mass=1.0, c=0.3):
        parts = [fullbody.Part(fullbody.Sphere(0.2), mass=m, position=[x, 0, 0]) for m, x in ((mass, 0.2), (1.0, -c))]
        bodies = body_list(A=(fullbody.Composite(parts), None), B=(fullbody.PointMass(), 0.1))
        velocity, spin = [[0.0] * 3, [0.0, 1.0, 0.1]], [[0, 0, 0.3], [0] * 3]
        return fullbody.System(bodies, G=1.0), fullbody.State([[0.0] * 3, [2.0, 0, 0]], velocity, spin=spin)

    options = {"sigma": 0.01, "body": 1, "about": 0, "geometry": VIEW}
    data = observing.RadarAstrometry(np.linspace(1.0, 8.0, 6), range=np.zeros(6), **options)
    assert compared(setup, {name: {"mass": 1.0, "c": 0.3}[name]}, data, {name: 1e-3})[name] < 1e-6


def test_the_parameters_of_a_system_change_as_a_setup_changes_it():
    def setup(a, share):
        egg = fullbody.Body(fullbody.Ellipsoid(a, 0.8, 0.6), density=2.0, name="egg")
        both = ((share, 0.3), (3.0 - share, -0.3))
        parts = [fullbody.Part(fullbody.Sphere(0.2), mass=mass, position=[x, 0.0, 0.0]) for mass, x in both]
        system = fullbody.System([egg, fullbody.Body(fullbody.Composite(parts), name="pair")], G=1.0)
        return system, fullbody.State([[0.0] * 3, [9.0, 0.0, 0.0]], [[0.0] * 3] * 2)

    data = observing.RadarAstrometry([1.0], range=[0.0], sigma=0.01, body=1, about=0, geometry=VIEW)
    problem = Problem(setup, Parameters({"a": 1.0, "share": 1.0}), [data], None)
    values = problem.parameters.start
    found = problem._chain.at(problem.make(values), values)
    expected = {
        "semi-axis a of egg": [1.0, 0.0],
        "mass of egg": [2.0 * 4.0 / 3.0 * np.pi * 0.8 * 0.6, 0.0],
        "mass of part 0 of pair": [0.0, 1.0],
        "mass of part 1 of pair": [0.0, -1.0],
    }
    assert not found.undifferentiable
    assert found.system.keys() == expected.keys()
    for name, row in expected.items():
        np.testing.assert_allclose(found.system[name], row, rtol=1e-10, atol=0.0)
