"""Input files of GUBAS: each number worked out by hand from the format, forces by that program's own formulas."""

import warnings

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody.errors import InvalidInput
from support import refused
from support.peers import DATA, changed, line_of, relative_acceleration
from support.scenes import differential, kepler_position

pytestmark = pytest.mark.filterwarnings("ignore:.* asks for:UserWarning")
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
    text = "# These should be in km, s, and degrees or radians\nFlyby: 0"
    path.write_text(path.read_text().replace("Flyby: 0", text))
    with warnings.catch_warnings(record=True, action="always") as caught:
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


def config(tmp_path, flags, numbers):
    """The pair of ellipsoids with switches and numbers."""
    lines = (DATA / "gubas_pair.cfg").read_text().split(f"[{EXTRA}]")[0]
    rows = {"Flyby": 0, "Solar Gravity": 0, "Tidal Torque": 0} | flags | numbers
    path = tmp_path / "pair.cfg"
    path.write_text(lines + f"[{EXTRA}]\n" + "\n".join(f"{name}: {value!r}" for name, value in rows.items()) + "\n")
    return path


def test_gubas_flyby_and_heliocentric_orbit(tmp_path):
    numbers = dict(zip(FLYBY_NAMES, FLYBY, strict=True)) | dict(zip(HELIO_NAMES, HELIO, strict=True))
    path = config(tmp_path, {"Flyby": 1, "Heliocentric Orbit": 1}, numbers)
    system, state = fullbody.read_gubas(path)
    assert [force.name for force in system.forces] == ["flyby", "Sun"]
    for name, (mass, *orbit), tolerance in (("flyby", FLYBY, 1e-5), ("Sun", HELIO, 1e-8)):
        for time in (0.0, 2.9e5, 4.0e5):
            at = kepler_position([*orbit[:-1], 0.0], system.G * mass, time - orbit[-1])
            scale = np.linalg.norm(at)
            np.testing.assert_allclose(system.third_body(name, time)[0], at, rtol=1e-11, atol=1e-11 * scale)
            result = relative_acceleration(system, state.replace(time=time), name)
            expected = np.subtract(*(differential(x, at, system.G * mass) for x in state.position[::-1]))
            # The remaining difference is the pull on the bodies' quadrupoles.
            assert np.linalg.norm(result - expected) < tolerance * np.linalg.norm(expected)
    # GUBAS has no torque; a flyby has.
    assert np.abs(system.loads(state.replace(time=3.0e5))["flyby"].torque).max() > 0.0
    with_units, _ = fullbody.read_gubas(path, units=True)
    assert str(with_units.third_body("Sun", 0.0)[0].unit) == "km"
    np.testing.assert_allclose(with_units.third_body("Sun", 0.0)[0].value, system.third_body("Sun", 0.0)[0], rtol=1e-14)


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
