"""Third bodies and tides of other programs' input files, against textbook formulas in those programs' own terms."""

from pathlib import Path

import fullbody
import numpy as np
import pytest
import rebound
from fullbody import forces
from fullbody.errors import InvalidInput
from support import refused
from support.scenes import differential, kepler_position

DATA = Path(__file__).parents[2] / "data" / "peers"
EXTRA = "Additional Forces and Perturbations"
FLYBY = (5.9722e24, -1.1072e4, 9.1284, 0.1745, 0.3, 0.4, 3.0e5)
HELIO = (1.988e30, 246013901.32, 0.38362664, 0.059475759, 1.277649080300677, 5.5732150380, 2582993.15688)
FLYBY_NAMES = (
    "Planetary Mass",
    "Semimajor Axis",
    "Eccentricity",
    "Inclination",
    "RAAN",
    "Argument of Periapsis",
    "Flyby Time",
)
HELIO_NAMES = ("Solar Mass", *(f"Heliocentric {name}" for name in FLYBY_NAMES[1:6]), "Time of periapsis passage")
TIDE_NAMES = ("Love Number", "Reference Radius", "Tidal Lag Angle")
pytestmark = pytest.mark.filterwarnings("ignore:.* asks for:UserWarning")


def config(tmp_path, flags, numbers):
    """The pair of ellipsoids with switches and numbers."""
    lines = (DATA / "gubas_pair.cfg").read_text().split(f"[{EXTRA}]")[0]
    rows = {"Flyby": 0, "Solar Gravity": 0, "Tidal Torque": 0} | flags | numbers
    path = tmp_path / "pair.cfg"
    path.write_text(lines + f"[{EXTRA}]\n" + "\n".join(f"{name}: {value!r}" for name, value in rows.items()) + "\n")
    return path


def relative_acceleration(system, state, name):
    masses = np.asarray(getattr(system.masses, "value", system.masses))
    force = system.loads(state)[name].force
    force = np.asarray(getattr(force, "value", force))
    return force[1] / masses[1] - force[0] / masses[0]


def test_gubas_flyby_and_heliocentric_orbit(tmp_path):
    numbers = dict(zip(FLYBY_NAMES, FLYBY, strict=True)) | dict(zip(HELIO_NAMES, HELIO, strict=True))
    path = config(tmp_path, {"Flyby": 1, "Heliocentric Orbit": 1}, numbers)
    system, state = fullbody.read_gubas(path)
    assert [force.name for force in system.forces] == ["flyby", "Sun"]
    for name, (mass, *orbit), tolerance in (("flyby", FLYBY, 1e-5), ("Sun", HELIO, 1e-8)):
        for time in (0.0, 2.9e5, 4.0e5):
            at = kepler_position([*orbit[:-1], 0.0], system.G * mass, time - orbit[-1])
            np.testing.assert_allclose(
                system.third_body(name, time)[0], at, rtol=1e-11, atol=1e-11 * np.linalg.norm(at)
            )
            result = relative_acceleration(system, state.replace(time=time), name)
            expected = np.subtract(*(differential(x, at, system.G * mass) for x in state.position[::-1]))
            # The remaining difference is the pull on the bodies' quadrupoles.
            assert np.linalg.norm(result - expected) < tolerance * np.linalg.norm(expected)
    # GUBAS has no torque; a flyby has.
    assert np.abs(system.loads(state.replace(time=3.0e5))["flyby"].torque).max() > 0.0
    united, _ = fullbody.read_gubas(path, units=True)
    assert str(united.third_body("Sun", 0.0)[0].unit) == "km"
    np.testing.assert_allclose(united.third_body("Sun", 0.0)[0].value, system.third_body("Sun", 0.0)[0], rtol=1e-14)


def test_gubas_solar_gravity_is_a_circular_orbit(tmp_path):
    numbers = {"Solar Orbit Radius": 1.5, "AU Definition": 149597870700.0, "Solar Mass": 1.988e30}
    system, state = fullbody.read_gubas(config(tmp_path, {"Solar Gravity": 1}, numbers))
    radius, mu = 1.5 * 149597870.7, system.G * 1.988e30
    n = np.sqrt(mu / radius**3)
    for time in (0.0, 1e6):
        expected = -radius * np.array([np.cos(n * time), np.sin(n * time), 0.0])
        result = system.third_body("Sun", state.time + time)[0]
        np.testing.assert_allclose(result, expected, atol=1e-10 * radius)
    # Hill's problem in axes that do not turn: n^2 (3 x ex - r).
    r = state.position[1] - state.position[0]
    hill = n**2 * (3 * r * [1, 0, 0] - r)
    np.testing.assert_allclose(relative_acceleration(system, state, "Sun"), hill, atol=1e-7 * np.abs(hill).max())


def test_gubas_tides_dissipate(tmp_path):
    numbers = {
        f"{body} {name}": value
        for body in ("Primary", "Secondary")
        for name, value in zip(TIDE_NAMES, (0.1, 400.0, 0.02), strict=True)
    }
    system, state = fullbody.read_gubas(config(tmp_path, {"Tidal Torque": 1}, numbers), euler="radian")
    r, v = (array[1] - array[0] for array in (state.position, state.velocity))
    orbital = np.cross(r, v) / (r @ r)
    for body, force in enumerate(system.forces):
        spin = state.rotation_matrix[body] @ state.spin[body]
        frequency = max(2 * np.linalg.norm(spin - orbital), np.linalg.norm(orbital))
        assert force.lag == pytest.approx(np.sin(0.04) / frequency, rel=1e-12)
        assert (force.k2, force.radius) == (0.1, 0.4)
    run = system.integrate(state, state.time + 2e4)
    assert all(work[-1] < 0.0 for work in run.work.values())


@pytest.mark.filterwarnings("default")
def test_reading_gubas_warns_of_forces_that_it_computes_differently(tmp_path):
    orbit = dict(zip(FLYBY_NAMES, FLYBY, strict=True))
    with pytest.warns(UserWarning, match="asks for a flyby: GUBAS leaves out its torques"):
        fullbody.read_gubas(config(tmp_path, {"Flyby": 1}, orbit))
    solar = {"Solar Orbit Radius": 1.5, "AU Definition": 149597870700.0, "Solar Mass": 1.988e30}
    with pytest.warns(UserWarning, match="holds its direction fixed"):
        fullbody.read_gubas(config(tmp_path, {"Solar Gravity": 1}, solar))


def test_missing_or_invalid_forces_of_gubas_are_refused(tmp_path):
    orbit = dict(zip(FLYBY_NAMES, FLYBY, strict=True))
    for name in FLYBY_NAMES:
        with pytest.raises(InvalidInput, match=f"no '{name}' in the section"):
            fullbody.read_gubas(config(tmp_path, {"Flyby": 1}, {k: v for k, v in orbit.items() if k != name}))
    with pytest.raises(InvalidInput, match=r"pair\.cfg: semi-major axis is -11072"):
        fullbody.read_gubas(config(tmp_path, {"Flyby": 1}, orbit | {"Eccentricity": 0.5}))
    solar = {"Solar Orbit Radius": 1.5, "AU Definition": 149597870700.0} | dict(zip(HELIO_NAMES, HELIO, strict=True))
    with pytest.raises(InvalidInput, match=r"line \d+: .*expected one of the two"):
        fullbody.read_gubas(config(tmp_path, {"Solar Gravity": 1, "Heliocentric Orbit": 1}, solar))


SIANS = """
kepler: {kepler}
sun: 1
@ Masses
2.4e12
1.4e11
@ Semiaxes
0.76 0.74 0.67
0.28 0.23 0.17
@ Positions
{positions}
@ Velocities
{velocities}
@ Angles
0 0 10
0 0 0
@ Angular velocities
0 0 2.27
0 0 0.36
@ BID
0
1
"""


def check_sians(system, state, first, second):
    """The barycentre's place and speed about the Sun, and the tide on the pair, from heliocentric places and speeds."""
    masses = np.array([2.4e12, 1.4e11])
    shares = masses / masses.sum()
    mean = shares[0] * first + shares[1] * second
    at, moving = system.third_body("Sun", 0.0)
    np.testing.assert_allclose(at, -mean[0], atol=1e-12 * 1e8)
    np.testing.assert_allclose(moving, -mean[1], atol=1e-11 * np.linalg.norm(mean[1]))
    np.testing.assert_allclose(state.position[1] - state.position[0], second[0] - first[0], atol=2e-7)
    np.testing.assert_allclose(masses @ state.position, 0.0, atol=1e-3)
    result = relative_acceleration(system, state, "Sun")
    expected = np.subtract(*(differential(x, -mean[0], system.G * 1.989e30) for x in state.position[::-1]))
    np.testing.assert_allclose(result, expected, atol=1e-7 * np.abs(expected).max())


def test_sians_sun_cartesian(tmp_path):
    first = np.array([[1.1e8, 2.0e7, -1.0e6], [-2.0e4, 1.1e5, 1.0e3]])
    second = first + np.array([[2.5, 0.3, 0.1], [-0.1, 0.35, 0.0]])
    path = tmp_path / "sun.txt"
    rows = ["\n".join(" ".join(map(repr, body[k].tolist())) for body in (first, second)) for k in (0, 1)]
    path.write_text(SIANS.format(kepler=0, positions=rows[0], velocities=rows[1]))
    system, state = fullbody.read_sians(path, units="kmhr")
    check_sians(system, state, first, second)


@pytest.mark.parametrize("kepler", [1, 2])
def test_sians_sun_kepler(tmp_path, kepler):
    """The first row is the orbit about the Sun; mu is as in that program, and periods are days."""
    G = 6.67408e-11 * 3600.0**2 / 1e9
    orbits = ((9.57e7, 0.2, 38.9, 245.0, 192.6, 30.0), (2.548, 0.01, 10.0, 105.0, 319.0, 20.0))
    motions = []
    for (a, e, i, node, argument, mean), mu in zip(orbits, (G * (1.989e30 + 2.4e12), G * 2.54e12), strict=True):
        sim = rebound.Simulation()
        sim.G = 1.0
        sim.add(m=mu)
        sim.add(
            m=0.0, a=a, e=e, inc=np.radians(i), Omega=np.radians(node), omega=np.radians(argument), M=np.radians(mean)
        )
        particle = sim.particles[1]
        motions.append(np.array([particle.xyz, particle.vxyz]))
    sizes = [a for a, *_ in orbits]
    angles = [mean for *_, mean in orbits]
    if kepler == 1:
        mus = (G * (1.989e30 + 2.4e12), G * 2.54e12)
        sizes = [2 * np.pi * np.sqrt(a**3 / mu) / 24.0 for a, mu in zip(sizes, mus, strict=True)]
        angles = [mean + argument for _, _, _, _, argument, mean in orbits]
    positions = "\n".join(f"{o[3]} {o[4]} {angle!r}" for o, angle in zip(orbits, angles, strict=True))
    velocities = "\n".join(f"{float(size)!r} {o[1]} {o[2]}" for o, size in zip(orbits, sizes, strict=True))
    path = tmp_path / "sun.txt"
    path.write_text(SIANS.format(kepler=kepler, positions=positions, velocities=velocities))
    system, state = fullbody.read_sians(path, units="kmhr")
    check_sians(system, state, motions[0], motions[0] + motions[1])
    united, start = fullbody.read_sians(path, units=("km", "hour", "kg"))
    np.testing.assert_allclose(united.third_body("Sun", 0.0)[0].value, system.third_body("Sun", 0.0)[0], rtol=1e-10)
    assert np.abs(united.integrate(start, 1.0).energy_drift).max() < 1e-13


@pytest.mark.filterwarnings("default")
def test_sians_warns_of_the_torque(tmp_path):
    path = tmp_path / "sun.txt"
    path.write_text(SIANS.format(kepler=0, positions="1e8 0 0\n100000002.5 0 0", velocities="0 1e5 0\n0 1e5 0"))
    with pytest.warns(UserWarning, match="in SIANS it acts on the bodies' centres alone"):
        fullbody.read_sians(path, units="kmhr")
    path.write_text(SIANS.format(kepler=0, positions="0 0 0\n0 0 0", velocities="0 0 0\n0 1 0"))
    refused(r"sun\.txt, line 10: orbit about the Sun", lambda: fullbody.read_sians(path, units="kmhr"))


def test_converting_to_rebound_warns_of_lost_forces():
    system, state = fullbody.systems.kw4()
    with_tide = system.with_forces([forces.Tide("Alpha", "Beta", 1e-5, 0.01)])
    with pytest.warns(UserWarning, match=r"without the external forces \(tide on Alpha\)"):
        sim = fullbody.to_rebound(with_tide, state)
    assert sim.N == 2
    sim.additional_forces = lambda pointer: None
    with pytest.warns(UserWarning, match="additional forces or operators, which are left out"):
        fullbody.from_rebound(sim)
