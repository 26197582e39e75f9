"""Maps in other units: numbers and labels change together."""

import fullbody
import numpy as np
import pytest
import xarray as xr
from astropy import units as u
from fullbody import observables
from fullbody.ensembles import in_units
from support import refused


def outcome(**units):
    fields = {"libration": ("angle", [0.1, np.nan], {"units": "rad", "long_name": "amplitude"}), "ratio": 2.0}
    return xr.Dataset(fields, {"angle": ("angle", [1.0, 2.0], {"units": "deg"})}, {"title": "a map"})


def test_numbers_and_attributes_change_together():
    map_ = in_units(outcome(), libration="deg", angle=u.rad)
    np.testing.assert_allclose(map_.libration, [18.0 / np.pi, np.nan])
    np.testing.assert_allclose(map_.angle, np.pi / 180 * np.array([1.0, 2.0]))
    assert map_.libration.attrs == {"units": "deg", "long_name": "amplitude"}
    assert map_.libration.angle.attrs["units"] == "rad"
    assert (map_.attrs, float(map_.ratio)) == ({"title": "a map"}, 2.0)
    assert in_units(map_, libration="rad", angle="deg").libration.values[0] == pytest.approx(0.1, rel=1e-15)
    # A plot takes its label from there.
    (line,) = map_.libration.plot()
    assert line.axes.get_ylabel() == "amplitude [deg]"


@pytest.mark.parametrize(
    ("units", "text"),
    [
        ({"roll": "deg"}, "the dataset has no 'roll'; expected some of libration, ratio, angle"),
        ({"ratio": "deg"}, "ratio has no unit; expected one in its attributes"),
        ({"libration": "km"}, "libration cannot be converted to 'km'"),
        ({"libration": "degs!"}, "libration cannot be converted to 'degs!'"),
    ],
)
def test_conversions_without_a_unit_or_to_another_dimension_are_refused(units, text):
    refused(text, lambda: in_units(outcome(), **units))


def test_no_variable_of_an_observable_has_the_name_of_a_method_of_xarray():
    system, state = fullbody.systems.kw4()
    run = system.integrate(state, 200.0, output=0.5)
    for name in observables.__all__:
        result = getattr(observables, name)(run) if name.islower() else None
        for entry in result.as_dict() if hasattr(result, "as_dict") else ():
            assert not hasattr(xr.Dataset, entry)
