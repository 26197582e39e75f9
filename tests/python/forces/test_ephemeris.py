"""Third bodies from ephemerides, against astropy at other times and against Kepler's equation."""

import sys

import fullbody
import numpy as np
import pytest
from astropy import units as u
from astropy.coordinates import BarycentricMeanEcliptic, SkyCoord, get_body_barycentric
from astropy.time import Time
from fullbody.errors import InvalidInput
from fullbody.forces import ThirdBody
from support.scenes import kepler_position

DATE = "2022-09-26T12:00:00 TDB"
ELEMENTS = (1.6442, 0.38385, 3.4079, 73.196, 319.32, 232.01)
ORBIT = fullbody.KeplerElements(ELEMENTS[0] * u.au, ELEMENTS[1], *(angle * u.deg for angle in ELEMENTS[2:]))
GM_SUN = 132712440041.279419


def helio(days):
    """The system from the Sun in km, ecliptic, by Kepler's equation in longdouble."""
    elements = [ELEMENTS[0] * 149597870.7, ELEMENTS[1], *np.radians(ELEMENTS[2:])]
    return np.array([kepler_position(elements, GM_SUN, 86400.0 * day) for day in days], dtype=float)


def planet(name, days):
    """A planet from the Sun in km, ecliptic, by astropy's rotation of coordinates."""
    times = Time(DATE.split()[0], scale="tdb") + days * u.day
    heliocentric = get_body_barycentric(name, times) - get_body_barycentric("sun", times)
    rotated = SkyCoord(heliocentric, frame="icrs", representation_type="cartesian").transform_to(
        BarycentricMeanEcliptic()
    )
    return rotated.cartesian.xyz.to_value("km").T


def spot(third, days, units=("km", "hour", "kg")):
    """The path that the core interpolates in the table, in km."""
    system, _ = fullbody.systems.kw4(units=units, frame="ecliptic")
    return system.with_forces([third]).third_body(third.name, days * u.day)[0].to_value("km")


@pytest.mark.parametrize("name", ["earth", "mars", "jupiter", "moon"])
def test_splines_of_planets_agree_with_astropy(name):
    days = np.random.default_rng(5).uniform(0.0, 200.0, 60)
    third = ThirdBody.from_ephemeris(name, DATE, orbit=ORBIT, duration=200 * u.day)
    expected = planet(name, days) - helio(days)
    error = np.linalg.norm(spot(third, days) - expected, axis=1) / np.linalg.norm(expected, axis=1)
    assert error.max() < 1.5e-9
    # The table is no denser than that needs.
    assert len(third.times) < 4000
    assert third.name == name.title()


def test_the_sun_is_opposite_to_the_heliocentric_position():
    days = np.random.default_rng(6).uniform(-900.0, 0.0, 50)
    third = ThirdBody.from_ephemeris("Sun", DATE, orbit=ORBIT, duration="-900 day")
    expected = -helio(days)
    error = np.linalg.norm(spot(third, days) - expected, axis=1) / np.linalg.norm(expected, axis=1)
    assert error.max() < 1.5e-9
    # A third body on the orbit itself is at the same positions.
    other = ThirdBody(mu=GM_SUN * u.km**3 / u.s**2, orbit=ORBIT, of="system", name="Sun")
    np.testing.assert_allclose(spot(other, days), expected, atol=1e-11 * 3e8)


def test_ephemerides_have_the_units_frame_and_epoch_of_the_system():
    quantities = ThirdBody.from_ephemeris("earth", DATE, orbit=ORBIT, duration=30 * u.day)
    unitless = ThirdBody.from_ephemeris("earth", DATE, orbit=ORBIT, duration=720.0, units=("km", "hour", "kg"))
    np.testing.assert_allclose(unitless.times, quantities.times.to_value("h"), rtol=1e-14)
    np.testing.assert_allclose(unitless.positions, quantities.positions.to_value("km"), rtol=1e-14)
    assert unitless.mu == pytest.approx(398600.435507 * 3600.0**2, rel=1e-15)
    system, state = fullbody.systems.kw4(frame="ecliptic")
    run = system.with_forces([unitless]).integrate(state, 10.0)
    assert np.abs(run.energy_drift).max() < 1e-13
    with pytest.raises(fullbody.FullbodyError, match="Earth"):
        system.with_forces([unitless]).integrate(state, 1e4)
    # The equator, by name and by a matrix.
    named = ThirdBody.from_ephemeris("earth", DATE, orbit=ORBIT, duration=30 * u.day, frame="equatorial")
    matrix = fullbody.frames.rotation("ecliptic", "equatorial")
    rotated = ThirdBody.from_ephemeris("earth", DATE, orbit=ORBIT, duration=30 * u.day, frame=matrix)
    np.testing.assert_allclose(rotated.positions.value, named.positions.value, atol=1e-4)
    np.testing.assert_allclose(named.positions.value, quantities.positions.value @ matrix.T, atol=1e-4)
    # Elements of another date.
    rate = np.sqrt(GM_SUN / (ELEMENTS[0] * 149597870.7) ** 3) * 86400.0
    earlier = fullbody.KeplerElements(
        ORBIT.a, ORBIT.e, ORBIT.i, ORBIT.Omega, ORBIT.omega, ORBIT.M - 10.0 * rate * u.rad
    )
    moved = ThirdBody.from_ephemeris("earth", DATE, orbit=earlier, epoch="2022-09-16T12:00:00 TDB", duration=30 * u.day)
    np.testing.assert_allclose(moved.positions.value, quantities.positions.value, atol=1e-3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "vulcan"}, "name is 'vulcan'; expected one of sun, mercury"),
        ({"name": "pluto"}, "pluto is not available from the ephemeris 'builtin'"),
        ({"date": "yesterday"}, "date is 'yesterday'; expected a date with its time scale"),
        ({"orbit": None}, "orbit is None; expected the KeplerElements"),
        ({"orbit": fullbody.KeplerElements([1.0, 2.0] * u.au, *([[0.1, 0.1]] * 5))}, "one orbit"),
        ({"orbit": fullbody.KeplerElements(1.6, 0, 0, 0, 0, 0)}, "semi-major axis of orbit is 1.6; expected a Quan"),
        ({"duration": 10.0}, r"duration is 10.0; expected a Quantity"),
        ({"duration": 0 * u.day}, "duration is 0; expected a time"),
        ({"duration": 3e4 * u.yr}, "expected a shorter one|is not available"),
        ({"duration": 1 * u.km}, "duration has the unit km"),
        ({"frame": [[1, 0, 0], [0, 1, 0], [0, 0, 2]]}, r"frame is .*; expected 'ecliptic', 'equatorial' or a rotation"),
        ({"ephemeris": "/no/such/file.bsp"}, "ephemeris '/no/such/file.bsp'|needs the package"),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_unavailable_ephemerides_are_refused(change, message):
    arguments = {"name": "earth", "date": DATE, "orbit": ORBIT, "duration": 10 * u.day} | change
    with pytest.raises((InvalidInput, ModuleNotFoundError), match=message):
        ThirdBody.from_ephemeris(**arguments)


def test_a_missing_package_of_ephemerides_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "jplephem", None)
    with pytest.raises(ModuleNotFoundError, match="'de440' needs the package jplephem: pip install jplephem"):
        ThirdBody.from_ephemeris("earth", DATE, orbit=ORBIT, duration=10 * u.day, ephemeris="de440")
