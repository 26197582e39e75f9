"""Fits that went wrong without a word: order of minima, jitter of nights, steps, third bodies, starts."""

import fullbody
import numpy as np
import pytest
from fullbody import observing
from fullbody.errors import InvalidInput
from fullbody.fitting import Free
from fullbody.fitting.free import Parameters
from fullbody.fitting.problem import Problem
from support import body_list, points
from support.fits import pair
from support.flows import central_of_state

FAR = observing.Geometry([-100.0, 400.0], to_observer=[1e6, 2e5, 1e5], light_time=False)


def orbit(M, mass=1.0):
    system = points(mass, 0.1)
    r, v = fullbody.KeplerElements(3.0, 0.3, 0.4, 0.5, 0.6, M).to_cartesian(system.mu())
    return system, fullbody.State(position=[0 * r, r], velocity=[0 * v, v])


def ranges(setup, times, noise, seed=0, sigma=0.02):
    options = {"sigma": sigma, "body": 1, "about": 0, "geometry": FAR}
    system, state = setup
    run = system.integrate(state, times[-1] + 1.0, dense=True)
    exact = observing.RadarAstrometry(times, range=0 * times, **options).predict(run).range
    seen = exact + noise * np.random.default_rng(seed).normal(size=len(times))
    return observing.RadarAstrometry(times, range=seen, **options)


@pytest.mark.parametrize("seed", [0, 7])
def test_minima_with_a_free_jitter_are_in_the_order_of_the_posterior(seed):
    data = ranges(orbit(1.0), np.linspace(1, 60, 60), 0.1, seed)
    free = {"M": Free(1.2, min=-3.0, max=3.5), "jitter": Free(0.3, min=0.0, max=10.0)}
    fit = fullbody.fit(orbit_of_mean_anomaly, free, lambda jitter: data.with_jitter(jitter), starts=6, rng=1)
    densities = [fit.log_posterior(minimum.values) for minimum in fit.minima]
    assert densities == sorted(densities, reverse=True)
    assert fit.minima[0].loss == pytest.approx(fit.loss)
    assert fit.p_value is None


def orbit_of_mean_anomaly(M):
    return orbit(M)


@pytest.mark.parametrize("start", [6.1e-17, -2.4e-16, 1e-12, 1e-10, 1e-7, 0.0])
def test_a_start_that_is_zero_up_to_rounding_moves(start):
    data = ranges(orbit(0.05), np.linspace(1, 60, 40), 0.0)
    fit = fullbody.fit(orbit, {"M": start, "mass": 1.0}, data)
    expected = fullbody.fit(orbit, {"M": 0.04, "mass": 1.0}, data)
    assert fit.values["M"] == pytest.approx(0.05, abs=1e-6)
    assert fit.sigma["M"] == pytest.approx(expected.sigma["M"], rel=1e-3)


@pytest.mark.parametrize("start", [1e-12, 1e-8, 0.1])
def test_the_fit_of_a_jitter_converges_from_any_start_above_zero(start):
    data = ranges(orbit(1.0), np.linspace(1, 60, 60), 0.06)
    free = {"mass": 1.0, "M": 1.0, "j": Free(start, min=0.0, max=10.0)}
    fit = fullbody.fit(orbit, free, lambda j: data.with_jitter(j))
    total = np.hypot(fit.values["j"], 0.02)
    assert total == pytest.approx(np.sqrt(np.mean(fit.residuals[0].range ** 2)), rel=1e-3)


def test_a_jitter_beside_zero_points_of_nights_is_not_too_small():
    rng = np.random.default_rng(0)
    jitters, stated = [], []
    bodies = [fullbody.Body(fullbody.Sphere(r), mass=m) for r, m in ((1.0, 1.0), (0.2, 0.01))]
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State([[0.0] * 3, [4.0, 0, 0]], [[0.0] * 3, [0, 0.5, 0]])
    geometry = observing.Geometry([0.0, 200.0], to_observer=[1e7, 3e6, 2e7], to_sun=[2e7, 1e6, 5e7], light_time=False)
    times = np.sort(rng.uniform(1.0, 20.0, 80))
    exact = observing.light_curve(system.integrate(state, 21.0, dense=True), times, geometry)
    night = np.repeat(np.arange(40), 2)
    for _ in range(12):
        seen = exact + rng.normal(size=80) * np.hypot(0.01, 0.04) + rng.normal(size=40)[night]
        data = observing.Photometry(times, seen, 0.01, geometry=geometry, night=night)
        free = {"j": Free(0.03, min=0.0, max=1.0)}
        fit = fullbody.fit(lambda: (system, state), free, lambda j, data=data: data.with_jitter(j))
        jitters.append(fit.values["j"])
        stated.append(fit.sigma["j"])
    error = np.mean(stated) / np.sqrt(12)
    assert abs(np.mean(jitters) - 0.04) < 4 * error
    # The variance of 40 differences is known to the root of 2 over 40, and the jitter to half of that.
    total = np.hypot(0.01, 0.04)
    assert np.mean(stated) == pytest.approx(total / np.sqrt(2 * 40) * total / 0.04, rel=0.1)


def tidal(radius, mass):
    bodies = body_list(A=(fullbody.Ellipsoid(1.0, 0.8, 0.6), mass), B=(fullbody.PointMass(), 0.1))
    tide = fullbody.forces.Tide(on="A", by="B", k2=0.5, lag=0.05, radius=radius, name="tide")
    state = fullbody.State([[0, 0, 0], [4.0, 0, 0.3]], [[0, 0, 0], [0, 0.52, 0.1]], spin=[[0.1, 0, 0.7], [0, 0, 0]])
    return fullbody.System(bodies, G=1.0, forces=[tide]), state


def test_the_step_of_a_difference_does_not_depend_on_earlier_values():
    data = ranges(tidal(0.8, 1.0), np.linspace(1, 60, 20), 0.0, sigma=0.001)
    free = Parameters({"radius": Free(0.78, min=0.0), "mass": 1.0})
    fresh, used = (Problem(tidal, free, data, None) for _ in range(2))
    used.jacobian(used.point(np.array([1e-6, 1.0])))
    at = np.array([0.85, 1.0001])
    rows = [problem.jacobian(problem.point(at)).rows for problem in (fresh, used)]
    np.testing.assert_allclose(rows[1], rows[0], rtol=1e-3, atol=1e-3 * np.abs(rows[0][:, 0]).max())


def with_third_body(t0=0.0, mass=1.0):
    elements = fullbody.KeplerElements(16.0, 0.3, 0.3, 0.2, 0.1, 0.4)
    third = fullbody.forces.ThirdBody(mass=1.5, orbit=elements, of="body", time=0.3, name="T")
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m, name=n) for m, n in ((mass, "A"), (0.15, "B"))]
    system = fullbody.System(bodies, G=1.0, forces=[third])
    state = fullbody.State([[0, 0, 0], [4.0, 0, 0.3]], [[0.1, 0, 0.05], [0, 0.53, 0.1]], time=t0)
    return system, state


def test_the_time_of_the_start_is_differentiated_beside_a_third_body():
    data = ranges(with_third_body(), np.linspace(2, 60, 15), 0.0)
    problem = Problem(with_third_body, Parameters({"t0": 0.5, "mass": 1.0}), [data], None)
    values = np.array([0.52, 1.001])
    rows = problem.jacobian(problem.point(values)).rows[:, 0]
    expected = central_of_state(lambda by: problem.point(values + np.array([by, 0.0])).rows, 1e-3)
    np.testing.assert_allclose(rows, expected, atol=1e-6 * np.abs(expected).max())


def test_the_run_of_a_fit_is_the_motion_that_was_fitted_before_the_epoch_too():
    times = np.linspace(-60, 60, 30)
    system, state = with_third_body()
    options = {"sigma": 0.01, "body": 1, "about": 0, "geometry": FAR}
    following, previous = times[times > 0], times[times < 0]
    exact = []
    for part, end in ((previous, -61.0), (following, 61.0)):
        blank = observing.RadarAstrometry(part, range=0 * part, **options)
        exact.append(blank.predict(system.integrate(state, end, dense=True)).range)
    data = observing.RadarAstrometry(times, range=np.concatenate(exact), **options)
    fit = fullbody.fit(lambda mass: with_third_body(mass=mass), {"mass": 1.0}, data)
    assert np.abs(data.residuals(fit.run).range).max() < 1e-8


@pytest.mark.parametrize("digits", [4, 5, 6])
def test_a_setup_that_rounds_is_refused(radar, digits):
    with pytest.raises(InvalidInput, match=r"do not change evenly with a .* rounded numbers"):
        fullbody.fit(lambda a: pair(a=float(f"{a:.{digits}f}")), {"a": 2.5501234}, radar)


def test_an_orbit_with_an_angle_plus_revolutions_is_the_same_minimum():
    data = ranges(orbit(1.0), np.linspace(1, 60, 40), 0.02)
    starts = [{"M": 1.0 + 2 * np.pi * k, "mass": 1.0} for k in (0, 1, -3)]
    fit = fullbody.fit(orbit, starts[0], data, starts=starts)
    assert [minimum.starts for minimum in fit.minima] == [3]


def test_stated_errors_that_change_with_a_parameter_are_refused(radar):
    def scaled(factor):
        columns = {"range": radar.range, "range_rate": radar.range_rate, "sigma": (0.02 * factor, 0.01 * factor)}
        return observing.RadarAstrometry(radar.times, **columns, body=1, about=0, geometry=radar.geometry)

    with pytest.raises(InvalidInput, match=r"stated errors .* change with factor"):
        fullbody.fit(lambda a: pair(a=a), {"a": 2.55, "factor": 1.0}, scaled)
