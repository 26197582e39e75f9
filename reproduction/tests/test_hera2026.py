"""The prediction for Hera: the start after the impact, simulated data, a small study, and the stored results."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import fullbody
import numpy as np
import pytest
import xarray
from fullbody.base import rotations
from scipy.stats import norm

from reproduction.hera2026 import (
    binary_yarkovsky,
    damping,
    ellipse,
    inputs,
    knowledge,
    measures,
    mission,
    model,
    posterior,
    report,
    results,
    study,
    weights,
)

ROOT = Path(__file__).parents[2]
NOMINAL = {name: inputs.INPUTS[name].value for name in model.NAMES}


def test_masses_follow_from_the_orbit_before_the_impact():
    """Kepler's third law has the first term of the oblateness; the next one is of the order of its square."""
    primary, secondary = model.masses(1189.0, 425.0, 310.0, 151.5, 2400.0)
    oblateness = (425.0**2 - 310.0**2) / 5 / 1189.0**2
    kepler = 4 * np.pi**2 * 1189.0**3 / (6.6743e-11 * (11.921473 * 3600) ** 2)
    assert primary + secondary == pytest.approx(kepler / (1 + 1.5 * oblateness), rel=2e-3)
    assert secondary == pytest.approx(2400 * np.pi / 6 * 151.5**3)


def test_inelastic_damping_by_the_rigidity_and_radius_of_a_sphere():
    """The time is D mu Q/(rho R^2 omega^3), with the rigidity of a sphere of 75 m that has k2 = 1e-3 and Q = 10."""
    density, radius, rotation = 2400.0, 75.0, 2 * np.pi / (11.3674 * 3600)
    gravity = 6.6743e-11 * 4 / 3 * np.pi * density * radius
    rigidity = 3 * density * gravity * radius / (19 * 1e-3)
    seconds = 300 * rigidity * 10 / (density * radius**2 * rotation**3)
    assert damping.years(1e-4, 300.0) == pytest.approx(seconds / 3.15576e7, rel=1e-12)


def test_the_impact_adds_momentum_and_angular_momentum():
    values = NOMINAL | {"yaw": 25.0, "miss_radial": 7.0, "miss_normal": -4.0, "normal": 1.0, "radial": 0.5}
    system, state = model.setup(**values)
    _, previous = model.setup(**values | {"along": 0.0, "normal": 0.0, "radial": 0.0})
    assert np.abs(system.momentum(state)).max() < 1e-12 * np.abs(system.masses[1] * state.velocity[1]).max()
    # The axes of the orbit: from Didymos, along the motion and normal to both.
    x = previous.position[1] - previous.position[0]
    x /= np.linalg.norm(x)
    y = previous.velocity[1] / np.linalg.norm(previous.velocity[1])
    axes = np.stack([x, y, np.cross(x, y)], axis=1)
    change = axes @ np.array([0.5, -2.63, 1.0]) * 3.6e-3
    relative = (state.velocity - previous.velocity)[1] - (state.velocity - previous.velocity)[0]
    np.testing.assert_allclose(relative, change, rtol=1e-9)
    inertia = system.bodies[1].inertia
    spins = (rotations.matrices(moment.attitude[1]) @ (inertia * moment.spin[1]) for moment in (state, previous))
    expected = np.cross(axes @ [7e-3, 0.0, -4e-3], system.masses[1] * change)
    np.testing.assert_allclose(np.subtract(*spins), expected, rtol=1e-9)
    # The pole is the published one.
    longitude, latitude = np.radians([309.8, -80.7])
    pole = [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)]
    np.testing.assert_allclose(axes[:, 2], pole, atol=1e-12)


def test_a_planar_start_stays_planar():
    system, state = model.planar(**{name: NOMINAL[name] for name in posterior.FITTED})
    run = system.integrate(state, 500.0, output=10.0, integrator=fullbody.SymplecticSplitting(step=0.5))
    assert not run.position[:, :, 2].any()


def truth():
    system, state = model.setup(**NOMINAL)
    columns = np.concatenate([state.position, state.velocity, state.attitude, state.spin], axis=1)
    names = ("equatorial", "polar", "diameter", "a_b", "b_c")
    return mission.Truth(*system.masses, *(NOMINAL[name] for name in names), columns)


def test_derivatives_of_landmarks_are_differences_of_the_directions():
    pair = truth()
    setup, values = mission.survey(pair)
    system, state = setup(**values)
    times = np.array([20.0, 60.0, 100.0])
    options = {"integrator": fullbody.Verner98(1e-10, 1e-10), "derivatives": ["mass of Dimorphos"]}
    run = system.integrate(state, times[-1], output=times, **options)
    directions = mission.Landmarks.predicted(run, "Dimorphos", "Hera 1", 0.07 * mission.LANDMARKS)
    data = mission.Landmarks(
        times, 0.07 * mission.LANDMARKS, "Dimorphos", "Hera 1", directions, np.full(directions.shape[:2], True), 1e-4
    )
    assert np.abs(data.pulls(run)).max() < 1e-9
    result, expected = data.derivatives(run), run.derivative_of(data.pulls)
    np.testing.assert_allclose(result.start, expected.start, rtol=1e-6, atol=1e-7 * np.abs(expected.start).max())
    mass = expected.by_parameter["mass of Dimorphos"]
    np.testing.assert_allclose(
        result.by_parameter["mass of Dimorphos"], mass, rtol=1e-5, atol=1e-7 * np.abs(mass).max()
    )


def test_moments_are_those_of_a_body():
    body = fullbody.Body(fullbody.Ellipsoid(1.3 * 1.2, 1.2, 1.0), mass=1.0)
    a, b, c = body.inertia
    np.testing.assert_allclose(knowledge.moments(1.3, 1.2), [(b - a) / c, (c - a) / b, (c - b) / a])


def test_reshaping_conserves_the_angular_momentum():
    """A prolate body of equal mass and angular momentum spins slower by the ratio of a^2 + b^2."""
    _, state = model.setup(**NOMINAL)
    c_intact, c_reshaped = 1.0 / (1.054 * 1.477**2) ** (1 / 3), 1.0 / (1.3 * 1.23**2) ** (1 / 3)
    intact = (c_intact * 1.477) ** 2 * (1.0 + 1.054**2)
    reshaped = (c_reshaped * 1.23) ** 2 * (1.0 + 1.3**2)
    expected = 2.0 * np.pi / 11.921473 * intact / reshaped
    np.testing.assert_allclose(state.spin[1], [0.0, 0.0, expected], rtol=1e-9, atol=1e-12)


def test_the_fitted_ellipse_of_a_precessing_kepler_orbit_is_the_orbit():
    """The orbit is r = p/(1 + e cos f), with apses that advance."""
    period, eccentricity, rate = 11.3674, 0.028, np.radians(6.7) / 24.0
    time = np.arange(0.0, 1609.0, 2.0)
    motion = 2.0 * np.pi / period
    anomaly = (motion - rate) * time + 0.4
    eccentric = anomaly
    for _ in range(50):
        eccentric = anomaly + eccentricity * np.sin(eccentric)
    f = 2.0 * np.arctan2(
        np.sqrt(1.0 + eccentricity) * np.sin(eccentric / 2.0), np.sqrt(1.0 - eccentricity) * np.cos(eccentric / 2.0)
    )
    distance = 1.15 * (1.0 - eccentricity * np.cos(eccentric))
    longitude = f + rate * time
    tilt = 0.3
    x, y = distance * np.cos(longitude), distance * np.sin(longitude)
    position = np.stack([x, y * np.cos(tilt), y * np.sin(tilt)], axis=1)
    velocity = np.stack([-y, x * np.cos(tilt), x * np.sin(tilt)], axis=1)
    run = SimpleNamespace(
        time=time,
        position=np.stack([np.zeros_like(position), position], axis=1),
        velocity=np.stack([np.zeros_like(velocity), velocity], axis=1),
    )
    result = ellipse.fitted_ellipse(run)
    assert result.period == pytest.approx(period, rel=1e-6)
    assert result.eccentricity == pytest.approx(eccentricity, rel=1e-2)
    assert result.precession == pytest.approx(6.7, abs=2e-3)
    assert result.coherence > 0.999


def test_prior_and_likelihood_are_normal():
    columns = {name: NOMINAL[name] + np.array([0.0, 0.7]) * inputs.INPUTS[name].sigma for name in model.NAMES}
    expected = sum(
        np.diff(norm.logpdf(columns[name], inputs.INPUTS[name].value, inputs.INPUTS[name].sigma))
        for name in model.NAMES
    )
    np.testing.assert_allclose(np.diff(posterior.prior(columns)), expected)
    orbits = {"period": np.array([11.3674, 11.3716, np.nan]), "eccentricity": [0.028, 0.02, 0.02]}
    orbits["precession"] = [6.7, 6.5, 6.5]
    expected = norm.logpdf(11.3716, 11.3674, 0.0042) + norm.logpdf(0.02, 0.028, 0.0053) + norm.logpdf(6.5, 6.7, 0.2)
    expected -= norm.logpdf(0.0, 0.0, 0.0042) + norm.logpdf(0.0, 0.0, 0.0053) + norm.logpdf(0.0, 0.0, 0.2)
    np.testing.assert_allclose(posterior.likelihood(orbits), [0.0, expected, -np.inf])


def test_weighted_draws_from_the_proposal_have_the_posterior():
    """With an exact surrogate, the weighted mean of a narrower prior is that of the normal distribution."""
    names = posterior.INPUT_NAMES
    value, sigma = inputs.INPUTS["along"].value, inputs.INPUTS["along"].sigma
    count = len(names)
    coefficients = np.zeros((1 + count + count * (count + 1) // 2, 3))
    coefficients[0] = [11.3674 + 0.002, 0.028, 6.7]
    coefficients[1 + names.index("along"), 0] = 0.004
    centre = np.array([inputs.INPUTS[name].value for name in names])
    scale = np.array([inputs.INPUTS[name].sigma for name in names])
    surrogate = posterior.Surrogate(centre, scale, coefficients, np.array([0.003, 0.001, 0.1]))
    columns = posterior.draws(surrogate, 4000, 7)
    period = 11.3694 + 0.004 * (columns["along"] - value) / sigma
    orbits = {"period": period, "eccentricity": np.full(4000, 0.028), "precession": np.full(4000, 6.7)}
    weight = weights.normalized(posterior.log_weights(columns, orbits, surrogate))
    # x is normal with mean 0 and sigma 1, and 0.004 x = -0.002 +- 0.0042.
    expected = -0.002 / 0.004 * (0.004 / 0.0042) ** 2 / (1.0 + (0.004 / 0.0042) ** 2)
    x = (columns["along"] - value) / sigma
    assert weight @ x == pytest.approx(expected, abs=0.08)
    assert np.sqrt(weight @ (x - weight @ x) ** 2) == pytest.approx(
        1.0 / np.sqrt(1.0 + (0.004 / 0.0042) ** 2), rel=0.08
    )
    assert np.sqrt(weight @ (columns["normal"] / 1.5) ** 2) == pytest.approx(1.0, rel=0.08)


def test_evidence_multiplies_the_odds():
    weight = weights.normalized(np.log([1.0, 2.0, 1.0]), [True, False, False], 10.0)
    np.testing.assert_allclose(weight, np.array([10.0, 2.0, 1.0]) / 13.0)
    assert list(weights.normalized([0.0, 0.0], [True, False], np.inf)) == [1.0, 0.0]
    assert weights.effective(np.full(8, 1 / 8)) == pytest.approx(8.0)
    share, error = weights.share(np.full(100, 0.01), np.arange(100) < 30)
    assert (share, error) == (pytest.approx(0.3), pytest.approx(np.sqrt(0.3 * 0.7 / 100)))


def test_inclusion_is_in_proportion_and_has_the_expected_number():
    logarithm = np.log(np.r_[np.full(90, 1.0), np.full(10, 3.0)])
    chance = weights.inclusion(logarithm, np.zeros(100, dtype=bool), 20.0)
    assert chance.sum() == pytest.approx(20.0, rel=0.05)
    assert chance[-1] == pytest.approx(3.0 * chance[0])


def test_change_is_a_circular_or_an_incoherent_orbit():
    dataset = xarray.Dataset(
        {
            "observed_eccentricity_later": ("row", [0.01, 0.028, 0.028]),
            "observed_coherence_later": ("row", [0.99, 0.5, 0.98]),
        }
    )
    assert list(weights.changed(dataset)) == [True, True, False]


def test_the_drift_is_that_of_keplers_third_law():
    """The drift is the integral of the mean motion sqrt(mu/a^3) of an orbit that shrinks."""
    effect = binary_yarkovsky.consequences(-7.0, 1150.0, 36000.0)
    mu = (2.0 * np.pi / 11.3674) ** 2 * 1150.0**3
    time = np.linspace(0.0, 36000.0, 20001)
    a = 1150.0 - 0.07 * time / 8766.0
    longitude = np.trapezoid(np.sqrt(mu / a**3) - np.sqrt(mu / 1150.0**3), time)
    assert effect["longitude"] == pytest.approx(np.degrees(longitude), rel=1e-3)
    assert effect["period"] == pytest.approx(3600.0 * (2.0 * np.pi / np.sqrt(mu / a[-1] ** 3) - 11.3674), rel=1e-3)


def test_outcomes_of_angles():
    roll, pitch, yaw = [5.0, 90.0, 20.0, np.nan, 1.0], [1.0, 20.0, 70.0, np.nan, 1.0], [10.0, 30.0, 80.0, np.nan, 1.0]
    words = measures.outcome(roll, pitch, yaw, ["bound", "bound", "bound", "", "escape"])
    assert list(words) == ["locked", "rolling", "end over end", "failed", "escape"]


#: Hours of the small study, which ends after both intervals of observations.
END = measures.CHANGE_DAYS * model.DAY + 100.0
SCRIPT = """
import sys
from pathlib import Path
from reproduction.tests.test_hera2026 import small_study
small_study(Path(sys.argv[1]))
"""


def small_study(folder):
    """Run four starts, one of which begins within Didymos."""
    rng = np.random.default_rng(5)
    columns = {name: rng.normal(inputs.INPUTS[name].value, 0.3 * inputs.INPUTS[name].sigma, 4) for name in model.NAMES}
    columns["separation"][2] = 450.0
    return study.sweep(
        model.setup, folder, "members", columns, END, partial(measures.measure, end=END), chunk=1, threads=1
    )


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    return small_study(tmp_path_factory.mktemp("hera"))


def test_members_with_reasons(full):
    assert list(full.error.values) == ["", "", "BodiesOverlap", ""]
    completed = full.isel(row=[0, 1, 3])
    assert (completed.fate == "bound").all()
    assert ((completed.observed_period > 11.2) & (completed.observed_period < 11.5)).all()
    assert (completed.energy_drift_orbital < 1e-7).all()
    assert np.isfinite(completed.observed_eccentricity_later).all()


@pytest.mark.skipif(os.name == "nt", reason="a process is killed by a signal")
def test_killed_and_resumed(full, tmp_path):
    command = [sys.executable, "-c", SCRIPT, str(tmp_path)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    process = subprocess.Popen(command, env=environment, cwd=ROOT)
    while process.poll() is None and not list(tmp_path.glob("members.nc.parts/*.npz")):
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    xarray.testing.assert_identical(small_study(tmp_path), full)


@pytest.fixture(scope="module")
def stored():
    return xarray.load_dataset(report.RESULTS / "members.nc")


def test_stored_results_are_complete_and_small(stored):
    assert stored.sizes["row"] >= 200
    assert (stored.error == "").all()
    reference, likely = (
        weights.share(results.normal_weights(stored, ratio), stored.outcome.values == "locked") for ratio in (1, 10)
    )
    # The page states that the report of a change makes a roll likelier.
    assert reference[0] > likely[0] + likely[1]
    assert sum((report.RESULTS / name).stat().st_size for name in os.listdir(report.RESULTS)) < 1_400_000


def test_criteria_are_improbable(stored):
    result = results.criteria(stored)
    assert set(result) == set(results.CRITERIA)
    assert all(weights.share(results.normal_weights(stored, 1.0), entry)[0] < 0.2 for entry in result.values())


def test_a_finding_near_a_member_scores_higher(stored):
    first = stored.isel(row=int(np.argmax(stored.log_weight.values)))
    finding = {"eccentricity": float(first.eccentricity), "a_b": float(first.a_b)}
    near = results.score(stored, str(first.outcome.values), finding)
    far = results.score(stored, str(first.outcome.values), finding | {"eccentricity": 0.1})
    assert near > far + 10.0
    assert results.score(stored, "end over end", finding) == -np.inf


def test_report(stored):
    numbers = json.loads((report.RESULTS / "numbers.json").read_text())
    text = report.text(numbers)
    assert numbers["dated"] in text
    assert not re.search(r"\b(nan|inf|None)\b", text)
    for name in inputs.INPUTS:
        assert f"| {name} |" in text
    assert {entry.source for entry in inputs.INPUTS.values()} <= {*inputs.SOURCES, "assumed"}
    assert numbers["members"] == stored.sizes["row"]
