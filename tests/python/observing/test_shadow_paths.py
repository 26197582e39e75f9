"""Paths of shadows over the Earth: stations on them and beside them, errors, tables, pictures, what is refused."""

import astropy.units as u
import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from astropy.coordinates import AltAz, EarthLocation, SkyCoord, get_sun
from astropy.time import Time
from fullbody import observing
from support import refused

START = Time("2024-03-01T02:00:00", scale="utc")
STAR = SkyCoord(160.0 * u.deg, 15.0 * u.deg)
RADIUS = 200.0


@pytest.fixture(scope="module")
def passage():
    """A run of a sphere and a geometry from the centre of the Earth, over which its shadow passes."""
    direction = np.asarray(STAR.cartesian.xyz.value)
    east = np.cross([0.0, 0.0, 1.0], direction)
    east /= np.linalg.norm(east)
    north = np.cross(direction, east)
    ends = np.array([-1500.0, 1500.0])
    # The observer moves to the east and a little to the north past the body, by 15 km/s.
    positions = -2e8 * direction + np.outer(ends, 14.5 * east + 3.0 * north) + 1500.0 * north
    geometry = observing.Geometry(START + ends * u.s, to_observer=positions * u.km, frame="equatorial")
    body = fullbody.Body(fullbody.Sphere(RADIUS), mass=1e15, name="A")
    system = fullbody.System([body], units=("km", "s", "kg"), epoch=START, frame="equatorial")
    return system.integrate(
        fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)), time=-3000.0), 1500.0, dense=True
    ), geometry


def position(path, name, k, shift=0.0):
    """A station on a line of a path, moved to the north by an angle in degrees."""
    return EarthLocation.from_geodetic(path.longitude[name][k] * u.deg, (path.latitude[name][k] + shift) * u.deg)


def test_stations_on_the_lines_of_a_path_see_what_it_says(passage):
    run, geometry = passage
    (path,) = observing.shadow_paths(run, STAR, geometry, n=21)
    on_earth = np.flatnonzero(
        ~path.longitude["centre"].mask & ~path.longitude["north"].mask & ~path.longitude["south"].mask
    )
    for k in on_earth[[2, len(on_earth) // 2, -3]]:
        inwards = {"north": -0.02, "south": 0.02}
        stations = [position(path, "centre", k)]
        stations += [position(path, name, k, sign * shift) for name, shift in inwards.items() for sign in (1.0, -1.0)]
        chords = observing.occultation_chords(run, STAR, stations, geometry)
        seen = {chord.station: chord for chord in chords}
        # Two kilometres within a limit there is a chord, and as far beyond it there is none.
        assert set(seen) == {0, 1, 3}
        middle = 0.5 * (seen[0].disappearance + seen[0].reappearance)
        assert middle.to_value("s") == pytest.approx(path.times[k].to_value("s"), abs=0.02)
        assert seen[0].duration.to_value("s") == pytest.approx(path.duration[k], rel=1e-3)


def test_altitudes_are_those_of_astropy(passage):
    (path,) = observing.shadow_paths(passage[0], STAR, passage[1], n=11)
    k = int(np.flatnonzero(~path.longitude["centre"].mask)[3])
    frame = AltAz(obstime=START + path.times[k], location=position(path, "centre", k))
    # Aberration and the Sun's parallax are left out.
    assert path.star_altitude[k] == pytest.approx(STAR.transform_to(frame).alt.deg, abs=0.01)
    assert path.sun_altitude[k] == pytest.approx(get_sun(frame.obstime).transform_to(frame).alt.deg, abs=0.02)


def test_errors_move_the_limits_outwards_by_their_part_across_the_path(passage):
    run, geometry = passage
    distance, sigma = 2e8, 50.0
    (path,) = observing.shadow_paths(run, STAR, geometry, errors=sigma / distance * u.rad, n=21)
    wider = fullbody.System(
        [fullbody.Body(fullbody.Sphere(RADIUS + sigma), mass=1e15)],
        units=("km", "s", "kg"),
        epoch=START,
        frame="equatorial",
    )
    big = wider.integrate(fullbody.State(np.zeros((1, 3)), np.zeros((1, 3)), time=-3000.0), 1500.0, dense=True)
    (other,) = observing.shadow_paths(big, STAR, geometry, n=401)
    middle = len(path.times) // 2
    limit = [lines["north"].compressed() for lines in (other.longitude, other.latitude)]
    order = np.argsort(limit[0])
    expected = np.interp(path.longitude["error_north"][middle], limit[0][order], limit[1][order])
    assert path.latitude["error_north"][middle] == pytest.approx(expected, abs=1e-3)
    # An error along the path alone does not widen it.
    along = np.array([14.5, 3.0]) / np.hypot(14.5, 3.0)
    (narrow,) = observing.shadow_paths(run, STAR, geometry, errors=1e-14 * np.outer(along, along) * u.rad**2, n=21)
    assert narrow.latitude["error_north"][middle] == pytest.approx(narrow.latitude["north"][middle], abs=1e-3)


def test_a_table_masks_what_is_not_on_the_earth(passage):
    (path,) = observing.shadow_paths(passage[0], STAR, passage[1], n=21)
    table = path.to_table()
    assert table.colnames[:3] == ["time", "longitude", "latitude"]
    assert np.asarray(table["longitude_north"].mask).any()
    assert abs((table["time"][10] - (START + path.times[10])).to_value("s")) < 1e-4
    assert not np.isnan(np.asarray(table["star_altitude"].unmasked)).any()


def test_a_path_is_drawn_on_the_axes_that_are_given(passage):
    (path,) = observing.shadow_paths(passage[0], STAR, passage[1], errors=5.0 * u.mas)
    _, ax = plt.subplots()
    assert path.plot(ax, stations=position(path, "centre", 60)) is ax
    labels = ax.get_legend_handles_labels()[1]
    assert labels == ["errors", "limits of A", "stations"]


def test_a_shadow_that_misses_the_earth_has_no_path(passage):
    run, geometry = passage
    other_star = SkyCoord(160.0 * u.deg, 15.01 * u.deg)
    assert observing.shadow_paths(run, other_star, geometry) == []


@pytest.mark.parametrize(
    ("errors", "message"),
    [
        (1.0, "errors is 1.0"),
        (1.0 * u.km, "errors has the unit km"),
        (-np.eye(2) * u.mas**2, "is no covariance"),
        ([1, 2] * u.mas, "errors is"),
    ],
)
def test_errors_that_are_no_angles_are_refused(passage, errors, message):
    refused(message, lambda: observing.shadow_paths(passage[0], STAR, passage[1], errors=errors))
