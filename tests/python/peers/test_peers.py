"""Input files of SIANS and GUBAS, and REBOUND's simulations: each number worked out by hand from the formats."""

import pathlib
import warnings

import astropy.units as u
import fullbody
import numpy as np
import pytest
import rebound
from fullbody.errors import InvalidInput
from support import refused

DATA = pathlib.Path(__file__).parents[2] / "data" / "peers"


def changed(tmp_path, name, old, new):
    """A copy of a sample with one text replaced."""
    text = (DATA / name).read_text()
    assert old in text
    path = tmp_path / name
    path.write_text(text.replace(old, new, 1))
    return path


def line_of(path, text):
    return next(k for k, line in enumerate(path.read_text().splitlines(), 1) if text in line)


# SIANS


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
    path.write_text(
        path.read_text().replace("2.548 0.0004", "0.72583 0.0004").replace("105.4 319.7 0", "105.4 319.7 330")
    )
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


# GUBAS


def test_files_of_gubas_are_read():
    system, state = fullbody.read_gubas(DATA / "gubas_pair.cfg")
    assert system.bodies[0].shape == fullbody.Ellipsoid(0.4, 0.39, 0.3)
    assert system.bodies[1].shape == fullbody.Ellipsoid(0.09, 0.08, 0.06)
    # 2.1 and 1.9 g/cm^3.
    masses = 4 / 3 * np.pi * np.array([400 * 390 * 300 * 2100.0, 90 * 80 * 60 * 1900.0])
    np.testing.assert_allclose(system.masses, masses, rtol=1e-12)
    np.testing.assert_allclose(system.G, 6.67e-20, rtol=1e-15)
    assert state.time == 60.0
    # The primary's y-axis is the inertial z-axis, its z-axis the inertial -y-axis.
    np.testing.assert_allclose(state.position[1] - state.position[0], [1.0, 0.05, 0.2], rtol=1e-14)
    np.testing.assert_allclose(state.velocity[1] - state.velocity[0], [1e-5, -2e-6, 1.5e-4], rtol=1e-14)
    np.testing.assert_allclose(system.momentum(state), 0.0, atol=1e-9 * masses[1] * 1.5e-4)
    np.testing.assert_allclose(masses @ state.position, 0.0, atol=1e-14 * masses[0])
    np.testing.assert_allclose(state.rotation_matrix[0], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-15)
    # The secondary's x-axis is the primary's y-axis.
    np.testing.assert_allclose(state.rotation_matrix[1][:, 0], [0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(state.spin, [[1e-6, 0, 7.7e-4], [2e-6, 3e-6, 1.5e-4]], atol=1e-20)


def test_units_of_gubas_are_read():
    system, state = fullbody.read_gubas(DATA / "gubas_pair.cfg", units=True, gravity="multipole:4")
    assert system.options["gravity"] == "multipole:4"
    np.testing.assert_allclose(system.bodies[0].density.to_value("kg / km3"), 2.1e12)
    assert state.time == 60 * u.s
    with pytest.raises(InvalidInput, match=r"units is \('m', 's', 'kg'\); expected True or False"):
        fullbody.read_gubas(DATA / "gubas_pair.cfg", units=("m", "s", "kg"))


def rotated(tmp_path, comment):
    """The rotation of B into A by 10, 20, 30 about x, y, z, with a comment before the flag."""
    path = changed(tmp_path, "gubas_pair.cfg", "B into A Euler Flag: 0", f"{comment}\nB into A Euler Flag: 1")
    text = path.read_text()
    for old, new in (("1 X: 0.", "1 X: 10."), ("2 Y: 0.", "2 Y: 20."), ("3 Z: 0.", "3 Z: 30.")):
        text = text.replace(f"B into A Euler {old}", f"B into A Euler {new}")
    path.write_text(text.replace("A into N Euler Flag: 0", "A into N Euler Flag: 1"))
    return path


def test_gubas_euler_angles_give_the_attitude(tmp_path):
    path = rotated(tmp_path, "")
    _, state = fullbody.read_gubas(path, euler="degree")
    # The first row of the matrix of 1-2-3 angles, written out: c2 c3, -c2 s3, s2.
    c2, s2, c3, s3 = np.cos(np.pi / 9), np.sin(np.pi / 9), np.cos(np.pi / 6), 0.5
    np.testing.assert_allclose(state.rotation_matrix[1][0], [c2 * c3, -c2 * s3, s2], rtol=1e-14)
    np.testing.assert_allclose(state.rotation_matrix[1][1, 2], -np.sin(np.pi / 18) * c2, rtol=1e-14)
    _, radians = fullbody.read_gubas(path, euler="radian")
    np.testing.assert_allclose(radians.rotation_matrix[1][0, 2], np.sin(20.0), rtol=1e-14)
    refused("euler", lambda: fullbody.read_gubas(path, euler="grad"))


@pytest.mark.parametrize(
    ("comment", "second", "warning"),
    [
        # Comments of two versions of hou_config.cfg: in the main folder, and among the examples.
        ("# the Body B z-axis. All rotations are in degrees", np.sin(np.pi / 9), "degrees as its comments say; GUBAS"),
        ("# the Body B z-axis. All rotations are in radians", np.sin(20.0), None),
        ("", np.sin(20.0), "in radians as GUBAS takes them; no comment"),
        ("# the spins are in rad/s or radians per second", np.sin(20.0), "no comment"),
        ("; angles in deg", np.sin(np.pi / 9), "degrees"),
    ],
)
def test_gubas_euler_angles_are_as_the_comments_say(tmp_path, comment, second, warning):
    path = rotated(tmp_path, comment)
    # Units in comments of other sections, here the fly-by, do not count.
    path.write_text(
        path.read_text().replace("Flyby: 0", "# These should be in km, s, and degrees or radians\nFlyby: 0")
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        _, state = fullbody.read_gubas(path)
    np.testing.assert_allclose(state.rotation_matrix[1][0, 2], second, rtol=1e-14)
    assert [warning in str(w.message) for w in caught] == [True] * (warning is not None)


def test_gubas_comments_that_contradict_are_refused(tmp_path):
    path = rotated(tmp_path, "# All rotations are in degrees\n# All rotations are in radians")
    refused(r"gubas_pair\.cfg: comments of .* degrees and radians", lambda: fullbody.read_gubas(path))
    fullbody.read_gubas(path, euler="radian")
    # Angles of zero are the same in both.
    path.write_text(path.read_text().replace(": 10.", ": 0.").replace(": 20.", ": 0.").replace(": 30.", ": 0."))
    np.testing.assert_allclose(fullbody.read_gubas(path)[1].rotation_matrix[1], np.eye(3), atol=1e-15)


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("Flyby: 0", "Flyby: 2", "Flyby is 2; expected one of"),
        ("Fahnestock Input File Flag: 0", "Fahnestock Input File Flag: 1", "Fahnestock"),
        ("Relative Position Y: 200.", "Relative Position Y: near", "'near'; expected a number"),
        ("Secondary Shape Flag: 1", "Secondary Shape Flag: 5", "expected one of"),
        ("Relative Position Y: 200.", "Relative Position Y", "no 'name: value'"),
        ("Relative Position Y: 200.", "Relative Position X: 200.", "already exists"),
        ("Primary Density: 2.1", "Primary Density: -2.1", "Primary Density is '-2.1'; expected a number above zero"),
        ("Semi-Minor Axis: 60.", "Semi-Minor Axis: -60.", "Secondary Semi-Minor Axis is '-60.'; expected"),
        ("G: 6.67e-11", "G: -1", "G is '-1'; expected a number, zero or above"),
        ("B into A (1,1): 0.0", "B into A (1,1): 0.5", "B into A is not a rotation matrix: .*; expected one to 1e-4"),
        ("A into N (1,1): 1.0", "A into N (1,1): -1.0", "A into N is not a rotation"),
    ],
)
def test_errors_of_gubas_files_name_the_line(tmp_path, old, new, what):
    line = line_of(DATA / "gubas_pair.cfg", old)
    path = changed(tmp_path, "gubas_pair.cfg", old, new)
    refused(f"line {line}: .*{what}", lambda: fullbody.read_gubas(path))


def test_an_axis_that_underflows_in_kilometres_names_the_file(tmp_path):
    path = changed(tmp_path, "gubas_pair.cfg", "Semi-Minor Axis: 60.", "Semi-Minor Axis: 5e-324")
    refused(r"gubas_pair\.cfg: semi-axis c is 0\.0; expected a finite number above", lambda: fullbody.read_gubas(path))


@pytest.mark.parametrize(
    ("line", "option"),
    [
        ("Primary Density: 2.1\n", "Primary Density"),
        # This flag selects angles or a matrix.
        ("B into A Euler Flag: 0\n", "B into A Euler Flag"),
    ],
)
def test_a_missing_entry_of_gubas_is_named(tmp_path, line, option):
    path = changed(tmp_path, "gubas_pair.cfg", line, "")
    refused(rf"gubas_pair\.cfg: no '{option}' in the section", lambda: fullbody.read_gubas(path))


@pytest.mark.parametrize("line", ["Fahnestock Input File Flag: 0\n", "Solar Gravity: 0\n"])
def test_gubas_config_without_a_switch_has_it_off(tmp_path, line):
    path = changed(tmp_path, "gubas_pair.cfg", line, "")
    assert fullbody.read_gubas(path) == fullbody.read_gubas(DATA / "gubas_pair.cfg")
    path = changed(tmp_path, "gubas_pair.cfg", "Start Time: 60.0\n", "")
    assert fullbody.read_gubas(path)[1].time == 0.0


def test_further_axes_of_spheres_of_gubas_are_ignored(tmp_path):
    path = changed(tmp_path, "gubas_pair.cfg", "Secondary Shape Flag: 1", "Secondary Shape Flag: 0")
    path.write_text(path.read_text().replace("Semi-Minor Axis: 60.", "Semi-Minor Axis: 0"))
    assert fullbody.read_gubas(path)[0].bodies[1].shape == fullbody.Sphere(0.09)


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path):
    for name, read in (("gubas_pair.cfg", fullbody.read_gubas), ("sians_pair.txt", fullbody.read_sians)):
        (tmp_path / name).write_bytes(b"\xef\xbb\xbf" + (DATA / name).read_bytes())
        assert read(tmp_path / name) == read(DATA / name)


def test_numbers_that_gubas_writes_for_itself_are_refused(tmp_path):
    path = tmp_path / "ic_input.txt"
    path.write_text("6.67e-20\n4\n")
    text = r"ic_input\.txt, line 1: text before the first \[section\]; expected a \.cfg of GUBAS"
    refused(text, lambda: fullbody.read_gubas(path))


# REBOUND


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
    refused(
        f"particle {first} has the mass .* for N_active is {active}; expected all 3", lambda: fullbody.from_rebound(sim)
    )
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
