"""The prediction for Hera: the start after the impact, simulated data, a small study, and the results that are kept."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import fullbody
import numpy as np
import pytest
import xarray
from fullbody.base import rotations

from reproduction.hera2026 import inputs, knowledge, measures, mission, model, report, results, study

ROOT = Path(__file__).parents[2]
NOMINAL = {name: inputs.INPUTS[name].value for name in model.NAMES}


def test_masses_of_the_orbit_before():
    """Kepler's third law with the first term of the oblateness; the next one is of the order of its square."""
    big, small = model.masses(1189.0, 425.0, 310.0, 151.5, 2400.0)
    oblateness = (425.0**2 - 310.0**2) / 5 / 1189.0**2
    kepler = 4 * np.pi**2 * 1189.0**3 / (6.6743e-11 * (11.921473 * 3600) ** 2)
    assert big + small == pytest.approx(kepler / (1 + 1.5 * oblateness), rel=2e-3)
    assert small == pytest.approx(2400 * np.pi / 6 * 151.5**3)


def test_the_impact():
    """An impulse beside the centre changes momentum and angular momentum as it does for any body."""
    values = NOMINAL | {"yaw": 25.0, "miss_radial": 7.0, "miss_normal": -4.0, "normal": 1.0, "radial": 0.5}
    system, state = model.setup(**values)
    _, before = model.setup(**values | {"along": 0.0, "normal": 0.0, "radial": 0.0})
    assert np.abs(system.momentum(state)).max() < 1e-12 * np.abs(system.masses[1] * state.velocity[1]).max()
    # The axes of the orbit: from Didymos, along the motion and normal to both.
    x = before.position[1] - before.position[0]
    x /= np.linalg.norm(x)
    y = before.velocity[1] / np.linalg.norm(before.velocity[1])
    axes = np.stack([x, y, np.cross(x, y)], axis=1)
    change = axes @ np.array([0.5, -2.63, 1.0]) * 3.6e-3
    relative = (state.velocity - before.velocity)[1] - (state.velocity - before.velocity)[0]
    np.testing.assert_allclose(relative, change, rtol=1e-9)
    inertia = system.bodies[1].inertia
    spins = (rotations.matrices(one.attitude[1]) @ (inertia * one.spin[1]) for one in (state, before))
    expected = np.cross(axes @ [7e-3, 0.0, -4e-3], system.masses[1] * change)
    np.testing.assert_allclose(np.subtract(*spins), expected, rtol=1e-9)
    # The pole is the published one.
    longitude, latitude = np.radians([310.0, -84.0])
    pole = [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)]
    np.testing.assert_allclose(axes[:, 2], pole, atol=1e-12)


def test_a_planar_start_stays_planar():
    left_out = ("normal", "miss_normal", "log_k2_q", "log_k2_q_primary", "byorp")
    system, state = model.planar(**{name: value for name, value in NOMINAL.items() if name not in left_out})
    run = system.integrate(state, 500.0, output=10.0, integrator=fullbody.SymplecticSplitting(step=0.5))
    assert not run.position[:, :, 2].any()


def truth():
    system, state = model.setup(**NOMINAL)
    columns = np.concatenate([state.position, state.velocity, state.attitude, state.spin], axis=1)
    names = ("equatorial", "polar", "diameter", "a_b", "b_c")
    return mission.Truth(*system.masses, *(NOMINAL[name] for name in names), columns)


def test_derivatives_of_landmarks():
    """Equal to differences of the directions themselves."""
    pair = truth()
    setup, values = mission.survey(pair)
    system, state = setup(**values)
    times = np.array([20.0, 60.0, 100.0])
    options = {"integrator": fullbody.Verner98(1e-10, 1e-10), "derivatives": ["mass of Dimorphos"]}
    run = system.integrate(state, times[-1], times, **options)
    lines = mission.Landmarks.directions(run, "Dimorphos", "Hera 1", 0.07 * mission.PLACES)
    data = mission.Landmarks(
        times, 0.07 * mission.PLACES, "Dimorphos", "Hera 1", lines, np.full(lines.shape[:2], True), 1e-4
    )
    assert np.abs(data.pulls(run)).max() < 1e-9
    found, expected = data.derivatives(run), run.derivative_of(data.pulls)
    np.testing.assert_allclose(found.start, expected.start, rtol=1e-6, atol=1e-7 * np.abs(expected.start).max())
    mass = expected.by_parameter["mass of Dimorphos"]
    np.testing.assert_allclose(found.by_parameter["mass of Dimorphos"], mass, rtol=1e-5, atol=1e-7 * np.abs(mass).max())


def test_moments():
    """Of a body's own moments of inertia."""
    body = fullbody.Body(fullbody.Ellipsoid(1.3 * 1.2, 1.2, 1.0), mass=1.0)
    a, b, c = body.inertia
    np.testing.assert_allclose(knowledge.moments(1.3, 1.2), [(b - a) / c, (c - a) / b, (c - b) / a])


#: Hours of the small study, which ends after the days observed.
END = measures.WINDOW + 100.0
SCRIPT = """
import sys
from pathlib import Path
from reproduction.hera2026 import study
study.sweep(Path(sys.argv[1]), 4, end=float(sys.argv[2]), chunk=1, threads=1)
"""


def kept_members(folder):
    """Members without a fit, which takes a minute."""
    rng = np.random.default_rng(5)
    columns = {name: rng.normal(inputs.INPUTS[name].value, 0.3 * inputs.INPUTS[name].sigma, 4) for name in model.NAMES}
    # One starts within Didymos.
    columns["separation"][2] = 450.0
    folder.mkdir()
    (folder / "members.json").write_text(json.dumps({"columns": {name: list(one) for name, one in columns.items()}}))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hera") / "whole"
    kept_members(folder)
    return folder, study.sweep(folder, 4, end=END, chunk=1, threads=1)


def test_outcomes_with_reasons(whole):
    _, found = whole
    assert list(found.error.values) == ["", "", "BodiesOverlap", ""]
    good = found.isel(row=[0, 1, 3])
    assert (good.fate == "bound").all()
    assert (good.unmeasured == "").all()
    assert ((good.period_after > 11.2) & (good.period_after < 11.5)).all()
    # Some 147 revolutions, less the second that ends are apart by.
    np.testing.assert_allclose(good.longitude, 2 * np.pi * END / good.period, rtol=2e-3)
    assert (good.energy_drift_orbital < 1e-6).all()
    last = {"last_yaw": ("row", [10.0, 80.0, np.nan, 20.0]), "last_roll": ("row", [5.0, 1, np.nan, 90])}
    assert list(measures.outcome(found.assign(last))) == ["locked", "tumbling", "failed", "rolling"]


@pytest.mark.skipif(os.name == "nt", reason="a process is killed by a signal")
def test_killed_and_resumed(whole, tmp_path):
    folder = tmp_path / "killed"
    kept_members(folder)
    command = [sys.executable, "-c", SCRIPT, str(folder), repr(END)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    process = subprocess.Popen(command, env=environment, cwd=ROOT)
    while process.poll() is None and not list(folder.glob("map.nc.parts/*.npz")):
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    found = study.sweep(folder, 4, end=END, chunk=1, threads=1)
    xarray.testing.assert_identical(found, whole[1])


@pytest.fixture(scope="module")
def kept():
    return xarray.load_dataset(report.RESULTS / "members.nc")


def test_results_that_are_kept(kept):
    assert kept.sizes["row"] >= 2000
    assert (kept.error == "").all()
    seen, locked = results.consistent(kept), kept.outcome.values == "locked"
    # What the page states: apses as observed go with a locked body.
    assert locked[seen].mean() > 2 * locked[~seen].mean()
    assert sum((report.RESULTS / name).stat().st_size for name in os.listdir(report.RESULTS)) < 1_400_000


def test_what_would_refute(kept):
    """What is said to refute the prediction does not happen in more than one member in fifty."""
    found = results.refuting(kept)
    assert set(found) == set(report.REFUTED)
    assert all(np.mean(one) <= 0.02 for one in found.values())


def test_report(kept):
    numbers = json.loads((report.RESULTS / "numbers.json").read_text())
    text = report.text(numbers)
    assert numbers["dated"] in text
    assert not re.search(r"\b(nan|inf|None)\b", text)
    for name in inputs.INPUTS:
        assert f"| {name} |" in text
    assert {one.source for one in inputs.INPUTS.values()} <= {*inputs.SOURCES, "assumed"}
    assert numbers["members"] == kept.sizes["row"]
