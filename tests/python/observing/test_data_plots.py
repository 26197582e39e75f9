"""Pictures of data with the predictions of a run and the residuals."""

import astropy.units as u
import fullbody
import matplotlib
import numpy as np
import pytest
from fullbody import observing

TIMES = np.linspace(1.0, 11.0, 7) * u.h
ZERO = np.zeros(7)


@pytest.fixture(scope="module")
def run():
    system, state = fullbody.systems.didymos(units=True, frame="ecliptic")
    return system.integrate(state, 12.0, dense=True)


@pytest.fixture(scope="module")
def geometry():
    vectors = {"to_observer": [0.1, 0.02, 0.0] * u.au, "to_sun": [0.9, 0.5, 0.0] * u.au}
    return observing.Geometry([0.0, 12.0] * u.h, **vectors)


def drawn(ax):
    """The heights of the points with error bars."""
    return ax.containers[0][0].get_ydata()


def check(data, run, residuals, names):
    axes = data.plot(run)
    assert axes.shape == (2, len(names))
    for k, (name, column) in enumerate(zip(names, residuals, strict=True)):
        assert axes[0, k].get_ylabel() == name
        np.testing.assert_allclose(drawn(axes[1, k]), column, rtol=1e-12, atol=1e-12 * np.abs(column).max())
        predicted = axes[0, k].lines[0].get_ydata()
        np.testing.assert_allclose(drawn(axes[0, k]) - predicted, column, rtol=1e-9, atol=1e-12)
    matplotlib.pyplot.close("all")


def test_all_data_are_drawn_over_their_predictions_with_residuals_below(run, geometry):
    offsets = observing.Astrometry(TIMES, ZERO * u.mas, ZERO * u.mas, 1 * u.mas, geometry=geometry)
    check(offsets, run, offsets.residuals(run).value.T, ["east [mas]", "north [mas]"])
    errors = 75 * u.m, 1 * u.mm / u.s
    radar = observing.RadarAstrometry(
        TIMES, range=ZERO * u.km, range_rate=ZERO * u.m / u.s, sigma=errors, geometry=geometry
    )
    left = radar.residuals(run)
    check(radar, run, [left.range.value, left.range_rate.value], ["range [km]", "range rate [m s⁻¹]"])
    light = observing.Photometry(TIMES, 14.0 + 0.01 * np.arange(7), 0.01, geometry=geometry)
    check(light, run, [light.residuals(run)], ["magnitude"])
    rate = observing.Measured("rate", lambda run: 2.0, 3.0, 0.1)
    check(rate, run, [[1.0]], ["rate"])


def test_magnitudes_decrease_upwards_and_dates_are_those_of_the_data(run, geometry):
    dates = run.system.epoch + TIMES
    view = observing.Geometry(dates[[0, -1]], to_observer=[0.1, 0.02, 0.0] * u.au, to_sun=[0.9, 0.5, 0.0] * u.au)
    light = observing.Photometry(dates, 14.0 + 0.01 * np.arange(7), 0.01, geometry=view)
    axes = light.plot(run, color="r")
    assert axes[0, 0].yaxis_inverted()
    assert axes[1, 0].yaxis_inverted()
    shown = axes[0, 0].lines[0].get_xdata()
    assert abs((shown[3] - dates[3].utc.to_datetime()).total_seconds()) < 1e-3
    assert axes[1, 0].get_xlabel() == "date, UTC"
    matplotlib.pyplot.close("all")


def test_spectra_and_images_are_drawn_by_their_bins_with_residuals():
    system, state = fullbody.systems.kw4(units=True)
    run = system.integrate(state, "8 h", dense=True)
    view = observing.Geometry([0.0, 24.0] * u.h, to_observer=[0.05, 0.0, 0.0] * u.au)
    times, bins, delays = [3.0, 6.0] * u.h, np.linspace(-12, 12, 13) * u.Hz, np.linspace(-20, 20, 6) * u.us
    radar = {"transmit_frequency": 2380 * u.MHz}
    noise = np.random.default_rng(1)
    power = observing.radar_spectrum(run, times, view, bins, **radar).power
    sigma = 0.1 * power.max()
    observed = power + noise.normal(size=power.shape) * sigma
    data = observing.RadarSpectrum(times, observed, sigma, frequencies=bins, geometry=view, **radar)
    axes = data.plot(run)
    assert axes.shape == (2, 2)
    for k in range(2):
        np.testing.assert_allclose(drawn(axes[0, k]), observed[k].value, rtol=1e-9)
        np.testing.assert_allclose(drawn(axes[1, k]), (observed - power)[k].value, atol=1e-9 * sigma.value)
        np.testing.assert_allclose(axes[0, k].patches[0].get_data().values, power[k].value, rtol=1e-9)
    assert axes[1, 0].get_xlabel() == "frequency [Hz]"
    power = observing.delay_doppler(run, times, view, delays, bins, **radar).power
    sigma = 0.1 * power.max()
    observed = power + noise.normal(size=power.shape) * sigma
    data = observing.DelayDoppler(times, observed, sigma, delays=delays, frequencies=bins, geometry=view, **radar)
    axes = data.plot(run)
    assert axes.shape == (3, 2)
    for k in range(2):
        shown = [ax.collections[0].get_array() for ax in axes[:, k]]
        np.testing.assert_allclose(shown[0], observed[k].value, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(shown[1], power[k].value, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(shown[2], ((observed - power)[k] / sigma).value, atol=1e-9)
    # The nearest surface is at the top.
    assert axes[0, 0].get_ylim() == (20.0, -20.0)
    matplotlib.pyplot.close("all")


def test_contacts_of_a_star_are_drawn_with_their_residuals():
    system, state = fullbody.systems.didymos(units=True)
    system = system.with_options(frame="ecliptic")
    run = system.integrate(state, "10 min", dense=True)
    path = {"to_observer": [[1e7, -2.0, 0.0], [1e7, 4.0, 0.0]] * u.km, "frame": "ecliptic"}
    view, star = observing.Geometry([0.0, 300.0] * u.s, **path), [-1.0, 0.0, 0.0]
    stations = [[0.0, 0.0, 0.1], [0.0, 0.0, -0.2]] * u.km
    seen = {"disappearance": [80.0, 80.0] * u.s, "reappearance": [118.0, 117.0] * u.s}
    options = {"star": star, "stations": stations, "geometry": view, "body": "Didymos"}
    data = observing.StellarOccultation(**seen, sigma=0.1 * u.s, **options)
    axes = data.plot(run)
    np.testing.assert_allclose(drawn(axes[1, 0]), data.residuals(run).to_value("h"), rtol=1e-9)
    assert axes[0, 0].get_ylabel().startswith("time of contact")
    matplotlib.pyplot.close("all")
