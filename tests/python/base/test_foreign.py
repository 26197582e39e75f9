"""Values with the units of xarray and pint, and lengths of time of Python, numpy and pandas."""

from datetime import timedelta
from types import SimpleNamespace

import fullbody
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from astropy import units as u
from fullbody.base.units import Units
from support import refused

SYSTEM = Units(("km", "hour", "kg"))
#: A Quantity as pint has them.
PINT = SimpleNamespace(magnitude=np.array([3600.0]), units="meter / second")


@pytest.mark.parametrize(
    ("quantity", "dimension", "expected"),
    [
        (xr.DataArray([90.0, 180.0], attrs={"units": "deg"}), "angle", [np.pi / 2, np.pi]),
        ([xr.DataArray(90.0, attrs={"units": "deg"}), 30 * u.arcmin], "angle", [np.pi / 2, np.pi / 360]),
        (xr.DataArray([1500.0], attrs={"units": "m"}), "length", [1.5]),
        (xr.DataArray([1500.0]), "length", [1500.0]),
        (xr.DataArray(["1500 m"]), "length", None),
        (xr.DataArray([2.0], attrs={"units": "dimensionless"}), "number", [2.0]),
        (PINT, "velocity", [12960.0]),
        (timedelta(minutes=90), "time", 1.5),
        ([timedelta(minutes=90), 1 * u.day], "time", [1.5, 24.0]),
        (np.array([1, 36], dtype="timedelta64[m]"), "time", [1 / 60, 0.6]),
        (pd.to_timedelta(["1h", "48h"]), "time", [1.0, 48.0]),
        (pd.Series(pd.to_timedelta(["1h", "48h"])), "time", [1.0, 48.0]),
    ],
)
def test_units_of_other_libraries_are_read(quantity, dimension, expected):
    if expected is None:
        refused("expected numbers", lambda: SYSTEM.strip(quantity, dimension, "value"))
    else:
        np.testing.assert_allclose(SYSTEM.strip(quantity, dimension, "value"), expected, rtol=1e-15)


def test_units_that_astropy_does_not_know_are_refused():
    for quantity in (xr.DataArray([1.0], attrs={"units": "furlongs"}), SimpleNamespace(magnitude=1.0, units="furlong")):
        refused(r"size has the unit 'furlongs?', which astropy cannot read", SYSTEM.strip, quantity, "length", "size")
    with pytest.raises(fullbody.errors.InvalidInput, match="size has the unit deg; expected a unit such as km"):
        SYSTEM.strip(xr.DataArray(1.0, attrs={"units": "deg"}), "length", "size")


def test_parameters_of_a_map_keep_their_units():
    def setup(angle):
        system, state = fullbody.systems.kw4(units=True)
        return system, state.rotated("Beta", [0, 0, 1], angle)

    def rotation_angle(run):
        start, end = (state.rotation_matrix[1] for state in (fullbody.systems.kw4()[1], run[0]))
        return {"turn": np.arccos((np.trace(start.T @ end) - 1.0) / 2.0)}

    first = fullbody.sweep(setup, {"angle": [2, 4] * u.deg}, "1 h", measure=rotation_angle, output="ends")
    again = fullbody.sweep(setup, {"angle": first.angle}, "1 h", measure=rotation_angle, output="ends")
    assert again.angle.attrs == first.angle.attrs == {"units": "deg"}
    np.testing.assert_allclose(again.turn, np.radians([2, 4]), rtol=1e-9)
    single = fullbody.sweep(setup, {"angle": first.angle[1]}, "1 h", measure=rotation_angle, output="ends")
    assert float(single.turn) == pytest.approx(np.radians(4), rel=1e-9)
    state = fullbody.systems.kw4(units=True)[1].rotated("Beta", [0, 0, 1], first.angle[0])
    assert rotation_angle([state])["turn"] == pytest.approx(np.radians(2), rel=1e-9)
    orbit = fullbody.KeplerElements(1.0, 0.0, first.angle[0], 0.0, 0.0, 0.0)
    assert orbit.to_cartesian(1.0)[1][2] == pytest.approx(np.sin(np.radians(2)), rel=1e-12)


def test_a_measure_with_units_keeps_them():
    def measure(run):
        return {"size": xr.DataArray([1.0, 2.0], attrs={"units": "km"})}

    result = fullbody.sweep(lambda x: fullbody.systems.case1(), {"x": [1.0]}, 0.1, measure=measure, output="ends")
    assert result["size"].attrs["units"] == "km"


def test_draws_with_units_keep_them():
    draws = fullbody.ensembles.draws(3, x=lambda rng: SimpleNamespace(magnitude=1500.0, units="meter"))
    result = fullbody.sweep(
        lambda x: fullbody.systems.case1(), draws, 0.1, measure=lambda run: {}, output="ends", rng=np.int64(1)
    )
    assert result.x.attrs == {"units": "m"}
    assert result.x.values.tolist() == [1500.0] * 3


def test_texts_are_read_by_their_unit():
    refused("whose unit 'furlong' is not known", lambda: SYSTEM.strip("-1.e3furlong", "density", "density"))
    refused(r"whose unit 'm\^' is not known", lambda: SYSTEM.strip(".5 m^", "density", "density"))
    text = "e is '0.02', which is text; expected plain numbers$"
    refused(text, lambda: fullbody.KeplerElements(1.0, "0.02", 0.0, 0.0, 0.0, 0.0))
    assert SYSTEM.strip("2 metre", "length", "size") == 0.002
