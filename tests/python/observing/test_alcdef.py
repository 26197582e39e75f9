"""Light curves in the format ALCDEF: a file of the archive, constants of blocks, and files that are written."""

import re

import astropy.units as u
import numpy as np
import pytest
from astropy.time import Time
from fullbody import observing
from support import DATA, refused_with

ZACHIA = DATA / "observations" / "alcdef_zachia.txt"
ABOUT = {"OBJECTNUMBER": 999, "OBJECTNAME": "Zachia", "CONTACTNAME": "A. Person", "CONTACTINFO": "person@example.org"}
ABOUT |= {"OBSERVERS": "A. Person", "FILTER": "C", "MAGBAND": "R", "STANDARD": "INTERNAL"}
HEAD = ["STARTMETADATA", "OBJECTNAME=Ceres", "SESSIONDATE=2011-09-13", "FILTER=C"]
DATES = Time([2451400.5, 2451500.5, 2455817.5, 2455818.5], format="jd", scale="utc")
#: The observer and the Sun at 2 and 3 au.
VIEW = {"to_observer": [2.0, 0.0, 0.0] * u.au, "to_sun": [0.0, 3.0, 0.0] * u.au}


def geometry(light_time=True):
    return observing.Geometry(DATES, **VIEW, light_time=light_time)


def read(path, light_time=True, **options):
    return observing.read_alcdef(path, geometry=geometry(light_time), **options)


def photometry(count=1, magnitude=7.0, sigma=0.1, **options):
    options = {"geometry": geometry()} | options
    return observing.Photometry(DATES[:count], [magnitude] * count, sigma, **options)


def written(folder, *lines):
    path = folder / "curves.txt"
    path.write_text("\n".join(lines))
    return path


def test_a_file_of_the_archive_has_its_blocks_and_points():
    result = read(ZACHIA, airmass=True)
    text = ZACHIA.read_text()
    assert sum(map(len, result)) == text.count("DATA=24")
    assert len(result) == text.count("ENDDATA") == 4
    first = result[0]
    assert first.nights.tolist() == ["1999-09-04 06:00:00 C"]
    assert first.times.scale == "utc"
    assert abs(first.times[0].jd - 2451425.613960) < 1e-9
    assert (first.magnitude[0], first.sigma[0], first.airmass[0]) == (13.192, 0.008, 1.583)
    assert first.geometry.light_time
    assert not first.reduced
    assert read(ZACHIA)[0].airmass is None


def test_blocks_of_old_files_end_without_a_mark(tmp_path):
    lines = [line for line in ZACHIA.read_text().splitlines() if line != "ENDDATA"]
    index = lines.index("ENDMETADATA")
    lines[index:index] = ["EPOCH=J2000.0", "EPOCH=J2000.0", "MPCCODE="]
    result = read(written(tmp_path, *lines))
    for first, other in zip(result, read(ZACHIA), strict=True):
        assert np.array_equal(first.magnitude, other.magnitude)


def test_constant_corrections_of_a_block_are_removed(tmp_path):
    words = ["LTCAPP=AVERAGE", "LTCTYPE=LIGHTTIME", "LTCDAYS=-0.01099", "REDUCEDMAGS=AVERAGE", "UCORMAG=-3.697"]
    lines = [*HEAD, *words, "MAGADJUST=+0.040", "ENDMETADATA", "DATA=2455817.7|7.3|+0.004", "ENDDATA"]
    (result,) = read(written(tmp_path, *lines))
    # JD(at the asteroid) = JD(at the Earth) + LTCDAYS; reduced = observed + UCORMAG.
    assert abs(result.times[0].jd - 2455817.71099) < 1e-9
    assert np.isclose(result.magnitude[0], 7.3 + 3.697 + 0.04, rtol=1e-14)
    assert not result.reduced


def test_corrections_point_by_point_need_a_geometry_at_the_asteroid(tmp_path):
    words = ["LTCAPP=POINT", "LTCTYPE=LIGHTTIME", "LTCDAYS=-0.01099", "REDUCEDMAGS=POINT", "DELIMITER=TAB"]
    path = written(tmp_path, *HEAD, *words, "ENDMETADATA", "DATA=2455817.7\t7.3\t0.004", "ENDDATA")
    (result,) = read(path, False)
    assert result.reduced
    assert abs(result.times[0].jd - 2455817.7) < 1e-9
    message = "curves.txt, line 1: times of the block are less light time, by LTCAPP=POINT; expected a geometry"
    refused_with(message, lambda: read(path))


@pytest.mark.parametrize("light_time", [True, False])
@pytest.mark.parametrize("reduced", [True, False])
def test_written_light_curves_are_read_back(tmp_path, light_time, reduced):
    rng = np.random.default_rng(3)
    days = np.concatenate([np.linspace(20.0, 20.2, 30), np.linspace(21.0, 21.3, 20)])
    times = Time(2451400.5, days, format="jd", scale="tdb")
    originals = [rng.normal(13.0, 0.3, 50), rng.uniform(0.002, 0.05, 50), rng.uniform(1.0, 2.0, 50)]
    options = {"geometry": geometry(light_time), "airmass": originals[2], "reduced": reduced}
    data = observing.Photometry(times, originals[0], originals[1], **options)
    path = tmp_path / "curves.txt"
    observing.write_alcdef(path, data, ABOUT)
    result = read(path, light_time, airmass=True)
    assert [len(curve) for curve in result] == [30, 20]
    for curve, rows in zip(result, (slice(30), slice(30, None)), strict=True):
        assert np.abs((curve.times - times[rows]).to_value("s")).max() < 0.5e-3
        columns = [curve.magnitude, curve.sigma, curve.airmass]
        assert all(np.abs(a - b[rows]).max() <= 0.51e-6 for a, b in zip(columns, originals, strict=True))
        assert curve.reduced == reduced
    text = path.read_text()
    # The standard's own formulas: LTCDAYS = -0.005772 times the distance in au; UCORMAG = -5 log10 of both.
    days = re.findall(r"LTCDAYS=(\S+)", text)
    assert days == [] if light_time else np.allclose([float(word) for word in days], -0.005772 * 2.0, rtol=1e-3)
    units = re.findall(r"UCORMAG=(\S+)", text)
    assert np.allclose([float(word) for word in units], -5.0 * np.log10(6.0), atol=1e-4) if reduced else units == []
    assert text.count("SESSIONTIME=") == 2
    # The middle of the first night, which is 64 s earlier in UTC.
    assert "SESSIONDATE=1999-08-30\nSESSIONTIME=02:22:55" in text


def test_light_curves_of_damit_go_into_alcdef(tmp_path):
    data = observing.read_damit(DATA / "damit" / "lc.txt", sigma="estimate")
    path = tmp_path / "ariadne.txt"
    observing.write_alcdef(path, data, ABOUT | {"OBJECTNUMBER": 43, "OBJECTNAME": "Ariadne", "STANDARD": "NONE"})
    first_block = written(tmp_path, path.read_text().partition("ENDDATA")[0])
    (first,) = observing.read_alcdef(first_block, geometry=data[0].geometry)
    assert np.abs(first.magnitude - data[0].magnitude).max() < 1e-6
    assert np.abs((first.times - data[0].times).to_value("s")).max() < 1e-3


def test_points_without_errors_need_them(tmp_path):
    rows = [f"DATA={2455817.5 + 0.002 * k}|{7.3 + 0.01 * (k % 3)}" for k in range(20)]
    path = written(tmp_path, *HEAD, "ENDMETADATA", *rows)
    (result,) = read(path, sigma="estimate")
    assert 0.005 < result.sigma[0] < 0.03
    assert (read(path, sigma=0.02)[0].sigma == 0.02).all()
    with pytest.warns(UserWarning, match="no standard errors"):
        read(path)
    path = written(tmp_path, *HEAD, "ENDMETADATA", *rows, "DATA=2455817.9|7.3|0.01")
    message = "line 1: the block of 2011-09-13 C has points without errors, and others have them; give sigma="
    refused_with(message, lambda: read(path))
    message = "line 1: the block of 2011-09-13 C has points without an airmass; expected airmass=False"
    refused_with(message, lambda: read(path, sigma=0.02, airmass=True))


GOOD = [*HEAD, "ENDMETADATA", "DATA=2455817.7|7.3|0.004", "ENDDATA"]


@pytest.mark.parametrize(
    ("index", "line", "message"),
    [
        (0, "OBJECTNAME=Ceres", "line 1: the line is 'OBJECTNAME=Ceres'; expected STARTMETADATA"),
        (2, "a line of text", "line 3: the line is 'a line of text'; expected KEYWORD=value or ENDMETADATA"),
        (2, "OBJECTNAME=Vesta", "line 3: OBJECTNAME is given twice, first in line 2; expected one value"),
        (2, "LTCAPP=YES", "line 3: LTCAPP is 'YES'; expected NONE or AVERAGE or POINT"),
        (2, "LTCTYPE=LIGHTTIME", "line 3: LTCTYPE is LIGHTTIME and LTCAPP NONE; expected NONE for both or for neither"),
        (2, "LTCAPP=AVERAGE", "line 1: the block has no LTCDAYS, and has LTCAPP=AVERAGE; expected a number"),
        (2, "REDUCEDMAGS=AVERAGE", "line 1: the block has no UCORMAG, and has REDUCEDMAGS=AVERAGE"),
        (2, "MAGADJUST=much", "line 3: MAGADJUST is 'much'; expected a number"),
        (2, "DELIMITER=COMMA", "line 3: DELIMITER is 'COMMA'; expected PIPE or TAB"),
        (5, "FILTER=V", "line 6: the line is 'FILTER=V'; expected DATA=..."),
        (5, "DATA=2455817.7", "line 6: DATA has 1 fields; expected JD, magnitude, its error and the airmass"),
        (5, "DATA=2455817.7|7.3|0.1|1.2|9", "line 6: DATA has 5 fields"),
        (5, "DATA=2455817.7|bright", "line 6: the magnitude is 'bright'; expected a number"),
        (5, "DATA=2455817.7|7.3|-0.1", "line 6: the error of the magnitude is '-0.1'; expected a number, zero"),
        (6, "STARTMETADATA\nOBJECTNAME=Vesta\nENDMETADATA\nDATA=2455817.8|7.3|0.1", "line 8: OBJECTNAME is 'Vesta'"),
    ],
)
def test_malformed_files_are_refused_with_the_line(tmp_path, index, line, message):
    lines = [*GOOD[:index], line, *GOOD[index:]]
    refused_with(message, lambda: read(written(tmp_path, *lines)))


def test_files_without_blocks_or_points_are_refused(tmp_path):
    message = "the file has no line STARTMETADATA; expected a file of the format ALCDEF"
    refused_with(message, lambda: read(written(tmp_path, "")))
    message = "line 5: the file ends in the block of line 1; expected lines DATA=..."
    refused_with(message, lambda: read(written(tmp_path, *GOOD[:5])))


@pytest.mark.parametrize(
    ("about", "message"),
    [
        ({"FILTER": ""}, "metadata has no FILTER; expected OBJECTNUMBER"),
        ({"LTCAPP": "NONE"}, "metadata has 'LTCAPP': 'NONE'; expected keywords in capitals that the data do not give"),
        ({"COMMENT": "two\nlines"}, "metadata has 'COMMENT': 'two\\nlines'"),
        ({"COMMENT": "two\u2028lines"}, "metadata has 'COMMENT': 'two\\u2028lines'"),
        ({"COMMENT": "half of \ud800"}, "printable text of one line"),
        ({"facility": "here"}, "metadata has 'facility': 'here'"),
        ({"STANDARD": "SOME"}, "STANDARD is 'SOME'; expected 'NONE', 'INTERNAL' or 'TRANSFORMED'"),
    ],
)
def test_malformed_metadata_are_refused(tmp_path, about, message):
    refused_with(message, lambda: observing.write_alcdef(tmp_path / "curves.txt", photometry(4), ABOUT | about))
    assert list(tmp_path.iterdir()) == []


def test_data_that_the_format_cannot_hold_are_refused(tmp_path):
    unitless = observing.Geometry([0.0, 1.0], to_observer=[1.0, 0, 0], to_sun=[1.0, 1.0, 0], light_time=False)
    distant = observing.Geometry(DATES, to_observer=[1.0, 0, 0], to_sun=[1.0, 1.0, 0])
    for message, data in (
        ("times of data are not dates", observing.Photometry([0.5], [7.0], 0.01, geometry=unitless)),
        ("the geometry of data has no units of length", photometry(geometry=distant)),
        ("sigma of data has the value 1e-07; expected errors from 1e-6 on", photometry(sigma=1e-7)),
        ("airmass of data has the value -1", photometry(airmass=[-1.0])),
        ("data has the filters R, V; expected one, named by FILTER", photometry(2, filter=["R", "V"])),
        ("data is None; expected a Photometry, or several", None),
        ("data is empty; expected one Photometry or more", []),
    ):
        refused_with(message, lambda data=data: observing.write_alcdef(tmp_path / "curves.txt", data, ABOUT))
