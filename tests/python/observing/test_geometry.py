"""Vectors to the observer and to the Sun agree with catalogues, closed forms and kernels; invalid input is refused."""

import warnings

import astropy.units as u
import fullbody
import numpy as np
import pytest
import spiceypy
from astropy.coordinates import EarthLocation, get_body_barycentric
from astropy.table import Table
from astropy.time import Time
from astropy.utils import iers
from fullbody import observing
from fullbody.errors import InconsistentInput, InvalidInput
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq
from support import DATA, refused
from support.eris import EPOCH, ERIS

#: The speed of light in km/s.
C = 299792.458


#: An orbit about the Sun.
ORBIT = fullbody.KeplerElements(1.6442 * u.au, 0.3837, *(angle * u.deg for angle in (3.408, 73.196, 319.319, 330.0)))


@pytest.fixture(scope="module")
def catalogue():
    """Distance, right ascension and declination of Eris as Grundy et al. (2019) list them."""
    return Table.read(DATA / "observations" / "tno" / "2003_ub313_astrometry.csv", format="ascii.csv")


def dates(catalogue):
    return Time(np.array(catalogue["time"]), format="jd", scale="utc")


def system_of(**options):
    """A system of two points, A and B, with negligible gravity."""
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m, name=name) for m, name in ((1.0, "A"), (3.0, "B"))]
    return fullbody.System(bodies, G=1e-30, gravity="point", **options)


def test_an_orbit_about_the_sun_gives_the_distances_and_directions_of_a_catalogue(catalogue):
    geometry = observing.Geometry.from_orbit(ERIS, EPOCH, span=dates(catalogue))
    from_observer = -fullbody.frames.rotate(geometry.to_observer(dates(catalogue)), "ecliptic", "equatorial")
    distance = np.linalg.norm(from_observer, axis=1).to_value("au")
    # The published semi-major axis has a relative precision of 1e-4.
    np.testing.assert_allclose(distance, catalogue["dist"], rtol=1e-4)
    ra, dec = fullbody.frames.pole_angles(from_observer)
    error = np.hypot(ra - np.radians(15 * catalogue["RA-Primary"]), dec - np.radians(catalogue["DEC-Primary"]))
    near = np.array(catalogue["time"]) < 2454000
    # Within half a year of the elements' epoch the error is that of their digits; in nine years Jupiter moves the Sun.
    assert np.degrees(error[near]).max() * 3600 < 0.5
    assert np.degrees(error).max() * 3600 < 60
    listed = {"ra": catalogue["RA-Primary"] * u.hourangle, "dec": catalogue["DEC-Primary"] * u.deg}
    from_catalogue = observing.Geometry.from_radec(dates(catalogue), **listed, distance=catalogue["dist"] * u.au)
    direct = -fullbody.frames.rotate(from_catalogue.to_observer(dates(catalogue)[near]), "equatorial", "ecliptic")
    np.testing.assert_allclose(-geometry.to_observer(dates(catalogue)[near]), direct, rtol=1e-4)


def test_vectors_of_an_orbit_agree_with_a_numerical_solution_of_the_light_time_equation():
    span = Time(["2022-09-01", "2022-11-01"], scale="tdb")
    at_arrival = observing.Geometry.from_orbit(ORBIT, "2022-09-26 TDB", span=span)
    at_emission = observing.Geometry.from_orbit(ORBIT, "2022-09-26 TDB", span=span, light_time=False)
    rotation = fullbody.frames.rotation("equatorial", "ecliptic")
    mu = 1.32712440041279419e11

    def barycentric(name, date):
        return rotation @ get_body_barycentric(name, date, ephemeris="builtin").xyz.to_value("km")

    def position(date):
        elapsed = (date - Time("2022-09-26", scale="tdb")).to_value("s")
        a = ORBIT.a.to_value("km")
        angles = [x.to_value("rad") for x in (ORBIT.i, ORBIT.Omega, ORBIT.omega, ORBIT.M)]
        propagated = fullbody.KeplerElements(a, ORBIT.e, *angles[:3], angles[3] + np.sqrt(mu / a**3) * elapsed)
        return barycentric("sun", date) + propagated.to_cartesian(mu)[0]

    def light_path(vector):
        """The vector, a function of the light time, at the root of the light-time equation, and the light time."""
        delay = brentq(lambda t: t - np.linalg.norm(vector(t)) / C, 0.0, 1000.0, xtol=1e-9)
        return vector(delay), delay

    for day in (0.0, 13.21, 30.7, 60.999):
        date = span[0] + day * u.day
        expected, delay = light_path(lambda delay, date=date: barycentric("earth", date) - position(date - delay * u.s))
        scale = np.linalg.norm(expected)
        assert np.linalg.norm(at_arrival.to_observer(date).value - expected) < 2e-9 * scale
        sun = barycentric("sun", date - delay * u.s) - position(date - delay * u.s)
        assert np.linalg.norm(at_arrival.to_sun(date).value - sun) < 2e-9 * np.linalg.norm(sun)
        expected, _ = light_path(lambda delay, date=date: barycentric("earth", date + delay * u.s) - position(date))
        assert np.linalg.norm(at_emission.to_observer(date).value - expected) < 2e-9 * scale


def test_an_observatory_keeps_its_distance_from_the_earths_centre_and_rotates_at_the_sidereal_rate(monkeypatch):
    # Astropy 6 would download the newest rotation of the Earth; its own table contains 2022.
    monkeypatch.setattr(iers.conf, "auto_download", False)
    span = Time(["2022-10-01", "2022-10-03"], scale="tdb")
    site = EarthLocation.from_geodetic(10 * u.deg, 50 * u.deg, 100 * u.m)
    geocentric, topocentric = (
        observing.Geometry.from_orbit(ORBIT, "2022-09-26 TDB", span=span, observer=observer)
        for observer in ("earth", site)
    )
    times = span[0] + np.linspace(0.0, 2.0, 40) * u.day
    site_vector = topocentric.to_observer(times) - geocentric.to_observer(times)
    site_vector = fullbody.frames.rotate(site_vector, "ecliptic", "equatorial")
    expected = np.linalg.norm([site.x.to_value("km"), site.y.to_value("km"), site.z.to_value("km")])
    # The asteroid moves by 1e-4 of the distance in the time that light takes from the site to the centre of the Earth.
    np.testing.assert_allclose(np.linalg.norm(site_vector, axis=1).value, expected, rtol=3e-4)
    angle = np.unwrap(np.arctan2(site_vector[:, 1], site_vector[:, 0]).value)
    rate = np.polyfit(np.linspace(0.0, 2.0, 40), angle, 1)[0] / (2 * np.pi)
    # The pole of the Earth at that date is 2e-3 rad from that of J2000.
    assert rate == pytest.approx(1.00273790935, abs=5e-4)


def test_directions_of_bodies_in_uniform_motion_solve_the_light_time_equation():
    # The speeds are a hundredth of that of light, so that approximations for small speeds fail the test.
    system = system_of(units=("km", "s", "kg"), frame="equatorial")
    r, v = np.array([[3.0e4, -2.0e4, 5.0e3], [0, 0, 0]]), np.array([[1500.0, 2500.0, -800.0], [0, 0, 0]])
    r[1], v[1] = -r[0] / 3, -v[0] / 3
    with pytest.warns(InconsistentInput, match="the speed of escape"):
        run = system.integrate(fullbody.State(position=r, velocity=v), 40.0, dense=True)
    d = np.array([9.0e5, 4.0e5, -2.0e5])
    geometry = observing.Geometry([0.0, 60.0] * u.s, to_observer=d * u.km)
    times = np.array([5.0, 12.5, 30.0])
    data = observing.Astrometry(times * u.s, np.zeros(3), np.zeros(3), 1.0, body="A", about="B", geometry=geometry)

    def from_observer(k, t):
        delay = brentq(lambda x: x - np.linalg.norm(d - r[k] - v[k] * (t - x)) / C, 0.0, 20.0, xtol=1e-15)
        return r[k] + v[k] * (t - delay) - d

    for t, (east, north) in zip(times, data.predict(run), strict=True):
        about, body = from_observer(1, t), from_observer(0, t)
        line_of_sight = about / np.linalg.norm(about)
        parallel = np.cross([0, 0, 1], line_of_sight) / np.hypot(line_of_sight[0], line_of_sight[1])
        depth = body @ line_of_sight
        np.testing.assert_allclose(east, body @ parallel / depth, rtol=1e-9)
        np.testing.assert_allclose(north, body @ np.cross(line_of_sight, parallel) / depth, rtol=1e-9)
    np.testing.assert_allclose(data.emission(system).to_value("s"), times - np.linalg.norm(d) / C, rtol=1e-14)


def test_utc_times_of_observations_are_converted_to_tdb():
    # TT - UTC was 69.184 s in 2022, and TDB differs from TT by less than 2 ms.
    system = system_of(units=True, epoch="2022-09-26T00:00:00 TDB", frame="ecliptic")
    span = Time(["2022-09-25", "2022-09-28"], scale="tdb")
    geometry = observing.Geometry(span, to_observer=[1.0, 0, 0] * u.au, light_time=False)
    data = observing.Astrometry(Time(["2022-09-26T00:00:00"], scale="utc"), [0.0], [0.0], 1.0, geometry=geometry)
    assert data.emission(system).to_value("s")[0] == pytest.approx(69.184, abs=2e-3)


def test_predictions_do_not_depend_on_the_frames_of_geometry_and_system():
    vectors = np.array([[0.1, 0.02, -0.03], [0.101, 0.019, -0.03]])
    predictions = []
    for geometry_frame in ("ecliptic", "equatorial"):
        for system_frame in ("ecliptic", "equatorial"):
            system, state = fullbody.systems.didymos(units=True)
            system = system.with_options(frame=system_frame)
            state = fullbody.frames.rotate_state(state, "ecliptic", system_frame)
            to_observer = fullbody.frames.rotate(vectors, "ecliptic", geometry_frame) * u.au
            geometry = observing.Geometry([0.0, 1.0] * u.day, to_observer=to_observer, frame=geometry_frame)
            data = observing.Astrometry([10.0] * u.h, [0.0], [0.0], 1.0, geometry=geometry)
            predictions.append(data.predict(system.integrate(state, 12.0, dense=True)))
    np.testing.assert_allclose(predictions, [predictions[0]] * 4, rtol=1e-9)


def test_geometry_from_a_systems_third_body_sun_equals_that_from_its_orbit():
    span = Time(["2022-09-27", "2022-10-10"], scale="tdb")
    system = system_of(units=True, epoch="2022-09-26 TDB", frame="ecliptic")
    sun = fullbody.forces.ThirdBody(mu=1.32712440041279419e11 * u.km**3 / u.s**2, orbit=ORBIT, of="system", name="Sun")
    system = system.with_forces([sun])
    from_system = observing.Geometry.from_system(system, span=span)
    from_orbit = observing.Geometry.from_orbit(ORBIT, "2022-09-26 TDB", span=span)
    times = span[0] + [0.0, 3.3, 13.0] * u.day
    # In the system the mu of the orbit includes the masses of the bodies, 4e-19 of it.
    for name in ("to_observer", "to_sun"):
        np.testing.assert_allclose(getattr(from_system, name)(times), getattr(from_orbit, name)(times), rtol=1e-7)


def test_spice_kernel_of_uniform_motion_gives_the_closed_form(tmp_path):
    start, velocity = np.array([1.5e8, 2.0e7, -3.0e6]), np.array([12.0, -25.0, 4.0])
    earth = np.array([1.2e8, -8.0e7, 1.0e5])
    path, length = str(tmp_path / "line.bsp"), 4.0e5
    handle = spiceypy.spkopn(path, "line", 0)
    et = 7.0e8
    for body, r, v in ((20065803, start, velocity), (399, earth, np.zeros(3)), (10, np.zeros(3), np.zeros(3))):
        ends = np.array([et - length, et + length])
        states = np.hstack([r + v * (ends - et)[:, None], np.broadcast_to(v, (2, 3))])
        spiceypy.spkw13(handle, body, 0, "J2000", ends[0], ends[1], "line", 3, 2, states, ends)
    spiceypy.spkcls(handle)
    zero = Time(2451545.0, format="jd", scale="tdb") + et * u.s
    geometry = observing.Geometry.from_spice(20065803, span=zero + [0.0, 2.0] * u.day, kernels=[path])
    for day in (0.0, 1.234, 2.0):
        t = day * 86400.0
        delay = brentq(lambda x, t=t: x - np.linalg.norm(earth - start - velocity * (t - x)) / C, 0.0, 2000.0)
        expected = earth - start - velocity * (t - delay)
        vector = geometry.to_observer(zero + day * u.day)
        np.testing.assert_allclose(vector.to_value("km"), expected, rtol=1e-9)
        sun = -(start + velocity * (t - delay))
        np.testing.assert_allclose(geometry.to_sun(zero + day * u.day).to_value("km"), sun, rtol=1e-9)
    with pytest.raises(InvalidInput, match="kernels do not contain the position of 20065803"):
        observing.Geometry.from_spice(20065803, span=zero + [0.0, 20.0] * u.day, kernels=[path])


def test_vectors_are_interpolated_by_a_cubic_spline_for_rows_in_any_order():
    times = np.array([0.0, 1.0, 2.5, 3.0, 4.5, 5.0])
    vectors = np.stack([40 + np.sin(times), np.cos(times), 0.3 * times], axis=1)
    expected = CubicSpline(times, vectors)(2.2)
    order = [3, 0, 5, 1, 4, 2]
    shuffled = observing.Geometry(times[order], to_observer=vectors[order], light_time=False)
    np.testing.assert_allclose(shuffled.to_observer(2.2), expected, rtol=1e-14)
    np.testing.assert_array_equal(shuffled.to_observer(times), vectors)
    assert shuffled == observing.Geometry(times, to_observer=vectors, light_time=False)


def test_rows_too_far_apart_cause_a_warning_only_between_the_rows():
    times = np.arange(8.0)
    vectors = np.stack([np.sin(2.5 * times), np.cos(2.5 * times), np.ones(8)], axis=1)
    geometry = observing.Geometry(times, to_observer=vectors)
    geometry.to_observer(times)
    with pytest.warns(InconsistentInput, match="so far apart in time"):
        geometry.to_observer(2.5)


def test_errors_name_what_a_geometry_lacks():
    geometry = observing.Geometry([0.0, 10.0] * u.day, to_observer=[1.0, 0, 0] * u.au, frame="ecliptic")
    refused("has no Sun", lambda: geometry.to_sun(1 * u.day))
    refused("outside the span of the geometry", lambda: geometry.to_observer(11 * u.day))
    refused("is a date", lambda: geometry.to_observer(Time("2022-09-26")))
    refused("expected a Quantity", lambda: geometry.to_observer(1.0))
    data = observing.Astrometry([1.0] * u.day, [0.0], [0.0], 1.0, geometry=geometry)
    refused(r"frame='ecliptic'", lambda: data.emission(system_of(units=True)))
    refused("needs the system's units", lambda: data.emission(system_of(frame="ecliptic")))
    unitless = observing.Geometry([0.0, 10.0], to_observer=[1.0, 0, 0])
    with pytest.raises(InvalidInput, match=r"light time .* needs the system's units"):
        observing.Astrometry([1.0], [0.0], [0.0], 1.0, geometry=unitless).emission(system_of())
    dated = observing.Astrometry(Time(["2022-09-26"]), [0.0], [0.0], 1.0, geometry=unitless)
    refused("needs the date of the system's time zero", lambda: dated.emission(system_of(units=True)))
    for span in ("2022-09-26 TDB", [], ["yesterday"]):
        refused("span", observing.Geometry.from_orbit, ERIS, EPOCH, span=span)
    with pytest.raises(InvalidInput, match="hubble is not available from the ephemeris"):
        observing.Geometry.from_orbit(ERIS, EPOCH, span=["2022-09-26 TDB"], observer="hubble")


def test_rows_too_far_apart_for_their_spline_cause_a_warning_for_any_number_of_rows():
    # The vectors are those from one planet to another, both on circles.
    rng = np.random.default_rng(8)
    warned = accurate = 0
    for _ in range(150):
        rows, step = int(rng.integers(2, 9)), 10.0 ** rng.uniform(-2.3, 0.3)
        plane, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        radius, other, rate = 1.0, rng.uniform(0.0, 0.6), rng.uniform(-1.0, 1.0)

        def path(t, plane=plane, radius=radius, other=other, rate=rate):
            in_plane = radius * np.exp(1j * t) + other * np.exp(1j * (rate * t + 1.0))
            return np.stack([in_plane.real, in_plane.imag, 0 * t], axis=-1) @ plane

        times = step * np.arange(rows)
        geometry = observing.Geometry(times, to_observer=path(times), light_time=False)
        between = np.linspace(times[0], times[-1], 101)
        with warnings.catch_warnings(record=True) as caught_warnings:
            warnings.simplefilter("always")
            interpolated = geometry.to_observer(between)
        exact = path(between)
        error = (np.linalg.norm(interpolated - exact, axis=1) / np.linalg.norm(exact, axis=1)).max()
        if error > 1e-2:
            warned += 1
            assert caught_warnings, (rows, step, error)
        elif error < 1e-5:
            accurate += 1
            assert not caught_warnings, (rows, step, error)
    assert min(warned, accurate) > 20
