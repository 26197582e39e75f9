"""Scans of sidereal periods on simulated light curves of known rotation."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody.errors import InconsistentInput, Interrupted
from fullbody.fitting import period_scan
from support import refused
from support.rotators import TRUE, geometry, light_curves, nights, setup

RNG = np.random.default_rng(2)
DAYS = nights(24, 6.0, RNG, points=12)
DATA = light_curves(*setup(**TRUE), DAYS, 0.01, RNG)
FEW = light_curves(*setup(**TRUE), DAYS[:100], 0.01, RNG)
RANGE = [8.385, 8.415] * u.h
OPTIONS = {"poles": 6, "degree": 2}


@pytest.fixture(scope="module")
def scan():
    return period_scan(DATA, RANGE, **OPTIONS)


def test_the_lowest_minimum_is_at_the_true_period(scan):
    spacing = 8.4**2 / (np.ptp(DAYS) * 24.0)
    assert abs(scan.minima[0].period - TRUE["period"]) < 0.05 * spacing * u.h
    assert scan.minima[1].chi2 > scan.minima[0].chi2 + 20.0
    # Light with errors of the stated size leaves as much chi2 as there are degrees of freedom.
    assert abs(scan.minima[0].chi2 - scan.dof) < 5.0 * np.sqrt(2.0 * scan.dof)


def test_steps_are_a_quarter_of_the_distance_of_aliases(scan):
    frequency = 1.0 / scan.periods.to_value("h")
    steps = -np.diff(frequency) * np.ptp(DAYS) * 24.0
    assert steps.min() > 0.2
    assert steps.max() <= 0.25 * (1.0 + 1e-6)
    assert scan.periods[[0, -1]].to_value("h") == pytest.approx(RANGE.value)


def test_the_best_pole_is_next_to_the_true_one_or_its_mirror(scan):
    best = scan.minima[0]
    mirror = TRUE["longitude"] - 180 * u.deg
    poles = [fullbody.frames.pole_vector(lon, TRUE["latitude"]) for lon in (TRUE["longitude"], mirror)]
    result = fullbody.frames.pole_vector(best.longitude, best.latitude)
    assert max(result @ pole for pole in poles) > np.cos(np.radians(25.0))


def test_minima_are_lower_than_their_neighbours(scan):
    chi2 = np.concatenate([[np.inf], scan.chi2, [np.inf]])
    lowest = sorted(b for a, b, c in zip(chi2, chi2[1:], chi2[2:], strict=False) if b < a and b <= c)
    assert [minimum.chi2 for minimum in scan.minima] == lowest
    poles = scan.poles_at(scan.periods[scan.chi2.argmin()])
    assert [minimum.chi2 for minimum in poles] == sorted(scan.by_pole[scan.chi2.argmin()])
    assert poles[0] == scan.minima[0]


def test_light_of_a_known_convex_series_is_fitted_without_residual():
    longitude, latitude = (angle[0] for angle in fullbody.fitting.pole_grid(3))
    # Another rule over the sphere, by the trapezoid rule in angles, and a period in radians per hour.
    theta, phi = np.meshgrid((np.arange(100) + 0.5) * np.pi / 100, np.arange(200) * np.pi / 100, indexing="ij")
    normals = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1).reshape(
        -1, 3
    )
    x, y, z = normals.T
    area = (1.0 + 0.3 * x * y - 0.2 * (3 * z * z - 1) + 0.1 * x * z + 0.1 * y) * np.sin(theta).ravel()
    view = geometry(DAYS)
    attitude = fullbody.frames.attitude(longitude, latitude)
    axes = fullbody.base.rotations.matrices(attitude)
    light = []
    distance = np.linalg.norm(view.to_observer(DATA.times).to_value("km"), axis=1) / 299792.458 / 3600.0
    for k, hours in enumerate(DAYS * 24.0 - distance):
        angle = 2.0 * np.pi * hours / 8.4
        quaternion = axes @ [[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]]
        vectors = (view.to_observer(DATA.times[k]).value, view.to_sun(DATA.times[k]).value)
        mu, mu0 = (np.maximum(normals @ (vector @ quaternion) / np.linalg.norm(vector), 0.0) for vector in vectors)
        light.append(np.sum(area * mu * mu0 / np.maximum(mu + mu0, 1e-12)))
    data = fullbody.observing.Photometry(DATA.times, -2.5 * np.log10(light), 1e-3, geometry=view)
    result = period_scan(data, [8.4, 8.4001, 8.4002] * u.h, poles=3, degree=2, smoothness=1e3)
    assert result.by_pole[0, 0] < 1.0
    assert result.fitted[0, 0].value == pytest.approx(8.4, abs=1e-6)
    assert result.longitude[0, 0].value == pytest.approx(longitude.value, abs=0.1)
    assert result.latitude[0, 0].value == pytest.approx(latitude.value, abs=0.1)


def test_an_interrupted_scan_continues_from_its_store(tmp_path, scan):
    store = tmp_path / "scan.npz"

    def interrupt(done, total, description):
        if done > 0.4 * total:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted, match="scan of periods"):
        period_scan(DATA, RANGE, **OPTIONS, store=store, progress=interrupt)
    done = []
    again = period_scan(DATA, RANGE, **OPTIONS, store=store, progress=lambda now, total, _: done.append(now / total))
    assert min(done) > 0.3
    np.testing.assert_array_equal(again.by_pole, scan.by_pole)


def test_a_store_of_another_scan_is_refused(tmp_path):
    store = tmp_path / "scan.npz"
    period_scan(DATA, [8.4, 8.401] * u.h, poles=1, degree=1, store=store)
    refused("other data or with other arguments", period_scan, DATA, [8.4, 8.402] * u.h, poles=1, degree=1, store=store)


def test_sets_of_data_have_their_own_zero_points(scan):
    # Nights have twelve magnitudes each.
    first = np.arange(len(DAYS)) < 12 * 11
    parts = [
        fullbody.observing.Photometry(
            DATA.times[rows], DATA.magnitude[rows] + offset, 0.01, geometry=geometry(DAYS[rows])
        )
        for rows, offset in ((first, 3.0), (~first, -2.0))
    ]
    lowest = int(np.argmin(scan.chi2))
    result = period_scan(parts, scan.periods[lowest - 2 : lowest + 3], **OPTIONS)
    assert result.minima[0].chi2 == pytest.approx(scan.minima[0].chi2, rel=0.01)


@pytest.mark.parametrize(
    ("periods", "match"),
    [
        ([8.4, 8.40001] * u.h, "two steps"),
        ([0.0, 8.4] * u.h, "above zero"),
        ([1e-3, 1e3] * u.h, "at most"),
        ([8.4, 8.4, 8.5] * u.h, "different"),
        ([8.4, 8.5], "a Quantity"),
    ],
)
def test_ranges_without_a_scan_are_refused(periods, match):
    refused(match, period_scan, DATA, periods, **OPTIONS)


def test_data_without_a_span_of_time_are_refused():
    data = fullbody.observing.Photometry(DATA.times[:1], [10.0], 0.01, geometry=geometry(DAYS[:1]))
    refused("no span of time", period_scan, data, RANGE)


def test_more_unknowns_than_data_are_refused():
    refused("coefficients of degree 12", period_scan, FEW, RANGE, degree=12)


def test_a_series_in_the_rotation_angle_is_refused():
    series = fullbody.observing.RotationSeries("Alone", 2)
    data = fullbody.observing.Photometry(DATA.times, DATA.magnitude, 0.01, geometry=geometry(DAYS), rotation=series)
    refused("RotationSeries", period_scan, data, RANGE)


def test_coarse_periods_cause_a_warning():
    with pytest.warns(InconsistentInput, match="may be missed") as caught:
        period_scan(DATA, [8.3, 8.4, 8.5] * u.h, poles=1, degree=1)
    # The warning is that of the line which called the scan.
    assert caught[0].filename == __file__


def test_the_plot_marks_the_minimum(scan):
    ax = scan.plot()
    line, mark = ax.get_lines()
    assert mark.get_xdata()[0] == scan.minima[0].period.value
    assert abs(mark.get_xdata()[0] - scan.periods[scan.chi2.argmin()].value) < 1e-3
    assert line.get_ydata().min() == pytest.approx(mark.get_ydata()[0])
    assert ax.get_xlabel() == "sidereal period [h]"


def test_the_table_has_a_row_for_each_period(scan):
    table = scan.to_table()
    assert len(table) == len(scan.periods)
    assert table["chi2"].min() == scan.minima[0].chi2
