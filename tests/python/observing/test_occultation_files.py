"""Files and tables of chords of stellar occultations: Occult, SODIS, KOALA, and files of another form."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from astropy.coordinates import EarthLocation, SkyCoord
from astropy.time import Time
from fullbody import observing
from support import refused
from test_chords import STAR, passing

pytestmark = pytest.mark.filterwarnings("ignore::fullbody.errors.InconsistentInput")
NAN = np.nan


@pytest.fixture
def event():
    """An event that three stations on the Earth saw by dates, a satellite among them, and one did not."""
    start = Time("2024-03-01T23:59:50", scale="utc")
    star = SkyCoord(160.0 * u.deg, 15.0 * u.deg)
    stations = EarthLocation.from_geodetic(
        [-30.25, 10.0, 60.0, 5.5] * u.deg, [10.0, 50.5, -35.0, 0.0] * u.deg, [0, 300, 2e3, 5] * u.m
    )
    direction = np.asarray(star.cartesian.xyz.value)
    ends = np.array([-3600.0, 3600.0])
    path = (-2e8 * direction + np.outer(ends, [5.0, 10.0, 0.0])) * u.km
    geometry = observing.Geometry(start + ends * u.s, to_observer=path, frame="equatorial")
    begin = (start + [0.25, 3.5, 11.125, 0.0] * u.s).copy()
    end = (start + [7.5, 9.25, 12.5, 0.0] * u.s).copy()
    begin[3] = end[3] = np.ma.masked
    chords = {"disappearance": begin, "reappearance": end}
    sigma = [[0.02, 0.03], [0.1, 0.1], [0.5, 0.25], [0.1, 0.1]] * u.s
    watched = (start - [60.0] * 4 * u.s, start + [80.0] * 4 * u.s)
    body = ["A", "A", "B", None]
    common = {"star": star, "geometry": geometry}
    return observing.StellarOccultation(
        stations=stations, sigma=sigma, body=body, watched=watched, **chords, **common
    ), common


def alike(result, wanted, tolerance=2e-3):
    """Two sets of chords have the same times, errors and stations."""
    (chords, watched), (expected, other_watch) = result.chords, wanted.chords
    assert np.array_equal(chords.mask, expected.mask)
    assert abs((chords - expected).to_value("s")[~np.asarray(chords.mask)]).max() < tolerance
    np.testing.assert_allclose(result.errors_of_chords.to_value("s"), wanted.errors_of_chords.to_value("s"), atol=1e-12)
    positions = [data.stations.locations.to_geocentric() for data in (result, wanted)]
    for first, other in zip(*positions, strict=True):
        assert abs((first - other).to_value("m")).max() < 1.0
    return watched, other_watch


def test_tables_of_chords_are_read_back(event):
    data, common = event
    watched, wanted = alike(observing.StellarOccultation.from_table(data.to_table(), **common), data, 1e-6)
    assert abs((watched - wanted).to_value("s")).max() < 1e-6
    chords = {"disappearance": [495.0, NAN, NAN] * u.s, "reappearance": [505.0, 506.0, NAN] * u.s}
    options = {"star": STAR, "geometry": passing(frame="equatorial"), "offset": 0.0}
    for stations in (np.eye(3), np.arange(18.0).reshape(3, 2, 3), np.arange(12.0).reshape(3, 2, 2)):
        watched = ([400.0] * 3 * u.s, [600.0] * 3 * u.s)
        data = observing.StellarOccultation(
            stations=stations * u.km, **chords, sigma=0.1 * u.s, watched=watched, **options
        )
        again = observing.StellarOccultation.from_table(data.to_table(), **options)
        assert np.array_equal(again.times, data.times)
        assert again.sign.tolist() == data.sign.tolist()
        assert np.array_equal(again.stations.vectors, stations * u.km)


def test_other_names_of_columns_are_read_from_a_table(event):
    data, common = event
    table, names = data.to_table(), {"sigma": ("first error", "last error"), "disappearance": "D"}
    columns = ["sigma_disappearance", "sigma_reappearance", "disappearance"]
    table.rename_columns(columns, ["first error", "last error", "D"])
    alike(observing.StellarOccultation.from_table(table, columns=names, **common), data, 1e-6)
    refused("'D' is not an option of columns", observing.StellarOccultation.from_table, table, columns={"D": "D"})


def test_files_of_occult_are_read_back(event, tmp_path):
    data, common = event
    path = tmp_path / "event.xml"
    data.write_occult(path, asteroid=(22, "Kalliope"), satellite="B")
    result = observing.StellarOccultation.read_occult(path, geometry=common["geometry"], body="A", satellite="B")
    alike(result, data)
    assert result.body == ("A", "A", "B", None)
    assert result.star.coordinates == pytest.approx(data.star.coordinates, abs=1e-8)


#: An event as the description of the format has it, with misses, clouds, a second star and default errors.
OCCULT = """<?xml version="1.0"?>
<AsteroidOccultations><FileVersion>2.15</FileVersion><Event>
<Date>2008|12|11|7.7</Date>
<Details><Star>TYC|1215-00223-1|3|100|2.7904481530|+19.846293622|0.1|0.1|0.02|0|2.8|19.9|11|10|9|</Star>
<Asteroid>135|Hertha|3.1|1.2|0|0|0|0|5.9|0|77|2|10.5</Asteroid></Details>
<Observations><Prediction>0|-110 00 00.0|+32 00 00.0|7 44 00.0|</Prediction>
<Observer><ID>1|A. Alpha|B. Beta|0|Tucson|AZ|-110 57 30.5|+32 13
15.0|730|_|20|3|a|a</ID><Conditions>1|1|5||</Conditions> <D>7 43 50.25|D|0.02||5|</D><R>7 43 57.50|R|||5|</R></Observer>
<Observer><ID>2|C. Gamma||0|Phoenix|AZ|-112 04 00.0|+33 27 00.0|330|_|20|3|f|f</ID><Conditions>||||</Conditions>
<D>7 43 40.0|M||||</D><R>7 44 10.0|M||||</R></Observer>
<Observer><ID>3|D. Delta||0|Yuma|AZ|-114 37 00.0|+32 41 00.0|43|_|20|3|a|b</ID><Conditions>||||</Conditions>
<D>7 43 45.1|D||||</D><R>7 43 51.1|R||||z</R></Observer>
<Observer><ID>4|E. Epsilon||0|Yuma|AZ|-114 37 00.0|+32 41 00.0|43|_|20|3|a|b</ID><Conditions>||||</Conditions>
<D>7 43 45.1|C||||</D><R>7 43 51.1|C||||</R></Observer>
</Observations></Event></AsteroidOccultations>"""


def test_an_event_of_occult_has_its_star_stations_misses_and_default_errors(tmp_path):
    path = tmp_path / "hertha.xml"
    path.write_text(OCCULT)
    geometry = observing.Geometry(
        Time(["2008-12-11T07:00:00", "2008-12-11T08:00:00"]), to_observer=[[-1e8, 0, 0], [-1e8, 1e4, 0]] * u.km
    )
    with pytest.warns(fullbody.errors.InconsistentInput, match="the observers 4 are left out"):
        data = observing.StellarOccultation.read_occult(path, geometry=geometry, body="Hertha")
    assert data.star.coordinates == pytest.approx((15.0 * 2.7904481530, 19.846293622), abs=1e-9)
    seconds = [time.isot.removeprefix("2008-12-11T07:43:") for time in data.times[data.sign != 0.0]]
    assert seconds == ["50.250", "51.100", "57.500"]
    # A miss, the first contact of the first station, and the second contact of the third one, which has "R only".
    rows = sorted(zip(data.station.tolist(), data.sign.tolist(), strict=True))
    assert rows == [(0, -1.0), (0, 1.0), (1, 0.0), (2, 1.0)]
    errors = data.errors_of_chords.to_value("s")
    assert errors[0].tolist() == [0.02, 0.5]
    assert errors[2].tolist() == [1.5, 1.5]
    position = data.stations.locations[0].to_geodetic("WGS84")
    assert position.lon.deg == pytest.approx(-(110 + 57 / 60 + 30.5 / 3600))
    assert position.height.to_value("m") == pytest.approx(730.0, abs=1e-6)


def test_reports_of_sodis_are_read_back_with_the_intervals_of_misses(event, tmp_path):
    data, common = event
    paths = data.write_sodis(tmp_path, asteroid=(22, "Kalliope"), star="UCAC4 526-049530", names=list("abcd"))
    assert len(paths) == 4
    assert "#D: D23:59:50.250\n" in paths[0].read_text()
    watched, wanted = alike(observing.StellarOccultation.read_sodis(paths, **common, body="A"), data)
    assert abs((watched - wanted).to_value("s")).max() < 2e-3
    # A single contact after midnight belongs to the night of the watch.
    text = paths[0].read_text().replace("#D: D23:59:50.250", "#D:").replace("#Acc_D", "#Other")
    paths[0].write_text(text)
    assert "#R: R23:59:57.500" in text
    paths[0].write_text(text.replace("R23:59:57.500", "R00:00:07.500"))
    delay = observing.StellarOccultation.read_sodis(paths, **common, body="A")
    assert delay.times[delay.station == 0].isot.tolist() == ["2024-03-02T00:00:07.500"]


#: A file of KOALA with the Earth at a distance of 1e8 km along x, which moves against the pole of the ecliptic.
KOALA = """1
1.0e8 0.0 0.0
0.0 0.0 -10.0
0.0
3
2454811.50000000 0.02 0.0 0.0 2454811.50005787 0.03 19.8874 -45.8740 3
2454811.50000000 0.02 1.0 2.0 2454811.50005787 0.03 20.8874 -43.8740 3
2454811.50000000 0.02 900.0 0.0 2454811.50005787 0.03 919.9 -45.9 -1
"""


def test_files_of_koala_have_positions_to_the_west_and_north_in_a_plane_that_moves_with_the_shadow(tmp_path):
    path = tmp_path / "event.occ"
    path.write_text(KOALA)
    data = observing.StellarOccultation.read_koala(path, body="A")
    assert data.errors_of_chords.to_value("s")[0].tolist() == [0.02, 0.03]
    assert data.sign.tolist().count(0.0) == 1
    assert data.times[0].isot == "2008-12-11T00:00:00.000"
    # The Earth moves by -10 km/s along the ecliptic's pole, at the star to the west by 10 sin and to the south by 10
    # cos of the obliquity. The first station moves with it, so that it stays where it is from the Earth.
    positions = data.stations.vectors.to_value("km")
    assert positions[0, 1] == pytest.approx(positions[0, 0], abs=1e-2)
    assert positions[1] - positions[0] == pytest.approx(np.array([[-1.0, 2.0], [-1.0, 2.0]]), abs=1e-2)


FORMS = {
    "koala": [
        ("", "not in the format of KOALA"),
        (KOALA.replace("\n3\n", "\n5\n"), "a line for each chord"),
        (KOALA.replace("19.8874 -45.8740 3", "19.8874"), "9 columns"),
        (KOALA.replace("1\n", "two\n", 1), "not in the format of KOALA"),
    ],
    "occult": [
        ("<a>", "is not a file of Occult"),
        ("<AsteroidOccultations></AsteroidOccultations>", "has 0 events"),
        (OCCULT.replace("<Date>2008|12|11|7.7</Date>", ""), "the tag Date is ''"),
        (OCCULT.replace("7 43 50.25", "7 43"), "a time is '7 43'"),
        (OCCULT.replace("-110 57 30.5|", "west|"), "longitude or latitude is 'west'"),
    ],
}


@pytest.mark.parametrize(
    ("kind", "content", "message"), [(kind, *case) for kind, cases in FORMS.items() for case in cases]
)
def test_files_in_another_form_are_refused(kind, content, message, tmp_path):
    path = tmp_path / "event.xml"
    path.write_text(content)
    options = {} if kind == "koala" else {"geometry": passing()}
    refused(message, getattr(observing.StellarOccultation, f"read_{kind}"), path, **options)
