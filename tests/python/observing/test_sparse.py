"""Sparse photometry in several filters: each filter has one zero point, in one data set or in several."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from astropy.table import QTable
from astropy.time import Time
from fullbody import observing
from fullbody.fitting import Free
from support import refused

ZERO_POINTS = {"R": 7.5, "V": 8.0}


def lone(period):
    """An ellipsoid alone that rotates about its z-axis with a period in hours."""
    body = fullbody.Body(fullbody.Ellipsoid("30 km", "20 km", "15 km"), density="2 g/cm3", name="A")
    system = fullbody.System([body], units=True, epoch="2020-01-01 TDB", frame="ecliptic")
    zeros = np.zeros((1, 3))
    return system, fullbody.State(
        zeros * u.km, zeros * u.km / u.h, spin=[[0.0, 0.0, 2.0 * np.pi / period]] * u.rad / u.h
    )


@pytest.fixture(scope="module")
def table():
    rng = np.random.default_rng(1)
    times = Time("2020-01-01", scale="tdb") + np.sort(rng.uniform(1.0, 90.0, 60)) * u.h
    view = {"to_observer": [2.0, 0.2, 0.1] * u.au, "to_sun": [2.5, 1.0, 0.3] * u.au, "frame": "ecliptic"}
    geometry = observing.Geometry(Time(["2020-01-01", "2020-01-05"], scale="tdb"), **view, light_time=False)
    system, state = lone(6.0)
    magnitude = observing.light_curve(system.integrate(state, "100 h", dense=True), times, geometry)
    band = np.where(np.arange(60) % 3 == 0, "V", "R")
    magnitude += [ZERO_POINTS[name] for name in band] + 0.01 * rng.normal(size=60)
    return QTable({"times": times, "magnitude": magnitude, "sigma": np.full(60, 0.01), "band": band}), geometry


def test_a_filter_has_one_zero_point_in_one_data_set_and_in_several(table):
    rows, geometry = table
    together = observing.Photometry.from_table(rows, filter="band", geometry=geometry)
    parts = [
        observing.Photometry.from_table(rows[part], filter="band", geometry=geometry)
        for part in (slice(40), slice(40, None))
    ]
    fits = [fullbody.fit(lone, {"period": Free(6.0005)}, data) for data in ([together], parts)]
    assert list(fits[1].values) == ["period", "zero point of R", "zero point of V"]
    results = np.array([[fit.values[name] for name in fits[1].values] for fit in fits])
    assert np.allclose(results[0], results[1], rtol=1e-9)
    # Three times the standard errors 0.00045 h, 0.0016 mag and 0.0024 mag.
    assert (np.abs(results[0] - [6.0, 7.5, 8.0]) < [0.0014, 0.0048, 0.0072]).all()
    system, state = lone(results[0, 0])
    run = system.integrate(state, "100 h", dense=True)
    assert together.filters.tolist() == ["R", "V"]
    assert np.allclose(together.zero_points(run), results[0, 1:], rtol=1e-6)
    assert together.to_table()["filter"].tolist() == rows["band"].tolist()


def test_filters_are_one_label_for_each_row_or_none(table):
    rows, geometry = table

    def photometry(filters):
        return observing.Photometry(rows["times"], rows["magnitude"], 0.01, geometry=geometry, filter=filters)

    refused(r"filter has shape \(3,\); expected \(60,\)", photometry, ["V", "R", "I"])
    refused("labels of several kinds", photometry, np.array([1, "V"] * 30, dtype=object))
    refused("filter has no label in row 1", photometry, ["V", np.nan] * 30)
    refused("filter has no label in row 0", photometry, np.ma.array(["V"] * 60, mask=[True] + [False] * 59))
    assert photometry([None] * 60).filters is None
    masked = rows.copy()
    masked["band"] = np.ma.array(rows["band"], mask=np.arange(60) == 3)
    refused("filter has no label in row 3", observing.Photometry.from_table, masked, filter="band", geometry=geometry)


def test_a_night_and_a_filter_of_one_name_have_two_zero_points(table):
    rows, geometry = table
    data = [
        observing.Photometry(rows["times"], rows["magnitude"], 0.01, geometry=geometry, **{kind: ["R"] * 60})
        for kind in ("filter", "night")
    ]
    names = list(fullbody.fit(lone, {"period": Free(6.0005)}, data).values)
    assert names == ["period", "zero point of R", "zero point of R of observations[1]"]
