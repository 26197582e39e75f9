"""Fits: Eris against independent ones, what changes nothing, priors, losses, jitter, bounds."""

import astropy.units as u
import fullbody
import numpy as np
import pandas
import pytest
from astropy.time import Time
from fullbody import observing
from fullbody.errors import InconsistentInput, InvalidInput
from fullbody.fitting import Free, Outliers
from fullbody.fitting.losses import loss_of
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from scipy.stats import norm
from support import DATA, body_list, refused
from support.eris import EPOCH, ERIS
from support.fits import QUICK, START, kw4, noisy, pair
from support.flows import central_of_state

TRUE = {"mass": 2.353, "a": 2.55}


def test_eris_has_the_values_and_errors_of_an_independent_fit():
    table = pandas.read_csv(DATA / "observations" / "eris_dysnomia.csv")
    span = Time(table["time"].to_numpy(), format="jd", scale="utc")
    names = {"times": "time", "east": "Delta-RA_Dysnomia", "north": "Delta-DEC_Dysnomia"}
    names["sigma"] = ("Delta-RA_Dysnomia-err", "Delta-DEC_Dysnomia-err")
    geometry = observing.Geometry.from_orbit(ERIS, EPOCH, span=span)
    options = {"dates": ("jd", "utc"), "body": "Dysnomia", "about": "Eris", "geometry": geometry}
    data = observing.Astrometry.from_table(table, columns=names, unit=u.arcsec, **options)
    epoch = Time(2453979.0, format="jd", scale="utc")

    def dysnomia(a, period, e, i, node, argument, mean):
        mu = 4 * np.pi**2 * a**3 / period**2
        bodies = body_list(Eris=(fullbody.PointMass(), mu), Dysnomia=(fullbody.PointMass(), 1e-9 * mu))
        units = {"units": ("km", "day", "kg"), "epoch": epoch, "frame": "equatorial"}
        system = fullbody.System(bodies, G=1.0, gravity="point", **units)
        elements = fullbody.KeplerElements(a, e, *(angle.to_value("rad") for angle in (i, node, argument, mean)))
        r, v = elements.to_cartesian(mu)
        return system, fullbody.State(position=[0 * r, r], velocity=[0 * v, v])

    start = {"a": 37300.0, "period": 15.7859, "e": Free(0.006, min=0.0), "i": 45.5 * u.deg, "node": 126.0 * u.deg}
    start |= {"argument": 180.0 * u.deg, "mean": 180.0 * u.deg}
    result = fullbody.fit(dysnomia, start, data, integrator=fullbody.Verner98(rtol=1e-11, atol=1e-11))
    assert result.chi2 == pytest.approx(107.545, abs=0.005)
    assert result.dof == 31
    # Holler et al. (2021) exclude a Keplerian orbit at 6.3 sigma.
    assert norm.isf(result.p_value / 2) == pytest.approx(6.3, abs=0.05)
    expected = {"a": (37272.3, 61.0), "period": (15.785897, 0.000047), "e": (0.00624, 0.00101), "i": (45.50, 0.16)}
    for name, (value, error) in expected.items():
        digit = {"a": 0.05, "period": 5e-7, "e": 5e-6, "i": 5e-3}[name]
        assert abs(getattr(result.values[name], "value", result.values[name]) - value) <= digit
        assert getattr(result.sigma[name], "value", result.sigma[name]) == pytest.approx(error, rel=0.03)
    assert result.runs <= 14
    text = repr(result)
    assert "chi2" in text
    assert "37272" in text
    assert result.values["node"].unit == u.deg
    # The run goes through all data, some years each way from the epoch, with one continuous solution.
    assert data.chi2(result.run) == pytest.approx(result.chi2, rel=1e-6)


def test_the_minimum_is_that_of_any_other_solver(radar, result):
    def chi2(x):
        system, state = pair(mass=x[0], a=x[1])
        run = system.integrate(state, 30.0, output=radar.emission(system))
        return radar.chi2(run)

    start = [result.values["mass"] + 1e-4, result.values["a"] - 1e-4]
    other = minimize(chi2, start, method="Nelder-Mead", options={"xatol": 1e-8, "fatol": 1e-8})
    assert result.chi2 == pytest.approx(other.fun, abs=1e-6)
    off = np.abs(other.x - list(result.values.values())) / list(result.sigma.values())
    assert off.max() < 1e-2
    # chi2 is higher by one at one error, with the other parameter at its best: the definition of the error.
    for k, name in enumerate(("mass", "a")):
        shift = result.covariance[:, k] / result.sigma[name]
        assert chi2(np.array(list(result.values.values())) + shift) - result.chi2 == pytest.approx(1.0, rel=0.02)


def test_order_units_and_epoch_of_the_data_change_nothing():
    radar = noisy(np.random.default_rng(5), *kw4(), np.linspace(2.0, 38.0, 15) * u.h, 40.0)
    result = fullbody.fit(kw4, START, radar, integrator=QUICK)
    order = np.random.default_rng(1).permutation(len(radar))
    options = {"body": "Beta", "about": "Alpha", "geometry": radar.geometry}
    columns = {"range": radar.range[order].to(u.m), "range_rate": radar.range_rate[order].to(u.km / u.day)}
    sigma = (0.075 * u.km, 0.01 * u.m / u.s)
    shuffled = observing.RadarAstrometry(radar.times[order].to(u.day), **columns, sigma=sigma, **options)

    def earlier_start(mass, a):
        """The same start, from which half a period earlier the motion is followed."""
        system, state = kw4(mass=mass.to_value(1e12 * u.kg), a=a.to_value(u.km))
        return system, system.integrate(state, 17.0, output="ends")[-1]

    start = {"mass": 2.36e9 * u.t, "a": 2545.0 * u.m}
    other = fullbody.fit(earlier_start, start, [shuffled], integrator=QUICK)
    assert other.chi2 == pytest.approx(result.chi2, rel=1e-8)
    assert abs(other.values["mass"].to_value(1e12 * u.kg) - result.values["mass"]) < 1e-4 * result.sigma["mass"]
    assert abs(other.values["a"].to_value(u.km) - result.values["a"]) < 1e-4 * result.sigma["a"]
    np.testing.assert_allclose(other.correlation, result.correlation, atol=1e-5)
    assert other.sigma["a"].to_value(u.km) == pytest.approx(result.sigma["a"], rel=1e-5)


def test_axes_of_the_system_change_nothing():
    radar = noisy(np.random.default_rng(5), *kw4(), np.linspace(2.0, 38.0, 15) * u.h, 40.0)
    quaternion = fullbody.frames.rotation("ecliptic", "equatorial")

    def rotated(mass, a):
        """The same system and state along the axes of the equator."""
        system, state = kw4(mass=mass, a=a)
        matrices = Rotation.from_matrix(quaternion @ state.rotation_matrix)
        vectors = {name: np.asarray(getattr(state, name)) @ quaternion.T for name in ("position", "velocity")}
        state = fullbody.State.from_scipy(rotation=matrices, spin=np.asarray(state.spin), **vectors)
        return system.with_options(frame="equatorial"), state

    item, other = (fullbody.fit(setup, START, radar, integrator=QUICK) for setup in (kw4, rotated))
    assert other.chi2 == pytest.approx(item.chi2, rel=1e-8)
    for name in START:
        assert abs(other.values[name] - item.values[name]) < 1e-3 * item.sigma[name]
        assert other.sigma[name] == pytest.approx(item.sigma[name], rel=1e-5)


def test_a_prior_on_what_the_data_do_not_touch_comes_back(radar):
    def setup(mass, a, colour):
        return pair(mass=mass, a=a)

    start = {"mass": 2.36, "a": 2.545, "colour": Free(0.3, prior=(0.5, 0.02))}
    with_prior = fullbody.fit(setup, start, radar)
    assert with_prior.values["colour"] == pytest.approx(0.5, abs=1e-6)
    assert with_prior.sigma["colour"] == pytest.approx(0.02, rel=1e-9)
    without = fullbody.fit(pair, START, radar)
    assert with_prior.dof == without.dof
    assert with_prior.chi2 == pytest.approx(without.chi2, rel=1e-7)
    # A prior on what they do touch is the weighted mean, for one parameter.
    alone = fullbody.fit(lambda a: pair(a=a), {"a": 2.55}, radar)
    mean, sigma = alone.values["a"] + 2 * alone.sigma["a"], alone.sigma["a"]
    combined = fullbody.fit(lambda a: pair(a=a), {"a": Free(2.55, prior=(mean, sigma))}, radar)
    assert combined.values["a"] == pytest.approx(alone.values["a"] + alone.sigma["a"], abs=1e-2 * sigma)
    assert combined.sigma["a"] == pytest.approx(sigma / np.sqrt(2), rel=1e-2)
    # The mean is one error from each of the two, and a prior counts as one more number of the data.
    assert combined.chi2 == pytest.approx(alone.chi2 + 2.0, abs=0.02)
    assert combined.dof == alone.dof + 1


def test_an_unconstrained_combination_is_named(radar):
    def setup(mass, a, more):
        return pair(mass=mass + 2 * more, a=a)

    with pytest.warns(InconsistentInput, match="the data do not constrain (mass|more)"):
        result = fullbody.fit(setup, {"mass": 2.36, "a": 2.545, "more": 0.01}, radar)
    assert result.condition > 1e8
    # A change of mass by -2 is one of more by 1.
    assert {"mass", "more"} == {name for name, part in result.weakest.items() if abs(part) > 0.1}
    assert "mass" in result.unconstrained
    assert np.isinf(result.sigma["mass"])
    assert np.isinf(result.sigma["more"])
    assert 0.0 < result.sigma["a"] < 0.1
    assert not np.isnan(result.covariance).any()
    assert result.values["mass"] + 2 * result.values["more"] == pytest.approx(2.353, abs=0.05)
    refused("no distribution to draw from", lambda: result.draw(3, 0))

    with pytest.warns(InconsistentInput, match="the data do not constrain colour"):
        fullbody.fit(lambda a, colour: pair(a=a), {"a": 2.545, "colour": 1.0}, radar)


def limited(least, most):
    def setup(mass, a):
        if not least < mass < most:
            raise ValueError(f"mass is {mass}; expected one that the author likes")
        return pair(mass=mass, a=a)

    return setup


def test_refused_proposals_are_shortened_and_counted(radar, result):
    far = fullbody.fit(limited(2.2, 2.5), {"mass": 2.4, "a": 2.45}, radar)
    assert far.refused > 0
    assert "that the author likes" in far.last_refusal
    assert f"{far.refused} proposals refused" in repr(far)
    assert far.chi2 == pytest.approx(result.chi2, rel=1e-8)
    with pytest.raises(InvalidInput, match=r"start of the fit is refused.*that the author likes"):
        fullbody.fit(limited(2.2, 2.5), {"mass": 3.0, "a": 2.5}, radar)


def test_refused_proposals_are_not_taken_for_good_ones_where_residuals_are_large(radar, result):
    # The errors are ten thousand times smaller than the noise, so that the best pulls are of that size.
    columns = {"range": radar.range, "range_rate": radar.range_rate, "sigma": (2e-6, 1e-6)}
    data = observing.RadarAstrometry(radar.times, **columns, body=1, about=0, geometry=radar.geometry)
    far = fullbody.fit(limited(2.2, 2.5), {"mass": 2.4, "a": 2.45}, data)
    assert far.refused > 0
    assert far.chi2 == pytest.approx(1e8 * result.chi2, rel=1e-6)


def test_a_fit_that_cannot_reach_its_minimum_causes_a_warning(radar):
    with pytest.warns(InconsistentInput, match=r"errors away from .* refused: ValueError: mass is 2\.36"):
        held = fullbody.fit(limited(2.369, 2.5), {"mass": 2.4, "a": 2.5}, radar)
    assert "errors away" in repr(held)
    assert held.minima[0].message


def test_robust_losses_withstand_outliers(radar):
    wrong = np.array(radar.range)
    wrong[[3, 9]] += 1.0
    columns = {"range": wrong, "range_rate": radar.range_rate, "sigma": (0.02, 0.01)}
    data = observing.RadarAstrometry(radar.times, **columns, body=1, about=0, geometry=radar.geometry)
    start = {"mass": 2.353, "a": 2.55}
    shifts = {}
    for loss in ("linear", "cauchy", "huber", "soft_l1", "arctan", Outliers(0.1, 30.0)):
        result = fullbody.fit(pair, start, data, loss=loss)
        shifts[str(loss)] = max(abs(result.values[name] - TRUE[name]) / result.sigma[name] for name in start)
        if loss != "linear":
            assert result.p_value is None
            assert 0.0 < result.sigma["a"] < 0.1
    linear = shifts.pop("linear")
    assert linear > 5.0
    assert max(shifts.values()) < 4.0


def test_the_error_of_a_robust_estimate_is_that_of_an_m_estimator():
    # Huber's estimate of a mean has a variance that is larger than that of the mean by a known factor.
    values = 2.0 + np.random.default_rng(4).normal(size=20000)
    data = observing.Measured("masses", lambda run: np.full(len(values), run.system.masses[0]), values, 1.0, times=[])
    result = fullbody.fit(lambda mass: pair(mass=mass), {"mass": 2.1}, data, loss="huber")
    # Huber & Ronchetti (2009): the mean of psi^2 over the square of the mean of psi', psi being cut at one.
    inside = norm.cdf(1.0) - norm.cdf(-1.0)
    factor = (inside - 2.0 * norm.pdf(1.0) + 2.0 * norm.sf(1.0)) / inside**2
    assert factor == pytest.approx(1.107, abs=1e-3)
    assert result.sigma["mass"] == pytest.approx(np.sqrt(factor / len(values)), rel=0.015)


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy", "arctan", Outliers(0.1, 5.0)])
def test_losses_have_the_derivatives_that_they_state(loss):
    arguments, h = loss_of(loss), 1e-5
    pulls = np.sqrt([0.01, 0.5, 3.0, 20.0, 900.0])

    def difference(function):
        return (function(pulls * (1 + h)) - function(pulls * (1 - h))) / (2 * h * pulls)

    def psi(pulls):
        return np.prod(arguments.roots(pulls), axis=0)

    root, slope = arguments.roots(pulls)
    assert (root > 0).all()
    np.testing.assert_allclose(difference(lambda pulls: arguments.roots(pulls)[0]), slope, rtol=1e-7)
    # Beside zeros the inflation by one pull tells the derivative of psi there, which may be below zero.
    zeros = np.zeros(20)
    level = arguments.roots(zeros)[1] ** 2
    for pull, item, change in zip(pulls, psi(pulls), difference(psi), strict=True):
        steep = np.sqrt(item**2 / 21 / arguments.inflation(np.append(zeros, pull), 0))
        assert 21 * steep - level.sum() == pytest.approx(change, rel=1e-6, abs=1e-9)


def test_a_mixture_is_the_likelihood_of_two_normal_distributions():
    z = np.linspace(-12.0, 12.0, 25)
    density = 0.9 * norm.pdf(z) + 0.1 * norm.pdf(z, scale=7.0)
    rho = Outliers(0.1, 7.0)(z**2)[0]
    np.testing.assert_allclose(rho, -2 * np.log(density / density[12]), atol=1e-10)


def test_a_fitted_jitter_has_the_expected_value_and_error():
    system, state = kw4()
    times = np.linspace(1.0, 39.0, 60) * u.h
    rng = np.random.default_rng(8)
    exact = noisy(rng, system, state, times, 40.0)
    run = system.integrate(state, 40.0, output=exact.emission(system), integrator=QUICK)
    ranges = exact.predict(run).range + rng.normal(size=60) * 225 * u.m
    options = {"sigma": 75 * u.m, "body": "Beta", "about": "Alpha", "geometry": exact.geometry}
    data = observing.RadarAstrometry(times, range=ranges, **options)
    start = {"a": 2.55, "jitter": Free(100 * u.m, min=0 * u.m)}
    result = fullbody.fit(lambda a: kw4(a=a), start, [lambda jitter: data.with_jitter(jitter)], integrator=QUICK)
    assert result.values["jitter"].unit == u.m
    # All errors are alike: the total variance is the mean square, up to the one degree of freedom of a.
    total = np.hypot(result.values["jitter"].to_value("m"), 75.0)
    scatter = np.sqrt(np.mean(result.residuals[0].range.to_value("m") ** 2))
    assert total == pytest.approx(scatter, rel=1e-4)
    # That of a normal distribution's width is the width over the root of 2 n.
    error = total / np.sqrt(2 * 60) * total / result.values["jitter"].to_value("m")
    assert result.sigma["jitter"].to_value("m") == pytest.approx(error, rel=1e-3)
    assert list(result.draw(3, 0).columns) == ["a"]


def test_bounds_hold_and_are_named(radar):
    result = fullbody.fit(pair, {"mass": Free(2.45, min=2.40), "a": 2.545}, radar)
    assert result.values["mass"] >= 2.40
    assert result.at_bounds == ("mass",)
    assert "at its bound" in repr(result)


def test_log_posterior_is_chi2_and_its_gradient(radar, result):
    values = {"mass": 2.352, "a": 2.5505}
    system, state = pair(**values)
    run = system.integrate(state, 30.0, output=radar.emission(system))
    density, gradient = result.log_posterior(values, gradient=True)
    assert density == pytest.approx(-0.5 * radar.chi2(run), rel=1e-12)
    assert result.log_posterior([2.352, 2.5505]) == density
    for k, name in enumerate(values):
        expected = central_of_state(
            lambda by, name=name: result.log_posterior(values | {name: values[name] + by}), 1e-5
        )
        assert gradient[k] == pytest.approx(expected, rel=1e-6)
    assert result.log_posterior([-1.0, 2.55]) == -np.inf
    refused("values has no 'a'", lambda: result.log_posterior({"mass": 2.0}))


def test_draws_have_the_covariance_and_go_through_a_sweep(result):
    drawn = result.draw(20000, rng=1)
    rows = np.stack([drawn.columns[name] for name in result.names])
    np.testing.assert_allclose(np.cov(rows), result.covariance, rtol=0.05)
    few = result.draw(3, rng=1)
    swept = fullbody.sweep(pair, few, 5.0, measure=lambda run: {"end": run.elements().e[-1]}, output="ends")
    assert swept.sizes == {"row": 3}
    np.testing.assert_array_equal(swept.mass, few.columns["mass"])


def test_several_starts_lead_to_mirror_images(radar):
    # Range rates alone cannot tell a pole tilted ahead from one tilted back in a square of the angle.

    def setup(angle, a):
        return pair(a=a + 0.002 * (angle.to_value("rad") ** 2 - 1.0) ** 2)

    options = {"starts": 6, "rng": 3, "integrator": QUICK}
    start = {"angle": Free(0.5 * u.rad, min=-2 * u.rad, max=2 * u.rad), "a": Free(2.54, prior=(2.5495, 1e-4))}
    result = fullbody.fit(setup, start, radar, **options)
    assert sum(item.starts for item in result.minima) == 6
    angles = sorted(round(abs(item.values["angle"].value), 1) for item in result.minima)
    assert len(angles) >= 2
    assert {item.values["angle"].value > 0 for item in result.minima} == {True, False}
    chi2 = [item.chi2 for item in result.minima]
    assert chi2 == sorted(chi2)
    assert "Minima from 6 starts" in repr(result)
    refused("rng is None", lambda: fullbody.fit(setup, start, radar, starts=3))
    refused("no parameter has two bounds or a prior", lambda: fullbody.fit(pair, {"a": 2.5}, radar, starts=3, rng=1))


def test_progress_reports_runs_and_chi2(radar, capsys):
    result = fullbody.fit(pair, START, radar, progress="a pair")
    assert f"chi2 {result.chi2:.5f}"[:-3] in capsys.readouterr().err
    seen = []
    fullbody.fit(pair, {"a": 2.545}, radar, progress=lambda *report: seen.append(report))
    assert seen[-1][0] > 3
    assert {total for _, total, _ in seen} == {None}
    first, last = (float(seen[k][2].partition("chi2 ")[2]) for k in (0, -1))
    assert last < first


def test_samples_and_figures_have_the_values_of_the_fit(radar, result):
    pytest.importorskip("emcee")
    pytest.importorskip("corner")
    samples = result.sample(steps=20, walkers=8, rng=2)
    assert samples.sizes == {"chain": 8, "draw": 20}
    assert abs(float(samples.a.mean()) - result.values["a"]) < result.sigma["a"]
    again = result.sample(steps=5, walkers=8, rng=2)
    np.testing.assert_array_equal(samples.mass[:, :5], again.mass)
    assert len(result.plot.residuals()) == 1
    assert len(result.plot.corner(samples).axes) == 4
    refused("sampler is 'gibbs'", result.sample, "gibbs", rng=1)
