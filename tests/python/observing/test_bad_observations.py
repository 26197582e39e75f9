"""What is wrong with the arguments of observations and geometries is named when they are made."""

import astropy.units as u
import numpy as np
import pandas as pd
import pytest
from fullbody import observing
from fullbody.errors import InconsistentInput
from support import refused

TIMES = [1.0, 2.0, 3.0] * u.h
#: The Sun and the observer at rest, far away.
LINES = {"to_observer": [1e6, 2e5, 4e5] * u.km, "to_sun": [1e8, 2e7, 4e7] * u.km}
VIEW = observing.Geometry([0.0, 100.0] * u.h, **LINES, light_time=False, frame="ecliptic")
UNITLESS = observing.Geometry([0.0, 100.0], to_observer=[1e6, 2e5, 4e5], light_time=False)


def radar(**options):
    arguments = {"times": [1.0, 2.0, 3.0], "range": np.ones(3), "sigma": 0.1, "body": 1, "about": 0}
    return observing.RadarAstrometry(**(arguments | {"geometry": UNITLESS} | options))


def astrometry(**options):
    arguments = {"times": TIMES, "east": [1, 2, 3] * u.mas, "north": [1, 2, 3] * u.mas, "sigma": 1 * u.mas}
    return observing.Astrometry(**(arguments | {"geometry": VIEW} | options))


def photometry(**options):
    return observing.Photometry(**({"times": TIMES, "magnitude": np.ones(3), "sigma": 0.1, "geometry": VIEW} | options))


def polar(separation, angle):
    return observing.Astrometry.from_polar([1.0] * u.h, separation, angle, 1 * u.mas, 0.1 * u.rad, geometry=VIEW)


def table(columns=("times", "east", "north", "sigma_east", "sigma_north"), **options):
    frame = pd.DataFrame({name: [1.0] for name in columns} | options.pop("also", {}))
    return observing.Astrometry.from_table(frame, **({"unit": u.mas, "geometry": VIEW} | options))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"range": None}, "range and range_rate are not given"),
        ({"sigma": 0.0}, "sigma of range of RadarAstrometry has the value 0.0; expected standard errors above zero"),
        ({"sigma": np.inf}, r"sigma of range of RadarAstrometry has the value inf; expected numbers of at most 1e\+60"),
        ({"sigma": 1e-61}, "sigma of range of RadarAstrometry has the value 1e-61; .* errors .* not below 1e-60"),
        ({"sigma": None}, "sigma of range of RadarAstrometry is None; expected numbers"),
        ({"sigma": [0.1, 0.2]}, r"sigma_range of RadarAstrometry has shape \(2,\); expected 3 rows"),
        ({"sigma": True}, "sigma of range of RadarAstrometry is True; expected numbers"),
        ({"range": np.ones(3, bool)}, "range of RadarAstrometry is an array of True and False"),
        ({"range": 3.0}, r"range of RadarAstrometry has shape \(\); expected \(K,\), one for each of times"),
        ({"range": np.ones((3, 2))}, r"range of RadarAstrometry has shape \(3, 2\); expected \(K,\)"),
        ({"range": ["far", "near", "far"]}, "range of RadarAstrometry is 'far'; expected numbers"),
        ({"range": np.ones(2)}, r"range of RadarAstrometry has shape \(2,\); expected 3 rows"),
        ({"range": np.ones(3) * u.s, "sigma": 1 * u.s}, "range of RadarAstrometry has the unit s; expected a unit"),
        ({"sigma": 0.1 * u.km}, "only one of range and its sigma has a unit"),
        ({"sigma": np.ones((3, 2))}, r"sigma_range of RadarAstrometry has shape \(3, 2\); expected \(3,\), or one"),
        ({"range_rate": np.zeros(3)}, "sigma is not a pair"),
        ({"range_rate": np.zeros(3), "sigma": (0.1, 0.1, 0.1)}, "sigma is not a pair"),
        ({"times": [True, False, True]}, "times of RadarAstrometry is True; expected numbers"),
        ({"times": ["now", "then", "later"]}, "times of RadarAstrometry is 'now'; expected numbers"),
        ({"times": [[1.0, 2.0, 3.0]]}, r"times of RadarAstrometry has shape \(1, 3\); expected \(K,\)"),
        ({"times": [1.0, 2.0, np.inf]}, "times of RadarAstrometry has the value inf; expected numbers of at"),
        ({"times": [], "range": []}, r"times of RadarAstrometry has shape \(0,\)"),
        ({"geometry": None}, "geometry of RadarAstrometry is None; expected an observing.Geometry"),
    ],
)
def test_bad_radar_is_refused_by_name(options, message):
    refused(message, lambda: radar(**options))


@pytest.mark.parametrize(
    ("jitter", "message"),
    [
        (np.nan, "jitter is nan; expected a standard deviation"),
        (-1.0, "jitter is -1.0; expected a standard deviation"),
        (True, "jitter is True; expected numbers"),
        ([1.0, 2.0], r"jitter is .*, of shape \(2,\); expected a standard deviation"),
        (1 * u.km, "only one of range and its jitter has a unit"),
    ],
)
def test_bad_jitter_is_refused_by_name(jitter, message):
    refused(message, lambda: radar().with_jitter(jitter))


def test_jitter_of_another_dimension_and_one_for_two_columns_are_refused():
    km = {"range": np.ones(3) * u.km, "sigma": 75 * u.m}
    refused("jitter has the unit s", radar(**km).with_jitter, 1 * u.s)
    refused("jitter is -0.001; expected a standard deviation, zero or above", radar(**km).with_jitter, -1 * u.m)
    both = km | {"range_rate": np.ones(3) * u.km / u.s, "sigma": (75 * u.m, 1 * u.cm / u.s)}
    refused("jitter is not a pair", radar(**both).with_jitter, 1 * u.m)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"correlation": 1.0}, "correlation has the value 1.0; expected numbers between -1 and 1"),
        ({"correlation": True}, "correlation is True; expected numbers"),
        ({"correlation": 0.1 * u.mas}, "correlation has the unit mas; expected plain numbers"),
        ({"correlation": [0.1, 0.2]}, r"correlation of Astrometry has shape \(2,\); expected 3 rows"),
        ({"sigma": [1.0, 0.0, 1.0] * u.mas}, "sigma of Astrometry has the value 0.0"),
        ({"sigma": np.ones((3, 3)) * u.mas}, r"has shape \(3, 3\); expected \(3,\) or \(3, 2\), or one number"),
        ({"sigma": np.ones((2, 3)) * u.mas}, r"sigma of Astrometry has shape \(2, 3\); expected 3 rows"),
        ({"sigma": 1.0}, "only one of east and sigma of Astrometry has a unit"),
        ({"east": 1 * u.mas}, r"east of Astrometry has shape \(\); expected \(K,\), one for each of times"),
        ({"east": [1.0, 2.0, 3.0] * u.km}, "east of Astrometry has the unit km; expected a unit such as rad"),
        ({"photocentre": 1}, "photocentre is 1; expected True or False"),
        ({"times": [np.nan] * 3 * u.h}, "no row without masked or missing values"),
        ({"frame": "sky"}, "cannot rotate from the frame 'equatorial' to 'sky'"),
        (
            {"east": [1.0, 2.0, 3.0] * u.Unit(1e-70 * u.mas)},
            "east of Astrometry has a unit that cannot be used: its scale is",
        ),
        (
            {"east": [1.0, 2.0, 1e70] * u.mas},
            "east of Astrometry has the value .*; expected numbers of at most 1e.60 in size",
        ),
    ],
)
def test_bad_astrometry_is_refused_by_name(options, message):
    refused(message, lambda: astrometry(**options))


ROW = pd.DataFrame({"times": [1.0], "magnitude": [1.0], "sigma": [1.0]})


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: polar([-5.0] * u.mas, [1.0] * u.deg), "separation has values that are not above zero"),
        (lambda: polar([0.0] * u.mas, [1.0] * u.deg), "separation has values that are not above zero"),
        (lambda: polar([1.0, 2.0] * u.mas, [1.0, 2.0, 3.0] * u.deg), r"errors have shapes \(2,\), \(3,\)"),
        (lambda: table(("times", "east")), "the table has no column 'north' for north of Astrometry"),
        (lambda: observing.Astrometry.from_table(None, geometry=VIEW), "table of Astrometry is None; expected a table"),
        (lambda: observing.Astrometry.from_table({"times": [1.0]}, geometry=VIEW), "expected a table of astropy or"),
        (lambda: table(unit="parrot"), "unit of east is 'parrot'"),
        (lambda: table(unit=0.0 * u.mas), "unit of east is <Quantity 0. mas>; expected a unit"),
        (lambda: table(unit=5e-324), "unit of east is 5e-324; .*its scale is 5e-324; expected 1e-60 to 1e60"),
        (lambda: table(unit=()), r"unit of east is \(\); .*a structure of several units"),
        (lambda: table(also={"east": [1j]}), "east of Astrometry has values that are no numbers: they are complex"),
        (lambda: table(also={"times": [1e9]}, dates=("jd", "utc")), "Astrometry are dates that cannot be subtracted"),
        (lambda: table(unit={"eats": u.mas}), "'eats' is not an option of unit of Astrometry; did you mean 'east'"),
        (lambda: table(unit={"east": u.mas}), "only one of east and north of Astrometry has a unit"),
        (lambda: table(also={"east": ["far"]}), "east of Astrometry has values that are no numbers"),
        (lambda: table(also={"east": [np.nan]}), "Astrometry has no row without masked or missing values"),
        (lambda: table(dates=("jd", "noon")), "not dates of the format and scale .*noon"),
        (lambda: table(dates="jd"), "dates is 'jd'; expected a format and a scale"),
        (lambda: table(columns_=("times",)), "'columns_' is not an option"),
        (lambda: observing.RadarAstrometry.from_table(ROW, geometry=VIEW), "no column 'range' or"),
        (
            lambda: observing.RadarAstrometry.from_table(ROW, columns=["range"], geometry=VIEW),
            r"columns of RadarAstrometry is \['range'\]; expected a dict",
        ),
        (lambda: observing.Photometry.from_table(ROW, night="n", geometry=VIEW), "table has no column 'n' for night"),
    ],
)
def test_bad_polar_coordinates_and_tables_are_refused_by_name(call, message):
    refused(message, call)


def test_units_of_a_table_may_be_given_by_column():
    assert table(unit="mas").east.unit == u.mas
    data = table(unit={"east": u.mas, "north": "arcsec", "sigma": u.mas})
    assert data.east[0].to_value("mas") == pytest.approx(1.0)
    assert data.north[0].to_value("mas") == pytest.approx(1000.0)
    frame = pd.DataFrame({"times": [1.0], "magnitude": [12.0], "sigma": [50.0]})
    bright = observing.Photometry.from_table(frame, unit={"sigma": "mmag"}, geometry=VIEW)
    assert bright.sigma.tolist() == [pytest.approx(0.05)]


def test_position_angles_that_look_like_degrees_are_warned_of():
    with pytest.warns(InconsistentInput, match="position_angle has values up to 45 radians"):
        polar([1.0] * u.mas, [45.0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"zero": True}, "zero is True; expected 'free' or a finite number"),
        ({"zero": np.nan}, "zero is nan; expected 'free' or a finite number"),
        ({"zero": np.array([1.0, 2.0])}, "expected 'free' or a finite number"),
        ({"mutual": "no"}, "mutual is 'no'; expected True or False"),
        ({"geometry": UNITLESS}, "has no Sun"),
        ({"reduced": 1}, "reduced is 1; expected True or False"),
        ({"magnitude": 12.0}, r"magnitude of Photometry has shape \(\)"),
        ({"magnitude": [1.0, 2.0, 3.0] * u.m}, "magnitude of Photometry has the unit m; expected a unit such as mag"),
        ({"sigma": 0}, "sigma of Photometry has the value 0.0"),
        ({"night": [1, 2]}, r"night has shape \(2,\); expected \(3,\)"),
    ],
)
def test_bad_photometry_is_refused_by_name(options, message):
    refused(message, lambda: photometry(**options))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("x", 3, 1.0, 1.0), "function of 'x' is 3; expected a function of a run"),
        ((3, len, 1.0, 1.0), "name of a measured value is 3; expected text"),
        (("x", len, True, 1.0), "value of x is True; expected finite numbers"),
        (("x", len, 1.0, True), "sigma of x is True; expected finite numbers above zero"),
        (("x", len, None, 1.0), "value of x is None; expected finite numbers"),
        (("x", len, [1.0, 2.0], [1.0, 2.0, 3.0]), r"sigma of x has shape \(3,\); expected \(2,\)"),
    ],
)
def test_bad_measured_values_are_refused_by_name(arguments, message):
    refused(message, lambda: observing.Measured(*arguments))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"times": [False, True]}, "times is False; expected finite numbers"),
        ({"to_observer": [True, False, False]}, "to_observer is True; expected finite numbers"),
        ({"to_observer": [0.0, 0.0, 0.0]}, "not all zero"),
        ({"to_sun": [1.0, 0, 0] * u.au}, "expected both or neither"),
        ({"times": [0.0, 0.0]}, "times has 0.0 twice"),
        ({"times": []}, "times has shape"),
        ({"times": [0.0, np.nan]}, "expected finite numbers"),
        ({"to_observer": [np.nan, 0.0, 0.0]}, "to_observer is .*; expected finite numbers"),
        ({"to_observer": np.ones((3, 3))}, r"to_observer has shape \(3, 3\); expected \(2, 3\)"),
        ({"light_time": "no"}, "light_time is 'no'; expected True or False"),
        ({"frame": "sky"}, "cannot rotate from the frame 'equatorial' to 'sky'"),
        ({"frame": 3}, "cannot rotate from the frame 'equatorial' to 3"),
        ({"frame": np.zeros(2)}, r"cannot rotate from the frame 'equatorial' to array\(\[0., 0.\]\)"),
    ],
)
def test_bad_geometries_are_refused_by_name(options, message):
    refused(message, lambda: observing.Geometry(**({"times": [0.0, 1.0], "to_observer": [1.0, 0.0, 0.0]} | options)))
