"""Fits of free-form shapes: exact derivatives by vertices and areas, prior knowledge, and closed loops."""

import functools

import fullbody
import numpy as np
import pytest
from fullbody import ConvexShape, HarmonicShape, fitting, observing
from fullbody.base import rotations
from fullbody.fitting import Free
from fullbody.fitting.free import Parameters
from fullbody.fitting.problem import Problem
from support import refused
from support.fits import relative_errors

DEGREES = np.floor(np.sqrt(np.arange(25) + 0.5))
#: A non-convex shape of degree 4 that is flattened along z.
SERIES = np.where(DEGREES > 1, np.random.default_rng(1).normal(size=25) * 0.1 / (1 + DEGREES), 0.0)
SERIES[[6, 8]] = -0.1, 0.1
ANGLES = np.linspace(0.0, 2 * np.pi, 61)
VIEW = observing.Geometry(
    np.linspace(0.0, 600.0, 61),
    to_observer=1e6 * np.stack([np.cos(ANGLES), np.sin(ANGLES), 0.6 * np.sin(2 * ANGLES)], axis=1),
    to_sun=1e6 * np.stack([np.cos(ANGLES + 0.4), np.sin(ANGLES + 0.4), 0.3 * np.cos(ANGLES)], axis=1),
    light_time=False,
)


def light(count=40, hours=40.0):
    times = np.sort(np.random.default_rng(2).uniform(0.0, hours, count))
    return observing.Photometry(times, np.zeros(count), 0.01, geometry=VIEW)


def convex(coefficients, period=6.0):
    body = fullbody.Body(ConvexShape([0.0, *coefficients], faces=492), mass=1.0, name="A")
    system = fullbody.System([body], G=1.0)
    return system, fullbody.State([[0.0] * 3], [[0.0] * 3], spin=[[0.0, 0.0, 2 * np.pi / period]])


def in_working_frame(body):
    """Position, attitude and axis of the spin, along z of the working frame, whose origin is at rest at zero."""
    frame = body.working_frame
    attitude = rotations.inverse(frame.attitude)
    return -rotations.matrices(attitude) @ frame.position, attitude, rotations.matrices(frame.attitude)[:, 2]


def alone(coefficients, period=6.0, faces=320):
    body = fullbody.Body(HarmonicShape([0.0, *coefficients], reference_radius=80.0, faces=faces), mass=7e18, name="A")
    position, attitude, axis = in_working_frame(body)
    spin = 2 * np.pi / period * axis
    return fullbody.System([body], G=1.0), fullbody.State([position], [[0.0] * 3], spin=[spin], attitude=[attitude])


def pair(coefficients, distance=600.0, mass=7.0, radius=0.0):
    body = fullbody.Body(
        HarmonicShape([0.0, *coefficients], reference_radius=80.0, faces=320), mass=mass * 1e18, name="A"
    )
    moon = fullbody.Body(HarmonicShape([radius], reference_radius=20.0, faces=80), mass=1e16, name="B")
    system = fullbody.System([body, moon], G=6.6743e-20 * 3600.0**2)
    position, attitude, axis = in_working_frame(body)
    speed = np.sqrt(system.G * mass * 1e18 / distance)
    state = fullbody.State(
        [position, [distance, 0.0, 0.0]],
        [[0.0] * 3, [0.0, 0.95 * speed, 0.3 * speed]],
        spin=[1.5 * axis, [0.0, 0.0, 0.07]],
        attitude=[attitude, [1.0, 0.0, 0.0, 0.0]],
    )
    return system, state


def test_the_light_of_a_convex_shape_has_exact_derivatives_by_the_coefficients():
    steps = {0: 1e-3, 4: 1e-3, 13: 1e-3, 23: 1e-3}
    errors = relative_errors(convex, {"coefficients": SERIES[1:], "period": 6.0}, light(), steps, np.median)
    assert max(errors.values()) < 1e-9


def test_the_light_of_a_harmonic_shape_has_exact_derivatives_by_the_coefficients():
    steps = {1: 3e-7, 6: 3e-7, 9: 3e-7, 22: 3e-7, 24: 1e-6}
    errors = relative_errors(alone, {"coefficients": SERIES[1:], "period": 6.0}, light(), steps, np.median)
    assert max(errors.values()) < 2e-6


def test_the_motion_of_a_pair_has_exact_derivatives_by_the_shape():
    data = [
        observing.RadarAstrometry(
            np.linspace(1.0, 20.0, 5), range=np.zeros(5), sigma=1e-3, body=1, about=0, geometry=VIEW
        )
    ]
    steps = {2: 1e-3, 5: 1e-3, 7: 1e-3, 12: 1e-3, 24: 1e-2, 25: 1e-3}
    parameters = {"coefficients": SERIES[1:], "distance": 600.0, "mass": 7.0}
    assert max(relative_errors(pair, parameters, data, steps, np.median).values()) < 1e-6


def test_the_motion_beside_a_body_that_is_a_sphere_but_for_one_coefficient_has_exact_derivatives():
    # Most coefficients of its gravity are zero up to the rounding errors of the sums of which they are left.
    data = observing.RadarAstrometry([1.0, 9.0, 20.0], range=np.zeros(3), sigma=1e-3, body=1, about=0, geometry=VIEW)
    parameters = {"coefficients": 0.02 * np.eye(15)[8], "distance": 600.0}
    assert max(relative_errors(pair, parameters, [data], {4: 1e-3, 6: 1e-3, 8: 1e-3}, np.median).values()) < 1e-6


def test_the_light_of_a_pair_with_events_has_exact_derivatives_by_the_shape():
    steps = {5: 3e-7, 7: 3e-7, 26: 1e-6}
    parameters = {"coefficients": SERIES[1:], "distance": 600.0, "mass": 7.0, "radius": 0.01}
    assert max(relative_errors(pair, parameters, light(20, 10.0), steps, np.median).values()) < 2e-6


def test_a_scale_factor_of_a_shape_is_no_deformation():
    def setup(size):
        shape = HarmonicShape(SERIES, reference_radius=size, faces=80)
        system = fullbody.System([fullbody.Body(shape, mass=7e18, name="A")], G=1.0)
        return system, fullbody.State([[0.0] * 3], [[0.0] * 3], spin=[[0.0, 0.0, 1.0]])

    problem = Problem(setup, Parameters({"size": 80.0}), light(5), None)
    derivatives = problem._setup_differences.at(problem.make(np.array([80.0])), np.array([80.0]))
    assert not derivatives.deformations
    np.testing.assert_allclose(derivatives.system["scale of A"], [1 / 80], rtol=1e-8)


def test_a_shape_that_nearly_touches_another_body_is_differenced_and_listed():
    def near(bump, mass):
        return pair(np.append(SERIES[1:6], [bump, 0.0, 0.0]), distance=125.0, mass=mass)

    problem = Problem(near, Parameters({"bump": 0.05, "mass": 7.0}), light(2), None)
    values = problem.parameters.start
    derivatives = problem._setup_differences.at(problem.make(values), values)
    assert list(derivatives.undifferentiable) == ["bump"]
    assert "sphere around it reaches another body" in derivatives.undifferentiable["bump"]
    np.testing.assert_allclose(derivatives.system["mass of A"], [0.0, 1e18])


def test_derived_quantities_and_other_observations_follow_deformations():
    data = observing.Measured("moment", lambda run: run.system["A"].inertia[2], 1e22, 1e19, [0.0, 1.0])
    steps = {5: 1e-4, 7: 1e-4, 20: 1e-4}
    assert max(relative_errors(alone, {"coefficients": SERIES[1:]}, [data, light(3)], steps, np.median).values()) < 1e-5


@functools.cache
def observed():
    """Magnitudes of a convex shape in two oppositions with errors of 0.01."""
    rng = np.random.default_rng(4)
    times = np.sort(rng.uniform(0.0, 600.0, 200))
    system, state = convex(2 * SERIES[1:16])
    curve = observing.light_curve(system.integrate(state, 600.0, dense=True), times, VIEW)
    return observing.Photometry(times, curve + 0.01 * rng.normal(size=200), 0.01, geometry=VIEW)


@pytest.fixture(scope="module")
def result():
    prior = (0.0, fitting.smoothness(3, 0.3)[1:])
    parameters = {"coefficients": Free(np.full(15, 0.01), prior=prior), "period": 6.0003}
    return fullbody.fit(convex, parameters, [observed(), fitting.closure("A", 0.01)])


def test_a_convex_shape_is_recovered_within_its_errors(result):
    assert not result.differenced
    assert 0.7 < result.chi2 / result.dof < 1.3
    apart = np.append(result.values["coefficients"] - 2 * SERIES[1:16], result.values["period"] - 6.0)
    errors = np.sqrt(np.diag(result.covariance))[:16]
    assert np.mean((apart / errors) ** 2) < 2.0
    assert result.sigma["coefficients"].max() < 0.05


def test_a_fit_of_faces_ends_where_their_kinks_hide_the_minimum():
    rng = np.random.default_rng(1)
    times = np.sort(rng.uniform(0.0, 40.0, 60))
    curve = observing.light_curve(
        alone(2 * SERIES[1:9])[0].integrate(alone(2 * SERIES[1:9])[1], 40.0, dense=True), times, VIEW
    )
    data = observing.Photometry(times, curve + 0.01 * rng.normal(size=60), 0.01, geometry=VIEW)
    prior = (0.0, fitting.smoothness(2, 0.3)[1:])
    fit = fullbody.fit(alone, {"coefficients": Free(1.8 * SERIES[1:9], prior=prior), "period": 6.0}, data)
    assert not fit.message
    assert not fit.differenced
    assert fit.iterations < 30
    apart = np.append(fit.values["coefficients"] - 2 * SERIES[1:9], fit.values["period"] - 6.0)
    assert np.mean((apart / np.sqrt(np.diag(fit.covariance))[:9]) ** 2) < 2.5


def test_a_shape_may_start_as_a_sphere_whose_principal_axes_are_not_defined():
    problem = Problem(alone, Parameters({"coefficients": np.zeros(8)}), light(6), None)
    values = problem.parameters.start
    derivatives = problem._setup_differences.at(problem.make(values), values)
    assert "coefficients[3]" in derivatives.undifferentiable
    assert "principal axes of A, which jump where" in derivatives.undifferentiable["coefficients[3]"]


def test_closure_is_one_of_the_observations(result):
    closure = result.system["A"].shape.closure
    assert np.abs(closure).max() < 0.03
    np.testing.assert_allclose(result.pulls[1], -closure / 0.01, atol=1e-12)


def test_regularisations_have_exact_derivatives():
    cases = {
        convex: [fitting.closure("A", 0.01)],
        alone: [fitting.convexity("A", 0.01), fitting.principal_axis("A", "1 deg")],
    }
    for setup, observations in cases.items():
        problem = Problem(setup, Parameters({"coefficients": SERIES[1:]}), [*observations, light(2)], None)
        values = problem.parameters.start
        rows = problem.jacobian(problem.point(values)).rows
        for k in (1, 5, 9, 20):
            ends = [problem.point(values + by * np.eye(24)[k]).rows for by in (-1e-5, 1e-5)]
            expected = (ends[1] - ends[0])[:-2] / 2e-5
            np.testing.assert_allclose(rows[:-2, k], expected, atol=1e-5 * max(np.abs(expected).max(), 1.0))


def value_of(regularisation, shape):
    system = fullbody.System([fullbody.Body(shape, mass=1.0, name="A")], G=1.0)
    state = fullbody.State([[0.0] * 3], [[0.0] * 3])
    return regularisation.predict(system.integrate(state, 0.0))


def test_a_convex_polyhedron_has_no_concavity_and_a_pit_has_that_of_its_edges():
    assert value_of(fitting.convexity("A"), HarmonicShape([0.0], faces=80))[0] == 0.0
    # A cube with a pyramid of slope t taken from one face: four edges between the pyramid's faces, where the cosine of
    # the angle is cos^2 t, since the edges at the rim stay convex.
    t = np.radians(30.0)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    vertices = np.vstack([corners, [0.0, 0.0, 1.0 - np.tan(t)]])
    faces = [
        [0, 2, 6],
        [0, 6, 4],
        [0, 4, 5],
        [0, 5, 1],
        [4, 6, 7],
        [4, 7, 5],
        [6, 2, 3],
        [6, 3, 7],
        [2, 0, 1],
        [2, 1, 3],
    ]
    faces += [[5, 7, 8], [7, 3, 8], [3, 1, 8], [1, 5, 8]]
    side = 1.0 / np.cos(t)
    expected = 4 * (1 - np.cos(t) ** 2) * 2 * side / (20.0 + 4 * side)
    assert abs(value_of(fitting.convexity("A"), fullbody.Polyhedron(vertices, faces))[0] - expected) < 1e-12


def test_the_tilt_of_the_principal_axis_is_that_by_which_a_shape_was_turned():
    rotation = rotations.matrices(rotations.about([1.0, 2.0, 0.0] / np.sqrt(5.0), 0.2))
    shape = HarmonicShape([0, 0, 0, 0, 0, 0, -0.2, 0, 0.1], faces=320)
    rotated = fullbody.Polyhedron(shape.vertices @ rotation.T, shape.faces)
    np.testing.assert_allclose(value_of(fitting.principal_axis("A"), rotated), rotation[:2, 2], atol=1e-9)
    refused("two of the moments of inertia are equal", value_of, fitting.principal_axis("A"), HarmonicShape([0.0]))


def test_regularisations_of_other_shapes_are_refused():
    refused("A is a Sphere; expected a ConvexShape", value_of, fitting.closure("A"), fullbody.Sphere(1.0))
    refused("A is a ConvexShape; expected a Polyhedron", value_of, fitting.convexity("A"), ConvexShape([0.0]))
    refused("body of closure of B is 'B'", value_of, fitting.closure("B"), ConvexShape([0.0]))
    refused("sigma is 0; expected a finite number above zero", fitting.smoothness, 3, 0)


def test_the_smoothness_prior_falls_with_the_degree():
    sigma = fitting.smoothness(3, 0.5, power=1.0)
    np.testing.assert_allclose(sigma[[1, 3, 4, 8, 9, 15]], [0.5, 0.5, 0.25, 0.25, 0.5 / 3, 0.5 / 3])
    assert np.isinf(sigma[0])
