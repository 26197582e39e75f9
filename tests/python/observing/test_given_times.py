"""Times of observations as tables, Python, numpy and pandas have them."""

import datetime

import astropy.units as u
import fullbody
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from astropy.time import Time
from fullbody import observing
from fullbody.errors import InvalidInput
from support import refused

VIEW = {"to_observer": [0.1, 0.01, 0.02] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au}
GEOMETRY = observing.Geometry([0, 2000] * u.h, **VIEW)
TEXTS = ["2022-10-01T04:35:10.047", "2022-10-01T05:35:10.047"]
#: The Julian dates in UTC, by the Gregorian calendar: 2022-10-01T00:00 is 2459853.5.
EXPECTED = 2459853.5 + (np.array([4, 5]) * 3600 + 35 * 60 + 10.047) / 86400
FIVE_HOURS_EAST = datetime.timezone(datetime.timedelta(hours=5))
ROWS = {"magnitude": [14.1, 14.2], "sigma": [0.01, 0.01]}


def table(times):
    return pd.DataFrame({"times": times, **ROWS})


@pytest.mark.parametrize(
    "times",
    [
        Time(TEXTS, scale="utc"),
        [Time(text, scale="utc") for text in TEXTS],
        [f"{text} UTC" for text in TEXTS],
        [f"{text}Z" for text in TEXTS],
        pd.Series([f"{text.replace('T', ' ')} UTC" for text in TEXTS]),
        [Time(TEXTS[0], scale="utc"), f"{TEXTS[1]} UTC"],
        np.array(TEXTS, dtype="datetime64[ms]"),
        list(np.array(TEXTS, dtype="datetime64[ms]")),
        [datetime.datetime.fromisoformat(text) for text in TEXTS],
        [datetime.datetime.fromisoformat(f"{text}+00:00") for text in TEXTS],
        [datetime.datetime.fromisoformat(f"{text}+00:00").astimezone(FIVE_HOURS_EAST) for text in TEXTS],
        pd.DatetimeIndex(TEXTS),
        pd.Series(pd.DatetimeIndex(TEXTS)),
        pd.Series(pd.DatetimeIndex(TEXTS, tz="UTC").tz_convert("Asia/Tokyo")),
        xr.DataArray(np.array(TEXTS, dtype="datetime64[ns]")),
    ],
    ids=lambda times: f"{type(times).__name__} {getattr(times, 'dtype', '')}",
)
def test_dates_of_all_kinds_are_the_same_moments(times):
    data = observing.Photometry(times, ROWS["magnitude"], ROWS["sigma"], geometry=GEOMETRY)
    assert np.abs((data.times.utc.jd1 - 2459853.5) + data.times.utc.jd2 - (EXPECTED - 2459853.5)).max() < 1e-9
    first, last = observing.Geometry(times, **VIEW).span
    assert (last - first).to_value("s") == pytest.approx(3600.0, abs=1e-6)
    assert abs(first.utc.jd - EXPECTED[0]) < 1e-8


def test_columns_of_texts_need_a_format_and_a_scale():
    for values in (TEXTS, pd.Series(TEXTS, dtype=object), pd.Series(TEXTS, dtype="string")):
        data = observing.Photometry.from_table(table(values), dates=("isot", "utc"), geometry=GEOMETRY)
        np.testing.assert_allclose(data.times.jd, EXPECTED, rtol=0, atol=1e-9)
    refused(r"or dates=\('isot', 'utc'\)", lambda: observing.Photometry.from_table(table(TEXTS), geometry=GEOMETRY))


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (TEXTS, "'2022-10-01T04:35:10.047'; expected a date with its time scale, such as .* TDB', or a Time$"),
        ([Time(TEXTS[0]), 1.0], "is the date 2022-10-01T04:35:10.047; expected the time since the system's epoch"),
        ([datetime.datetime(2022, 10, 1), "x"], "'x'; expected numbers"),
        (["2022-13-01 UTC"] * 2, "is '2022-13-01 UTC': "),
    ],
)
def test_errors_state_the_form_that_a_date_needs(times, message):
    with pytest.raises(InvalidInput, match=f"times of Photometry.*{message}"):
        observing.Photometry(times, ROWS["magnitude"], ROWS["sigma"], geometry=GEOMETRY)


def test_messages_show_three_values_of_a_column():
    times = Time("2022-10-01T00:00:00", scale="utc") + np.arange(500) * u.h
    system, state = fullbody.systems.kw4(units=True)
    for call in (
        lambda: system.integrate(state, times),
        lambda: observing.Photometry(np.array(["a"] * 500), np.ones(500), 0.01, geometry=GEOMETRY),
        lambda: GEOMETRY.to_observer(times),
    ):
        with pytest.raises(InvalidInput) as caught:
            call()
        assert len(str(caught.value)) < 400
        assert "497 more" in str(caught.value) or "expected such a time" in str(caught.value)


def test_times_between_dates_of_pandas_have_their_unit():
    data = observing.Photometry(pd.to_timedelta(["1h", "2h"]), [1, 2], 0.01, geometry=GEOMETRY)
    np.testing.assert_array_equal(data.times.to_value("h"), [1.0, 2.0])
    with pytest.raises(InvalidInput, match="complex or dates"):
        observing.Photometry([1, 2] * u.h, pd.Series(pd.DatetimeIndex(TEXTS)), 0.01, geometry=GEOMETRY)


def test_dates_of_a_short_type_are_refused_or_good_to_half_a_second():
    rng, refused = np.random.default_rng(2), 0
    for _ in range(150):
        jd = np.sort(2459860.5 + rng.choice([0.01, 0.3, 30.0, 300.0]) * rng.random(rng.integers(1, 30)))
        how, zero = rng.choice(["jd", "mjd", "unix", "jyear"]), Time(2459860.5, format="jd", scale="utc")
        exact = Time(jd, format="jd", scale="utc")
        values = np.asarray(getattr(exact, how)).astype(rng.choice(["f4", "f8", "i4", "i8"]))
        rows = pd.DataFrame({"times": values, "magnitude": np.ones(len(jd)), "sigma": 0.01})
        try:
            data = observing.Photometry.from_table(rows, dates=(how, "utc"), geometry=GEOMETRY)
        except InvalidInput:
            refused += 1
            continue
        error = (data.times - zero).to_value("s") - np.sort((exact - zero).to_value("s"))
        assert np.abs(error).max() <= 1.0
    assert 50 < refused < 125


def test_times_of_a_short_type_that_collapse_are_refused():
    for times in ((1000 + 1e-4 * np.arange(5)).astype("f4"), np.full(3, 7.1, dtype="f4")):
        with pytest.raises(InvalidInput, match="numbers of the type float32"):
            observing.Photometry(times * u.h, np.ones(len(times)), 0.01, geometry=GEOMETRY)
        refused("numbers of the type float32", observing.Geometry, times, to_observer=[1.0, 0.0, 0.0])
    observing.Photometry(np.arange(5, dtype="f4") * u.h, np.ones(5), 0.01, geometry=GEOMETRY)
    observing.Photometry(np.arange(5) * u.h, np.ones(5), 0.01, geometry=GEOMETRY)


def test_no_times_give_no_magnitudes_and_no_observations():
    system, state = fullbody.systems.kw4(units=True)
    run = system.integrate(state, "1 h", dense=True)
    none = [] * u.h
    assert observing.light_curve(run, none, GEOMETRY).shape == (0,)
    assert observing.light_curve(run, none, GEOMETRY, per_body=True).shape == (0, 2)
    assert run(none).position.shape == (0, 2, 3)
    assert run.states([])["attitude"].shape == (0, 2, 4)
    for call in (
        lambda: observing.Photometry(none, [], 0.01, geometry=GEOMETRY),
        lambda: observing.Astrometry(none, [], [], 0.01, geometry=GEOMETRY),
        lambda: observing.Geometry(none, **VIEW),
    ):
        refused(r"has shape \(0,\); expected \(K,\), one time or more", call)


def test_labels_of_nights_are_of_one_kind_or_none():
    def nights(labels):
        return observing.Photometry([1, 2, 30] * u.h, np.ones(3), 0.01, geometry=GEOMETRY, night=labels).nights.tolist()

    assert nights(None) == nights([None] * 3) == [0, 1]
    assert nights(xr.DataArray(["a", "b", "a"])) == ["a", "b"]
    refused(r"night is .*, labels of several kinds", lambda: nights([None, 1, 1]))


def test_magnitudes_of_xarray_keep_their_unit():
    magnitude = xr.DataArray([14000.0, 14100.0], attrs={"units": "mmag"})
    data = observing.Photometry([1, 2] * u.h, magnitude, xr.DataArray([0.01, 0.02]), geometry=GEOMETRY)
    np.testing.assert_allclose(data.magnitude, [14.0, 14.1], rtol=1e-15)
    np.testing.assert_array_equal(data.sigma, [0.01, 0.02])


def test_no_module_has_the_name_of_a_function_that_one_expects():
    assert not hasattr(fullbody.observables, "tumbling")
    assert not hasattr(observing, "photocentre")


def test_values_that_their_type_rounds_beyond_their_errors_are_refused():
    # Near 1.5e7 km float32 is spaced by 1 km; near 14 mag by 1e-6 mag, which matters to no error of 1e-3 mag.
    times, ranges = [1.0, 2.0] * u.h, np.array([1.5e7, 1.6e7], dtype=np.float32)
    expected = "range of RadarAstrometry are numbers of the type float32, which near 1.5e.07 are 1.8 apart"
    for values in (ranges * u.km, ranges):
        unit = u.km if hasattr(values, "unit") else 1.0
        refused(expected, observing.RadarAstrometry, times, range=values, sigma=0.15 * unit, geometry=GEOMETRY)
        observing.RadarAstrometry(times, range=values, sigma=100.0 * unit, geometry=GEOMETRY)
    light = {"magnitude": np.array([14.1, 14.2], dtype=np.float32), "sigma": np.array([1e-3, 1e-3], dtype=np.float32)}
    assert len(observing.Photometry(times, **light, geometry=GEOMETRY)) == 2
    for sigma in (1e-6, [1e-6, 1e-3]):
        with pytest.raises(InvalidInput, match="magnitude of Photometry are numbers of the type float32"):
            observing.Photometry(times, light["magnitude"], sigma, geometry=GEOMETRY)
    rows = pd.DataFrame({"times": [f"{text}Z" for text in TEXTS], "range": ranges, "sigma_range": 0.15})
    with pytest.raises(InvalidInput, match=expected):
        observing.RadarAstrometry.from_table(rows, unit={"range": "km", "sigma_range": "km"}, geometry=GEOMETRY)
    offsets = np.array([0.5, 0.6], dtype=np.float32) * u.arcsec
    assert len(observing.Astrometry(times, offsets, offsets, 1e-3 * u.arcsec, geometry=GEOMETRY)) == 2
    with pytest.raises(InvalidInput, match="east of Astrometry are numbers of the type float32"):
        observing.Astrometry(times, offsets, offsets, [[1e-7, 1e-3]] * 2 * u.arcsec, geometry=GEOMETRY)
