"""Files that version 0.1.0 wrote are read."""

import fullbody
import numpy as np
import pytest
from astropy import units as u
from fullbody import events
from support import DATA

# An example of its documentation.
TOML = """
[system]
units = ["km", "hour", "kg"]
gravity = "focal"

[[body]]
name = "Alpha"
semi_axes = [0.766, 0.7475, 0.6735]
mass = 2.353e12
angles = ["3.2 deg", 0, 0]
spin = [0, 0, 2.2728]

[[body]]
name = "Beta"
semi_axes = [0.285, 0.2315, 0.1745]
mass = 0.135e12
orbit = { about = "Alpha", a = 2.548, e = 0.0004, i = 0, Omega = 0, omega = 0, M = 0 }
spin = [0, 0, 0.3611]

[integrator]
name = "SymplecticSplitting"
step = "15 min"
scheme = "ABA1064"

[run]
until = "30 day"
output = "1 hour"
start = 0
origin = "barycentre"
file = "kw4.nc"
"""


def test_a_run_with_units_shapes_and_events():
    with pytest.warns(fullbody.UncheckedFile):
        run = fullbody.load(DATA / "events-0.1.0.nc")
    alpha, beta, gamma = run.system.bodies
    assert alpha.shape == fullbody.Ellipsoid(0.766 * u.km, 0.7475 * u.km, 0.6735 * u.km)
    assert beta.shape == fullbody.Sphere(0.23 * u.km)
    assert gamma.shape == fullbody.PointMass()
    assert [body.name for body in run.system.bodies] == ["Alpha", None, "Gamma"]
    # Given as 1.5 g/cm3.
    assert np.isclose(alpha.density.to_value(u.g / u.cm**3), 1.5, rtol=1e-15)
    assert (beta.mass, gamma.mass) == (0.135e12 * u.kg, 1e9 * u.kg)
    options = run.system.options
    assert options.pop("gravity_tolerance") == 1e-14
    assert options == {
        "gravity": "multipole:4",
        "order": (7, 9),
        "attitude_chart": "quaternion",
        "vector_path": "portable",
        "epoch": "2001-05-25T00:00:00 TDB",
        "frame": "ecliptic",
    }
    # Given as 15 minutes.
    assert run.integrator == fullbody.SymplecticSplitting(0.25, "ABA1064")
    assert run.stop_reason == "event"
    assert run.time.to_value(u.h)[:-1].tolist() == [0.0, 8.0, 16.0]
    asked = {type(happened.event).__name__: happened.event for happened in run.events}
    assert len(run.events) == 22
    assert asked["Periapsis"] == events.Periapsis(0, "body 1")
    assert asked["Apoapsis"] == events.Apoapsis(0, 1)
    assert asked["Alignment"] == events.Alignment(0, 1)
    assert "height" in repr(asked["Function"])
    assert run.events[0].event == events.Separation(0, 1, 2500 * u.m, direction=-1)
    assert run.events[-1].event == events.Separation("Gamma", 0, 8 * u.km, terminal=True)
    planes = {happened.event for happened in run.events if isinstance(happened.event, events.PlaneCrossing)}
    assert planes == {events.PlaneCrossing(1, None, (1, 0.5, 0)), events.PlaneCrossing(1, 0, direction=1)}
    # The last event is what it says it is, and the run goes on from there.
    state = run.events[-1].state
    assert state == run[-1]
    distance = np.linalg.norm(state.position[2] - state.position[0])
    assert np.isclose(distance.to_value(u.km), 8.0, rtol=1e-13)
    more = run.system.integrate(state, 20 * u.h, integrator=run.integrator)
    assert abs(more.energy[-1] / run.energy[0] - 1) < 1e-6


def test_a_setup(tmp_path):
    (tmp_path / "system.toml").write_text(TOML)
    setup = fullbody.read_toml(tmp_path / "system.toml")
    assert setup.system.names == ("Alpha", "Beta")
    assert setup.integrator == fullbody.SymplecticSplitting(0.25 * u.h, "ABA1064")
    assert setup.until == 720 * u.h
    assert setup.file == tmp_path / "kw4.nc"
    assert setup.run(until=2.0).statistics.steps == 8
