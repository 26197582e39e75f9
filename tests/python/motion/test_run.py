"""Runs: which samples are recorded, forwards and backwards, their energies and drifts, and reports of progress."""

import fullbody
import numpy as np
import pytest
from fullbody import observables
from fullbody.errors import InconsistentInput
from support import angle_between, refused

SYSTEM, STATE = fullbody.systems.case1()


def test_output_none_is_every_accepted_step():
    run = SYSTEM.integrate(STATE, 20.0)
    assert len(run) == run.statistics.steps + 1
    assert run.time[0] == 0.0
    assert run.time[-1] == 20.0
    assert (np.diff(run.time) > 0).all()


def test_an_output_number_is_the_spacing_and_includes_the_end():
    assert SYSTEM.integrate(STATE, 10.0, output=2.5).time.tolist() == [0.0, 2.5, 5.0, 7.5, 10.0]
    assert SYSTEM.integrate(STATE, 10.0, output=4.0).time.tolist() == [0.0, 4.0, 8.0, 10.0]
    with pytest.warns(InconsistentInput, match="the run is only 10 long"):
        assert SYSTEM.integrate(STATE, 10.0, output=40.0).time.tolist() == [0.0, 10.0]


def test_samples_at_a_spacing_do_not_accumulate_round_off():
    time = SYSTEM.integrate(STATE.replace(time=5.0), 15.0, output=0.1).time
    assert len(time) == 101
    assert np.abs(time - (5.0 + 0.1 * np.arange(101))).max() < 4e-15
    assert time[-1] == 15.0


def test_output_ends_is_start_and_end():
    start = STATE.replace(time=5.0)
    for until in (15.0, -5.0):
        ends, every = SYSTEM.integrate(start, until, output="ends"), SYSTEM.integrate(start, until)
        assert ends.time.tolist() == [5.0, until]
        assert (ends[0], ends[-1]) == (every[0], every[-1])
        assert ends.statistics == every.statistics
    assert SYSTEM.integrate(start, 5.0, output="ends").time.tolist() == [5.0]
    crossing = fullbody.events.Function(lambda s: s.time - 7.0, terminal=True)
    assert SYSTEM.integrate(start, 15.0, output="ends", events=[crossing]).time == pytest.approx([5.0, 7.0], abs=1e-12)
    refused("output is 'end'", lambda: SYSTEM.integrate(start, 15.0, output="end"))


def test_an_output_array_is_exactly_those_times():
    times = np.array([0.3, np.pi, 7.123456789, 9.0])
    run = SYSTEM.integrate(STATE, 10.0, output=times)
    assert np.array_equal(run.time, times)
    assert len(SYSTEM.integrate(STATE, 10.0, output=[])) == 0
    assert SYSTEM.integrate(STATE, 10.0, output=[0.0, 10.0]).time.tolist() == [0.0, 10.0]


def test_a_run_without_samples_has_empty_arrays():
    run = SYSTEM.integrate(STATE, 10.0, output=[])
    for values in (run.energy_drift, run.energy_drift_orbital, run.angular_momentum_drift):
        assert values.shape == (0,)
        assert values.dtype == float
    assert run.elements().e.shape == (0,)
    assert list(run) == []
    assert "samples" in run._repr_html_()
    for needs_samples in (run.plot, run.plot.elements, run.plot.scene, run.view):
        refused("the run has no samples; expected at least one", needs_samples)
    for observable in (observables.mutual_period, observables.orbit_precession, observables.obliquity):
        refused(r"the run has 0 samples; .* needs", lambda observable=observable: observable(run))


def test_arrays_of_a_run_have_their_shapes():
    run = SYSTEM.integrate(STATE, 3.0, output=1.0)
    shapes = {"time": (4,), "position": (4, 2, 3), "velocity": (4, 2, 3), "attitude": (4, 2, 4), "spin": (4, 2, 3)}
    shapes |= {"energy": (4,), "angular_momentum": (4, 3), "energy_drift": (4,), "angular_momentum_drift": (4,)}
    for name, shape in shapes.items():
        array = getattr(run, name)
        assert array.shape == shape, name
        assert array.dtype == np.float64
    assert run.elements().a.shape == (4,)
    assert run.position.flags.c_contiguous
    with pytest.raises(ValueError, match="read-only"):
        run.position[0] = 0.0


def test_recorded_energies_are_those_of_the_states():
    run = SYSTEM.integrate(STATE, 20.0, output=5.0)
    for k, state in enumerate(run):
        energy = SYSTEM.energy(state)
        assert run.energy[k] == pytest.approx(energy.total, rel=1e-14)
        assert run.potential_energy[k] == pytest.approx(energy.potential, rel=1e-14)
        assert run.translational_energy[k] == pytest.approx(energy.translational, rel=1e-14)
        assert run.rotational_energy[k] == pytest.approx(energy.rotational, rel=1e-13, abs=1e-16)
        assert run.angular_momentum[k] == pytest.approx(SYSTEM.angular_momentum(state), rel=1e-14, abs=1e-14)


def test_drifts_are_changes_from_the_start():
    run = SYSTEM.integrate(STATE, 50.0, integrator=fullbody.Verner98(rtol=1e-6, atol=1e-6))
    energy = run.energy
    assert np.array_equal(run.energy_drift, (energy - energy[0]) / abs(energy[0]))
    orbital = abs(run.potential_energy[0] + run.translational_energy[0])
    assert run.energy_drift_orbital == pytest.approx((energy - energy[0]) / orbital, rel=1e-12, abs=0)
    momentum = run.angular_momentum
    change = np.linalg.norm(momentum - momentum[0], axis=1) / np.linalg.norm(momentum[0])
    assert run.angular_momentum_drift == pytest.approx(change, rel=1e-12, abs=0)
    # A loose tolerance shows: the drift is not zero by construction.
    assert np.abs(run.energy_drift).max() > 1e-13


def test_drifts_from_zero_are_absolute():
    two = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)] * 2, G=1.0)
    run = two.integrate(fullbody.State([[0, 0, 0], [5, 3, 1]], np.zeros((2, 3))), 1.0, output=0.1)
    assert np.array_equal(run.angular_momentum_drift, np.linalg.norm(run.angular_momentum, axis=1))
    assert run.angular_momentum_drift.max() < 1e-15
    single = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)], G=1.0)
    run = single.integrate(fullbody.State([[0, 0, 0]], np.zeros((1, 3))), 1.0, output=0.1)
    for drift in (run.energy_drift, run.energy_drift_orbital, run.angular_momentum_drift):
        assert np.array_equal(drift, np.zeros(11))
    # Such drifts are neither in the table nor in the plot.
    assert "drift" not in repr(run) + run._repr_html_()
    assert not run.plot.energy().lines


def test_an_index_gives_the_state_of_a_sample():
    run = SYSTEM.integrate(STATE, 4.0, output=1.0)
    assert len(run) == 5
    assert run[0] == STATE
    assert run[-1] == run[4]
    assert isinstance(run[-1], fullbody.State)
    assert run[2].time == 2.0
    assert np.array_equal(run[2].position, run.position[2])
    assert [state.time for state in run] == [0.0, 1.0, 2.0, 3.0, 4.0]
    for index in (5, -6):
        with pytest.raises(IndexError):
            run[index]


def test_runs_go_backwards():
    run = SYSTEM.integrate(STATE, -20.0, output=4.0)
    assert run.time.tolist() == [0.0, -4.0, -8.0, -12.0, -16.0, -20.0]
    steps = SYSTEM.integrate(STATE, -20.0)
    assert (np.diff(steps.time) < 0).all()
    assert steps.time[-1] == -20.0
    back = SYSTEM.integrate(run[-1], 0.0, output=[-10.0, 0.0])
    assert np.abs(back.position[-1] - STATE.position).max() < 1e-12
    assert angle_between(back[-1].rotation_matrix, STATE.rotation_matrix).max() < 1e-12
    refused("output", lambda: SYSTEM.integrate(STATE, -20.0, output=[-20.0, -10.0]))


def test_a_run_of_no_length_is_its_start():
    run = SYSTEM.integrate(STATE, 0.0)
    assert run.time.tolist() == [0.0]
    assert run[0] == STATE
    assert run.statistics.steps == 0


def test_evaluations_follow_from_the_number_of_steps():
    run = SYSTEM.integrate(STATE, 100.0)
    s = run.statistics
    assert s.steps > 50
    assert s.rejected >= 0
    # A step has sixteen stages, of which one may be kept from the step before; some more choose the first step.
    assert 15 * s.steps <= s.evaluations <= 16 * (s.steps + s.rejected) + 10


def test_the_repr_of_a_run_has_its_samples_times_and_rule_of_gravity():
    text = repr(SYSTEM.integrate(STATE, 5.0, output=1.0))
    for word in ("6 samples", "0.0", "5.0", "steps", "focal"):
        assert word in text
    assert "no samples" in repr(SYSTEM.integrate(STATE, 5.0, output=[]))


@pytest.mark.parametrize("until", [3.0, 3.001, 60.0, -60.0])
def test_the_progress_function_receives_the_elapsed_and_the_total_time(until):
    reports = []
    system, state = fullbody.systems.kw4_ho2021()
    system.integrate(state.replace(time=3.0), until, output=[until], progress=lambda *a: reports.append(a))
    assert {total for _, total, _ in reports} == {abs(until - 3.0)}
    done = [passed for passed, _, _ in reports]
    assert done[0] == 0.0
    assert done[-1] == abs(until - 3.0)
    assert done == sorted(done)
    assert done.count(done[-1]) <= 2
    assert [reports[0][2], reports[-1][2]] == ["t = 3", f"t = {until:.6g}"]


def test_the_progress_function_receives_the_time_of_an_event_that_ends_the_run():
    system, state = fullbody.systems.kw4()
    reports = []
    event = fullbody.events.Separation(0, 1, 2.557, terminal=True)
    run = system.integrate(state, 1e4, events=[event], progress=lambda *a: reports.append(a))
    assert run.time[-1] < 1e4
    assert reports[0][:2] == (0.0, 1e4)
    assert reports[-1][:2] == (run.time[-1], 1e4)


def test_an_exception_of_the_progress_function_stops_a_simulation_that_can_continue():
    class Enough(Exception):
        pass

    def stop(done, total, description):
        if done > 0.0:
            raise Enough(done)

    sim = fullbody.Simulation(*fullbody.systems.kw4_ho2021(gravity="surface"))
    with pytest.raises(Enough):
        sim.integrate(1e6, progress=stop)
    now = sim.time
    assert now < 1e5
    assert sim.integrate(now + 1.0).time[-1] == now + 1.0


def test_the_progress_bar_ends_at_100_per_cent_and_is_off_by_default(capsys):
    SYSTEM.integrate(STATE, 50.0, progress=True)
    captured = capsys.readouterr()
    assert "100%" in captured.err
    assert captured.out == ""
    SYSTEM.integrate(STATE, 50.0)
    assert capsys.readouterr() == ("", "")
