"""Binaries and bodies from numbers as they are published: GM in place of masses, and draws within standard errors."""

import pickle

import fullbody
import numpy as np
import pytest
from astropy import constants
from astropy import units as u
from fullbody import Body, Component, Sphere, System, binary
from fullbody.errors import InvalidInput
from support import refused

STILL = float("inf")
SMALL = {"semi_major_axis": 3.0, "G": 2.0}
TWICE = {"GM": 1.0, "total_mass": 1.0, **SMALL}


def test_a_system_divides_GM_by_its_own_constant():
    system = System([Body(Sphere(0.4), GM=6.0), Body(Sphere(0.1), mass=1.0)], G=2.0)
    assert system.masses.tolist() == [3.0, 1.0]
    arguments = [Body(Sphere("390 m"), GM="36 m3/s2"), Body(Sphere("80 m"), GM="3e-10 km3/s2")]
    with_units = System(arguments, units=True, G="6.6e-11 m3/(kg s2)")
    assert with_units.masses.to_value(u.kg) == pytest.approx([36.0 / 6.6e-11, 0.3 / 6.6e-11], rel=1e-14)
    assert with_units.mu().to_value("m3/s2") == pytest.approx(36.3, rel=1e-14)


def test_a_body_by_itself_takes_the_constant_of_astropy_or_the_given_one():
    body = Body(Sphere("390 m"), GM="36 m3/s2", name="Didymos")
    assert body.mass.to_value(u.kg) == pytest.approx(36.0 / constants.G.value, rel=1e-14)
    assert body.density.to_value("kg/m3") == pytest.approx(
        36.0 / constants.G.value / (4 / 3 * np.pi * 390**3), rel=1e-14
    )
    field = body.gravity([1.0, 0.0, 0.0] * u.km, G=6e-11 * u.m**3 / u.kg / u.s**2).field
    assert field[0].to_value("m/s2") == pytest.approx(-36e-6, rel=1e-14)
    assert pickle.loads(pickle.dumps(body)) == body != Body(Sphere("390 m"), GM="37 m3/s2", name="Didymos")
    refused("mass of B follows from its GM and the G of a system", lambda: Body(Sphere(1.0), GM=1.0, name="B").mass)


def test_a_third_body_takes_GM_for_mu():
    orbit = fullbody.KeplerElements(100.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    item = fullbody.forces.ThirdBody(GM=2.0, orbit=orbit, of="body")
    assert item == fullbody.forces.ThirdBody(mu=2.0, orbit=orbit, of="body")
    with pytest.raises(InvalidInput, match=r"GM and mu of third body are 2\.0 and 1\.0; expected one of the two"):
        fullbody.forces.ThirdBody(GM=2.0, mu=1.0, orbit=orbit, of="body")


def test_a_binary_takes_GM_of_its_bodies_or_of_both():
    system, _ = binary(Component(diameter=1.0, rotation_period=STILL, GM=6.0), Component(diameter=0.1, GM=1.0), **SMALL)
    assert system.masses.tolist() == [3.0, 0.5]
    masses = {"GM": 6.0, "mass_ratio": 0.2}
    system, _ = binary(Component(diameter=1.0, rotation_period=STILL), Component(diameter=0.1), **masses, **SMALL)
    assert system.masses == pytest.approx([2.5, 0.5], rel=1e-14)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Body(Sphere(1.0), GM=1.0, mass=1.0), "the body is given both a mass and a GM; expected one of them"),
        (lambda: Body(Sphere(1.0), GM=1.0, density=1.0, mass=1.0), "a mass and a density and a GM"),
        (lambda: Body(Sphere(1.0)), "the body is given neither mass nor density nor GM"),
        (lambda: Body(Sphere(1.0), GM=-1.0), "GM of the body is -1.0; expected a finite number above zero"),
        (lambda: Component(diameter=1.0, GM=1.0, density=2.0), "a density and a GM; expected at most one of them"),
        (lambda: binary(Component(diameter=1.0), Component(diameter=0.1), **TWICE), "both total_mass and GM are given"),
    ],
)
def test_masses_that_are_given_twice_or_not_at_all_are_refused(make, message):
    refused(message, make)


def test_draws_have_the_means_and_the_errors_of_the_published_numbers():
    # The mean of 100 draws has an error of sigma / 10, and sigma one of 7 per cent; the limits are three of these.
    shapes = Component(diameter="780 ± 30 m", rotation_period="2.26 h"), Component(diameter="151 m")
    orbit = {"total_mass": "(5.4 ± 0.4)e11 kg", "mass_ratio": "0.0093(13)", "semi_major_axis": "1.19 ± 0.03 km"}
    pair = binary(*shapes, **orbit, units=True)
    drawn = pair.draw(100, rng=3)
    masses = np.array([system.masses.to_value(u.kg) for system, _ in drawn])
    radii = [system[0].shape.a.to_value(u.m) for system, _ in drawn]
    for result, mean, sigma in (
        (masses.sum(axis=1), 5.4e11, 4e10),
        (masses[:, 1] / masses[:, 0], 0.0093, 0.0013),
        (radii, 390, 15),
    ):
        assert np.mean(result) == pytest.approx(mean, abs=0.3 * sigma)
        assert np.std(result) == pytest.approx(sigma, rel=0.21)
    # The numbers without an error stay, and the draws are those of the seed.
    assert {system[1].shape.a.to_value(u.m) for system, _ in drawn} == {75.5}
    assert [s.masses[0] for s, _ in pair.draw(3, rng=3)] == [s.masses[0] for s, _ in drawn[:3]]
    assert pickle.loads(pickle.dumps(pair))[1] == pair[1]


def test_draws_stay_physical_where_errors_are_as_large_as_the_numbers():
    shapes = Component(diameter=1.0, rotation_period=STILL), Component(diameter=0.1)
    orbit = {"total_mass": 1.0, "mass_ratio": "0.01 ± 0.02", "semi_major_axis": 3.0, "eccentricity": "0.1 ± 0.1"}
    pair = binary(*shapes, **orbit, pole=("310 ± 4 deg", "-88 ± 4 deg"), G=1.0)
    assert all(system.masses.min() > 0.0 for system, _ in pair.draw(30, rng=1))


def test_draws_of_exact_numbers_are_refused():
    pair = binary(Component(diameter=1.0, rotation_period=STILL, mass=1.0), Component(diameter=0.1, mass=0.1), **SMALL)
    refused("no argument has a standard error; expected one such as", pair.draw, 2, rng=1)
