"""Simulated observations of 1999 KW4 and Didymos: what was put in is found, with the errors that a fit states.

The suite fits a few realisations of the noise. ``FULLBODY_CLOSED_LOOP=200`` takes so many, of full length.
"""

import functools
import os

import astropy.units as u
import fullbody
import numpy as np
import pytest
from astropy.time import Time
from fits import QUICK, dimorphos, kw4, noisy
from fullbody import observing
from scipy.stats import chi2 as chi2_distribution
from scipy.stats import kstest

COUNT = int(os.environ.get("FULLBODY_CLOSED_LOOP", "0"))
FULL = COUNT > 0


def check(fits, truth):
    """Pulls of the parameters have mean 0 and standard deviation 1 within their errors; p-values are uniform."""
    count = len(fits)
    pulls = np.array([[(one.values[name] - truth[name]) / one.sigma[name] for name in truth] for one in fits])
    names = ", ".join(truth)
    print(f"\n{count} fits of {names}: means {pulls.mean(axis=0).round(3)}, deviations {pulls.std(axis=0).round(3)}")
    # Five errors of a mean, and of a standard deviation, of normal numbers.
    assert np.abs(pulls.mean(axis=0)).max() < 5 / np.sqrt(count)
    assert np.abs(pulls.std(axis=0) - 1.0).max() < 5 / np.sqrt(2 * count)
    # All parameters together, with their correlation: the scatter is that of the covariance.
    apart = np.array([[one.values[name] - truth[name] for name in truth] for one in fits])
    together = [row @ np.linalg.solve(one.covariance, row) for row, one in zip(apart, fits, strict=True)]
    distances = kstest(together, chi2_distribution(len(truth)).cdf)
    uniform = kstest([one.p_value for one in fits], "uniform")
    print(f"p of the distances in the covariance {distances.pvalue:.3f}, of the p-values {uniform.pvalue:.3f}")
    print(f"relative errors {', '.join(f'{name} {fits[0].sigma[name]:.2g}' for name in truth)}")
    assert distances.pvalue > 1e-3
    assert uniform.pvalue > 1e-3


def test_radar_of_1999_kw4_gives_masses_axis_and_pole():
    """Ranges to 75 m and range rates to 1 cm/s over two weeks, every half hour."""
    truth = {"mass": 2.353, "ratio": 0.0574, "a": 2.55, "c": 0.6735, "tilt": 0.05, "roll": 0.02}
    if not FULL:
        # The shape and the pole turn the orbit slowly.
        truth = {name: truth[name] for name in ("mass", "a")}
    hours = 336.0 if FULL else 30.0
    times = np.linspace(1.0, hours - 1.0, 600 if FULL else 20) * u.h
    rng, (system, state) = np.random.default_rng(1), kw4(**truth)
    fits = []
    for _ in range(COUNT or 8):
        # What Alpha does about the barycentre tells the ratio of the masses.
        data = [noisy(rng, system, state, times, hours, **places) for places in ({}, {"body": "Alpha"})]
        fits.append(fullbody.fit(kw4, truth, data, integrator=QUICK))
    check(fits, truth)


@functools.cache
def sky(epoch, days):
    orbit = fullbody.KeplerElements(1.6442 * u.au, 0.3837, *(x * u.deg for x in (3.408, 73.196, 319.319, 225.0)))
    span = Time([epoch - 1 * u.day, epoch + (days + 1) * u.day])
    return observing.Geometry.from_orbit(orbit, "2022-01-21 TDB", span=span)


def test_light_curves_of_didymos_give_shape_and_pole_of_dimorphos():
    """Nights of 0.01 mag in the geometry of 2022, with occultations and eclipses."""
    truth = {"b": 0.87, "c": 0.66, "longitude": 310.0, "latitude": -80.0, "period": 11.92, "phase": 0.4}
    if not FULL:
        truth = {name: truth[name] for name in ("b", "latitude", "phase")}
    epoch, nights, points = Time("2022-10-01", scale="tdb"), 12 if FULL else 2, 25
    setup = functools.partial(dimorphos, epoch=epoch)
    hours = np.concatenate([night * 24.0 * 2.3 + np.linspace(0.5, 7.5, points) for night in range(nights)])
    times = epoch + hours * u.h + 300 * u.s
    geometry = sky(epoch, 2.3 * nights + 1.0)
    blank = observing.Photometry(times, 0.0 * hours, 0.01, geometry=geometry)
    system, state = setup(**truth)
    exact = blank.predict(system.integrate(state, hours[-1] + 1.0, blank.emission(system), QUICK))
    rng = np.random.default_rng(2)
    fits = []
    for _ in range(COUNT or 4):
        data = observing.Photometry(times, exact + 0.01 * rng.normal(size=len(hours)), 0.01, geometry=geometry)
        fits.append(fullbody.fit(setup, truth, data, integrator=QUICK))
    assert fits[0].dof == len(hours) - len(truth) - nights
    check(fits, truth)


@pytest.mark.parametrize("seed", [1])
def test_points_give_pulls_and_p_values_of_their_distributions(seed):
    """Sixty realisations of two points, for which a run takes a millisecond; the scatter is the covariance."""
    from test_fit import VIEW, pair

    rng, (system, state) = np.random.default_rng(seed), pair()
    options = {"sigma": (0.02, 0.01), "body": 1, "about": 0, "geometry": VIEW}
    times, zero, truth = np.linspace(2.0, 30.0, 15), np.zeros(15), {"mass": 2.353, "a": 2.55}
    exact = observing.Radar(times, range=zero, range_rate=zero, **options).predict(system.integrate(state, 30.0, times))
    fits = []
    for _ in range(max(60, COUNT)):
        noise = rng.normal(size=(2, 15)) * [[0.02], [0.01]]
        columns = {"range": exact.range + noise[0], "range_rate": exact.range_rate + noise[1]}
        fits.append(fullbody.fit(pair, truth, observing.Radar(times, **columns, **options), integrator=QUICK))
    check(fits, truth)
    scatter = np.cov([[one.values[name] for one in fits] for name in truth])
    # Elements of a covariance from 60 draws are known to a fifth.
    np.testing.assert_allclose(scatter, fits[0].covariance, rtol=5 * np.sqrt(2 / len(fits)))
