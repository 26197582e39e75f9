"""Periodic orbits, their multipliers, sections and frequencies."""

import fullbody
import numpy as np
import pytest
import support
from fullbody.errors import BodiesOverlap
from scipy.special import ellipk
from support import body_list

analysis = fullbody.analysis


@pytest.fixture(scope="module")
def orbit(ellipsoids, locked):
    """A periodic orbit on which both bodies librate out of the orbit's plane."""
    return analysis.periodic_orbit(ellipsoids, locked.modes.excited(-1, 0.05), locked.modes.period[-1])


def closure_error(orbit, run):
    """Return the largest difference between the end of a run and its start rotated by the orbit's rotation angle."""
    start, end = run[0], run[-1]
    R = support.rot_z(orbit.rotation_angle)
    results = [end.position - start.position @ R.T, end.velocity - start.velocity @ R.T, end.spin - start.spin]
    for k in range(len(start)):
        results.append(end.rotation_matrix[k] - R @ start.rotation_matrix[k])
    return max(np.abs(part).max() for part in results)


def test_a_periodic_orbit_closes_with_another_integrator_and_not_at_half_its_period(ellipsoids, orbit):
    assert orbit.closure < 1e-12
    # The check takes other steps than the search.
    other = fullbody.Verner87(rtol=1e-14, atol=1e-14)
    assert closure_error(orbit, ellipsoids.integrate(orbit.state, orbit.period, integrator=other)) < 1e-12
    # It is not the equilibrium.
    run = ellipsoids.integrate(orbit.state, orbit.period, output=orbit.period / 8)
    tilt = np.asarray(fullbody.observables.roll_pitch_yaw(run, body="B", about="A"))[:, :2]
    assert np.abs(tilt).max() > 0.02
    assert closure_error(orbit, run[: len(run) // 2]) > 1e-3


def test_multipliers_come_in_reciprocal_pairs(orbit):
    multipliers = orbit.multipliers
    assert len(multipliers) == 12
    assert max(np.abs(1 / multiplier - multipliers).min() for multiplier in multipliers) < 1e-10
    assert max(np.abs(np.conj(multiplier) - multipliers).min() for multiplier in multipliers) < 1e-10
    # A resonance makes the orbit unstable at this amplitude; the pairs are reciprocal all the same.
    assert not orbit.linearly_stable
    assert abs(np.prod(multipliers) - 1.0) < 1e-9
    # The monodromy matrix has six more eigenvalues: four ones, and two for a tilt of the angular momentum.
    eigenvalues = np.linalg.eigvals(orbit.monodromy)
    assert np.sum(np.abs(eigenvalues - 1) < 1e-4) == 4
    for sign in (1, -1):
        assert np.abs(eigenvalues - np.exp(1j * sign * orbit.rotation_angle)).min() < 1e-9


@pytest.mark.parametrize("mode", [3, 5])
def test_small_orbits_have_the_multipliers_of_the_modes(ellipsoids, locked, mode):
    modes = locked.modes
    period_changes = []
    for amplitude in (4e-3, 2e-3):
        result = analysis.periodic_orbit(ellipsoids, modes.excited(mode, amplitude), modes.period[mode])
        period_changes.append(abs(result.period / modes.period[mode] - 1))
        frequencies = np.delete(modes.frequency, mode)
        expected = np.exp(1j * frequencies * result.period)
        assert max(np.abs(multiplier - result.multipliers).min() for multiplier in expected) < 1e-3
        assert result.linearly_stable
    # The period changes with the square of the amplitude.
    assert period_changes[0] < 1e-4
    assert period_changes[0] / period_changes[1] == pytest.approx(4.0, rel=0.1)


def test_the_family_of_a_libration_has_the_period_of_a_pendulum(ellipsoids, locked):
    family = analysis.periodic_family(locked, 3, np.geomspace(0.05, 0.6, 8))
    amplitudes = []
    for orbit in family:
        assert orbit.closure < 1e-12
        assert orbit.angular_momentum == pytest.approx(locked.angular_momentum, rel=1e-13)
        run = ellipsoids.integrate(orbit.state, orbit.period, output=orbit.period / 64)
        amplitudes.append(np.abs(fullbody.observables.roll_pitch_yaw(run, body="B", about="A")[:, 2]).max())
    assert amplitudes[-1] > 0.5
    # For a light secondary, twice the angle moves like a pendulum: the period at the amplitude A is 2 K(sin A) / pi
    # times that of small librations.
    periods = np.array([orbit.period for orbit in family]) / locked.modes.period[3]
    pendulum = ellipk(np.sin(amplitudes) ** 2) * 2 / np.pi
    np.testing.assert_allclose(periods - 1, pendulum - 1, rtol=0.15)


def test_an_orbit_near_an_unstable_equilibrium_grows_at_its_rate(ellipsoids):
    near = analysis.relative_equilibrium(ellipsoids, separation=1.8)
    modes = near.modes
    growth = modes.growth.max()
    assert growth > 0
    mode = int(np.flatnonzero(~modes.in_plane)[-1])
    result = analysis.periodic_orbit(ellipsoids, modes.excited(mode, 1e-3), modes.period[mode])
    assert not result.linearly_stable
    assert abs(result.multipliers[0]) == pytest.approx(np.exp(growth * result.period), rel=1e-4)
    assert abs(result.multipliers[0] * result.multipliers[-1]) == pytest.approx(1.0, rel=1e-9)


def test_orbits_do_not_depend_on_the_number_of_segments(ellipsoids, locked, orbit):
    modes = locked.modes
    options = {"hold": ["energy", "angular_momentum"]}
    single, result = (
        analysis.periodic_orbit(ellipsoids, modes.excited(-1, 0.05), modes.period[-1], segments=count, **options)
        for count in (1, 3)
    )
    assert result.period == pytest.approx(single.period, rel=1e-11)
    assert result.energy == pytest.approx(single.energy, rel=1e-13)
    at_period = analysis.periodic_orbit(ellipsoids, modes.excited(-1, 0.05), orbit.period, hold="period")
    assert at_period.period == pytest.approx(orbit.period, rel=1e-12)
    assert at_period.closure < 1e-12


def test_an_orbit_closes_after_a_half_turn_of_the_primary():
    # The primary rotates by half a turn relative to the orbit in a ninth of a revolution.
    bodies = body_list(A=(fullbody.Ellipsoid(0.8, 0.7, 0.6), 1.0), B=(fullbody.Ellipsoid(0.3, 0.27, 0.2), 0.02))
    system = fullbody.System(bodies, G=1.0)
    mean = analysis.averaged(system, "A", copies=8)
    equilibrium = analysis.relative_equilibrium(mean, separation=3.0, spin={"A": 1.1})
    period = np.pi / (1.1 - equilibrium.rate)
    result = analysis.periodic_orbit(system, equilibrium.state, period)
    assert result.half_turns == {"A": "z"}
    angle = np.remainder(equilibrium.rate * period + np.pi, 2 * np.pi) - np.pi
    assert result.rotation_angle == pytest.approx(angle, rel=1e-2)
    run = system.integrate(result.state, result.period)
    R = support.rot_z(result.rotation_angle)
    assert np.abs(run.position[-1] - run.position[0] @ R.T).max() < 1e-12
    rotated = R @ run[0].rotation_matrix[0] @ np.diag([-1.0, -1.0, 1.0])
    assert np.abs(run[-1].rotation_matrix[0] - rotated).max() < 1e-12


def test_sections_are_the_events_of_runs(ellipsoids, locked):
    starts = [locked.modes.excited(3, size) for size in (0.01, 0.02)]
    event = fullbody.events.Periapsis("A", "B")
    result = analysis.section(ellipsoids, starts, 300.0, event)
    assert repr(result).startswith("Section(2 starts, ")
    distance = result.values(lambda state: np.linalg.norm(state.position[1] - state.position[0]))
    for start, values in zip(starts, distance, strict=True):
        run = ellipsoids.integrate(start, 300.0, events=[event])
        expected = [np.linalg.norm(passage.state.position[1] - passage.state.position[0]) for passage in run.events]
        assert len(expected) > 2
        np.testing.assert_array_equal(values, expected)


def test_a_section_keeps_the_crossings_before_a_collision():
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0) for _ in range(2)]
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State([[0, 0, 0], [6, 0, 0]], [[0, 0, 0], [0, 0, 0]])
    falling = analysis.section(system, state, 50.0, fullbody.events.Separation(0, 1, 4.0))
    assert isinstance(falling.errors[0], BodiesOverlap)
    assert len(falling.crossings[0]) == 1


def test_frequencies_of_two_sinusoids_are_recovered(ellipsoids, locked):
    run = ellipsoids.integrate(locked.state, 200.0, output=0.5)
    time = run.time
    result = analysis.frequencies(run, 0.3 * np.cos(1.234 * time) + 2.0 * np.sin(0.7 * time + 1.0), n=2)
    np.testing.assert_allclose(result.frequency, [0.7, 1.234], rtol=1e-5)
    np.testing.assert_allclose(result.amplitude, [2.0, 0.3], rtol=1e-4)
