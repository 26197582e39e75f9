"""Ranges and range rates of bodies, and values of any function of a run."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from astropy.table import QTable
from fullbody import observing
from fullbody.errors import InconsistentInput
from support import refused
from support.displacements import by_start

DISTANCE = 3.0e7
TIMES = np.linspace(110.0, 130.0, 9)


@pytest.fixture(scope="module")
def run():
    """Two spheres on a circular orbit of radius 2.5 km, period 2 pi s / 1e-3, in the plane of the line of sight."""
    bodies = [fullbody.Body(fullbody.Sphere(0.1), mass=m, name=n) for m, n in ((3.0, "A"), (1.0, "B"))]
    system = fullbody.System(
        bodies, G=2.5**3 * 1e-6 / 4.0, gravity="point", units=("km", "s", "kg"), frame="equatorial"
    )
    position, velocity = np.outer([-0.25, 0.75], [2.5, 0, 0]), np.outer([-0.25, 0.75], [0, 2.5e-3, 0])
    return system.integrate(fullbody.State(position=position, velocity=velocity), 1000.0, dense=True)


@pytest.fixture(scope="module")
def geometry():
    """An observer who recedes along the x-axis at 10 km/s."""
    rows = np.linspace(0.0, 1100.0, 12)
    positions = np.stack([DISTANCE + 10.0 * rows, 0 * rows, 0 * rows], axis=1)
    return observing.Geometry(rows * u.s, to_observer=positions * u.km)


def test_ranges_are_those_of_a_circular_orbit(run, geometry):
    data = observing.RadarAstrometry(
        TIMES * u.s, range=np.zeros(9) * u.km, range_rate=np.zeros(9) * u.cm / u.s, sigma=(75 * u.m, 1 * u.cm / u.s),
        body="B", about="A", geometry=geometry,
    )  # fmt: skip
    result = data.predict(run)
    # Each body is seen as it was by its own distance earlier, 1e-5 s of difference; the rest is a small angle squared.
    delay = (DISTANCE + 10.0 * TIMES) / 299792.458
    angle = 1e-3 * (TIMES - delay)
    np.testing.assert_allclose(result.range.to_value("km"), -2.5 * np.cos(angle), atol=2e-7)
    # Rates are by the time of arrival, and light is 3.3e-5 later each second.
    expected = 2.5e-3 * np.sin(angle) * (1 - 10.0 / 299792.458)
    np.testing.assert_allclose(result.range_rate.to_value("km/s"), expected, atol=2e-9)
    assert result.range_rate.unit == u.cm / u.s
    chi2 = np.sum((result.range.to_value("m") / 75) ** 2) + np.sum(result.range_rate.to_value("cm/s") ** 2)
    assert data.chi2(run) == pytest.approx(chi2, rel=1e-9)


def test_range_rates_are_derivatives_of_the_ranges(run, geometry):
    step = 1.0
    moments = np.concatenate([[t - step, t, t + step] for t in TIMES])
    data = observing.RadarAstrometry(
        moments * u.s, range=np.zeros(27), range_rate=np.zeros(27), sigma=(1.0, 1.0), body="A", geometry=geometry
    )
    result = data.predict(run)
    earlier, _, later = result.range.to_value("km").reshape(9, 3).T
    rates = result.range_rate.to_value("km/s").reshape(9, 3)[:, 1]
    np.testing.assert_allclose(rates, (later - earlier) / (2 * step), rtol=1e-9)
    np.testing.assert_allclose(rates, 10.0, rtol=1e-3)


def test_partial_derivatives_are_differences(run, geometry):
    columns = {"range": [0.0], "range_rate": [0.0], "sigma": (1.0, 1.0), "body": "B", "about": "A"}
    for time in TIMES[::4]:
        # The rates between the rows of a geometry need more than one row.
        data = observing.RadarAstrometry([time] * u.s, **columns, geometry=geometry)
        moment = run(data.emission(run.system)[0])
        exact, differences = by_start(data, run.system, moment, {"position": 1.0, "velocity": 1e-2})
        for body in range(2):
            own = slice(12 * body, 12 * body + 6)
            np.testing.assert_allclose(exact[:, own], differences[:, own], atol=3e-7)


def test_rows_of_tables_are_sorted_and_missing_ones_left_out(run, geometry):
    table = QTable(
        {"times": [220.0, 200.0, 210.0] * u.s, "range": [3.0, 1.0, np.nan] * u.m, "sigma_range": [1.0, 2.0, 3.0] * u.m}
    )
    with pytest.warns(InconsistentInput, match="1 of 3 rows of RadarAstrometry"):
        data = observing.RadarAstrometry.from_table(table, body="B", about="A", geometry=geometry)
    assert data.range.to_value("m").tolist() == [1.0, 3.0]
    assert data.range_rate is None
    assert data.residuals(run).range_rate is None
    back = observing.RadarAstrometry.from_table(data.to_table(), body="B", about="A", geometry=geometry)
    np.testing.assert_array_equal(back.residuals(run).range, data.residuals(run).range)


def test_equal_and_unknown_bodies_are_refused(run, geometry):
    for about, message in (("B", "both B; expected two bodies"), ("C", "about of RadarAstrometry is 'C'")):
        data = observing.RadarAstrometry(
            [200.0] * u.s, range=[1.0], sigma=1.0, body="B", about=about, geometry=geometry
        )
        refused(message, data.predict, run)


def test_measured_values_are_compared_with_functions_of_a_run(run):
    period = observing.Measured(
        "period", lambda run: run.elements().period(run.system.mu()).mean(), 1.75 * u.h, 18 * u.s
    )
    expected = (1.75 * 3600 - 2 * np.pi * 1e3) / 18
    assert period.pulls(run)[0] == pytest.approx(expected, rel=1e-6)
    assert period.residuals(run).to_value("s")[0] == pytest.approx(expected * 18, rel=1e-6)
    assert period.chi2(run) == pytest.approx(expected**2, rel=1e-6)
    pair = observing.Measured("spin of A", lambda run: run.spin[-1, 0].value, [0.0, 0.0, 1.0], [1.0, 1.0, 0.5])
    np.testing.assert_allclose(pair.pulls(run), [0.0, 0.0, 2.0])


@pytest.mark.parametrize(
    ("function", "value", "sigma", "message"),
    [
        (3.0, 1.0, 1.0, "expected a function"),
        (lambda run: 1.0, np.nan, 1.0, "expected finite numbers"),
        (lambda run: 1.0, 1.0, 0.0, "above zero"),
        (lambda run: 1.0, 1.0, 1.0 * u.s, "expected a plain number"),
        (lambda run: 1.0, 1.0 * u.s, 1.0 * u.s, "expected a unit such as s"),
        (lambda run: np.nan, 1.0, 1.0, "expected finite numbers"),
        (lambda run: [1.0, 2.0], 1.0, 1.0, r"gave shape \(2,\)"),
        (lambda run: 1.0 * u.km, 1.0 * u.s, 1.0 * u.s, "has the unit km"),
    ],
)
def test_bad_measurements_are_refused(run, function, value, sigma, message):
    refused(message, lambda: observing.Measured("period", function, value, sigma).residuals(run))
