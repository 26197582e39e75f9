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


def test_magnitudes_decrease_upwards_and_dates_are_those_of_the_data(run):
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
