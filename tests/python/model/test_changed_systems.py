"""A system with another body, force or setting keeps everything else."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import forces
from fullbody.errors import InvalidInput
from support import refused
from support.meshes import box

EPOCH = "2022-09-26T23:14:24.183 UTC"


@pytest.fixture(scope="module")
def didymos():
    return fullbody.systems.didymos_after_dart(sun=True, units=True, gravity="surface")[0]


def two_spheres(mass=1.0):
    parts = [fullbody.Part(fullbody.Sphere(50 * u.m), mass=mass * u.kg, position=[x, 0, 0] * u.m) for x in (-40, 40)]
    return fullbody.Composite(parts)


@pytest.mark.parametrize("shape", [fullbody.Sphere(80 * u.m), fullbody.Ellipsoid(0.09, 0.08, 0.07), two_spheres(),
                                   box(0.13, 0.13, 0.13)])  # fmt: skip
@pytest.mark.parametrize("body", ["Dimorphos", 1])
def test_another_shape_keeps_the_rest(didymos, shape, body):
    other = didymos.with_body(body, shape)
    assert type(other["Dimorphos"].shape) is type(shape)
    np.testing.assert_allclose(other.masses.value, didymos.masses.value, rtol=1e-14)
    assert other.names == didymos.names
    assert other["Didymos"] == didymos["Didymos"]
    assert (other.options, other.units, other.G) == (didymos.options, didymos.units, didymos.G)
    assert other.epoch == didymos.epoch
    assert other.forces == didymos.forces
    # And back.
    back = other.with_body("Dimorphos", didymos["Dimorphos"].shape)
    np.testing.assert_allclose(back.masses.value, didymos.masses.value, rtol=1e-14)


def test_another_mass_or_density_keeps_the_rest(didymos):
    shape = fullbody.Sphere(80 * u.m)
    assert didymos.with_body(1, shape, mass=3e9 * u.kg)["Dimorphos"].mass == 3e9 * u.kg
    dense = didymos.with_body(1, shape, density="2 g/cm3")["Dimorphos"]
    np.testing.assert_allclose(dense.mass.to_value("kg"), 2000 * 4 / 3 * np.pi * 80**3, rtol=1e-13)
    np.testing.assert_allclose(
        didymos.with_body(1, two_spheres(), mass=4e9 * u.kg)[1].mass.to_value("kg"), 4e9, rtol=1e-14
    )
    for arguments, text in {
        ("Dimorfos", shape): "body is 'Dimorfos'; did you mean 'Dimorphos'",
        (1, "sphere"): "shape of Dimorphos is 'sphere'; expected an Ellipsoid",
        (1, shape, 1 * u.kg, 1 * u.kg / u.m**3): "Dimorphos is given both a mass and a density",
        (1, two_spheres(), None, 1 * u.kg / u.m**3): "density of Dimorphos is .*; expected a mass beside a composite",
    }.items():
        with pytest.raises(InvalidInput, match=text):
            didymos.with_body(*arguments[:2], **dict(zip(("mass", "density"), arguments[2:], strict=False)))


def test_one_more_force_keeps_the_rest(didymos):
    tide = forces.Tide(on="Didymos", by="Dimorphos", k2=1e-5, lag=1 * u.s)
    other = didymos.with_force(tide)
    assert [force.name for force in other.forces] == ["Sun", "tide on Didymos"]
    assert other == didymos.with_forces([*didymos.forces, tide])
    refused("tide on Didymos", lambda: other.with_force(tide))
    refused(r"forces has .tide.; expected forces of fullbody\.forces", lambda: didymos.with_force("tide"))


@pytest.mark.parametrize("option", ["bodies", "G", "units"])
def test_what_a_system_is_made_of_is_no_option(didymos, option):
    message = rf"'{option}' is not an option of with_options, .*; expected some of gravity, "
    refused(message, lambda: didymos.with_options(**{option: 1.0}))


def ephemeris():
    orbit = fullbody.KeplerElements(1.6442 * u.au, 0.38385, 3.408 * u.deg, 73.2 * u.deg, 319.3 * u.deg, 0.0)
    return forces.ThirdBody.from_ephemeris("sun", EPOCH, orbit=orbit, duration="20 day")


def test_a_path_for_another_date_is_refused(didymos, tmp_path):
    sun = ephemeris()
    assert sun.date == EPOCH
    fitting = didymos.with_forces([sun])
    for other in ("2000-01-01 TDB", "2022-09-26T23:14:24.183 TDB"):
        with pytest.raises(InvalidInput, match=f"path of Sun is for the date {EPOCH} at time zero, and the epoch of"):
            didymos.with_options(epoch=other, forces=[sun])
        refused("path of Sun is for the date", fitting.with_options, epoch=other)
    # The same moment in another time scale, and a system without an epoch, are accepted.
    same = fitting.epoch.tdb
    assert abs((fitting.with_options(epoch=same).epoch - fitting.epoch).to_value("s")) < 1e-6
    without = fitting.with_options(epoch=None)
    # Files keep the date.
    state = fullbody.systems.didymos_after_dart(units=True)[1]
    run = without.integrate(state, "1 hour")
    run.save(tmp_path / "run.nc")
    simulation = fullbody.Simulation(without, state)
    simulation.save(tmp_path / "simulation.fbs")
    for system in (fullbody.load(tmp_path / "run.nc").system,
                   fullbody.Simulation.load(tmp_path / "simulation.fbs").system):  # fmt: skip
        assert system == without
        refused("path of Sun is for the date", system.with_options, epoch="2000-01-01 TDB")
