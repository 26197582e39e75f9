"""The stepping object: steps, copies and archives that go on bit for bit, autosave."""

import copy
import pickle
from pathlib import Path

import fullbody
import numpy as np
import pytest
from fullbody.errors import BodiesOverlap, Interrupted, InvalidInput, StepSizeTooSmall
from fullbody.record import integrators
from support import points, refused

KW4 = fullbody.systems.kw4_ho2021()
CASE1 = fullbody.systems.case1()

FIXED = [fullbody.LieGroupVariational(0.1)]
FIXED += [fullbody.SymplecticSplitting(0.25, scheme) for scheme in ("leapfrog", "ABA864", "ABA1064")]
ADAPTIVE = [
    getattr(integrators, name)(1e-11, 1e-12)
    for name in integrators.__all__
    if hasattr(getattr(integrators, name), "rtol")
]
ADAPTIVE.append(fullbody.Verner98.to_roundoff())
# The symplectic methods turn bodies on the rotation group and refuse the angles.
EACH = [(method, "quaternion") for method in ADAPTIVE + FIXED] + [(method, "tait_bryan") for method in ADAPTIVE]
methods = pytest.mark.parametrize(("integrator", "chart"), EACH, ids=lambda method: str(method).replace(" ", ""))


def started(integrator, chart, system=KW4):
    """A simulation some steps on its way, past a change of its quadrature if there is one."""
    system, state = system
    sim = fullbody.Simulation(system.with_options(attitude_chart=chart), state, integrator=integrator)
    sim.integrate(7.3, output=[7.3])
    sim.step()
    return sim


def bits(state):
    names = ("time", "position", "velocity", "attitude", "spin")
    return b"".join(np.float64(getattr(state, name)).tobytes() for name in names)


def identical(first, other):
    return bits(first.state) == bits(other.state) and first.statistics == other.statistics


def continued(sim):
    """The states that a simulation meets by steps, a run and a run back."""
    states = []
    for _ in range(5):
        sim.step()
        states.append(bits(sim.state))
    run = sim.integrate(21.7)
    states += [bits(state) for state in run]
    run = sim.integrate(4.0, output=[15.0, 4.0])
    states += [bits(state) for state in run]
    return states


@methods
def test_copies_and_files_continue_bit_for_bit(integrator, chart, tmp_path):
    sim = started(integrator, chart)
    sim.save(tmp_path / "a.sim")
    loaded = fullbody.Simulation.load(tmp_path / "a.sim")
    copies = [copy.deepcopy(sim), copy.copy(sim), pickle.loads(pickle.dumps(sim)), loaded]
    copies.append(fullbody.Simulation.load(str(tmp_path / "a.sim")))
    for other in copies:
        assert identical(other, sim)
        assert other.integrator == sim.integrator
        assert other.system == sim.system
        assert other.quadrature == sim.quadrature
        assert other.time == sim.time
    expected = continued(sim)
    for other in copies:
        # Nothing is shared: the copies have not moved with it.
        assert other.time != sim.time
        assert continued(other) == expected
        assert identical(other, sim)


def test_files_keep_units_epoch_and_names(tmp_path):
    from astropy import units as u

    system, state = fullbody.systems.kw4(units=True, epoch="2001-05-25T00:00:00 TDB")
    sim = fullbody.Simulation(system, state, integrator=fullbody.SymplecticSplitting(15 * u.min))
    sim.integrate(5 * u.h)
    sim.save(tmp_path / "units.sim")
    loaded = fullbody.Simulation.load(tmp_path / "units.sim")
    assert loaded.time == 5 * u.h
    assert loaded.state == sim.state
    assert loaded.system.epoch == system.epoch
    assert loaded.system.names == system.names
    assert loaded.system.units == ("km", "h", "kg")
    assert (loaded.integrate(10 * u.h).position == sim.integrate(10 * u.h).position).all()


def test_single_steps_advance_the_simulation():
    system, state = CASE1
    sim = fullbody.Simulation(system, state)
    for count in range(1, 6):
        previous = sim.time
        sim.step()
        assert sim.time > previous
        assert sim.statistics.steps == count
    # Never beyond, in either direction; none where there is no way to go.
    target = sim.time + 1e-3
    sim.step(target)
    assert sim.time == target
    previous = bits(sim.state)
    sim.step(target)
    assert bits(sim.state) == previous
    sim.step(-np.inf)
    assert sim.time < target
    for until in (np.nan, "later", [1.0, 2.0]):
        refused(r"until (is|has) .*expected", lambda until=until: sim.step(until))


def test_each_run_of_a_simulation_begins_at_the_end_of_the_last():
    system, state = CASE1
    sim = fullbody.Simulation(system, state)
    for until in (5.0, 12.0, 3.0, -8.0, -8.0, 0.0):
        previous = bits(sim.state)
        run = sim.integrate(until)
        assert bits(run[0]) == previous
        assert run.time[-1] == sim.time == until
        assert bits(run[-1]) == bits(sim.state)
        assert run.statistics.steps == len(run) - 1
    assert np.abs(sim.state.position - state.position).max() < 1e-12


@pytest.mark.parametrize("integrator", ADAPTIVE + FIXED, ids=lambda method: str(method).replace(" ", ""))
def test_setting_the_state_equals_a_new_simulation(integrator):
    system, state = CASE1
    sim = fullbody.Simulation(system, state, integrator=integrator)
    sim.integrate(9.0)
    sim.state = state.replace(time=2.0)
    assert sim.time == 2.0
    assert sim.state == state.replace(time=2.0)
    fresh = fullbody.Simulation(system, state.replace(time=2.0), integrator=integrator)
    ours, theirs = sim.integrate(6.0), fresh.integrate(6.0)
    assert [bits(s) for s in ours] == [bits(s) for s in theirs]
    for wrong in (None, 3.0, "rest"):
        with pytest.raises(InvalidInput, match=r"state is .*; expected a State"):
            sim.state = wrong
    with pytest.raises(InvalidInput, match="number of bodies in the state is 1; expected 2"):
        sim.state = fullbody.State([[0, 0, 0]], [[0, 0, 0]])
    with pytest.raises(BodiesOverlap):
        sim.state = state.replace(position=0 * state.position)
    # Refused, and where it was.
    assert sim.time == 6.0
    assert bits(sim.state) == bits(ours[-1])


def test_statistics_count_from_the_start():
    sim = fullbody.Simulation(*CASE1)
    assert sim.statistics.steps == sim.statistics.rejected == 0
    runs = [sim.integrate(until).statistics for until in (10.0, 20.0, 5.0)]
    assert sim.statistics.steps == sum(s.steps for s in runs)
    assert sim.statistics.rejected == sum(s.rejected for s in runs)
    # One evaluation a step for the variational method, seven for ABA864, and one to begin.
    sim = fullbody.Simulation(*CASE1, integrator=fullbody.LieGroupVariational(0.25))
    run = sim.integrate(10.0, output=[10.0])
    assert (run.statistics.steps, run.statistics.rejected) == (40, 0)
    assert run.statistics.evaluations == 41
    sim = fullbody.Simulation(*CASE1, integrator=fullbody.SymplecticSplitting(0.25))
    assert sim.integrate(10.0, output=[10.0]).statistics.evaluations == 7 * 40


def test_the_quadrature_depends_on_the_distance():
    system, state = KW4
    sim = fullbody.Simulation(system.with_options(order=(6, 9)), state)
    (rule,) = sim.quadrature
    assert rule["pair"] == ("Alpha", "Beta")
    assert rule["integrated"] in rule["pair"]
    assert rule["order"] == (6, 9)
    assert rule["points"] > 0
    sim = fullbody.Simulation(points(1.0, 1.0), fullbody.State([[0, 0, 0], [1, 0, 0]], np.zeros((2, 3))))
    assert sim.quadrature == []
    # Near bodies take more points than far ones.
    counts = []
    for distance in (1.5, 2.5, 25.0):
        distant = state.replace(position=[[0, 0, 0], [distance, 0, 0]])
        counts.append(fullbody.Simulation(system, distant).quadrature[0]["points"])
    assert counts[0] > counts[1] > counts[2]


# Files that are not right


@pytest.fixture
def archive(tmp_path):
    path = tmp_path / "run.sim"
    started(fullbody.Verner98(), "quaternion").save(path)
    return path


def refused_file(path):
    with pytest.raises(InvalidInput) as caught:
        fullbody.Simulation.load(path)
    assert str(path) in str(caught.value)
    return str(caught.value)


def test_truncated_files_are_refused(archive):
    data = archive.read_bytes()
    for length in range(0, len(data), 5):
        archive.write_bytes(data[:length])
        refused_file(archive)
    archive.write_bytes(data + b"\n")
    assert "too long" in refused_file(archive)


def test_altered_files_are_refused(archive):
    data = archive.read_bytes()
    for offset in range(0, len(data), 5):
        altered = bytearray(data)
        altered[offset] ^= 1 << offset % 8
        archive.write_bytes(altered)
        refused_file(archive)


def test_files_that_are_no_simulation_are_refused(archive, tmp_path):
    path = tmp_path / "other.sim"
    for data in (b"", b"CDF\x01", b"FULLBODY", np.random.default_rng(1).bytes(4000)):
        path.write_bytes(data)
        refused_file(path)
    path.write_bytes(archive.read_bytes().replace(b"135000000000.0", b"136000000000.0"))
    assert "checksum" in refused_file(path)
    with pytest.raises(FileNotFoundError):
        fullbody.Simulation.load(tmp_path / "nothing.sim")


# Autosave


def test_autosave_does_not_change_the_run(tmp_path):
    system, state = KW4
    reference = system.integrate(state, 200.0, output=10.0)
    saved = system.integrate(state, 200.0, output=10.0, autosave=(tmp_path / "a.sim", 0.0))
    assert reference == saved
    assert [path.name for path in tmp_path.iterdir()] == ["a.sim"]


@pytest.mark.parametrize("seconds", [0.0, 1e8])
def test_autosave_writes_the_start_and_the_end_of_any_run(tmp_path, seconds):
    system, state = CASE1
    path = tmp_path / "a.sim"
    times = []

    def record(state):
        times.append(fullbody.Simulation.load(path).time)
        return 1.0

    sim = fullbody.Simulation(system, state)
    sim.integrate(1.0, events=[fullbody.events.Function(record)], autosave=(path, seconds))
    assert times[0] == 0.0
    assert identical(fullbody.Simulation.load(path), sim)
    assert sim.time == 1.0

    # An event and an error end a run too.
    near = fullbody.events.Separation(0, 1, 7.9, terminal=True)
    assert sim.integrate(60.0, events=[near], autosave=(path, seconds)).stop_reason == "event"
    assert fullbody.Simulation.load(path).time == sim.time < 60.0

    def fail(state):
        return 1.0 if state.time < 30.0 else 1 / 0

    with pytest.raises(ZeroDivisionError) as caught:
        sim.integrate(60.0, events=[fullbody.events.Function(fail)], autosave=(path, seconds))
    assert identical(fullbody.Simulation.load(path), sim)
    # The step that could not be looked through is taken back.
    assert sim.time == caught.value.run.time[-1] < 30.0


def test_an_interrupted_run_is_autosaved(tmp_path):
    sim = fullbody.Simulation(*KW4)

    def stop(done, total, description):
        if done > 0.0:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as caught:
        sim.integrate(1e9, output=[1e9], progress=stop, autosave=(tmp_path / "a.sim", 1e8))
    loaded = fullbody.Simulation.load(tmp_path / "a.sim")
    assert identical(loaded, sim)
    assert loaded.time > 0.0
    assert caught.value.run.stop_reason == "interrupted"


def test_an_autosave_that_cannot_be_written_is_an_error_before_the_run(tmp_path):
    sim = fullbody.Simulation(*KW4)
    (tmp_path / "a.sim").mkdir()
    with pytest.raises(IsADirectoryError, match=r"a\.sim"):
        sim.integrate(1e9, output=[1e9], autosave=(tmp_path / "a.sim", 1e8))
    assert sim.time == 0.0


@pytest.mark.parametrize(("until", "seconds"), [(1.0, 1e8), (1e9, 0.0)], ids=["at the end", "on the way"])
def test_an_autosave_that_fails_is_an_error_with_the_run_so_far(until, seconds, tmp_path, monkeypatch):
    write, written = Path.write_bytes, []

    def once(path, data):
        # The first file, of the start, still fits.
        if written:
            raise OSError(28, "No space left on device")
        written.append(write(path, data))

    sim = fullbody.Simulation(*fullbody.systems.kw4_ho2021(gravity="surface"))
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", once)
        with pytest.raises(OSError, match=r"No space left on device: .*a\.sim") as caught:
            sim.integrate(until, output="ends", autosave=(tmp_path / "a.sim", seconds))
    assert [path.name for path in tmp_path.iterdir()] == ["a.sim"]
    assert fullbody.Simulation.load(tmp_path / "a.sim").time == 0.0
    # The simulation is where it stopped, and usable.
    now = sim.time
    assert now == until == 1.0 or 0.0 < now < until
    assert caught.value.run[-1] == sim.state
    assert sim.integrate(now + 1.0).time[-1] == now + 1.0


@pytest.mark.parametrize("seconds", [-1.0, np.nan, np.inf, None, "often"], ids=str)
def test_bad_autosaves_are_refused(tmp_path, seconds):
    system, state = CASE1
    refused(r"autosave is .*; expected", lambda: system.integrate(state, 1.0, autosave=(tmp_path / "a.sim", seconds)))
    for wrong in ("a.sim", tmp_path / "a.sim", 5.0, (1, 2, 3)):
        refused(r"autosave is .*; expected \(path, seconds\)", system.integrate, state, 1.0, autosave=wrong)
    # Before the run, not when the first file is due.
    with pytest.raises(FileNotFoundError, match="no folder"):
        system.integrate(state, 1.0, autosave=(tmp_path / "missing" / "a.sim", 60.0))


def test_the_repr_of_a_simulation_tells_time_and_steps():
    sim = fullbody.Simulation(*CASE1, integrator=fullbody.SymplecticSplitting(0.25))
    for word in ("time=0.0", "focal", "SymplecticSplitting(step=0.25, scheme='ABA864')"):
        assert word in repr(sim)


def test_times_that_differ_by_rounding_alone_are_one():
    system, state = fullbody.systems.kw4()
    sim = fullbody.Simulation(system, state)
    for k in range(1, 40):
        sim.integrate(sim.time + 0.1)
        sim.integrate(k * 0.1)
        assert sim.time == k * 0.1
    reference = system.integrate(state, 3.9)[-1]
    np.testing.assert_allclose(sim.state.position, reference.position, rtol=1e-12, atol=1e-12)
    run = system.integrate(state, 5e-324, dense=True)
    np.testing.assert_allclose(run[-1].position, state.position, rtol=1e-15, atol=1e-300)


def test_a_dense_run_of_no_length_is_its_start():
    system, state = fullbody.systems.case1()
    run = system.integrate(state, 0.0, dense=True)
    assert run(0.0) == state
    assert run([0.0]).position.shape == (1, 2, 3)
    refused(r"expected one from 0\.0 to 0\.0", lambda: run(1e-300))


def test_a_simulation_cannot_be_used_within_its_run():
    system, state = fullbody.systems.case1()
    sim = fullbody.Simulation(system, state)
    for touch in (lambda: sim.time, lambda: sim.state, sim.step, lambda: sim.integrate(1.0), lambda: repr(sim)):
        watched = fullbody.events.Function(lambda _, touch=touch: touch() and 1.0)
        with pytest.raises(fullbody.FullbodyError, match="the simulation is in the middle of a run") as caught:
            sim.integrate(sim.time + 5.0, events=[watched])
        assert not isinstance(caught.value, StepSizeTooSmall)
    sim.integrate(40.0)
    assert sim.time == 40.0
