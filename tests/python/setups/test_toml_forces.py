"""The tables ``[[forces]]`` of a ``system.toml`` make forces."""

from dataclasses import fields

import fullbody
import numpy as np
import pytest
from astropy import constants
from astropy import units as u
from fullbody import forces
from fullbody.errors import InvalidInput
from support import refused
from support.toml_texts import read

PAIR = """
[system]
units = ["km", "hour", "kg"]
G = 8.64960768e-13
[[body]]
name = "Alpha"
semi_axes = [0.766, 0.7475, 0.6735]
mass = 2.353e12
spin = [0, 0, 2.27]
[[body]]
name = "Beta"
semi_axes = [0.285, 0.2315, 0.1745]
mass = 0.135e12
orbit = { about = "Alpha", a = 2.548, e = 0, i = 0, Omega = 0, omega = 0, M = 0 }
spin = [0, 0, 0.3611]
[run]
until = 1.0
output = 1.0
"""
SUN = """
[[forces]]
kind = "ThirdBody"
name = "Sun"
mass = "1 M_sun"
of = "system"
time = "30 min"
orbit = { a = "0.64 au", e = 0.69, i = "38.9 deg", Omega = "245 deg", omega = 3.37, M = 0.2 }
"""
MOON = """
[[forces]]
kind = "ThirdBody"
mu = "4902.8 km3/s2"
of = "body"
times = [-1, 0, "60 min", 2]
positions = [[4e5, 0, 0], ["4e8 m", 1e3, 0], [4e5, 2e3, 0], [4e5, 3e3, 0]]
"""
TIDE = """
[[forces]]
kind = "Tide"
on = "Alpha"
by = "Beta"
k2 = 1e-5
lag = "36 s"
radius = "700 m"
"""
RADIATION = """
[[forces]]
kind = "Yorp"
on = "Alpha"
along = ["1 N m", 2e3, 3e3, "4 N m"]
across = 5e3
obliquity = [0, "60 deg", "120 deg", "180 deg"]
pole = [0, 1, 1]
[[forces]]
kind = "Byorp"
name = "push"
on = "Beta"
about = "Alpha"
force = "0.01 N"
"""


def test_every_kind_is_that_of_the_constructor(tmp_path):
    # The conversions are done by hand: a second is 1/3600 hours, a newton 3600^2/1000 kg km/h^2.
    setup = read(tmp_path, PAIR + SUN + MOON + TIDE + RADIATION)
    orbit = fullbody.KeplerElements(0.64 * 149597870.7, 0.69, np.radians(38.9), np.radians(245), 3.37, 0.2)
    newton, joule = 3600.0**2 / 1e3, 3600.0**2 / 1e6
    path = {"times": [-1, 0, 1, 2], "positions": [[4e5, y, 0] for y in (0, 1e3, 2e3, 3e3)]}
    torques = {"along": [joule, 2e3, 3e3, 4 * joule], "across": 5e3, "obliquity": np.radians([0, 60, 120, 180])}
    expected = [
        forces.ThirdBody(mass=constants.M_sun.value, orbit=orbit, of="system", time=0.5, name="Sun"),
        forces.ThirdBody(mu=4902.8 * 3600.0**2, **path, of="body"),
        forces.Tide("Alpha", "Beta", 1e-5, 0.01, radius=0.7),
        forces.Yorp("Alpha", **torques, pole=(0, 1, 1)),
        forces.Byorp("Beta", "Alpha", 0.01 * newton, name="push"),
    ]
    other = setup.system.with_forces(expected)
    state = setup.state
    for name, load in other.loads(state).items():
        loads_of_file = setup.system.loads(state)[name]
        for item, exact in ((loads_of_file.force, load.force), (loads_of_file.torque, load.torque)):
            np.testing.assert_allclose(item, exact, rtol=1e-11, atol=1e-13 * np.abs(exact).max())
    for name in ("Sun", "third body"):
        item, exact = (np.array(s.third_body(name, [0.0, 1.5])) for s in (setup.system, other))
        np.testing.assert_allclose(item, exact, rtol=1e-13)
    assert [force.name for force in setup.system.forces] == [force.name for force in other.forces]
    run = setup.run()
    assert run.work["Sun"].unit.is_equivalent(u.J)
    assert np.abs(run.energy_drift).max() < 1e-14


def test_without_forces_the_system_is_what_it_was(tmp_path):
    assert read(tmp_path, PAIR).system.forces == ()
    assert read(tmp_path, PAIR).run().work == {}
    refused(r"system\.forces: is not a key", lambda: read(tmp_path, PAIR.replace("[system]", "[system]\nforces = []")))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SUN.replace("ThirdBody", "Function"), r"forces\[0\]\.kind: is 'Function', which no file can hold"),
        (SUN.replace("ThirdBody", "thirdbody"), r"forces\[0\]\.kind: is 'thirdbody'; expected one of 'ThirdBody', "),
        (SUN.replace('kind = "ThirdBody"', ""), r"forces\[0\]\.kind: is missing; expected one of 'ThirdBody'"),
        (SUN.replace("time =", "tiem ="), r"forces\[0\]\.tiem: is not a key of this table; did you mean 'time'"),
        (SUN.replace("M = 0.2", "MA = 0.2"), r"forces\[0\]\.orbit\.MA: is not a key of .*expected some of a, e"),
        (SUN.replace(", M = 0.2", ""), r"forces\[0\]\.orbit: the elements have no M; expected one of M, f"),
        (SUN.replace("0.69", "-0.69"), r"forces\[0\]\.orbit: .*e"),
        (SUN.replace('"1 M_sun"', '"1 km"'), r"forces\[0\]\.mass: has the unit km"),
        (SUN.replace('mass = "1 M_sun"', ""), r"forces\[0\]: mass and mu of Sun are None and None"),
        (SUN.replace('of = "system"', 'of = "star"'), r"forces\[0\]: the argument 'of' of Sun is 'star'; expected "),
        (MOON.replace("[4e5, 3e3, 0]", "[4e5, 3e3]"), "positions of third body"),
        (MOON.replace("[4e5, 3e3, 0]", "[4e5, true, 0]"), r"forces\[0\]\.positions: is True; expected numbers"),
        (TIDE.replace('lag = "36 s"', ""), r"forces\[0\]\.lag: is missing; Tide needs it"),
        (TIDE.replace("36 s", "-36 s"), "lag of tide on Alpha"),
        (TIDE.replace('on = "Alpha"', 'on = "Gamma"'), "on of tide on Alpha is|on of tide on Gamma is 'Gamma'"),
        (TIDE.replace('on = "Alpha"', "on = 0"), r"forces\[0\]\.on: is 0; expected text"),
        (TIDE + TIDE, "distinct names"),
        ("[forces]\nkind = 'Tide'", r"forces: is .*; expected tables, each headed \[\[forces\]\]"),
        (RADIATION.replace('"0.01 N"', '"0.01 J"'), r"forces\[1\]\.force: has the unit J"),
    ],
)
def test_faults_name_file_key_and_expectation(tmp_path, text, message):
    with pytest.raises(InvalidInput, match=message) as raised:
        read(tmp_path, PAIR + text)
    assert str(raised.value).startswith(f"{tmp_path / 'system.toml'}: ")


def test_normalizations_of_radiation_are_read(tmp_path):
    text = """
[[forces]]
kind = "Yorp"
on = "Alpha"
along = "1e-8 rad / day2"
normalization = "acceleration"
[[forces]]
kind = "Byorp"
on = "Beta"
about = "Alpha"
coefficient = 0.02
normalization = "jacobson_scheeres_2011"
pressure = "4.5e-6 Pa"
"""
    setup = read(tmp_path, PAIR + text)
    loads = setup.system.loads(setup.state)
    inertia = 2.353e12 / 5 * (0.766**2 + 0.7475**2)
    assert loads["YORP on Alpha"].torque[0, 2].value == pytest.approx(1e-8 / 24.0**2 * inertia, rel=1e-12)
    published = {"normalization": "jacobson_scheeres_2011", "pressure": 4.5e-6 * u.Pa}
    arguments = forces.Byorp("Beta", "Alpha", coefficient=0.02, **published)
    expected = setup.system.with_forces([arguments]).loads(setup.state)["BYORP on Beta"].force
    np.testing.assert_allclose(loads["BYORP on Beta"].force, expected, rtol=1e-13)
    with pytest.raises(InvalidInput, match=r"forces\[1\]\.coefficient: is '1 N'; expected numbers"):
        read(tmp_path, PAIR + text.replace("0.02", '"1 N"'))


def test_every_argument_of_the_kinds_is_read(tmp_path):
    needed = {
        "ThirdBody": {},
        "Tide": {"on": '"Alpha"', "by": '"Beta"', "k2": "0.1", "lag": "1"},
        "Yorp": {"on": '"Alpha"', "along": "1"},
        "Byorp": {"on": '"Beta"', "about": '"Alpha"'},
        "BinaryYarkovsky": {"on": '"Beta"', "about": '"Alpha"', "pressure": "1"},
    }
    refused(f"expected one of {', '.join(map(repr, needed))}$", read, tmp_path, f'{PAIR}[[forces]]\nkind = "tide"\n')
    for kind, arguments in needed.items():
        for entry in fields(getattr(forces, kind)):
            wrong = "".join(f"{name} = {value}\n" for name, value in (arguments | {entry.name: "false"}).items())
            with pytest.raises(InvalidInput, match=rf"forces\[0\]\.{entry.name}: is False; expected"):
                read(tmp_path, f'{PAIR}[[forces]]\nkind = "{kind}"\n{wrong}')
