"""Published numbers in ``system.toml``: bodies by their figures, binaries, poles, orbits about several bodies."""

import re

import fullbody
import numpy as np
import pytest
from support import refused
from support.toml_texts import read

HEAD = """
[system]
G = 1.0
frame = "ecliptic"
"""
BODIES = """
[[body]]
name = "A"
diameter = 2.0
rotation_period = 3.0
mass = 1.0
[[body]]
name = "B"
diameter = 0.5
mass = 0.02
"""
BINARY = """
[binary]
semi_major_axis = 6.0
eccentricity = 0.1
"""
RUN = """
[run]
until = 2.0
"""


def elements(setup):
    """Return the elements of the second body about the first."""
    r, v = (part[1] - part[0] for part in (setup.state.position, setup.state.velocity))
    return fullbody.KeplerElements.from_cartesian(r, v, setup.system.mu())


@pytest.mark.parametrize(
    ("figure", "semi_axes"),
    [
        ("diameters = [2.0, 1.8, 1.6]", (1.0, 0.9, 0.8)),
        ("diameter = 2.0", (1.0, 1.0, 1.0)),
        # a b c = 1, the cube of the radius, in all of these.
        ('diameter = 2.0\n"a/b" = 2.0\n"a/c" = 4.0', (2.0, 1.0, 0.5)),
        ('diameter = 2.0\n"a/c" = 8.0', (2.0, 2.0, 0.25)),
        ("diameter = 2.0\naxis_ratios = [2.0, 2.0]", (2.0, 1.0, 0.5)),
        # (a^2 - c^2)/5 of a = 2, c = 1/4.
        (f"diameter = 2.0\nJ2 = {(4 - 1 / 16) / 5}", (2.0, 2.0, 0.25)),
        # A prolate spheroid.
        (f"diameter = 2.0\nJ2 = {(1 / 4 - 16) / 5}", (0.5, 0.5, 4.0)),
    ],
)
def test_figures_of_a_body_are_read(tmp_path, figure, semi_axes):
    text = HEAD + f"[[body]]\n{figure}\nmass = 1.0\n[[body]]\npoint = true\nmass = 0.1\nposition = [9, 0, 0]\n" + RUN
    shape = read(tmp_path, text).system.bodies[0].shape
    np.testing.assert_allclose(shape.semi_axes, semi_axes, rtol=1e-13)


@pytest.mark.parametrize(
    ("item", "value"),
    [
        ("{ value = 2.5, unit = 'km' }", 2.5),
        ("{ value = 2500, unit = 'm', error = '3', source = 'X', doubt = 'second-hand' }", 2.5),
        ("{ value = 2.5 }", 2.5),
    ],
)
def test_a_published_number_is_read_by_value_and_unit(tmp_path, item, value):
    text = (HEAD + BODIES + BINARY + RUN).replace("G = 1.0", 'units = ["km", "hour", "kg"]')
    text = text.replace("diameter = 2.0", f"diameter = {item}")
    radius = read(tmp_path, text).system.bodies[0].shape.semi_axes[0]
    assert radius.to_value("km") == pytest.approx(value / 2, rel=1e-15)


def test_tables_that_describe_a_system_build_nothing(tmp_path):
    text = 'title = "A pair"\nassumed = ["it exists"]\n' + HEAD + BODIES + BINARY + RUN
    more = '[sources]\nX = "Nobody (1900)"\n[not_used]\nalbedo = { value = 0.2, source = "X" }\n'
    ours, expected = read(tmp_path, text + more), read(tmp_path, HEAD + BODIES + BINARY + RUN)
    assert ours.system == expected.system
    assert ours.state == expected.state


def test_masses_are_read_as_gm(tmp_path):
    text = (HEAD + BODIES + BINARY + RUN).replace("G = 1.0", "G = 0.5")
    by_body = text.replace("mass = 1.0", "GM = 1.0").replace("mass = 0.02", "GM = 0.02")
    np.testing.assert_allclose(read(tmp_path, by_body).system.masses, [2.0, 0.04], rtol=1e-15)
    by_pair = text.replace("mass = 1.0\n", "").replace("mass = 0.02\n", "").replace("[binary]", "[binary]\nGM = 1.02")
    by_pair = by_pair.replace("[binary]", "[binary]\nmass_ratio = 0.02")
    np.testing.assert_allclose(read(tmp_path, by_pair).system.masses, [2.0, 0.04], rtol=1e-15)


def test_the_plane_of_a_binary_by_its_pole_or_by_inclination_and_node(tmp_path):
    by_pole = read(tmp_path, HEAD + BODIES + BINARY + "pole = ['30 deg', '60 deg']" + RUN)
    orbit = elements(by_pole)
    assert (np.degrees(orbit.i), np.degrees(orbit.Omega)) == pytest.approx((30.0, 120.0), rel=1e-12)
    angles = "inclination = '30 deg'\nascending_node = '120 deg'\nargument_of_periapsis = '40 deg'\n"
    by_node = read(tmp_path, HEAD + BODIES + BINARY + angles + "mean_longitude = '170 deg'" + RUN)
    orbit = elements(by_node)
    expected = (30.0, 120.0, 40.0, 10.0)
    assert np.degrees([orbit.i, orbit.Omega, orbit.omega, orbit.M]) == pytest.approx(expected, rel=1e-12)


def test_a_synchronous_primary_points_at_the_secondary_and_rotates_with_the_orbit(tmp_path):
    text = (HEAD + BODIES + BINARY + RUN).replace("rotation_period = 3.0", "synchronous = true")
    text = text.replace("semi_major_axis = 6.0", "period = 60.0\nmean_anomaly = 1.0")
    setup = read(tmp_path, text)
    line = setup.state.position[1] - setup.state.position[0]
    np.testing.assert_allclose(setup.state.rotation_matrix[0, :, 0], line / np.linalg.norm(line), rtol=0, atol=1e-14)
    np.testing.assert_allclose(setup.state.spin[0], [0.0, 0.0, 2 * np.pi / 60.0], rtol=1e-15)


def test_a_start_period_replaces_the_search(tmp_path, monkeypatch):
    def search(*_):
        raise AssertionError("the period was searched")

    monkeypatch.setattr("fullbody.setups.elements.start_with_period", search)
    text = (HEAD + BODIES + BINARY + RUN).replace("semi_major_axis = 6.0", "period = 60.0\nstart_period = 60.001")
    text = text.replace("diameter = 2.0", "diameters = [2.2, 2.0, 1.8]")
    read(tmp_path, text)
    with pytest.raises(AssertionError, match="the period was searched"):
        read(tmp_path, text.replace("start_period = 60.001\n", ""))


TRIPLE = """
[[body]]
name = "A"
radius = 1.0
mass = 1.0
[[body]]
name = "C"
radius = 0.1
mass = 0.1
pole = "orbit"
rotation_period = 5.0
orbit = { about = ["A", "B"], a = 50.0, e = 0.2, i = 0.3, Omega = 0.4, omega = 0.5, M = 0.6 }
[[body]]
name = "B"
radius = 0.2
mass = 0.2
synchronous = true
orbit = { about = "A", a = 6.0, e = 0.1, i = 0.2, Omega = 0.7, omega = 0.8, M = 0.9 }
"""


def test_an_orbit_about_the_barycentre_of_bodies_that_come_later(tmp_path):
    state = read(tmp_path, HEAD + TRIPLE + RUN).state
    a, c, b = zip(state.position, state.velocity, strict=True)
    inner, outer = (6.0, 0.1, 0.2, 0.7, 0.8, 0.9), (50.0, 0.2, 0.3, 0.4, 0.5, 0.6)
    relative = [x - y for x, y in zip(b, a, strict=True)]
    np.testing.assert_allclose(relative, fullbody.KeplerElements(*inner).to_cartesian(1.2), rtol=1e-13)
    centre = [(x + 0.2 * y) / 1.2 for x, y in zip(a, b, strict=True)]
    relative = [x - y for x, y in zip(c, centre, strict=True)]
    np.testing.assert_allclose(relative, fullbody.KeplerElements(*outer).to_cartesian(1.3), rtol=1e-13)


def test_a_pole_of_the_orbit_and_a_synchronous_body(tmp_path):
    state = read(tmp_path, HEAD + TRIPLE + RUN).state
    matrices = state.rotation_matrix
    for k, (i, node) in ((1, (0.3, 0.4)), (2, (0.2, 0.7))):
        normal = [np.sin(i) * np.sin(node), -np.sin(i) * np.cos(node), np.cos(i)]
        np.testing.assert_allclose(matrices[k, :, 2], normal, rtol=0, atol=1e-14)
    np.testing.assert_allclose(matrices[1, :, 0], [np.cos(0.4), np.sin(0.4), 0.0], rtol=0, atol=1e-14)
    line = state.position[0] - state.position[2]
    np.testing.assert_allclose(matrices[2, :, 0], line / np.linalg.norm(line), rtol=0, atol=1e-14)
    np.testing.assert_allclose(state.spin[2], [0, 0, np.sqrt(1.2 / 6.0**3)], rtol=1e-14)
    np.testing.assert_allclose(state.spin[1], [0, 0, 2 * np.pi / 5.0], rtol=1e-15)


def test_a_pole_in_another_frame(tmp_path):
    pole = 'name = "A"\npole = ["90 deg", "66.5 deg"]\npole_frame = "equatorial"'
    z = read(tmp_path, HEAD + TRIPLE.replace('name = "A"', pole, 1) + RUN).state.rotation_matrix[0, :, 2]
    expected = fullbody.frames.pole_vector(*np.radians([90.0, 66.5]))
    expected = fullbody.frames.rotation("equatorial", "ecliptic") @ expected
    np.testing.assert_allclose(z, expected, rtol=0, atol=1e-14)


NAME, ROTATION = 'name = "A"', 'pole = "orbit"\nrotation_period = 5.0'
TWO, THREE, SIZE = HEAD + BODIES + BINARY + RUN, HEAD + TRIPLE + RUN, "diameter = 2.0"


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (TWO, SIZE, 'diameter = 2.0\n"a/b" = "x"', r"body\[0\]\.a/b: is 'x'; expected a number"),
        (TWO, SIZE, 'diameter = 2.0\nJ2 = 0.1\n"a/c" = 2.0', r"body\[0\]: has a/c and J2; expected one of"),
        (TWO, SIZE, "radius = 1.0\nJ2 = 0.1", r"body\[0\]\.J2: is given beside radius; expected it beside a diam"),
        (TWO, SIZE, "diameter = 2.0\nradius = 1.0", r"body\[0\]: has radius and diameter; expected one of"),
        (TWO, SIZE, "diameter = { value = 2.0, errors = '1' }", r"'errors' is not a key of a published number"),
        (TWO, SIZE, "diameter = { value = 2.0, unit = 'km' }", r"body\[0\]\.diameter: .*"),
        (TWO, "mass = 0.02", "mass = 0.02\nsynchronous = true", r"body\[1\]\.synchronous: .*expected it in \[binary\]"),
        (TWO, "mass = 0.02", "mass = 0.02\nposition = [1, 0, 0]", r"body\[1\]\.position: is not a key"),
        (TWO, "eccentricity", "excentricity", r"binary\.excentricity: is not a key .*did you mean 'eccentricity'"),
        (TWO, "[binary]", "[binary]\npole = [0, 0]\ninclination = 1", r"binary: has pole and inclination; expected"),
        (TWO, "[binary]", "[binary]\ninclination = 1.0", r"binary\.ascending_node: is missing"),
        (TWO, "[binary]", "[binary]\npole = [0]", r"binary\.pole: is \[0\]; expected 2 numbers"),
        (TWO, "[binary]", "[binary]\nstart_period = 1.0", "start_period is 1.0; expected it beside a period of mean"),
        (TWO, "[binary]", "[[body]]\npoint = true\n[binary]", r"binary: has 3 bodies; expected two"),
        (THREE, '["A", "B"]', '["A", "D"]', r"body\[1\]\.orbit\.about: is \['A', 'D'\]; expected the name of another"),
        (THREE, '["A", "B"]', "[]", r"body\[1\]\.orbit\.about: is \[\]; expected the name of another body, or"),
        (THREE, 'about = "A"', 'about = "C"', r"orbit\.about: is a body that orbits about this one"),
        (THREE, ROTATION, "synchronous = true\nspin = [0, 0, 1]", r"body\[1\]\.spin: is given for a synchronous"),
        (THREE, "synchronous = true", "synchronous = 1", r"body\[2\]\.synchronous: is 1; expected true or false"),
        (THREE, NAME, f"{NAME}\nsynchronous = true", r"body\[0\]: has no orbit; expected one for a pole of 'orbit'"),
        (THREE, NAME, f'{NAME}\npole_frame = "ecliptic"', r"body\[0\]\.pole_frame: is given without a pole"),
        (THREE, NAME, f"{NAME}\npole = [0, 2]", r"body\[0\]\.pole: .*"),
    ],
)
def test_faults_name_file_key_and_expectation(tmp_path, text, old, new, message):
    assert old in text
    refused(f"^{re.escape(str(tmp_path / 'system.toml'))}: .*{message}", read, tmp_path, text.replace(old, new, 1))
