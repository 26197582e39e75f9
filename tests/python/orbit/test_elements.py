"""Kepler elements in Python: against rebound's, with units, as arrays, and along a run."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import KeplerElements
from support import refused, worst


def apart(first, other):
    """Angle between two directions of a plane."""
    return np.abs((np.asarray(first) - other + np.pi) % (2 * np.pi) - np.pi).max()


def test_angles_are_reduced():
    back = KeplerElements.from_cartesian(*KeplerElements(2.5, 0.3, 0.7, -1.0, 8.0, -0.5).to_cartesian(1.0), 1.0)
    for angle, expected in ((back.Omega, -1.0), (back.omega, 8.0), (back.M, -0.5)):
        assert 0 <= angle < 2 * np.pi
        assert apart(angle, expected) < 1e-14


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
        single = KeplerElements(a[n], [0.1, 0.2, 0.3][n], 0.5, 0.0, 0.1, float(n)).to_cartesian(1.5)
        assert np.array_equal(single[0], r[n])
        assert np.array_equal(single[1], v[n])
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
    refused("mean motion", lambda: KeplerElements(1e-320, 0.0, 0.0, 0.0, 0.0, 0.0))
