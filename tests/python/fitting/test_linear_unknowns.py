"""Linear unknowns of photometry (zero points, slopes, series) are solved for in a fit as if they were parameters."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import observing
from fullbody.fitting import Free
from fullbody.fitting.free import Parameters
from fullbody.fitting.losses import loss_of
from fullbody.fitting.problem import Problem
from scipy.optimize import minimize
from support import refused
from support.fits import QUICK, kw4, view

SERIES = observing.RotationSeries("Alpha", order=2)
VIEW = view(40.0, sun=True)
#: Two nights, of which the second is observed at a larger range of airmasses.
TIMES = np.concatenate([np.linspace(1.0, 8.0, 30), np.linspace(25.0, 33.0, 30)])
NIGHT = np.repeat([0, 1], 30)
AIRMASS = np.concatenate([1.0 + 0.02 * (TIMES[:30] - 4.0) ** 2, 1.2 + 0.03 * (TIMES[30:] - 27.0) ** 2])
#: The coefficients of the series, cos 1, sin 1, cos 2, sin 2, and the zero points and slopes of the nights.
COEFFICIENTS = np.array([0.01, -0.02, 0.03, 0.005])
ZEROS, SLOPES = np.array([14.1, 14.3]), np.array([0.12, 0.2])
START = {"a": 2.5503, "libration": 0.05, "tilt": 0.05}


def angle(run):
    """The rotation angle of Alpha from the bisector of the phase angle to its x-axis, in plain geometry."""
    times = TIMES * u.h
    directions = [
        vector / np.linalg.norm(vector, axis=1)[:, None] for vector in (VIEW.to_observer(times), VIEW.to_sun(times))
    ]
    middle = sum(directions).value
    axes = np.array([run[k].rotation_matrix[0] for k in range(len(run))])
    along, across = (np.sum(middle * axes[:, :, k], axis=1) for k in (0, 1))
    # Where the bisector stands ahead of the x-axis, the body has still to turn.
    return -np.arctan2(across, along)


def series(run, coefficients):
    phases = angle(run)[:, None] * [1, 2]
    terms = np.stack([np.cos(phases), np.sin(phases)], axis=-1).reshape(len(run), 4)
    return terms @ coefficients


@pytest.fixture(scope="module")
def light():
    """Magnitudes of 1999 KW4 with a series and the air of two nights, and with noise of 0.005 magnitudes."""
    system, state = kw4()
    unitless = observing.Photometry(TIMES * u.h, np.zeros(60), 0.005, geometry=VIEW, zero=0.0)
    run = system.integrate(state, 40.0, output=unitless.emission(system), integrator=QUICK)
    noise = 0.005 * np.random.default_rng(2).normal(size=60)
    return (
        unitless.predict(run)
        + series(run, COEFFICIENTS)
        + (ZEROS + SLOPES * AIRMASS[:, None])[range(60), NIGHT]
        + noise
    )


OPTIONS = {"geometry": VIEW, "night": NIGHT, "airmass": AIRMASS, "rotation": SERIES}


@pytest.fixture(scope="module")
def data(light):
    return observing.Photometry(TIMES * u.h, light, 0.005, **OPTIONS)


class Explicit:
    """Photometry with given linear unknowns, in a class without exact derivatives."""

    def __init__(self, light, zeros, slopes, coefficients):
        self.data = observing.Photometry(TIMES * u.h, light, 0.005, geometry=VIEW, zero=0.0)
        self.air = (zeros + slopes * AIRMASS[:, None])[range(60), NIGHT]
        self.coefficients = coefficients

    def emission(self, system):
        return self.data.emission(system)

    def pulls(self, run):
        return (self.data.residuals(run) - self.air - series(run, self.coefficients)) / 0.005


@pytest.fixture(scope="module")
def result(data):
    return fullbody.fit(kw4, START, data, integrator=QUICK)


def explicit_fit(light, **options):
    def observations(z0, z1, x0, x1, c1, s1, c2, s2):
        return Explicit(light, np.array([z0, z1]), np.array([x0, x1]), np.array([c1, s1, c2, s2]))

    reference = dict(
        zip(("z0", "z1", "x0", "x1", "c1", "s1", "c2", "s2"), [*ZEROS, *SLOPES, *COEFFICIENTS], strict=True)
    )
    return fullbody.fit(kw4, START | reference, observations, integrator=QUICK, **options)


def test_linear_unknowns_have_the_values_errors_and_correlations_of_parameters(light, result):
    explicit = explicit_fit(light)
    assert result.names[3:7] == ("zero point of 0", "zero point of 1", "airmass slope of 0", "airmass slope of 1")
    assert result.names[7:] == ("cos 1 of Alpha", "sin 1 of Alpha", "cos 2 of Alpha", "sin 2 of Alpha")
    assert result.chi2 == pytest.approx(explicit.chi2, rel=1e-8)
    assert result.dof == explicit.dof == 60 - 11
    errors = np.sqrt(np.diag(explicit.covariance))
    assert np.abs((result.numbers - explicit.numbers) / errors).max() < 1e-3
    np.testing.assert_allclose(np.sqrt(np.diag(result.covariance)), errors, rtol=1e-4)
    np.testing.assert_allclose(result.correlation, explicit.correlation, atol=1e-4)
    # The series takes part of what tells how Alpha is tilted.
    assert np.abs(result.correlation[2, 7:]).max() > 0.1
    assert result.iterations <= explicit.iterations
    # The truth is within the errors that were put in.
    truth = np.concatenate([[2.55, 0.05, 0.05], ZEROS, SLOPES, COEFFICIENTS])
    assert np.abs((result.numbers - truth) / errors).max() < 4.0


def differences(problem, k, step):
    """Derivatives of fourth order of all pulls, by complete runs, in which the linear unknowns are solved for."""

    def rows(by):
        moved = problem.parameters.start.copy()
        moved[k] += by
        return problem.point(moved).rows

    return (8 * (rows(step) - rows(-step)) - (rows(2 * step) - rows(-2 * step))) / (12 * step)


def spinning(rate=2.273, **parameters):
    """1999 KW4 with a rate of rotation of Alpha in rad/h."""
    system, state = kw4(**parameters)
    motion = {name: getattr(state, name) for name in ("position", "velocity", "attitude")}
    return system, fullbody.State(**motion, spin=[[0.0, 0.0, rate], state.spin[1]])


@pytest.mark.parametrize("loss", ["linear", "soft_l1", "cauchy"])
def test_projected_pulls_have_exact_derivatives(light, loss):
    wrong = light.copy()
    wrong[[4, 40]] += 0.06
    start = {"a": 2.552, "mass": 2.36, "tilt": 0.08, "rate": 2.274}
    # At contacts light is not smooth.
    system, state = spinning(**start)
    events = observing.mutual_events(system.integrate(state, 40.0, dense=True), VIEW)
    contacts = [getattr(e, name) for e in events for name in ("begin", "end", "total_begin", "total_end")]
    smooth = np.abs(TIMES[:, None] - [contact.value for contact in contacts if contact is not None]).min(axis=1) > 0.1
    assert smooth.sum() > 40
    options = OPTIONS | {name: OPTIONS[name][smooth] for name in ("night", "airmass")}
    free = {"drift": "free", "phase_slope": "free"}
    data = observing.Photometry(TIMES[smooth] * u.h, wrong[smooth], 0.005, **free, **options)
    problem = Problem(spinning, Parameters(start), data, fullbody.Verner98(), loss_of(loss))
    jacobian = problem.jacobian(problem.point(problem.parameters.start))
    for k, step in enumerate((2e-5, 2e-4, 1e-3, 1e-4)):
        expected = differences(problem, k, step)
        assert np.abs(jacobian.rows[:, k] - expected).max() < 2e-6 * np.abs(expected).max()


def test_derivatives_of_data_with_a_series_are_those_of_the_run_displaced(data):
    system, state = kw4()
    names = ["mass of Alpha", "mass of Beta", "semi-axis a of Alpha", "G"]
    run = system.integrate(state, 40.0, output=data.emission(system), derivatives=names)
    exact, displaced = data.derivatives(run), run.derivative_of(data.pulls)
    np.testing.assert_array_equal(exact.value, displaced.value)
    kinds = displaced.start.reshape(-1, 2, 4, 3)
    size = np.abs(kinds).max(axis=(0, 1, 3))[:, None]
    assert (np.abs(exact.start.reshape(kinds.shape) - kinds) / size).max() < 1e-6
    for name in names:
        size = np.abs(displaced.by_parameter[name]).max()
        np.testing.assert_allclose(exact.by_parameter[name], displaced.by_parameter[name], atol=1e-6 * size)


def test_the_angle_of_a_series_grows_with_the_rotation_from_the_bisector():
    ball = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name="A")], G=1.0)
    state = fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)), spin=[[0.0, 0.0, 2 * np.pi]])
    sides = {"to_observer": [1e9, 1e9, 3e8], "to_sun": [1e9, -1e9, 3e8]}
    geometry = observing.Geometry([0.0, 3.0], **sides, light_time=False)
    item = observing.RotationSeries("A", order=2)
    # The x-axis starts along the bisector; a quarter of a turn follows.
    times = np.array([0.0, 0.25, 0.5, 1.125])
    data = observing.Photometry(times, np.zeros(4), 1.0, geometry=geometry, zero=0.0, rotation=item)
    design = data.linear(ball.integrate(state, 3.0, dense=True)).design[:, 0]
    half = np.sqrt(0.5)
    expected = [[1, 0, 1, 0], [0, 1, -1, 0], [-1, 0, 1, 0], [half, half, 0, 1]]
    np.testing.assert_allclose(design, expected, atol=1e-9)


def test_log_posterior_is_integrated_over_the_linear_unknowns(light):
    """The density of a, zero point and drift is integrated over the latter two by a sum over a fine grid."""
    data = observing.Photometry(TIMES[:30] * u.h, light[:30], 0.02, geometry=VIEW, drift="free")
    fit = fullbody.fit(lambda a: kw4(a=a), {"a": 2.55}, data, integrator=QUICK)
    for a in (2.55, 2.548):
        system, state = kw4(a=a)
        run = system.integrate(state, 40.0, output=data.emission(system), integrator=QUICK)
        unitless = observing.Photometry(TIMES[:30] * u.h, light[:30], 0.02, geometry=VIEW, zero=0.0).residuals(run)
        hours, best = TIMES[:30] - TIMES[:30].mean(), fit.linear[0]
        zeros = best["zero point of 0"] + np.linspace(-0.06, 0.06, 241)
        drifts = best["drift of 0"].to_value(1 / u.h) + np.linspace(-0.025, 0.025, 241)
        left = unitless - zeros[:, None, None] - drifts[:, None] * hours
        density = np.exp(-0.5 * np.sum((left / 0.02) ** 2, axis=-1))
        total = density.sum() * (zeros[1] - zeros[0]) * (drifts[1] - drifts[0])
        assert fit.log_posterior({"a": a}) == pytest.approx(np.log(total), abs=1e-6)


def test_log_posterior_has_the_gradient_of_its_determinant():
    """Of few and poor data the determinant of the series changes more with the rate of rotation than chi2 does."""
    times, noise = np.sort(np.random.default_rng(0).uniform(1.0, 30.0, 11)), np.random.default_rng(1).normal(size=11)
    options = {
        "geometry": VIEW,
        "night": np.zeros(11, dtype=int),
        "rotation": observing.RotationSeries("Alpha", order=4),
    }
    data = observing.Photometry(times * u.h, noise, 1.0, **options)
    fit = fullbody.fit(spinning, {"rate": Free(2.273, min=2.2, max=2.3)}, data, integrator=QUICK)
    problem, at = fit._minimised().problem, 2.27
    point = problem.point(np.array([at]))
    assert abs(problem.jacobian(point).log_determinant[0]) > 1.0
    ends = [fit.log_posterior([at + by * 1e-4]) for by in (1, -1, 2, -2)]
    expected = (8 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / 12e-4
    assert fit.log_posterior([at], gradient=True)[1][0] == pytest.approx(expected, rel=1e-5)


class Custom:
    """Observations of a class that declares linear unknowns and has no derivatives of its own."""

    def __init__(self, data):
        self.emission, self.linear, self.residuals = data.emission, data.linear, data.residuals

    def pulls(self, run):
        return self.linear(run).solved()[1]


def test_classes_of_users_may_declare_linear_unknowns(data, result):
    custom = fullbody.fit(kw4, START, Custom(data), integrator=QUICK)
    np.testing.assert_allclose(custom.numbers, result.numbers, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(custom.correlation, result.correlation, atol=1e-6)


def test_samples_are_of_the_parameters_without_linear_unknowns(light):
    data = observing.Photometry(TIMES[:30] * u.h, light[:30], 0.02, geometry=VIEW, drift="free")
    fit = fullbody.fit(lambda a: kw4(a=a), {"a": 2.55}, data, integrator=QUICK)
    samples = fit.sample(steps=3, rng=1)
    assert list(samples.data_vars) == ["a", "log_posterior"]
    last = samples.isel(chain=0, draw=-1)
    assert float(last.log_posterior) == pytest.approx(fit.log_posterior({"a": float(last.a)}), rel=1e-12)


def test_log_posterior_takes_the_parameters_without_linear_unknowns(result):
    refused(
        "values has 'zero point of 0'; expected all of a, libration, tilt", lambda: result.log_posterior(result.values)
    )


@pytest.mark.parametrize("loss", ["huber", "cauchy", fullbody.fitting.Outliers(0.05, 10.0)])
def test_under_a_robust_loss_linear_unknowns_minimise_its_sum(light, loss):
    wrong = light.copy()
    wrong[[4, 17, 40, 41]] += 0.3
    data = observing.Photometry(TIMES * u.h, wrong, 0.005, **OPTIONS)
    fit = fullbody.fit(kw4, {"a": 2.55}, data, loss=loss, integrator=QUICK)
    model = data.linear(fit.run)
    rho = loss_of(loss)

    def total(values):
        return rho.total((model.pulls - model.design @ values).ravel())

    best = fit.numbers[1:]
    errors = np.sqrt(np.diag(fit.covariance))[1:]
    other = minimize(lambda x: total(best + errors * x), np.full(8, 0.3), method="BFGS", options={"gtol": 1e-7})
    assert fit.loss == pytest.approx(other.fun, rel=1e-7)
    assert np.abs(other.x).max() < 1e-3
    # The points that are wrong by 60 errors have hardly moved the zero points.
    truth = np.concatenate([ZEROS, SLOPES, COEFFICIENTS])
    assert np.abs((best - truth) / errors).max() < 4.0
    refused("expected loss='linear'", lambda: fit.log_posterior({"a": 2.55}))


def test_a_jitter_beside_a_series_is_that_of_the_unknowns_in_matrices(light):
    """The restricted likelihood of Patterson & Thompson (1971) over a jitter has the same maximum in dense matrices."""
    noisy = light + 0.01 * np.random.default_rng(4).normal(size=60)
    data = observing.Photometry(TIMES * u.h, noisy, 0.005, **OPTIONS)
    system, state = kw4()
    fit = fullbody.fit(
        lambda: (system, state), {"j": Free(0.02, min=0.0)}, lambda j: data.with_jitter(j), integrator=QUICK
    )
    run = system.integrate(state, 40.0, output=data.emission(system), integrator=QUICK)
    model = data.linear(run)
    residuals, design = 0.005 * model.pulls[:, 0], 0.005 * model.design[:, 0]

    def loss(j):
        weights = 1.0 / (0.005**2 + j**2)
        information = weights * design.T @ design
        left = residuals - design @ np.linalg.solve(information, weights * design.T @ residuals)
        return weights * left @ left - 60 * np.log(weights) + np.linalg.slogdet(information)[1]

    grid = fit.values["j"] * (1.0 + np.array([-1e-3, 0.0, 1e-3]))
    low, middle, high = map(loss, grid)
    assert middle < min(low, high)
    assert fit.sigma["j"] == pytest.approx(np.sqrt(2.0 / ((low - 2 * middle + high) / (1e-3 * grid[1]) ** 2)), rel=0.02)


def shortened(which, **options):
    chosen = {"geometry": VIEW, "night": NIGHT[which]} | options
    return observing.Photometry(TIMES[which] * u.h, np.zeros(len(TIMES[which])), 0.01, **chosen)


def test_a_table_gives_airmasses_only_if_its_column_is_named(data):
    table = data.to_table()
    options = {"geometry": VIEW, "night": "night", "rotation": SERIES}
    read = observing.Photometry.from_table(table, airmass="airmass", **options)
    np.testing.assert_array_equal(read.airmass, AIRMASS)
    np.testing.assert_array_equal(read.nights, data.nights)
    # A column of airmasses may be there for information.
    assert observing.Photometry.from_table(table, **options).airmass is None


FLAT = np.where(NIGHT == 0, 1.3, AIRMASS)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"airmass": FLAT}, r"leave zero point of 0, airmass slope of 0 undetermined beside each other"),
        ({"night": [0] + [1] * 59, "drift": "free"}, "leave drift of 0 undetermined; expected times at which it has"),
        ({"rotation": observing.RotationSeries(0, order=31)}, r"the 60 data leave .* of Alpha.* undetermined"),
    ],
)
def test_unknowns_that_the_data_cannot_separate_are_named(options, message):
    data = shortened(slice(None), **options)
    system, state = kw4()
    run = system.integrate(state, 40.0, output=data.emission(system), integrator=QUICK)
    refused(message, data.chi2, run)
    refused(f"the start of the fit is refused.*{message}", fullbody.fit, kw4, {"a": 2.55}, data, integrator=QUICK)


def test_a_series_of_an_order_that_epochs_alias_is_refused():
    """Four phases of a rotation, seen again and again, tell all but sin 2, which is zero at each of them."""
    ball = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name="A")], G=1.0)
    state = fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)), spin=[[0.0, 0.0, 2 * np.pi]])
    geometry = observing.Geometry([0.0, 9.0], to_observer=[1e9, 0, 0], to_sun=[1e9, 0, 0], light_time=False)
    options = {"geometry": geometry, "rotation": observing.RotationSeries("A", order=2)}
    data = observing.Photometry(np.arange(32) / 4.0, np.zeros(32), 0.01, **options)
    refused("leave sin 2 of A undetermined", lambda: data.chi2(ball.integrate(state, 9.0, dense=True)))


def test_series_are_shared_by_data_sets_and_zero_points_are_not(light, result):
    """Each night as a data set of its own, with the same label, gives the same fit as both nights in one."""
    parts = []
    for night in (0, 1):
        mask = night == NIGHT
        options = OPTIONS | {"night": np.zeros(30, dtype=int), "airmass": AIRMASS[mask]}
        parts.append(observing.Photometry(TIMES[mask] * u.h, light[mask], 0.005, **options))
    joint = fullbody.fit(kw4, START, parts, integrator=QUICK)
    assert joint.chi2 == pytest.approx(result.chi2, rel=1e-9)
    assert joint.names[3:5] == ("zero point of 0 of observations[0]", "airmass slope of 0 of observations[0]")
    assert joint.names[5:9] == result.names[7:]
    order = [*range(3), 3, 9, 4, 10, *range(5, 9)]
    np.testing.assert_allclose(joint.numbers[order], result.numbers, rtol=1e-6)
    np.testing.assert_allclose(joint.covariance[np.ix_(order, order)], result.covariance, rtol=1e-3, atol=1e-12)
    np.testing.assert_allclose(np.concatenate(joint.residuals), result.residuals[0], atol=1e-7)
    # Each of the data sets predicts with the unknowns of the fit, which are not those at which its own chi2 is least.
    left = parts[0].residuals(joint.run, joint.linear[0])
    np.testing.assert_allclose(left, joint.residuals[0], atol=1e-6)
    assert parts[0].chi2(joint.run) < np.sum((left / 0.005) ** 2) - 1e-3
    refused("linear has no 'zero point of 0'", lambda: parts[0].predict(joint.run, {}))


def test_a_fit_with_linear_unknowns_is_saved_drawn_and_shown(result, tmp_path):
    path = tmp_path / "fit.nc"
    result.save(path)
    read = fullbody.load(path)
    assert read == result
    assert read.names == result.names
    assert read.values == result.values
    np.testing.assert_array_equal(read.covariance, result.covariance)
    assert repr(read) == repr(result)
    assert list(result.to_table()["parameter"]) == list(result.names)
    assert list(result.draw(3, 0).columns) == ["a", "libration", "tilt"]
    assert list(result.minima[0].values) == ["a", "libration", "tilt"]
    assert result.values["zero point of 0"] == result.linear[0]["zero point of 0"]
