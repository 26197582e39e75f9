"""Fits of bodies alone: rotation over decades, the change of its rate by sunlight, and the mirror pole."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from support.rotators import TRUE, light_curves, nights, setup


def test_a_fit_over_decades_recovers_the_rotation():
    rng = np.random.default_rng(3)
    data = light_curves(*setup(**TRUE), nights(16, 40.0, rng), 0.01, rng)
    start = TRUE | {"longitude": 268 * u.deg, "period": 8.400601 * u.h}
    fit = fullbody.fit(setup, start, data)
    for name, true in TRUE.items():
        assert abs(fit.values[name] - true) < 3.5 * fit.sigma[name]
    assert fit.sigma["period"] < 1e-6 * u.h
    assert not fit.differenced


def test_a_fit_recovers_the_change_of_the_rate_by_sunlight():
    rng = np.random.default_rng(5)
    true = TRUE | {"acceleration": 1e-8 * u.rad / u.day**2}
    data = light_curves(*setup(**true), nights(16, 40.0, rng), 0.01, rng)
    limit = 3e-8 * u.rad / u.day**2
    fit = fullbody.fit(setup, true | {"acceleration": fullbody.fitting.Free(0.0 * limit, min=-limit, max=limit)}, data)
    error = fit.sigma["acceleration"]
    assert abs(fit.values["acceleration"] - true["acceleration"]) < 3.0 * error
    assert error < 0.1 * true["acceleration"]
    without = fullbody.fit(setup, TRUE, data)
    assert without.chi2 > fit.chi2 + 25.0


def test_the_error_of_the_change_of_the_rate_is_that_of_many_draws():
    pulls = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        true = TRUE | {"acceleration": 1e-8 * u.rad / u.day**2}
        data = light_curves(*setup(**true), nights(8, 30.0, rng, points=12), 0.02, rng)
        fit = fullbody.fit(setup, true, data)
        pulls.append((fit.values["acceleration"] - true["acceleration"]) / fit.sigma["acceleration"])
    spread = np.sum(np.square(pulls))
    # These are the quantiles 0.001 and 0.999 of chi2 with 8 degrees of freedom.
    assert 0.857 < spread < 26.1


def test_the_mirror_pole_is_among_the_minima():
    rng = np.random.default_rng(7)
    data = light_curves(*setup(**TRUE), nights(10, 12.0, rng), 0.01, rng)
    fit = fullbody.fit(setup, TRUE, data)
    assert fit.starts == 2 == len(fit.minima)
    best, mirror = (minimum.values["longitude"].to_value("deg") for minimum in fit.minima)
    assert (mirror - best) % 360.0 == pytest.approx(180.0, abs=20.0)
    assert fit.minima[1].chi2 > fit.minima[0].chi2


def test_a_fit_from_both_poles_adds_no_start():
    rng = np.random.default_rng(7)
    data = light_curves(*setup(**TRUE), nights(10, 12.0, rng), 0.01, rng)
    starts = [TRUE, TRUE | {"longitude": 92 * u.deg}]
    assert fullbody.fit(setup, TRUE, data, starts=starts).starts == 2


def test_a_grid_of_poles_is_even():
    poles = fullbody.fitting.pole_grid(50)
    lon, lat = (angles.to_value("rad") for angles in poles)
    vectors = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=1)
    cosines = vectors @ vectors.T - 2.0 * np.eye(50)
    nearest = np.degrees(np.arccos(cosines.max(axis=1)))
    # A hexagonal grid of 50 cells of equal area has neighbours 31 degrees apart.
    assert nearest.min() > 20.0
    assert nearest.max() < 31.0
    assert np.linalg.norm(vectors.mean(axis=0)) < 0.02
