"""Systems from ``system.toml`` are built as written, and errors name file, key and expectation."""

import re

import fullbody
import numpy as np
import pytest
from fullbody.errors import InvalidInput
from fullbody.setups.toml import __doc__ as MANUAL
from support import refused
from support.toml_texts import KW4, PAIR, read


def test_kw4_is_the_ready_made_one(tmp_path):
    setup = read(tmp_path, KW4)
    system, state = fullbody.systems.kw4_ho2021(units=True)
    assert [body.shape for body in setup.system.bodies] == [body.shape for body in system.bodies]
    assert np.array_equal(setup.system.masses, system.masses)
    assert setup.system.options["gravity"] == "surface"
    assert setup.system.options["gravity_tolerance"] == 1e-13
    for name in ("position", "velocity", "spin"):
        ours, theirs = getattr(setup.state, name), getattr(state, name)
        assert ours.unit == theirs.unit
        assert np.allclose(ours.value, theirs.value, rtol=1e-9, atol=0), name
    assert np.allclose(setup.state.attitude, state.attitude, rtol=0, atol=1e-15)
    assert setup.integrator == fullbody.Verner98(rtol=1e-12)
    assert setup.until.to_value("hour") == 24.0
    assert setup.output.to_value("hour") == 0.5
    assert setup.file == tmp_path / "system.nc"
    usual = read(tmp_path, KW4.replace('["km", "hour", "kg"]', "true"))
    assert usual.system == read(tmp_path, KW4).system
    run = setup.run(until=3.0)
    assert run == setup.system.integrate(setup.state, 3.0, output=0.5, integrator=setup.integrator)
    assert len(run) == 7


def examples():
    """Return the examples of the manual, which are indented."""
    blocks = MANUAL.split(".. code-block:: toml")[1:]
    return ["\n".join(line[4:] for line in block.splitlines() if line[:4].isspace()) for block in blocks]


def test_the_manuals_example_of_a_binary_is_that_of_the_function(tmp_path):
    setup = read(tmp_path, examples()[1])
    first = fullbody.Component(diameters=(0.851, 0.849, 0.620), rotation_period=2.26, name="Didymos")
    second = fullbody.Component(diameter=0.151, axis_ratios=(1.02, 1.53 / 1.02), name="Dimorphos")
    pole = tuple(np.radians([310.0, -84.0]))
    system, state = fullbody.binary(
        first, second, period=11.921, semi_major_axis=1.206, pole=pole, equal_density=True, frame="ecliptic",
        units=("km", "hour", "kg"),
    )  # fmt: skip
    assert setup.system.names == ("Didymos", "Dimorphos")
    assert setup.system.frame == "ecliptic"
    np.testing.assert_allclose(setup.system.masses.value, system.masses.value, rtol=1e-14)
    for name in ("position", "velocity", "spin"):
        ours, theirs = getattr(setup.state, name).value, getattr(state, name).value
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())


def test_the_manuals_example_runs(tmp_path):
    setup = read(tmp_path, examples()[0])
    masses = setup.system.masses.value
    assert np.allclose(masses @ setup.state.position.value, 0.0, atol=1e-3)
    assert np.allclose(masses @ setup.state.velocity.value, 0.0, atol=1e-3)
    assert setup.state.position.value[1, 0] - setup.state.position.value[0, 0] == pytest.approx(2.548 * (1 - 0.0004))
    assert len(setup.run(until=2.0)) == 3


def test_without_units_numbers_stay_numbers(tmp_path):
    setup = read(tmp_path, PAIR)
    assert setup.until == 2.0
    assert setup.output is None
    assert setup.system == fullbody.System(
        [fullbody.Body(fullbody.Sphere(1.0), mass=1.0), fullbody.Body(fullbody.PointMass(), mass=1e-3)], G=1.0
    )
    assert np.array_equal(setup.state.position, [[0, 0, 0], [3, 0, 0]])
    assert np.array_equal(setup.state.velocity, [[0, 0, 0], [0, 0.6, 0]])


def test_rates_periods_times_and_starts_are_read(tmp_path):
    text = KW4.replace("spin = [0, 0, 2.2728]", 'rotation_period = "2.7645 hour"')
    text = text.replace("spin = [0, 0, 0.3611]", 'spin = [0, 0, "496 deg / day"]')
    text = text.replace('output = "30 min"', 'output = [1, "90 min", 2.5]\nstart = "30 min"\nfile = "out/kw4.nc"')
    setup = read(tmp_path, text)
    assert setup.state.spin.value[0, 2] == pytest.approx(2 * np.pi / 2.7645, rel=1e-15)
    assert setup.state.spin.value[1, 2] == pytest.approx(np.deg2rad(496) / 24, rel=1e-15)
    assert setup.state.time.value == 0.5
    assert np.array_equal(setup.output.value, [1.0, 1.5, 2.5])
    assert setup.file == tmp_path / "out" / "kw4.nc"


MASS, AXES, SPIN = "mass = 0.135e12", "[0.285, 0.2315, 0.1745]", "spin = [0, 0, 0.3611]"
GRAVITY, RTOL, UNTIL, OUTPUT = 'gravity = "surface"', "rtol = 1e-12", 'until = "1 day"', 'output = "30 min"'


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (MASS, "mass = -1.0", r"body\[1\]\.mass: .*expected a finite number above zero"),
        (MASS, "", r"body\[1\]: Beta is given neither mass nor density nor GM; expected one of them"),
        (MASS, 'mass = "3 km"', r"body\[1\]\.mass: .*unit km; expected a unit such as kg"),
        (MASS, 'mass = "heavy"', r"body\[1\]\.mass: is 'heavy'; expected a finite number, or .* such as '2.5 kg'"),
        (MASS, "mass = true", r"body\[1\]\.mass: is True; expected a number, or text with a unit"),
        (MASS, "mass = nan", r"body\[1\]\.mass: is nan; expected a finite number"),
        (MASS, "maas = 1.0", r"body\[1\]\.maas: is not a key .* did you mean 'mass'\?"),
        (AXES, "[0.285, 0.2315]", r"body\[1\]\.semi_axes: is .* expected 3 numbers"),
        (AXES, "[0.285, 0.2315, 0]", r"body\[1\]\.semi_axes: semi-axis c is 0.0"),
        (f"semi_axes = {AXES}", "", r"body\[1\]: has none of semi_axes, radius, point"),
        (SPIN, "spinn = [0, 0, 1]", r"body\[1\]\.spinn: is not a key .* did you mean 'spin'\?"),
        (SPIN, "spin = 0.3", r"body\[1\]\.spin: is 0.3; expected 3 numbers"),
        (SPIN, 'spin = ["0 Hz", "0 Hz", "1e-4 Hz"]', r"body\[1\]\.spin: .*Hz, .*expected an angle by a time"),
        (SPIN, 'rotation_period = "0 h"', r"body\[1\]\.rotation_period: is 0"),
        (SPIN, "position = [1, 0, 0]", r"body\[1\]: has position and orbit; expected an orbit, or"),
        (SPIN, "attitude = [0, 0, 0, 0]", r"body\[1\]\.attitude: is zero; expected a quaternion"),
        ('about = "Alpha"', 'about = "Gamma"', r"body\[1\]\.orbit\.about: is 'Gamma'; .* another body, or .*: Alpha"),
        ("e = 0.0004", "e = 1.0", r"body\[1\]\.orbit: .*e"),
        ("e = 0.0004, ", "", r"body\[1\]\.orbit\.e: is missing; expected a number"),
        ('i = "156.1 deg"', 'i = "156.1 km"', r"body\[1\]\.orbit\.i: .*unit km; expected a unit such as rad"),
        ('"kg"]', '"km"]', r"system\.units: units has 'km'; expected a unit of mass"),
        ('["km", "hour", "kg"]', '"SI"', r"system\.units: units is 'SI'; expected \(length, time, mass\)"),
        (GRAVITY, 'gravity = "sponge"', r"system: .*sponge"),
        (GRAVITY, "order = [1.5, 2]", r"system: order is \(1\.5, 2\); expected \(n, m\), whole"),
        (RTOL, "rtol = 2.0", r"integrator: rtol is 2.0; expected a number from 0 to below 1"),
        (RTOL, "rtoll = 1.0", r"integrator\.rtoll: is not a key .* did you mean 'rtol'\?"),
        (RTOL, 'name = "Euler"', r"integrator\.name: is 'Euler'; expected one of 'Verner98'"),
        (UNTIL, "", r"run\.until: is missing; expected a number, or text with a unit"),
        (UNTIL, 'until = "10"', r"run\.until: is '10', which has no unit; .*such as '10 h', or a number"),
        (UNTIL, 'until = "1 km"', r"run\.until: .*unit km; expected a unit such as h"),
        (UNTIL, 'until = "1e308 day"', r"run\.until: is '1e308 day'; expected a finite number"),
        ("[run]", "[runn]", r"runn: is not a key of this table; did you mean 'run'\?"),
        ("[run]", "[extra]\n[run]", r"extra: is not a key of this table"),
        ("[run]", '[run]\norigin = "sun"', r"run\.origin: is 'sun'; expected one of 'given', 'barycentre'"),
        ("[run]", '[run]\nfile = "kw4.csv"', r"run\.file: path is 'kw4\.csv'; .*ends in one of \.nc, \.nc4"),
        ("[run]", '[run]\nfile = "out/"', r"run\.file: path is 'out/'; .*ends in one of \.nc"),
        ("[run]", "[run", r"not valid TOML: .*line 25"),
        (OUTPUT, 'output = "-1 hour"', r"run\.output: is '-1 hour'; expected a spacing above zero, or a list"),
        (OUTPUT, "output = 0", r"run\.output: is 0; expected a spacing above zero"),
        (OUTPUT, 'output = "fast"', r"run\.output: is 'fast'; expected a finite number, or .* such as '2.5 h'"),
    ],
)
def test_faults_name_file_key_and_expectation(tmp_path, old, new, message):
    assert old in KW4
    with pytest.raises(InvalidInput) as caught:
        read(tmp_path, KW4.replace(old, new, 1))
    text = str(caught.value)
    assert text.startswith(f"{tmp_path / 'system.toml'}: ")
    assert text.count("system.toml") == 1
    assert re.search(message, text), text


def test_times_that_do_not_fit_name_the_file_too(tmp_path):
    for output, what in (("[1, 0.5]", "direction"), ("[1, 9]", "from 0 to 2"), ("1e-9", "which ask for 2e")):
        run = read(tmp_path, f"{PAIR}output = {output}").run
        refused(f"^{re.escape(str(tmp_path / 'system.toml'))}: run: .*output.*{what}", run)


def test_units_in_a_system_without_any_are_refused(tmp_path):
    with_units = PAIR.replace("radius = 1.0", 'radius = "1 km"')
    refused(r"body\[0\]\.radius: .*the system has no units", read, tmp_path, with_units)
    refused(r"system: G is not given", lambda: read(tmp_path, PAIR.replace("G = 1.0", "")))
    with pytest.raises(InvalidInput, match=r"body\[1\]: has no position and no orbit"):
        read(tmp_path, PAIR.replace("position = [3, 0, 0]", ""))
    with pytest.raises(FileNotFoundError, match=r"no file .*nothing\.toml$"):
        fullbody.read_toml(tmp_path / "nothing.toml")


def test_files_that_are_no_toml_are_refused(tmp_path):
    system, state = fullbody.systems.case1()
    system.integrate(state, 1.0).save(tmp_path / "run.nc")
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\r\n")
    for name, what in (("run.nc", "is not text"), ("picture.png", "is not text"), ("", "is a folder")):
        refused(f"{what}; expected a file of TOML", fullbody.read_toml, tmp_path / name)


def test_a_byte_order_mark_is_accepted(tmp_path):
    unitless = read(tmp_path, PAIR)
    (tmp_path / "system.toml").write_bytes(b"\xef\xbb\xbf" + PAIR.replace("\n", "\r\n").encode())
    setup = fullbody.read_toml(tmp_path / "system.toml")
    assert (setup.system, setup.state, setup.until) == (unitless.system, unitless.state, unitless.until)


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("G = 1.0", "G = {}", r"system\.G: is 9+\.\.\.9+; expected a finite number"),
        ("radius = 1.0", "radius = -{}", r"body\[0\]\.radius: is -9+\.\.\.9+; expected a finite number"),
        ("[3, 0, 0]", "[3, {}, 0]", r"body\[1\]\.position: is 9+\.\.\.9+; expected a finite number"),
        ("until = 2.0", "until = {}", r"run\.until: is 9+\.\.\.9+; expected a finite number"),
        ("G = 1.0", "G = 1.0\ngravity_tolerance = {}", r"system: gravity_tolerance is 9+\.\.\.9+; expected a number"),
        ("G = 1.0", 'units = [{}, "s", "kg"]', r"system\.units: units has 9+, which is not a unit"),
    ],
)
def test_integers_beyond_all_doubles_are_refused(tmp_path, old, new, what):
    refused(what, lambda: read(tmp_path, PAIR.replace(old, new.format("9" * 400), 1)))


@pytest.mark.parametrize("value", ["9" * 5000, "[" * 3000 + "]" * 3000])
def test_files_that_cannot_be_read_are_refused(tmp_path, value):
    refused(r"system\.toml: not valid TOML: ", lambda: read(tmp_path, PAIR.replace("until = 2.0", f"until = {value}")))


def test_an_invalid_name_of_a_body_is_refused(tmp_path):
    text = PAIR.replace("radius = 1.0", "name = 'a\u0085b'\nradius = 1.0")
    refused(r"system\.toml: body\[0\].name: name is .* without control characters", read, tmp_path, text)
