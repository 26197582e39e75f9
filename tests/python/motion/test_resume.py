"""A run that is interrupted and goes on from a file equals the unbroken one bit for bit, also between its steps."""

import shutil
import time

import fullbody
import numpy as np
import pytest
from fullbody import events
from fullbody.errors import Interrupted, InvalidInput
from fullbody.record import integrators
from support import DATA, body_list, refused

KW4 = fullbody.systems.kw4_ho2021()
UNTIL = 30.0
ARRAYS = ("position", "velocity", "attitude", "spin")

# Steps of a twelfth of the orbit, each of which needs several polynomials, and shorter ones of the variational method.
FIXED = [fullbody.LieGroupVariational(0.4)]
FIXED += [fullbody.SymplecticSplitting(1.4, scheme) for scheme in ("leapfrog", "ABA864", "ABA1064")]
ADAPTIVE = [
    getattr(integrators, name)(1e-8, 1e-9)
    for name in integrators.__all__
    if hasattr(getattr(integrators, name), "rtol")
]
CASES = [(method, "quaternion") for method in ADAPTIVE + FIXED] + [(method, "tait_bryan") for method in ADAPTIVE]
methods = pytest.mark.parametrize(("integrator", "chart"), CASES, ids=lambda method: str(method).replace(" ", ""))


def watched():
    """Return events of several kinds."""
    return [
        events.Periapsis(0, 1),
        events.Apoapsis(0, 1),
        events.Alignment("Beta", "Alpha"),
        events.Contact(0, 1),
        events.PlaneCrossing(1, 0),
        events.PlaneCrossing(1, None, (1.0, 0.2, 0.0)),
        events.Separation(0, 1, 2.545),
        events.Function(lambda state: state.spin[1, 0]),
    ]


def ctrl_c_after(moment):
    """Return an event that never happens, in whose function Ctrl-C arrives after a time."""

    def function(state):
        if abs(state.time) > moment:
            raise KeyboardInterrupt
        return 1.0

    return events.Function(function)


def by_ctrl_c(sim, until, output, path, moment=0.4 * UNTIL):
    """Return the run that Ctrl-C ended, and the simulation that it saved."""
    all_events = [*watched(), ctrl_c_after(moment)]
    # The time between two files is so long that only the interruption writes one.
    with pytest.raises(Interrupted) as caught:
        sim.integrate(until, output=output, events=all_events, dense=True, autosave=(path, 1e8))
    assert caught.value.run.stop_reason == "interrupted"
    return caught.value.run, fullbody.Simulation.load(path)


def by_steps(sim, until, output, path):
    """Return no run, and a simulation that was saved after single steps."""
    while abs(sim.time) < 0.4 * UNTIL:
        sim.step(until)
    sim.save(path)
    return None, fullbody.Simulation.load(path)


def occurrences(run, since=-1.0):
    kinds = [type(happened.event).__name__ for happened in run.events]
    pairs = zip(kinds, run.events, strict=True)
    return [(kind, event.time, event.state) for kind, event in pairs if abs(event.time) > since]


def same_samples(run, expected):
    names = ("time", "position", "velocity", "attitude", "spin", "energy", "angular_momentum")
    same = all(np.array_equal(getattr(run, name), getattr(expected, name)) for name in names)
    return same and all(np.array_equal(run.work[name], work) for name, work in expected.work.items())


def counts(*statistics):
    return tuple(sum(getattr(s, name) for s in statistics) for name in ("steps", "rejected", "evaluations"))


@pytest.mark.parametrize("until", [UNTIL, -UNTIL], ids=["forwards", "backwards"])
@pytest.mark.parametrize("interrupted", [by_ctrl_c, by_steps])
@methods
def test_a_resumed_run_equals_an_unbroken_one(integrator, chart, interrupted, until, tmp_path):
    system, state = KW4
    system = system.with_options(attitude_chart=chart)
    times = np.random.default_rng(8).uniform(0.0, UNTIL, 300)
    grid = np.sort(times[:40]) * np.sign(until)
    times *= np.sign(until)
    for output in (None, 1.3, grid):
        sim = fullbody.Simulation(system, state, integrator=integrator)
        unbroken = sim.integrate(until, output=output, events=watched(), dense=True)
        sim_of_part = fullbody.Simulation(system, state, integrator=integrator)
        first_part, resumed = interrupted(sim_of_part, until, output, tmp_path / "a.sim")
        now = resumed.time
        assert 0.3 * UNTIL < abs(now) < abs(until)
        assert same_samples(unbroken, sim.system.integrate(state, until, output=output, integrator=integrator))
        statistics = resumed.statistics
        remaining_times = None if output is None else unbroken.time[abs(unbroken.time) > abs(now)]
        run = resumed.integrate(until, output=remaining_times, events=watched(), dense=True)
        assert resumed.state == sim.state
        assert resumed.time == sim.time

        # With output at each step, the resumed run records the state from which it starts.
        remaining = np.abs(unbroken.time) >= abs(now) if output is None else np.abs(unbroken.time) > abs(now)
        first = int(remaining.argmax())
        assert same_samples(run, unbroken[first:])
        late_times = times[abs(times) > abs(now)]
        late_times = np.append(late_times, [now, until])
        ours, theirs = run(late_times), unbroken(late_times)
        assert all(np.array_equal(getattr(ours, name), getattr(theirs, name)) for name in ARRAYS)
        result = occurrences(run)
        assert len(result) > 12
        if first_part is None:
            assert result == occurrences(unbroken, abs(now))
            continue
        assert occurrences(first_part) + result == occurrences(unbroken)
        # An interrupted run ends with the state that it reached, whatever the output.
        assert first_part.time[-1] == now
        samples = first_part if output is None else first_part[:-1]
        assert same_samples(samples, unbroken[: first + (output is None)])
        early_times = np.append(times[abs(times) <= abs(now)], [0.0, now])
        ours, theirs = first_part(early_times), unbroken(early_times)
        assert all(np.array_equal(getattr(ours, name), getattr(theirs, name)) for name in ARRAYS)
        # Evaluations for events and output are counted, each of them once.
        assert counts(first_part.statistics, run.statistics) == counts(unbroken.statistics)
        assert counts(statistics, run.statistics) == counts(resumed.statistics) == counts(sim.statistics)


@methods
def test_outputs_change_neither_events_nor_the_continuous_solution(integrator, chart):
    system, state = KW4
    system = system.with_options(attitude_chart=chart)
    times = np.random.default_rng(9).uniform(0.0, UNTIL, 100)

    def run(**options):
        return system.integrate(state, UNTIL, integrator=integrator, **options)

    first = run(output=[], events=watched(), dense=True)
    variants = [
        run(events=watched(), dense=True),
        run(output=0.11, events=watched(), dense=True),
        run(output=times[:1], events=watched()[::-1], dense=True),
        run(output=[], dense=True),
    ]
    for other in variants[:3]:
        assert sorted(map(repr, occurrences(other))) == sorted(map(repr, occurrences(first)))
    for other in variants:
        ours, theirs = other(times), first(times)
        assert all(np.array_equal(getattr(ours, name), getattr(theirs, name)) for name in ARRAYS)
    # Samples between the steps are the continuous solution, and those at their ends too.
    for other in variants[:2]:
        assert all(np.array_equal(getattr(other(other.time), name), getattr(other, name)) for name in ARRAYS)
    # An event alone is found at the same times as among others.
    for event in watched():
        alone = run(output=[], events=[event])
        # The repr of a function contains its address.
        label = type(event).__name__ if isinstance(event, events.Function) else repr(event)
        expected = [passage.time for passage in first.events if repr(passage.event).startswith(label)]
        assert [passage.time for passage in alone.events] == expected


@pytest.mark.parametrize("integrator", [FIXED[0], FIXED[2], ADAPTIVE[-1]], ids=lambda method: type(method).__name__)
def test_a_run_continues_from_an_autosave_bit_for_bit(integrator, tmp_path):
    system, state = KW4
    path, copy = tmp_path / "a.sim", tmp_path / "copy.sim"
    pauses = [0.3 * UNTIL, 0.5 * UNTIL]
    reports = []

    def pause(state):
        # Longer than the time between two interrupt checks, which also save: the next one follows at once.
        if pauses and state.time > pauses[0]:
            pauses.pop(0)
            time.sleep(0.06)
        return 1.0

    def copy_file(done, total, description):
        reports.append(done)
        if not pauses and not copy.exists():
            shutil.copy(path, copy)

    all_events = [*watched(), events.Function(pause)]
    sim = fullbody.Simulation(system, state, integrator=integrator)
    unbroken = sim.integrate(UNTIL, output=0.7, events=all_events, dense=True, progress=copy_file, autosave=(path, 0.0))
    resumed = fullbody.Simulation.load(copy)
    now = resumed.time
    assert 0.3 * UNTIL < now < UNTIL
    assert now in reports
    run = resumed.integrate(UNTIL, output=unbroken.time[unbroken.time > now], events=watched(), dense=True)
    assert occurrences(run) == occurrences(unbroken, now)
    assert same_samples(run, unbroken[int((unbroken.time > now).argmax()) :])
    assert resumed.state == sim.state
    times = np.random.default_rng(10).uniform(now, UNTIL, 100)
    assert np.array_equal(run(times).spin, unbroken(times).spin)
    assert resumed.statistics == sim.statistics


def test_no_event_is_lost_if_the_function_of_an_event_raises_an_error():
    system, state = KW4
    for integrator in (ADAPTIVE[-1], FIXED[2]):
        sim = fullbody.Simulation(system, state, integrator=integrator)

        def fail(state):
            return 1.0 if state.time < 20.0 else 1 / 0

        with pytest.raises(ZeroDivisionError) as caught:
            sim.integrate(UNTIL, events=[*watched(), events.Function(fail)])
        first_part = caught.value.run
        assert first_part.time[-1] == sim.time < 20.0
        run = sim.integrate(UNTIL, events=watched())
        unbroken = system.integrate(state, UNTIL, integrator=integrator, events=watched())
        assert occurrences(first_part) + occurrences(run) == occurrences(unbroken)
        assert np.array_equal(np.append(first_part.time, run.time[1:]), unbroken.time)


# The file of a simulation


def test_a_file_contains_each_number_of_the_system_once(tmp_path):
    bodies = body_list(
        (fullbody.Sphere(0.2345), 1.7),
        Alpha=(fullbody.Ellipsoid(0.7661, 0.74752, 0.67353), 2.3531),
        Gamma=(fullbody.PointMass(), 0.0567),
    )
    options = {"order": (397, 793), "gravity_tolerance": 3.7e-13, "frame": "ecliptic"}
    system = fullbody.System(bodies, G=0.8649, units=True, epoch="2001-05-25T00:00:00 TDB", **options)
    state = fullbody.State([[2.5, 0, 0], [0, 0, 0], [0, -9, 0]], [[0, 0.9, 0], [0, 0, 0], [0.4, 0, 0]])
    sim = fullbody.Simulation(system, state, integrator=fullbody.SymplecticSplitting(0.01234, "ABA1064"))
    # After a single step the time equals the step, which would be in the file twice.
    sim.step()
    sim.step()
    sim.save(tmp_path / "a.sim")
    data = (tmp_path / "a.sim").read_bytes()
    for number in (0.7661, 0.74752, 0.67353, 2.3531, 1.7, 0.0567, 0.8649, 3.7e-13, 0.01234):
        assert data.count(repr(number).encode()) == 1, number
        assert data.count(np.float64(number).tobytes()) == 0, number
    # A sphere is stored with three semi-axes.
    assert data.count(b"0.2345") == 3
    assert data.count(b"[397,793]") == 1
    loaded = fullbody.Simulation.load(tmp_path / "a.sim")
    assert loaded.system == system
    assert loaded.system.options == system.options
    assert [body.name for body in loaded.system.bodies] == [None, "Alpha", "Gamma"]
    assert [type(body.shape) for body in loaded.system.bodies] == [type(body.shape) for body in bodies]
    assert loaded == sim


def test_notes_of_the_package_that_contradict_the_core_are_refused(tmp_path):
    system, state = KW4
    sim = fullbody.Simulation(system, state)

    def with_notes(notes):
        integrator = fullbody.Verner98()._describe(system.context.units)
        core = fullbody._core.Simulation(system.context.core, state.core, integrator, notes)
        (tmp_path / "noted.sim").write_bytes(core.to_bytes())
        return fullbody.Simulation.load(tmp_path / "noted.sim")

    # A simulation that a Rust program saved has no notes.
    assert with_notes("").system == sim.system
    for notes, message in (
        ('{"bodies": [{"shape": "Sphere"}, {}]}', r"Alpha is a Sphere of semi-axes \[0\.766, 0\.7475, 0\.6735\]"),
        ('{"bodies": [{"shape": "PointMass"}, {}]}', "Alpha is a PointMass of semi-axes"),
        ('{"bodies": [{"shape": "Cube"}, {}]}', "Cube"),
        ('{"bodies": [{}]}', "the notes have 1 bodies; expected 2"),
        ('{"units": ["km", "km", "kg"]}', "units has 'km'"),
        ("[]", "notes of the simulation are damaged"),
        ("{", "notes of the simulation are damaged"),
    ):
        refused(message, lambda notes=notes: with_notes(notes))


def test_a_file_of_another_format_is_refused_and_its_number_is_given(tmp_path):
    other = bytearray((DATA / "simulation.bin").read_bytes())
    # The number of the format follows eight bytes that name the file's kind.
    other[8] = 4
    (tmp_path / "other.sim").write_bytes(other)
    with pytest.raises(
        InvalidInput, match=r"other\.sim is not a readable simulation .* of format 4; expected format 2"
    ):
        fullbody.Simulation.load(tmp_path / "other.sim")
    refused(r"it is a simulation, which fullbody\.Simulation\.load reads", fullbody.load, DATA / "simulation.bin")
