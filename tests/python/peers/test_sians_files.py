"""Input files of SIANS: each number worked out by hand from the format, the Sun by textbook formulas."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
import rebound
from fullbody.errors import InvalidInput
from support import refused
from support.peers import DATA, changed, line_of, relative_acceleration
from support.scenes import differential

pytestmark = pytest.mark.filterwarnings("ignore:.* asks for:UserWarning")
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


def test_a_cartesian_start_of_sians_is_read():
    system, state = fullbody.read_sians(DATA / "sians_pair.txt")
    assert system.G == 1.0
    np.testing.assert_array_equal(system.masses, [3.0, 0.25])
    assert system.bodies[1].shape == fullbody.Ellipsoid(0.4, 0.3, 0.2)
    np.testing.assert_array_equal(state.position, [[0, 0, 0], [6, 0.5, -0.25]])
    np.testing.assert_array_equal(state.velocity, [[0, 0, 0], [0, 0.7, 0.1]])
    np.testing.assert_allclose(np.degrees(state.tait_bryan), [[30, 0, 0], [0, -20, 45]], atol=1e-13)
    np.testing.assert_allclose(state.spin, [[0, 0, 1.5], [0.01, 0, 0.39269908169872414]], rtol=1e-15)


def test_sians_kw4_is_the_paper_run():
    system, state = fullbody.read_sians(DATA / "sians_kw4.txt", units="kmhr")
    expected_system, expected = fullbody.systems.kw4_ho2021()
    np.testing.assert_allclose(system.G, expected_system.G, rtol=1e-15)
    assert [b.shape for b in system.bodies] == [b.shape for b in expected_system.bodies]
    for name in ("position", "velocity", "attitude", "spin"):
        np.testing.assert_allclose(getattr(state, name), getattr(expected, name), rtol=1e-14, atol=1e-15)


def test_sians_units_give_quantities():
    system, state = fullbody.read_sians(DATA / "sians_kw4.txt", units=("km", "hour", "kg"))
    assert system.units == ("km", "h", "kg")
    np.testing.assert_allclose(system.G.to_value(u.m**3 / (u.kg * u.s**2)), 6.67408e-11, rtol=1e-15)
    assert state.spin[0, 2] == 2.2728 * u.rad / u.hour


def test_sians_period_is_in_days(tmp_path):
    path = changed(tmp_path, "sians_kw4.txt", "kepler: 2", "kepler: 1")
    text = path.read_text().replace("2.548 0.0004", "0.72583 0.0004")
    path.write_text(text.replace("105.4 319.7 0", "105.4 319.7 330"))
    system, state = fullbody.read_sians(path, units="kmhr")
    r, v = state.position[1] - state.position[0], state.velocity[1] - state.velocity[0]
    orbit = fullbody.KeplerElements.from_cartesian(r, v, system.mu())
    np.testing.assert_allclose(orbit.period(system.mu()) / 24.0, 0.72583, rtol=1e-12)
    # The mean longitude is counted from the node: M = 330 - 319.7 degrees.
    np.testing.assert_allclose(np.degrees([orbit.omega, orbit.M]), [319.7, 10.3], rtol=1e-9)
    refused("days", lambda: fullbody.read_sians(path))


def test_sians_densities_and_points_are_read(tmp_path):
    path = changed(tmp_path, "sians_pair.txt", "density: 0", "density: 1")
    system, _ = fullbody.read_sians(path)
    np.testing.assert_allclose(system.masses, 4 / 3 * np.pi * np.array([3.0 * 0.4, 0.25 * 0.024]), rtol=1e-15)
    path = changed(tmp_path, "sians_pair.txt", "0.4 0.3 0.2", "0 0 0")
    assert fullbody.read_sians(path)[0].bodies[1].shape == fullbody.PointMass()


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("0.4 0.3 0.2", "beta.obj", "no file 'beta.obj'"),
        ("0.4 0.3 0.2", "beta.obj 0.5", "no file 'beta.obj'"),
        ("0.4 0.3 0.2", "0.4 0.3", "no file '0.4'"),
        ("0.4 0.3 0.2", ". 0.5", "no file '.'"),
        ("0.4 0.3 0.2", "..", "no file '..'"),
        ("0.4 0.3 0.2", "0.4 0.3 -0.2", "above zero"),
        ("0 0.7 0.1", "0 0.7 fast", "'fast'; expected a number"),
        ("0 0.7 0.1", "0 0.7", "expected three numbers"),
        ("0 0.7 0.1", "0 0.7 nan", "finite"),
        ("3*1e0", "3*1e0 4", "expected one number"),
        ("3*1e0", "-3.25", "above zero"),
        ("0.01 0 pi/8", "0.01 0 pi/8/2", "one division"),
        ("0.01 0 pi/8", "0.01 0 pi/0", "division by zero"),
        ("quadval: 4", "quadval 4", "not a setting"),
        ("quadval: 4", "quadvalue: 4", "not a setting of SIANS"),
        ("kepler: 0", "kepler: 3", "expected one of"),
        ("0 0.7 0.1", "0 0.7 0.1\n0 0 0", "expected 2"),
    ],
)
def test_errors_of_sians_files_name_the_line(tmp_path, old, new, what):
    path = changed(tmp_path, "sians_pair.txt", old, new)
    line = line_of(path, new.splitlines()[-1])
    if "\n" in new:
        line = line_of(path, new.splitlines()[0]) + 1
    refused(f"line {line}: .*{what}", lambda: fullbody.read_sians(path))


def test_sians_names_are_distinct(tmp_path):
    path = tmp_path / "named.txt"
    text = (DATA / "sians_pair.txt").read_text() + "\n@ Names\nTwin of\nTwin  of\n"
    path.write_text(text)
    line = len(text.splitlines())
    refused(rf"named\.txt, line {line}: 'Twin of' is the name of body 0 too", lambda: fullbody.read_sians(path))
    path.write_text(text.replace("Twin  of", "Beta"))
    assert fullbody.read_sians(path)[0].names == ("Twin of", "Beta")


def test_a_missing_section_of_sians_is_named(tmp_path):
    path = tmp_path / "cut.txt"
    path.write_text((DATA / "sians_pair.txt").read_text().split("@ Angular")[0])
    refused("no section of angular velocities", lambda: fullbody.read_sians(path))
    with pytest.raises(FileNotFoundError):
        fullbody.read_sians(tmp_path / "none.txt")
    refused("'km'", lambda: fullbody.read_sians(DATA / "sians_pair.txt", units="km"))


def test_sians_files_without_a_kind_of_start_are_refused(tmp_path):
    """SIANS itself stops at such a file: "Missing parameter kepler:"."""
    path = changed(tmp_path, "sians_kw4.txt", "kepler: 2\n", "")
    expected = "'kepler: 0' or 'kepler: 1' or 'kepler: 2'"
    with pytest.raises(InvalidInput, match=rf"sians_kw4\.txt: no parameter 'kepler'; expected a line {expected}"):
        fullbody.read_sians(path, units="kmhr")


@pytest.mark.parametrize("name", ["sun", "density"])
def test_sians_without_a_switch_has_it_off(tmp_path, name):
    path = changed(tmp_path, "sians_kw4.txt", f"{name}: 0\n", "")
    assert fullbody.read_sians(path, units="kmhr") == fullbody.read_sians(DATA / "sians_kw4.txt", units="kmhr")


def test_sians_elements_without_the_ids_of_the_binary_are_refused(tmp_path):
    """SIANS itself stops there too; a Cartesian start does without."""
    for name in ("sians_pair.txt", "sians_kw4.txt"):
        (tmp_path / name).write_text((DATA / name).read_text().split("@ BID")[0])
    assert fullbody.read_sians(tmp_path / "sians_pair.txt") == fullbody.read_sians(DATA / "sians_pair.txt")
    refused(r"sians_kw4\.txt: no section of binary ids", fullbody.read_sians, tmp_path / "sians_kw4.txt", units="kmhr")


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
        node, argument, mean = np.radians([node, argument, mean])
        sim.add(m=0.0, a=a, e=e, inc=np.radians(i), Omega=node, omega=argument, M=mean)
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
    with_units, start = fullbody.read_sians(path, units=("km", "hour", "kg"))
    np.testing.assert_allclose(with_units.third_body("Sun", 0.0)[0].value, system.third_body("Sun", 0.0)[0], rtol=1e-10)
    assert np.abs(with_units.integrate(start, 1.0).energy_drift).max() < 1e-13


@pytest.mark.filterwarnings("default")
def test_sians_warns_of_the_torque(tmp_path):
    path = tmp_path / "sun.txt"
    path.write_text(SIANS.format(kepler=0, positions="1e8 0 0\n100000002.5 0 0", velocities="0 1e5 0\n0 1e5 0"))
    with pytest.warns(UserWarning, match="in SIANS it acts on the bodies' centres alone"):
        fullbody.read_sians(path, units="kmhr")
    path.write_text(SIANS.format(kepler=0, positions="0 0 0\n0 0 0", velocities="0 0 0\n0 1 0"))
    refused(r"sun\.txt, line 10: orbit about the Sun", lambda: fullbody.read_sians(path, units="kmhr"))
