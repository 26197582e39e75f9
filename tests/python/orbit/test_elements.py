"""Kepler elements against rebound's, and against closed forms where rebound's angles are undefined."""

import fullbody
import numpy as np
import pytest
import rebound
from astropy import units as u
from fullbody import KeplerElements
from fullbody.errors import InvalidInput
from hypothesis import given
from hypothesis import strategies as st
from support import rot_x, rot_z, worst

angles = st.floats(0.0, 6.28)
ellipses = st.tuples(st.floats(0.1, 100.0), st.floats(0.0, 0.97), st.floats(0.0, np.pi), angles, angles, angles)
# Rebound answers M = 0 on a hyperbola with NaN; test_hyperbolas_are_exact_at_periapsis_and_far_out has that.
anomalies = st.floats(0.01, 9.0).flatmap(lambda M: st.sampled_from([M, -M]))
hyperbolas = st.tuples(st.floats(-100.0, -0.1), st.floats(1.05, 8), st.floats(0, np.pi), angles, angles, anomalies)


def by_rebound(a, e, i, Omega, omega, M, mu):
    sim = rebound.Simulation()
    sim.add(m=mu)
    sim.add(a=a, e=e, inc=i, Omega=Omega, omega=omega, M=M)
    p = sim.particles[1]
    return np.array(p.xyz), np.array(p.vxyz)


def apart(one, other):
    """Angle between two directions of a plane."""
    return np.abs((np.asarray(one) - other + np.pi) % (2 * np.pi) - np.pi).max()


@given(ellipses, st.floats(0.01, 100.0))
def test_elements_of_ellipses_are_rebounds(elements, mu):
    r, v = KeplerElements(*elements).to_cartesian(mu)
    r_expected, v_expected = by_rebound(*elements, mu)
    # Rebound stops Kepler's iteration at 1e-16 in E; the flattest orbits stretch that by 1 / (1 - e).
    limit = 2e-14 / (1 - elements[1])
    assert worst(r, r_expected) < limit
    assert worst(v, v_expected) < limit / (1 - elements[1])


@given(hyperbolas, st.floats(0.01, 100.0))
def test_elements_of_hyperbolas_are_rebounds(elements, mu):
    r, v = KeplerElements(*elements).to_cartesian(mu)
    r_expected, v_expected = by_rebound(*elements, mu)
    assert worst(r, r_expected) < 1e-12
    assert worst(v, v_expected) < 1e-12


@given(st.one_of(ellipses, hyperbolas), st.floats(0.01, 100.0))
def test_energy_and_angular_momentum_are_those_of_the_elements(elements, mu):
    """Energy is -mu / 2a, angular momentum sqrt(mu a (1 - e^2)) along the normal of (i, Omega)."""
    a, e, i, Omega, _, _ = elements
    r, v = KeplerElements(*elements).to_cartesian(mu)
    distance = np.linalg.norm(r)
    energy = v @ v / 2 - mu / distance
    assert energy == pytest.approx(-mu / (2 * a), abs=1e-14 * (mu / distance + v @ v))
    normal = np.array([np.sin(i) * np.sin(Omega), -np.sin(i) * np.cos(Omega), np.cos(i)])
    expected = np.sqrt(mu * a * (1 - e * e)) * normal
    assert worst(np.cross(r, v), expected, scale=distance * np.linalg.norm(v)) < 2e-15 * 4 / min(abs(1 - e), 1.0)


@given(st.one_of(ellipses, hyperbolas), st.floats(0.01, 100.0))
def test_elements_of_a_cartesian_state_describe_it(elements, mu):
    r, v = KeplerElements(*elements).to_cartesian(mu)
    back = KeplerElements.from_cartesian(r, v, mu)
    again = back.to_cartesian(mu)
    a, e = elements[:2]
    limit = 1e-13 / min(abs(1 - e), 1.0) ** 2 * (1 + abs(elements[5]))
    assert back.a == pytest.approx(a, rel=limit)
    assert back.e == pytest.approx(e, abs=limit)
    assert worst(again[0], r) < limit
    assert worst(again[1], v) < limit


def test_angles_of_a_general_orbit():
    elements = (2.5, 0.3, 0.7, 1.1, 2.2, 3.3)
    back = KeplerElements.from_cartesian(*KeplerElements(*elements).to_cartesian(1.7), 1.7)
    values = [back.a, back.e, back.i, back.Omega, back.omega, back.M]
    assert values == pytest.approx(elements, rel=1e-14)


def test_angles_are_reduced():
    back = KeplerElements.from_cartesian(*KeplerElements(2.5, 0.3, 0.7, -1.0, 8.0, -0.5).to_cartesian(1.0), 1.0)
    for angle, expected in ((back.Omega, -1.0), (back.omega, 8.0), (back.M, -0.5)):
        assert 0 <= angle < 2 * np.pi
        assert apart(angle, expected) < 1e-14


def test_a_circle_counts_its_anomaly_from_the_node():
    mu, radius, i, Omega, u0 = 3.0, 2.0, 0.6, 0.9, 1.3
    frame = rot_z(Omega) @ rot_x(i)
    r = frame @ [radius * np.cos(u0), radius * np.sin(u0), 0]
    v = frame @ [-np.sqrt(mu / radius) * np.sin(u0), np.sqrt(mu / radius) * np.cos(u0), 0]
    k = KeplerElements.from_cartesian(r, v, mu)
    assert k.a == pytest.approx(radius, rel=1e-15)
    assert k.e < 1e-15
    assert k.i == pytest.approx(i, rel=1e-14)
    assert pytest.approx(Omega, rel=1e-14) == k.Omega
    assert apart(k.omega + k.M, u0) < 1e-14
    if k.e == 0:
        assert k.omega == 0


@pytest.mark.parametrize("i", [0.0, np.pi])
def test_an_equatorial_orbit_counts_its_periapsis_from_x(i):
    mu, a, e, periapsis = 1.0, 1.0, 0.4, 0.8
    sense = np.cos(i)
    frame = rot_z(sense * periapsis) @ np.diag([1.0, sense, sense])
    r, v = frame @ [a * (1 - e), 0, 0], frame @ [0, np.sqrt(mu / a * (1 + e) / (1 - e)), 0]
    k = KeplerElements.from_cartesian(r, v, mu)
    assert k.i == i
    assert k.Omega == 0.0
    assert apart(k.omega, periapsis) < 1e-14
    assert apart(k.M, 0.0) < 1e-14
    assert k.e == pytest.approx(e, rel=1e-14)
    assert worst(k.to_cartesian(mu)[0], r) < 1e-14


def test_a_circle_in_the_equator_counts_its_anomaly_from_x():
    k = KeplerElements.from_cartesian([0, 2, 0], [-1, 0, 0], 2.0)
    assert (k.a, k.e, k.i, k.Omega, k.omega) == (2.0, 0.0, 0.0, 0.0, 0.0)
    assert pytest.approx(np.pi / 2, rel=1e-15) == k.M


def test_hyperbolas_are_exact_at_periapsis_and_far_out():
    r, v = KeplerElements(-1.0, 2.0, 0, 0, 0, 0).to_cartesian(1.0)
    assert r == pytest.approx([1.0, 0, 0], abs=1e-15)
    assert v == pytest.approx([0, np.sqrt(3), 0], abs=1e-15)
    # M = e sinh H - H with H = 5.
    r, _ = KeplerElements(-1.0, 2.0, 0, 0, 0, 2 * np.sinh(5.0) - 5.0).to_cartesian(1.0)
    assert np.linalg.norm(r) == pytest.approx(2 * np.cosh(5.0) - 1, rel=1e-13)


@pytest.mark.parametrize("E", [1e-6, 0.01, 1.0, 3.0])
@pytest.mark.parametrize("e", [0.0, 0.5, 0.99, 0.999999])
def test_keplers_equation_is_solved_to_round_off(e, E):
    """The mean anomaly is M = E - e sin E, in long double, for the cancellation near e = 1."""
    M = float(np.longdouble(E) - np.longdouble(e) * np.sin(np.longdouble(E)))
    r, _ = KeplerElements(1.0, e, 0, 0, 0, M).to_cartesian(1.0)
    expected = [np.cos(E) - e, np.sqrt((1 - e) * (1 + e)) * np.sin(E), 0]
    assert worst(r, expected) < 1e-14 + 2e-16 / (1 - e)


def test_periods_are_keplers():
    assert KeplerElements(4.0, 0.3, 0, 0, 0, 0).period(4.0) == pytest.approx(8 * np.pi, rel=1e-15)
    period = KeplerElements([1.0, 4.0], 0.1, 0, 0, 0, 0).period(1.0)
    assert period == pytest.approx([2 * np.pi, 16 * np.pi], rel=1e-15)
    year = KeplerElements(1 * u.AU, 0.0, 0, 0, 0, 0).period(1.32712440018e20 * u.m**3 / u.s**2)
    assert year.to_value(u.day) == pytest.approx(365.2569, abs=1e-4)


def test_elements_have_units():
    k = KeplerElements(2548 * u.m, 0.0004, 156.1 * u.deg, 105.4 * u.deg, 319.7 * u.deg, 0 * u.deg)
    plain = KeplerElements(2.548, 0.0004, *np.deg2rad([156.1, 105.4, 319.7, 0.0]))
    mu = 2.152
    r, v = k.to_cartesian(mu * u.km**3 / u.hour**2)
    r_plain, v_plain = plain.to_cartesian(mu)
    assert worst(r.to_value(u.km), r_plain) < 1e-14
    assert worst(v.to_value(u.km / u.hour), v_plain) < 1e-14
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
        one = KeplerElements(a[n], [0.1, 0.2, 0.3][n], 0.5, 0.0, 0.1, float(n)).to_cartesian(1.5)
        assert np.array_equal(one[0], r[n])
        assert np.array_equal(one[1], v[n])
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
    assert apart(k.M, 0.7 + run.time * np.sqrt(3.0 / 1.2**3)) < 1e-11
    # The other way round: the same but for the half turn of the periapsis.
    assert apart(run.elements(body=0, about=1).omega, 0.6 + np.pi) < 1e-11
    assert np.abs(run.elements(mu=6.0).a - 1.2).min() > 0.1


def test_an_orbit_whose_mean_motion_overflows_is_refused():
    """The mean motion is sqrt(mu / a^3), which is 1e480 here."""
    with pytest.raises(InvalidInput, match="mean motion"):
        KeplerElements(1e-320, 0.0, 0.0, 0.0, 0.0, 0.0)
