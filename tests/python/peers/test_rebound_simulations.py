"""Conversion from and to simulations of REBOUND."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
import rebound
from fullbody import forces
from fullbody.errors import InvalidInput
from support import refused


def test_conversion_to_rebound_and_back_is_exact():
    sim = rebound.Simulation()
    sim.G = 39.5
    sim.add(m=1.0, r=0.005)
    sim.add(m=1e-3, a=5.2, e=0.05, inc=0.02, Omega=1.0, omega=2.0, M=3.0)
    sim.move_to_com()
    system, state = fullbody.from_rebound(sim)
    assert system.bodies[0].shape == fullbody.Sphere(0.005)
    assert system.bodies[1].shape == fullbody.PointMass()
    back = fullbody.to_rebound(system, state)
    assert back.G == 39.5
    for particle, result in zip(sim.particles, back.particles, strict=True):
        assert result.xyz == particle.xyz
        assert result.vxyz == particle.vxyz
        np.testing.assert_allclose(result.r, particle.r, rtol=1e-14)


def test_to_rebound_strips_units():
    system, state = fullbody.systems.kw4(units=True)
    sim = fullbody.to_rebound(system, state)
    # Equal volumes, km.
    np.testing.assert_allclose(sim.particles[0].r, (1.417 * 1.361 * 1.183) ** (1 / 3) / 2, rtol=1e-14)
    np.testing.assert_allclose(sim.particles[1].m, 0.135e12)


def test_rebound_particles_without_mass_are_refused():
    sim = rebound.Simulation()
    refused("no particles", lambda: fullbody.from_rebound(sim))
    sim.add(m=1.0)
    sim.add(a=1.0)
    refused("particle 1", lambda: fullbody.from_rebound(sim))


@pytest.mark.parametrize(("active", "first"), [(0, 0), (1, 1), (2, 2)])
def test_rebound_test_particles_with_a_mass_are_refused(active, first):
    sim = rebound.Simulation()
    for k in range(3):
        sim.add(m=1e-3**k, x=k)
    assert len(fullbody.from_rebound(sim)[0]) == 3
    sim.N_active = active
    text = f"particle {first} has the mass .* for N_active is {active}; expected all 3"
    refused(text, fullbody.from_rebound, sim)
    sim.N_active = 3
    assert len(fullbody.from_rebound(sim)[0]) == 3


def sun_and_earth(*units):
    """The Sun and the Earth on a circle, in astronomical units, years and solar masses."""
    sim = rebound.Simulation()
    if units:
        sim.units = units
    else:
        sim.G = 4 * np.pi**2
    sim.add(m=1.0, r=0.00465, name="Sun")
    sim.add(m=3e-6, a=1.0)
    sim.t = 0.25
    return sim


def test_rebound_units_make_quantities_of_the_same_numbers():
    system, state = fullbody.from_rebound(sun_and_earth(), units=("au", "yr", "solMass"))
    # One revolution a year is v = 2 pi au / yr, 29.785 km/s.
    np.testing.assert_allclose(state.velocity[1, 1].to_value(u.km / u.s), 29.785, rtol=1e-4)
    assert state.position[1, 0] == 1.0 * u.au
    assert state.time == 0.25 * u.yr
    assert (state.spin == 0.0 * u.rad / u.yr).all()
    np.testing.assert_allclose(system.masses[1].to_value(u.kg), 5.97e24, rtol=1e-2)
    # Simulations without units: km, hour, kg, as for a System.
    assert fullbody.from_rebound(sun_and_earth(), units=True)[1].position.unit == u.km
    for none in (None, False):
        assert type(fullbody.from_rebound(sun_and_earth(), units=none)[1].position) is np.ndarray


def test_rebound_own_units_are_not_relabelled():
    sim = sun_and_earth("AU", "yr", "Msun")
    for wrong in (("km", "hour", "kg"), ("au", "yr", "kg"), ("au", "day", "solMass")):
        with pytest.raises(InvalidInput, match=rf"'{wrong[2]}|solMass'.*own, \('au', 'yr', 'msun'\); expected"):
            fullbody.from_rebound(sim, units=wrong)
    assert fullbody.from_rebound(sim)[0].units is None
    system, state = fullbody.from_rebound(sim, units=True)
    assert [u.Unit(name) for name in system.units] == [u.au, u.yr, u.Msun]
    assert (system, state) == fullbody.from_rebound(sim, units=("au", "yr", "M_sun"))
    np.testing.assert_allclose(system.G.to_value("m3 / (kg s2)"), 6.674e-11, rtol=1e-4)


@pytest.mark.parametrize(
    "names", ["m s kg", "cm hr g", "km day msun", "au yr mearth", "pc kyr mjupiter", "au gyr msun"]
)
def test_rebound_units_are_those_of_astropy(names):
    """The sizes are those of rebound's own table, within the differences of the two packages' constants."""
    sim = rebound.Simulation()
    sim.units = length, time, mass = names.split()
    sim.add(m=1.0)
    sizes = (rebound.units.lengths_SI[length], rebound.units.times_SI[time], rebound.units.masses_SI[mass])
    units = fullbody.from_rebound(sim, units=True)[0].units
    for name, size, si in zip(units, sizes, ("m", "s", "kg"), strict=True):
        np.testing.assert_allclose(u.Unit(name).to(si), size, rtol=1e-4)


def test_rebound_units_without_a_name_are_refused():
    sim = sun_and_earth("AU", "yr2pi", "Msun")
    refused("'yr2pi', which astropy has no name for; expected one of s, hour", fullbody.from_rebound, sim, units=True)
    refused("'yr2pi'", lambda: fullbody.from_rebound(sim, units=("au", "yr", "solMass")))
    # A sidereal year is not a Julian one.
    with pytest.raises(InvalidInput, match="'sidereal_yr'"):
        fullbody.from_rebound(sun_and_earth("AU", "sidereal_yr", "Msun"), units=("au", "yr", "solMass"))
    assert fullbody.from_rebound(sim)[0].G == sim.G


def test_names_are_kept_in_rebound_and_back():
    names = ["Größe 1999 KW₄", None, "probe"]
    system = fullbody.System([fullbody.Body(fullbody.PointMass(), mass=1.0, name=name) for name in names], G=1.0)
    state = fullbody.State([[0, 0, 0], [1, 0, 0], [5, 0, 0]], np.zeros((3, 3)))
    sim = fullbody.to_rebound(system, state)
    assert [particle.name for particle in sim.particles] == names
    assert [body.name for body in fullbody.from_rebound(sim)[0].bodies] == names


def test_rebound_wrong_arguments_are_named():
    system, state = fullbody.systems.case1()
    single = fullbody.State([[0, 0, 0]], [[0, 0, 0]])
    refused("number of bodies in the state is 1; expected 2", lambda: fullbody.to_rebound(system, single))
    refused(r"system is 3; expected a System", lambda: fullbody.to_rebound(3, state))
    refused(r"state is 4; expected a State", lambda: fullbody.to_rebound(system, 4))
    for wrong in (3, None, "sim", [rebound.Simulation()]):
        refused(r"sim is .*; expected a rebound\.Simulation", lambda wrong=wrong: fullbody.from_rebound(wrong))


def test_converting_to_rebound_warns_of_lost_forces():
    system, state = fullbody.systems.kw4()
    with_tide = system.with_forces([forces.Tide("Alpha", "Beta", 1e-5, 0.01)])
    with pytest.warns(UserWarning, match=r"no external forces \(tide on Alpha\)"):
        sim = fullbody.to_rebound(with_tide, state)
    assert sim.N == 2
    sim.additional_forces = lambda pointer: None
    with pytest.warns(UserWarning, match="additional forces or operators, which are left out"):
        fullbody.from_rebound(sim)
