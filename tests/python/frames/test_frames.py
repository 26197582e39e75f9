"""Frames, poles, epochs: against astropy's own coordinates and published directions."""

import pickle

import astropy.units as u
import fullbody
import numpy as np
import pytest
from astropy.coordinates import BarycentricMeanEcliptic, SkyCoord
from astropy.time import Time
from fullbody import frames
from fullbody.errors import InvalidInput
from support import ready, refused

#: Obliquity of the ecliptic at J2000, IAU 2006 (Capitaine et al. 2003).
OBLIQUITY = np.radians(84381.406 / 3600)


def test_the_ecliptic_is_rotated_about_the_equinox_by_the_obliquity():
    c, s = np.cos(OBLIQUITY), np.sin(OBLIQUITY)
    expected = [[1, 0, 0], [0, c, s], [0, -s, c]]
    # The ICRS differs from the equator and equinox of J2000 by some hundredths of an arc second.
    np.testing.assert_allclose(frames.rotation("equatorial", "ecliptic"), expected, atol=2e-7)


def test_poles_are_rotated_as_by_astropy():
    lon, lat = frames.rotate_pole(310 * u.deg, -84 * u.deg, "ecliptic", "equatorial")
    expected = SkyCoord(310 * u.deg, -84 * u.deg, frame=BarycentricMeanEcliptic()).icrs
    assert abs(lon - expected.ra).to_value(u.arcsec) < 1e-6
    assert abs(lat - expected.dec).to_value(u.arcsec) < 1e-6
    back = frames.rotate_pole(lon, lat, "equatorial", "ecliptic")
    np.testing.assert_allclose([b.to_value(u.deg) for b in back], [310, -84], rtol=1e-13)


def test_any_frame_of_astropy_and_none_else():
    # The north galactic pole for J2000: 12h 51m 26.282s, +27d 07' 42.01" (Reid & Brunthaler 2004).
    ra, dec = frames.rotate_pole(0.0, np.pi / 2, "galactic", "equatorial")
    np.testing.assert_allclose(np.degrees([ra, dec]), [192.859508, 27.128336], atol=1e-4)
    # Names of no frame, and frames that belong to an observer, a time, a moving origin or aberrated light.
    for name in ("elliptic", "altaz", "hadec", "teme", "itrs", "hcrs", "fk4", None, 3):
        for pair in ((name, "equatorial"), ("ecliptic", name)):
            expected = "expected 'ecliptic', 'eclipj2000', 'equatorial' or a frame"
            refused(f"{name!r}.*; {expected}", lambda pair=pair: frames.rotation(*pair))


def test_attitude_of_a_pole_points_z_there():
    lon, lat, w = 2.0, -1.1, 0.7
    state = fullbody.State([[0, 0, 0]], [[0, 0, 0]], [frames.attitude(lon, lat, w)])
    x, _, z = state.rotation_matrix[0].T
    np.testing.assert_allclose(z, frames.pole_vector(lon, lat), atol=1e-15)
    # W is measured from the node of the body's equator, which lies at right angles to the pole and in the xy-plane.
    node = np.array([-np.sin(lon), np.cos(lon), 0.0])
    np.testing.assert_allclose(x @ node, np.cos(w), atol=1e-15)
    np.testing.assert_allclose(np.cross(node, x) @ z, np.sin(w), atol=1e-15)
    refused("latitude", lambda: frames.attitude(0.0, 2.0))


@pytest.mark.parametrize("degrees", [False, True])
def test_elements_rotate_like_their_vectors(degrees):
    a, e, mu = 2.5 * u.km, 0.3, 2e-6 * u.km**3 / u.s**2
    angles = np.radians([156.1, 105.4, 319.7, 40.0]) * u.rad
    angles = angles.to(u.deg) if degrees else angles
    orbit = fullbody.KeplerElements(a, e, *angles)
    rotated = orbit.to_frame("ecliptic", "equatorial")
    assert rotated.a == a
    assert rotated.e == e
    assert rotated.i.unit == angles.unit
    for arguments, result in zip(orbit.to_cartesian(mu), rotated.to_cartesian(mu), strict=True):
        expected = SkyCoord(*arguments.value, frame=BarycentricMeanEcliptic(), representation_type="cartesian").icrs
        np.testing.assert_allclose(result.value, expected.cartesian.xyz.value, rtol=1e-12)
    back = rotated.to_frame("equatorial", "ecliptic")
    for name in ("i", "Omega", "omega", "M"):
        np.testing.assert_allclose(getattr(back, name).value, getattr(orbit, name).value, rtol=1e-12)


def test_elements_of_a_run_are_in_its_frame():
    """Patroclus' published pole has the right ascension 178 and the declination -74.1 degrees, so i is 164.1."""
    system, state = fullbody.systems.patroclus_menoetius(gravity="point")
    elements = system.integrate(state, 2.0, output=1.0).elements()
    assert elements.frame == elements[0].frame == "equatorial"
    np.testing.assert_allclose(np.degrees([elements.i, elements.Omega]), [[164.1] * 3, [268.0] * 3], rtol=1e-9)
    rotated = elements.to_frame(target="ecliptic")
    pole = SkyCoord(178 * u.deg, -74.1 * u.deg).transform_to(BarycentricMeanEcliptic())
    np.testing.assert_allclose(np.degrees(rotated.i), 90 - pole.lat.deg, rtol=1e-9)
    np.testing.assert_allclose(np.degrees(rotated.Omega), pole.lon.deg + 90 - 360 * (pole.lon.deg > 270), rtol=1e-9)
    assert rotated.frame == "ecliptic"
    assert rotated == elements.to_frame("equatorial", "ecliptic")
    # What is given goes before what is known, for a system's frame is but a name.
    assert elements.to_frame("ecliptic", "ecliptic") != rotated
    np.testing.assert_allclose(rotated.to_frame(target="equatorial").Omega, elements.Omega, rtol=1e-9)
    relative = (state.position[1] - state.position[0], state.velocity[1] - state.velocity[0], system.mu())
    made = fullbody.KeplerElements.from_cartesian(*relative, frame=system.frame)
    assert made.frame == "equatorial"
    np.testing.assert_allclose(made.to_frame(target="ecliptic").i, rotated.i[0], rtol=1e-12)


def test_elements_of_an_unknown_frame_are_not_rotated():
    orbit = fullbody.KeplerElements(2.0, 0.1, 0.2, 0.3, 0.4, 0.5)
    system, state = fullbody.systems.case1()
    for elements in (orbit, system.integrate(state, 1.0).elements()):
        assert elements.frame is None
        refused(r"the frame that .* not known; expected origin='ecliptic'", elements.to_frame, target="equatorial")
        elements.to_frame("ecliptic", "equatorial")
    _, plane = ready("didymos", frame="orbit")
    with pytest.raises(InvalidInput, match="cannot rotate from the frame 'orbit' to 'ecliptic'"):
        ready("didymos", frame="orbit")[0].integrate(plane, 1.0).elements().to_frame(target="ecliptic")


def test_a_frame_of_elements_is_kept_and_compared():
    values = (2.0, 0.1, [0.2, 0.3], 0.3, 0.4, 0.5)
    of_date = BarycentricMeanEcliptic(equinox="J2015")
    made = [fullbody.KeplerElements(*values, frame=frame) for frame in (None, "ecliptic", "equatorial", of_date)]
    made.append(fullbody.KeplerElements(*values, frame=BarycentricMeanEcliptic()))
    for k, item in enumerate(made):
        assert [item == other for other in made] == [k == n for n in range(len(made))]
        twin = pickle.loads(pickle.dumps(item))
        assert twin == item
        assert repr(twin) == repr(item)
        assert twin[1] == item[1]
    assert repr(made[1]).endswith("M=0.5, frame='ecliptic')")
    assert "frame" not in repr(made[0])
    with pytest.raises(AttributeError, match="cannot be changed"):
        made[0].frame = "ecliptic"


def test_a_hyperbola_and_arrays_are_rotated():
    orbit = fullbody.KeplerElements(-1.0, 1.5, np.array([0.1, 0.2]), 0.3, 0.4, -2.0, frame="ecliptic")
    back = orbit.to_frame(target="equatorial").to_frame(target="ecliptic")
    np.testing.assert_allclose(back.i, orbit.i, rtol=1e-12)
    np.testing.assert_allclose(back.M, [-2.0, -2.0], rtol=1e-12)


def test_epochs_are_read_in_any_form():
    system, state = fullbody.systems.kw4(units=True, epoch=Time(2459849.0, format="jd", scale="tdb"))
    assert system.epoch == Time("2022-09-26T12:00:00", scale="tdb")
    run = system.integrate(state, 2 * u.hour, output=1 * u.hour)
    assert run.dates.scale == "tdb"
    np.testing.assert_allclose((run.dates - system.epoch).to_value(u.s), [0, 3600, 7200], atol=1e-6)
    unitless, _ = fullbody.systems.case1(epoch="2000-01-01T12:00:00 tt")
    assert unitless.options["epoch"] == "2000-01-01T12:00:00 TT"
    refused("scale", lambda: fullbody.systems.case1(epoch="2000-01-01"))
    refused("no epoch", lambda: fullbody.systems.case1()[0].integrate(fullbody.systems.case1()[1], 1.0).dates)


def test_epoch_and_frame_survive_a_file(tmp_path):
    system, state = fullbody.systems.case1(epoch="2000-01-01T12:00:00 TT")
    system = system.with_options(frame="ecliptic")
    run = system.integrate(state, 1.0)
    run.save(tmp_path / "run.nc")
    loaded = fullbody.load(tmp_path / "run.nc")
    assert loaded == run
    assert loaded.system.frame == "ecliptic"
    assert loaded.system.epoch == system.epoch


@pytest.mark.parametrize(
    ("vector", "what"),
    [
        ([1.0, 2.0], r"has shape \(2,\); expected \(\.\.\., 3\)"),
        (1.0, r"has shape \(\); expected \(\.\.\., 3\)"),
        ([1.0, np.nan, 0.0], "is .*nan.*; expected finite numbers"),
        ("up", "is 'up'; expected numbers"),
        (None, "is None; expected finite numbers"),
    ],
)
def test_values_that_are_no_vectors_are_refused(vector, what):
    refused("vectors " + what, lambda: frames.rotate(vector, "ecliptic", "equatorial"))
    refused("vector " + what, lambda: frames.pole_angles(vector))


def test_values_that_are_no_directions_or_states_are_refused():
    refused(r"vector is .*; expected three numbers that are not all zero", frames.pole_angles, [[0, 0, 1], [0, 0, 0]])
    refused("state is 3; expected a State", lambda: frames.rotate_state(3, "ecliptic", "equatorial"))


def test_vectors_with_units_keep_them():
    rotated = frames.rotate([0 * u.km, 0 * u.km, 1000 * u.m], "ecliptic", "equatorial")
    assert rotated.unit.is_equivalent(u.km)
    np.testing.assert_allclose(rotated[2].to_value(u.km), np.cos(np.deg2rad(84381.406 / 3600)), rtol=1e-6)
    longitude, latitude = frames.pole_angles([0, 2, 2] * u.km)
    np.testing.assert_allclose([longitude, latitude], [np.pi / 2, np.pi / 4], rtol=1e-15)


def test_the_ecliptic_is_that_of_astropy():
    axes = SkyCoord([0, 90, 0] * u.deg, [0, 0, 90] * u.deg).transform_to(BarycentricMeanEcliptic())
    expected = axes.cartesian.xyz.value
    np.testing.assert_allclose(frames.rotation("equatorial", "ecliptic"), expected, atol=1e-16)
    np.testing.assert_allclose(frames.rotation("ecliptic", "icrf"), expected.T, atol=1e-16)


def test_the_ecliptic_of_spice_is_a_frame_of_its_own():
    """The mean ecliptic of J2000 of astropy differs from SPICE's ECLIPJ2000 by 0.04 arc seconds."""
    spice = pytest.importorskip("spiceypy")
    theirs = spice.pxform("J2000", "ECLIPJ2000", 0.0)
    np.testing.assert_allclose(frames.rotation("equatorial", "eclipj2000"), theirs, atol=1e-15)
    np.testing.assert_allclose(frames.rotation("eclipj2000", "icrs"), theirs.T, atol=1e-15)
    np.testing.assert_allclose(frames.rotation("eclipj2000", "eclipj2000"), np.eye(3), atol=1e-15)
    between = frames.rotation("ecliptic", "eclipj2000")
    angle = np.linalg.norm(between - np.eye(3)) / np.sqrt(2.0)
    assert 0.03 < np.degrees(angle) * 3600 < 0.06
    # The rotation through an intermediate frame is the direct one.
    through = frames.rotation("eclipj2000", "galactic") @ between
    np.testing.assert_allclose(through, frames.rotation("ecliptic", "galactic"), atol=1e-15)
