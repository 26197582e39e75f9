"""Observations with a further error of all rows: their covariances, and how much wider these are."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fits import kw4, view
from fullbody import observing


def wider(data, system, jitter):
    """The covariance that a jitter has to give, and the logarithm of the ratio of the determinants."""
    covariance = data._covariance(system)
    expected = covariance + np.diag(np.broadcast_to(np.square(jitter), covariance.shape[-1]))
    return expected, np.log(np.linalg.det(expected) / np.linalg.det(covariance))


@pytest.mark.parametrize("kind", ["Astrometry", "Radar", "Photometry"])
def test_jitter_adds_to_the_variances(kind):
    system, _ = kw4()
    times, zero = [1.0, 2.0, 3.0] * u.h, np.zeros(3)
    places = {"body": "Beta", "about": "Alpha", "geometry": view(10.0, sun=True)}
    if kind == "Astrometry":
        sigma = [[1.0, 2.0], [3.0, 1.0], [1.0, 1.0]] * u.mas
        data = observing.Astrometry(times, zero * u.mas, zero * u.mas, sigma, [0.5, -0.9, 0.0], **places)
        jitter, plain = 2 * u.mas, (2 * u.mas).to_value("rad")
    elif kind == "Radar":
        columns = {"range": zero * u.km, "range_rate": zero * u.km / u.s, "sigma": (75 * u.m, 1 * u.cm / u.s)}
        data = observing.Radar(times, **columns, **places)
        jitter, plain = (30 * u.m, 2 * u.cm / u.s), [0.03, 2e-5 * 3600]
    else:
        data = observing.Photometry(times, zero, [0.01, 0.02, 0.03], geometry=places["geometry"])
        jitter, plain = 0.015, 0.015
    with_jitter = data.with_jitter(jitter)
    covariance, widening = wider(data, system, plain)
    np.testing.assert_allclose(with_jitter._covariance(system), covariance, rtol=1e-12, atol=0)
    np.testing.assert_allclose(with_jitter.widening(system).sum(axis=1), widening, rtol=1e-9)
    assert not data.widening(system).any()
    # A second jitter adds to the first, and counts from the same errors.
    again = with_jitter.with_jitter(jitter)
    doubled, widening = wider(data, system, np.sqrt(2) * np.array(plain))
    np.testing.assert_allclose(again._covariance(system), doubled, rtol=1e-12, atol=0)
    np.testing.assert_allclose(again.widening(system).sum(axis=1), widening, rtol=1e-9)


def test_bad_jitter_is_refused():
    options = {"body": "Beta", "about": "Alpha", "geometry": view(10.0)}
    zero = [0.0] * u.km
    data = observing.Radar([1.0] * u.h, range=zero, sigma=75 * u.m, **options)
    with pytest.raises(fullbody.InvalidInput, match="zero or above"):
        data.with_jitter(-1 * u.m)
    with pytest.raises(fullbody.InvalidInput, match="jitter"):
        data.with_jitter(1 * u.s)
    both = {"range": zero, "range_rate": zero / u.s, "sigma": (75 * u.m, 1 * u.cm / u.s)}
    with pytest.raises(fullbody.InvalidInput, match="jitter is not a pair"):
        observing.Radar([1.0] * u.h, **both, **options).with_jitter(1 * u.m)
