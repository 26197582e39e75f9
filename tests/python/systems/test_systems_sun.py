"""The Sun of the ready-made systems has the right position in every frame."""

import fullbody
import numpy as np
import pytest
import rebound
from astropy import units as u
from astropy.coordinates import get_body_barycentric
from fullbody import forces, systems
from support import ready, refused

pytestmark = pytest.mark.usefixtures("memoised_searches")

AU = 149597870.7
BINARIES = ("didymos", "didymos_after_dart", "dinkinesh", "fg3_1996", "patroclus_menoetius", "antiope", "sn263_2001")


def sun(system, time=0.0):
    result = system.third_body("Sun", time)[0]
    return np.asarray(getattr(result, "value", result)) / AU


@pytest.mark.parametrize("name", BINARIES)
def test_the_sun_is_the_same_in_every_frame(name):
    seen = []
    for frame in ("ecliptic", "equatorial", "orbit"):
        system, state = getattr(systems, name)(frame=frame, sun=True)
        r, v = state.position[1] - state.position[0], state.velocity[1] - state.velocity[0]
        basis = np.array([r, v, np.cross(r, v)])
        basis /= np.linalg.norm(basis, axis=1)[:, None]
        force = system.loads(state)["Sun"].force[1]
        seen.append([*(basis @ sun(system)), *(basis @ force / np.linalg.norm(force))])
    np.testing.assert_allclose(seen[1], seen[0], atol=1e-10)
    np.testing.assert_allclose(seen[2], seen[0], atol=1e-10)


@pytest.mark.parametrize("name", BINARIES)
def test_the_orbit_about_the_sun_is_the_published_one(name):
    facts = systems.published(name)
    a, e, *degrees = facts["heliocentric orbit (a, e, i, Omega, omega, M), ecliptic"]
    i, node, argument, mean = np.radians(degrees)
    system, _ = getattr(systems, name)(frame="ecliptic", sun=True)
    days = 0.0 if system.epoch is None else system.epoch.tdb.jd - facts["epoch of the heliocentric orbit"]
    sim = rebound.Simulation()
    sim.add(m=0.01720209895**2)
    sim.add(a=a, e=e, inc=i, Omega=node, omega=argument, M=mean + 0.01720209895 * a**-1.5 * days)
    np.testing.assert_allclose(sun(system), -np.array(sim.particles[1].xyz), atol=3e-6)


def test_didymos_at_the_impact_of_dart():
    # It was 1.046 au from the Sun and 0.0757 au from the Earth, 11.3 million kilometres.
    system, _ = ready("didymos", sun=True)
    assert np.linalg.norm(sun(system)) == pytest.approx(1.046, abs=1e-3)
    a, e, *degrees = systems.published("didymos")["heliocentric orbit (a, e, i, Omega, omega, M), ecliptic"]
    orbit = fullbody.KeplerElements(a * u.au, e, *(degrees * u.deg))
    earth = forces.ThirdBody.from_ephemeris(
        "earth", system.epoch, orbit=orbit, epoch="2022-01-21 TDB", duration=10.0, units=("km", "hour", "kg")
    )
    with_earth = system.with_forces([*system.forces, earth])
    assert np.linalg.norm(with_earth.third_body("Earth", 0.0)[0]) == pytest.approx(0.0757 * AU, rel=2e-3)


def test_kw4_takes_its_pole_and_epoch():
    # The Earth was 0.0346 au away on 25 May 2019, 23:05; the plane is the one of the assumed pole.
    system, state = systems.kw4(sun=True, epoch="2019-05-25T23:05:00 TDB")
    lon, lat = np.radians([325.8, -61.8])
    pole = fullbody.frames.pole_vector(lon, lat)
    node = np.array([-np.sin(lon), np.cos(lon), 0.0])
    x, y, z = sun(system)
    ecliptic = x * node + y * np.cross(pole, node) + z * pole
    separation = get_body_barycentric("earth", system.epoch) - get_body_barycentric("sun", system.epoch)
    earth = fullbody.frames.rotate(separation.xyz.to_value("au"), "equatorial", "ecliptic")
    # Elements of two years before, to four digits.
    assert np.linalg.norm(earth + ecliptic) == pytest.approx(0.0346, rel=0.02)
    assert np.linalg.norm(sun(systems.kw4(sun=True)[0])) == pytest.approx(0.2006, abs=5e-4)
    run = system.integrate(state, 20.0)
    assert np.abs(run.energy_drift).max() < 1e-13
    assert np.abs(run.work["Sun"]).max() > 0.0


def test_units_and_other_forces_stay():
    unitless, _ = ready("didymos", sun=True)
    tide = forces.Tide("Didymos", "Dimorphos", k2=1e-5, lag=0.01)
    for units in (True, ("m", "s", "kg")):
        system, state = systems.didymos(sun=True, units=units, forces=[tide])
        assert [force.name for force in system.forces] == ["tide on Didymos", "Sun"]
        np.testing.assert_allclose(system.third_body("Sun", 0.0)[0].to_value("au"), sun(unitless), rtol=1e-12)
        lag = system.forces[0].lag
        assert lag == 0.01 if units is True else lag.to_value("hour") == pytest.approx(0.01)
        force = system.loads(state)["tide on Didymos"].force[0].to_value("N")
        if units is True:
            expected = force
    np.testing.assert_allclose(force, expected, rtol=1e-10)
    assert systems.didymos()[0].forces == ()
    refused("sun is 'yes'; expected True or False", lambda: systems.didymos(sun="yes"))


def test_without_the_sun_nothing_changes():
    for name in ("kw4", *BINARIES):
        assert getattr(systems, name)(sun=False) == getattr(systems, name)()
