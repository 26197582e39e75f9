"""Jitter, an error that is added to those of all rows: its part in pulls, and in determinants of covariances."""

import astropy.units as u
import numpy as np
import pytest
from fullbody import observing
from fullbody.fitting.noise import log_determinant
from support.fits import kw4, view


def expected_with(jitter, covariance, residuals):
    """The sums of squared pulls of the rows, and the logarithms of the growth of the determinants by a jitter."""
    wider = covariance + np.diag(np.broadcast_to(np.square(jitter), covariance.shape[-1]))
    squares = np.einsum("ki,ki->k", residuals, np.linalg.solve(wider, residuals[..., None])[..., 0])
    return squares, np.log(np.linalg.det(wider) / np.linalg.det(covariance))


@pytest.mark.parametrize("kind", ["Astrometry", "RadarAstrometry", "Photometry"])
def test_jitter_adds_to_the_variances(kind):
    system, state = kw4()
    run = system.integrate(state, 4.0, dense=True)
    times = [1.0, 2.0, 3.0] * u.h
    options = {"body": "Beta", "about": "Alpha", "geometry": view(10.0, sun=True)}
    if kind == "Astrometry":
        sigma, correlation = np.array([[1.0, 2.0], [3.0, 1.0], [1.0, 1.0]]), np.array([0.5, -0.9, 0.0])
        data = observing.Astrometry(times, *np.zeros((2, 3)) * u.mas, sigma * u.mas, correlation, **options)
        jitter, number, residuals = 2 * u.mas, 2.0, data.residuals(run).to_value("mas")
        covariance = np.einsum("ki,kj->kij", sigma, sigma)
        covariance[:, [0, 1], [1, 0]] *= correlation[:, None]
    elif kind == "RadarAstrometry":
        columns = {"range": np.zeros(3) * u.km, "range_rate": np.zeros(3) * u.km / u.s}
        data = observing.RadarAstrometry(times, **columns, sigma=(75 * u.m, 1 * u.cm / u.s), **options)
        jitter, number, result = (30 * u.m, 2 * u.cm / u.s), [30.0, 2.0], data.residuals(run)
        residuals = np.stack([result.range.to_value("m"), result.range_rate.to_value("cm/s")], axis=1)
        covariance = np.repeat(np.diag([75.0**2, 1.0])[None], 3, axis=0)
    else:
        data = observing.Photometry(times, np.zeros(3), [0.01, 0.02, 0.03], geometry=options["geometry"], zero=0.0)
        jitter, number, residuals = 0.015, 0.015, data.residuals(run)[:, None]
        covariance = np.square([0.01, 0.02, 0.03])[:, None, None]
    assert log_determinant(data.errors(system)) == 0.0
    # The variances of two jitters add up, and the determinants are compared with those of no jitter.
    with_jitter = data
    for count in (1, 2):
        with_jitter = with_jitter.with_jitter(jitter)
        squares, log_ratios = expected_with(np.sqrt(count) * np.array(number), covariance, residuals)
        np.testing.assert_allclose((with_jitter.pulls(run) ** 2).sum(axis=1), squares, rtol=1e-9)
        assert log_determinant(with_jitter.errors(system)) == pytest.approx(log_ratios.sum(), rel=1e-9)
