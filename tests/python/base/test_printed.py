"""Numbers as papers print them: with a standard error, with a power of ten, and as a sum of terms."""

import re

import fullbody
import pytest
from astropy import units as u
from fullbody.base.unit_names import error_of
from fullbody.base.units import as_quantity
from fullbody.errors import InvalidInput
from support import refused

#: Texts with their value, standard error and unit, as a reader of the paper takes them.
PRINTED = {
    "11.921473 ± 0.000044 h": (11.921473, 4.4e-5, "h"),
    "11.921473 +- 0.000044 h": (11.921473, 4.4e-5, "h"),
    "11.921473+/-0.000044h": (11.921473, 4.4e-5, "h"),
    "11.921473(44) h": (11.921473, 4.4e-5, "h"),
    "5.4(12) km": (5.4, 1.2, "km"),
    "5.4(0.3) km": (5.4, 0.3, "km"),
    "54(3) m": (54.0, 3.0, "m"),
    "(5.4 ± 0.4)e11 kg": (5.4e11, 4e10, "kg"),
    "(5.4 ± 0.4) \N{MULTIPLICATION SIGN} 10^11 kg": (5.4e11, 4e10, "kg"),
    "5.4(4)e11 kg": (5.4e11, 4e10, "kg"),
    "5.4e11 ± 0.4e11 kg": (5.4e11, 4e10, "kg"),
    "5.4 x 10^11 kg": (5.4e11, None, "kg"),
    "\N{MINUS SIGN}84 ± 2 deg": (-84.0, 2.0, "deg"),
    "11 h 55.3 min": (11.0 + 55.3 / 60.0, None, "h"),
    "11 h 55.3 ± 0.6 min": (11.0 + 55.3 / 60.0, 0.01, "h"),
    "1 d 2 h": (26.0, None, "h"),
    "-1 h 30 min": (-1.5, None, "h"),
    "+10 deg 30 arcmin": (10.5, None, "deg"),
    "\N{MINUS SIGN}38° 12' 36\"": (-38.21, None, "deg"),
    "+38° 12\N{PRIME} 36\N{DOUBLE PRIME}": (38.21, None, "deg"),
    "38 deg 12 arcmin 36 arcsec": (38.21, None, "deg"),
}


@pytest.mark.parametrize("text", PRINTED)
def test_a_printed_number_is_read_with_its_error_and_unit(text):
    value, error, unit = PRINTED[text]
    result = as_quantity(text, "a number")
    assert result.to_value(unit) == pytest.approx(value, rel=1e-14)
    if error is None:
        assert error_of(result) is None
    else:
        assert (error_of(result) * result.unit).to_value(unit) == pytest.approx(error, rel=1e-14)


def test_a_column_of_printed_numbers_keeps_the_error_of_each():
    result = as_quantity(["849 ± 15 m", "0.8 ± 0.1 km", "3 km"], "diameters")
    assert (error_of(result) * result.unit).to_value("m") == pytest.approx([15.0, 100.0, 0.0], rel=1e-14)


def test_an_error_is_forgotten_where_it_is_computed_with():
    assert error_of(2.0 * as_quantity("849 ± 15 m", "diameter")) is None


REFUSED = {
    "1 km 3 h": "'1 km 3 h', a sum of terms that do not go together",
    "0.5 -0.3 kg": "whose unit '-0.3 kg' is not known",
    "5.4 +0.5 -0.3 kg": "not known",
    "2 3 kg": "whose unit '3 kg' is not known",
    "1.2 ± 0.1": "has no unit",
    "10 deg 20": "whose unit 'deg 20' is not known",
    "10 deg 2e1 arcmin": "whose unit 'deg 2e1 arcmin' is not known",
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_malformed_text_is_refused(text):
    refused(re.escape(REFUSED[text]), lambda: as_quantity(text, "mass", "mass"))


def test_an_unknown_unit_is_named_with_the_unit_that_is_meant(tmp_path):
    message = r"density of {} is '2\.4 g/cc', whose unit 'g/cc' is not known; did you mean '2\.4 g/cm3'\?"
    refused(message.format("Alpha"), lambda: fullbody.Body(fullbody.Sphere("1 km"), density="2.4 g/cc", name="Alpha"))
    refused(message.format("a component"), lambda: fullbody.Component(diameter="1 km", density="2.4 g/cc"))
    path = tmp_path / "system.toml"
    path.write_text(
        '[system]\nunits = ["km", "hour", "kg"]\n[[body]]\nradius = 1\ndensity = "2.4 g/cc"\n[run]\nuntil = 1\n'
    )
    refused(
        r"body\[0\]\.density: is '2\.4 g/cc', whose unit 'g/cc' is not known; did you", lambda: fullbody.read_toml(path)
    )


def test_lengths_are_spelt_in_either_english():
    for text in ("250 metre", "250 metres", "250 meter", "0.25 kilometres", "25000 centimetres"):
        assert as_quantity(text, "size", "length").to_value(u.m) == pytest.approx(250.0, rel=1e-14)


def test_the_rate_of_a_spin_without_an_angle_is_refused():
    with pytest.raises(InvalidInput, match="along of YORP on Alpha has the unit 1 / d2, which may count turns"):
        fullbody.forces.Yorp("Alpha", along="1e-8 1/day2", normalization="acceleration")
