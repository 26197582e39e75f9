"""Kepler elements: periods, units, arrays, along a run, and other angles by the conventions of REBOUND."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import KeplerElements
from fullbody.errors import InconsistentInput, InvalidInput
from support import refused, worst
from support.toml_texts import PAIR


def angle_between_directions(item, other):
    """Angle between two directions of a plane."""
    return np.abs((np.asarray(item) - other + np.pi) % (2 * np.pi) - np.pi).max()


def test_angles_are_reduced():
    back = KeplerElements.from_cartesian(*KeplerElements(2.5, 0.3, 0.7, -1.0, 8.0, -0.5).to_cartesian(1.0), 1.0)
    for angle, expected in ((back.Omega, -1.0), (back.omega, 8.0), (back.M, -0.5)):
        assert 0 <= angle < 2 * np.pi
        assert angle_between_directions(angle, expected) < 1e-14


def test_periods_are_keplers():
    assert KeplerElements(4.0, 0.3, 0, 0, 0, 0).period(4.0) == pytest.approx(8 * np.pi, rel=1e-15)
    period = KeplerElements([1.0, 4.0], 0.1, 0, 0, 0, 0).period(1.0)
    assert period == pytest.approx([2 * np.pi, 16 * np.pi], rel=1e-15)
    year = KeplerElements(1 * u.AU, 0.0, 0, 0, 0, 0).period(1.32712440018e20 * u.m**3 / u.s**2)
    assert year.to_value(u.day) == pytest.approx(365.2569, abs=1e-4)


def test_elements_have_units():
    k = KeplerElements(2548 * u.m, 0.0004, 156.1 * u.deg, 105.4 * u.deg, 319.7 * u.deg, 0 * u.deg)
    unitless = KeplerElements(2.548, 0.0004, *np.deg2rad([156.1, 105.4, 319.7, 0.0]))
    mu = 2.152
    r, v = k.to_cartesian(mu * u.km**3 / u.hour**2)
    r_unitless, v_unitless = unitless.to_cartesian(mu)
    assert worst(r.to_value(u.km), r_unitless) < 1e-14
    assert worst(v.to_value(u.km / u.hour), v_unitless) < 1e-14
    back = KeplerElements.from_cartesian(r, v, mu * u.km**3 / u.hour**2)
    assert back.a.to_value(u.km) == pytest.approx(2.548, rel=1e-13)
    assert back.i.to_value(u.deg) == pytest.approx(156.1, rel=1e-13)
    assert not isinstance(back.e, u.Quantity)


def test_elements_may_be_arrays():
    a = np.array([1.0, 2.0, 3.0])
    k = KeplerElements(a, [0.1, 0.2, 0.3], 0.5, 0.0, 0.1, [0.0, 1.0, 2.0])
    r, v = k.to_cartesian(1.5)
    assert r.shape == v.shape == (3, 3)
    for n in range(3):
        item = KeplerElements(a[n], [0.1, 0.2, 0.3][n], 0.5, 0.0, 0.1, float(n)).to_cartesian(1.5)
        assert np.array_equal(item[0], r[n])
        assert np.array_equal(item[1], v[n])
    back = KeplerElements.from_cartesian(r, v, 1.5)
    assert len(back) == 3
    assert worst(back.a, a) < 1e-14
    assert pytest.approx(back.M[1]) == back[1].M
    assert back[1].e == back.e[1]


def test_scalars_are_floats():
    k = KeplerElements.from_cartesian([1, 0, 0], [0, 1.1, 0], 1.0)
    assert all(isinstance(value, float) for value in (k.a, k.e, k.i, k.Omega, k.omega, k.M))


def test_the_elements_of_a_spherical_pair_stay():
    bodies = [fullbody.Body(fullbody.Sphere(0.1), mass=m) for m in (1.0, 0.5)]
    system = fullbody.System(bodies, G=2.0)
    orbit = KeplerElements(1.2, 0.3, 0.4, 0.5, 0.6, 0.7)
    r, v = orbit.to_cartesian(3.0)
    run = system.integrate(fullbody.State(np.add([[0, 0, 0], r], [1, 2, 3]), [[0, 0, 0], v]), 4.0, output=0.5)
    k = run.elements()
    assert k.a.shape == (9,)
    for name in ("a", "e", "i", "Omega", "omega"):
        assert np.abs(getattr(k, name) - getattr(orbit, name)).max() < 1e-11
    assert angle_between_directions(k.M, 0.7 + run.time * np.sqrt(3.0 / 1.2**3)) < 1e-11
    # The other way round: the same but for the half turn of the periapsis.
    assert angle_between_directions(run.elements(body=0, about=1).omega, 0.6 + np.pi) < 1e-11
    assert np.abs(run.elements(mu=6.0).a - 1.2).min() > 0.1


def test_an_orbit_whose_mean_motion_overflows_is_refused():
    """The mean motion is sqrt(mu / a^3), which is 1e480 here."""
    refused("mean motion", lambda: KeplerElements(1e-320, 0.0, 0.0, 0.0, 0.0, 0.0))


def ours_and_rebounds(a, e, inc, Omega, arguments, time=0.3):
    """Return position and velocity (6,) by both programs."""
    rebound = pytest.importorskip("rebound")
    simulation = rebound.Simulation()
    simulation.add(m=1.0)
    simulation.t = time
    simulation.add(a=a, e=e, inc=inc, Omega=Omega, **arguments)
    body = simulation.particles[1]
    arguments = arguments | ({"mu": 1.0, "time": time} if "T" in arguments else {})
    r, v = KeplerElements(a, e, inc, Omega, **arguments).to_cartesian(1.0)
    return np.array([*r, *v]), np.array([body.x, body.y, body.z, body.vx, body.vy, body.vz])


@pytest.mark.parametrize("anomaly", ["M", "f", "T", "l", "theta"])
@pytest.mark.parametrize("periapsis", ["omega", "pomega"])
def test_elements_have_the_conventions_of_rebound(anomaly, periapsis):
    """Of 100 orbits with e up to 0.97, every second one is retrograde, and every fourth one is a hyperbola."""
    rng = np.random.default_rng([len(anomaly), ord(anomaly[0]), len(periapsis)])
    for k in range(100):
        bound = k % 4 > 0
        e = rng.uniform(0.01, 0.97) if bound else rng.uniform(1.05, 3.0)
        a = 10.0 ** rng.uniform(-1.0, 2.0) * (1.0 if bound else -1.0)
        inc = rng.uniform(0.05, 1.5) if k % 2 else rng.uniform(1.65, 3.1)
        Omega, angle = rng.uniform(-6.0, 6.0, 2)
        value = rng.uniform(-6.0, 6.0) if bound else rng.uniform(-0.9, 0.9) * np.arccos(-1.0 / e)
        if not bound and anomaly == "theta":
            direction = 1.0 if inc < np.pi / 2 else -1.0
            value = Omega + direction * (value + (angle if periapsis == "omega" else direction * (angle - Omega)))
        result, expected = ours_and_rebounds(a, e, inc, Omega, {periapsis: angle, anomaly: value})
        for part in (slice(3), slice(3, 6)):
            assert np.abs(result[part] - expected[part]).max() < 3e-13 * np.abs(expected[part]).max(), (k, e)


def test_arrays_and_units_go_in():
    """At e = 1/2 a true anomaly of 120 degrees is E = 90 degrees, as cos E = (e + cos f)/(1 + e cos f) = 0."""
    orbit = KeplerElements("2 km", 0.5, 0.0, 0.0, "10 deg", f=[0.0, 120.0, 240.0] * u.deg)
    np.testing.assert_allclose(orbit.M, [0.0, np.pi / 2 - 0.5, 1.5 * np.pi + 0.5], rtol=1e-15)
    orbit = KeplerElements("1 au", 0.2, 0.0, 0.0, 0.0, T="-25 d", mu="1 au3/yr2", time="0 d")
    np.testing.assert_allclose(orbit.M, 25.0 / 365.25, rtol=1e-14)
    system, _ = fullbody.systems.kw4(units=True)
    by_system = KeplerElements(2.5, 0.0, 0.0, 0.0, 0.0, T=-1.0, mu=system.mu())
    np.testing.assert_allclose(by_system.M, np.sqrt(system.mu().value / 2.5**3), rtol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"omega": 0.0}, "the elements have no M; expected one of M, f, T, l, theta"),
        ({"omega": 0.0, "M": 0.0, "f": 0.0}, "both M and f; expected one of"),
        ({"M": 0.0}, "the elements have no omega; expected one of omega, pomega"),
        ({"M": 0.0, "omega": 0.0, "pomega": 0.0}, "both omega and pomega"),
        ({"omega": 0.0, "T": 1.0}, "mu is not given beside T, which is 1.0"),
        ({"omega": 0.0, "M": 1.0, "mu": 1.0}, "mu is 1.0 without T"),
        ({"omega": 0.0, "T": "1 d", "mu": 1.0}, "T has the unit d, but mu has none"),
        ({"omega": 0.0, "f": "1 km"}, "f has the unit km"),
    ],
)
def test_an_orbit_without_exactly_one_anomaly_is_refused(arguments, message):
    refused(message, lambda: KeplerElements(1.0, 0.1, 0.2, 0.3, **arguments))


def test_a_true_anomaly_beyond_the_asymptote_is_refused():
    with pytest.raises(InvalidInput, match=r"true anomaly is 2\.5 on a hyperbola of e = 2; expected below 2\.0944"):
        KeplerElements(-1.0, 2.0, 0.0, 0.0, 0.0, f=2.5)


def test_warnings_of_degrees_name_the_given_angle():
    with pytest.warns(InconsistentInput, match="theta is 245 radians"):
        KeplerElements(1.0, 0.1, 0.0, 0.0, 0.0, theta=245.0)


def test_a_file_takes_the_same_words(tmp_path):
    words = 'orbit = { about = "body 0", a = 2.0, e = 0.5, i = 0, Omega = 0, pomega = "10 deg", f = "120 deg" }'
    text = PAIR.replace("position = [3, 0, 0]\nvelocity = [0, 0.6, 0]", words)
    path = tmp_path / "system.toml"
    path.write_text(text.replace("body 0", "A").replace("radius", 'name = "A"\nradius'))
    orbit = KeplerElements(2.0, 0.5, 0.0, 0.0, np.radians(10.0), np.pi / 2 - 0.5)
    assert fullbody.read_toml(path).state.position[1] == pytest.approx(orbit.to_cartesian(1.001)[0], rel=1e-14)
    path.write_text(path.read_text().replace('f = "120 deg"', 'f = "120 deg", M = 0'))
    refused(r"body\[1\]\.orbit: the elements have both M and f", lambda: fullbody.read_toml(path))
