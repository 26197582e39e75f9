"""Observations with a further error of all rows: their covariances, and how much wider these are."""

import astropy.units as u
import numpy as np
import pytest
from fullbody import observing
from fullbody.fitting.noise import log_determinant
from support.fits import kw4, view


def weighted(covariance, jitter, residuals):
    """The sums of squared pulls that a jitter has to give, and the logarithms of the ratios of the determinants."""
    wider = covariance + np.diag(np.broadcast_to(np.square(jitter), covariance.shape[-1]))
    squares = np.einsum("ki,ki->k", residuals, np.linalg.solve(wider, residuals[..., None])[..., 0])
    return squares, np.log(np.linalg.det(wider) / np.linalg.det(covariance))


@pytest.mark.parametrize("kind", ["Astrometry", "RadarAstrometry", "Photometry"])
def test_jitter_adds_to_the_variances(kind):
    system, state = kw4()
    run = system.integrate(state, 4.0, dense=True)
    times = [1.0, 2.0, 3.0] * u.h
    pair = {"body": "Beta", "about": "Alpha", "geometry": view(10.0, sun=True)}
    if kind == "Astrometry":
        sigma, correlation = np.array([[1.0, 2.0], [3.0, 1.0], [1.0, 1.0]]), np.array([0.5, -0.9, 0.0])
        data = observing.Astrometry(times, *np.zeros((2, 3)) * u.mas, sigma * u.mas, correlation, **pair)
        jitter, size, residuals = 2 * u.mas, 2.0, data.residuals(run).to_value("mas")
        covariance = np.einsum("ki,kj->kij", sigma, sigma)
        covariance[:, [0, 1], [1, 0]] *= correlation[:, None]
    elif kind == "RadarAstrometry":
        columns = {"range": np.zeros(3) * u.km, "range_rate": np.zeros(3) * u.km / u.s}
        data = observing.RadarAstrometry(times, **columns, sigma=(75 * u.m, 1 * u.cm / u.s), **pair)
        jitter, size, result = (30 * u.m, 2 * u.cm / u.s), [30.0, 2.0], data.residuals(run)
        residuals = np.stack([result.range.to_value("m"), result.range_rate.to_value("cm/s")], axis=1)
        covariance = np.repeat(np.diag([75.0**2, 1.0])[None], 3, axis=0)
    else:
        data = observing.Photometry(times, np.zeros(3), [0.01, 0.02, 0.03], geometry=pair["geometry"], zero=0.0)
        jitter, size, residuals = 0.015, 0.015, data.residuals(run)[:, None]
        covariance = np.square([0.01, 0.02, 0.03])[:, None, None]
    assert log_determinant(data.errors(system)) == 0.0
    # A second jitter adds to the first, and counts from the same errors.
    with_jitter = data
    for count in (1, 2):
        with_jitter = with_jitter.with_jitter(jitter)
        squares, widening = weighted(covariance, np.sqrt(count) * np.array(size), residuals)
        np.testing.assert_allclose((with_jitter.pulls(run) ** 2).sum(axis=1), squares, rtol=1e-9)
        assert log_determinant(with_jitter.errors(system)) == pytest.approx(widening.sum(), rel=1e-9)
