"""Ensembles: each run equals a single one, none is lost, and none disturbs another."""

import os
import signal
import threading
import warnings

import fullbody
import numpy as np
import pytest
from fullbody import State, events, integrate_many
from fullbody.errors import ForceFailed, InconsistentInput, Interrupted, InvalidInput
from fullbody.forces import Function, Tide
from support import points, refused

SYSTEM, STATE = fullbody.systems.case1()
THREADS = [1, 2, 5]


def spheres(speed=0.0, **options):
    """Two spheres, 4 between their surfaces, the second one on its way to the first or from it."""
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=0.1, name=name) for name in ("A", "B")]
    state = State([[0, 0, 0], [6, 0, 0]], [[0, 0, 0], [speed, 0, 0]])
    return fullbody.System(bodies, G=1.0, **options), state


def single(member, *args, **kwargs):
    """The answer to one member: its run or its error."""
    system, state = member
    try:
        return system.integrate(state, *args, **kwargs)
    except (Exception, Interrupted) as error:
        return error


def equal(item, other):
    if isinstance(item, BaseException):
        same = type(item) is type(other) and str(item) == str(other)
        return same and (item.run is other.run is None or equal(item.run, other.run))
    same = item == other and item.integrator == other.integrator
    return same and all(np.array_equal(getattr(item, name), getattr(other, name)) for name in ("energy", "spin"))


def mixed():
    """Members of many kinds, some of which fail."""
    kw4, state = fullbody.systems.kw4(units=True)
    tide = Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
    return [
        (SYSTEM, STATE),
        (kw4, state),
        fullbody.systems.case2(),
        (fullbody.systems.kw4()[0].with_forces([tide]), fullbody.systems.kw4()[1]),
        spheres(-1.0),
        fullbody.systems.kw4(gravity="surface", attitude_chart="tait_bryan"),
        spheres(0.3),
        (SYSTEM, STATE.replace(time=3.0)),
    ]


@pytest.mark.parametrize("threads", THREADS)
@pytest.mark.parametrize("integrator", [fullbody.Verner98(1e-10, 1e-10), fullbody.SymplecticSplitting(step=0.02)])
def test_each_run_of_an_ensemble_equals_a_single_run_bit_for_bit(threads, integrator):
    options = {"output": 1.5, "integrator": integrator, "events": [events.Contact(), events.Separation(value=7.5)]}
    # With units and without, lengths are plain numbers in each system's own.
    expected = [single(member, 20.0, dense=True, **options) for member in mixed()]
    answers = integrate_many(mixed(), 20.0, dense=True, threads=threads, **options)
    assert all(map(equal, answers, expected))
    kinds = [type(answer).__name__ for answer in answers]
    # Fixed steps refuse the tide and the angles.
    varied = ["Run"] if isinstance(integrator, fullbody.Verner98) else ["InvalidInput"]
    assert kinds == ["Run"] * 3 + varied + ["BodiesOverlap"] + varied + ["Run"] * 2
    assert sum(len(answer.events) for answer in answers if isinstance(answer, fullbody.Run)) > 0
    time = answers[0].time[3] + 0.1
    assert answers[0](time) == expected[0](time)


@pytest.mark.parametrize("output", [None, "ends", [], [1.0, 2.5], np.array([3.0])])
def test_ensembles_record_the_requested_samples(output):
    runs = integrate_many([(SYSTEM, STATE)] * 3, 3.0, output=output)
    alone = SYSTEM.integrate(STATE, 3.0, output=output)
    assert runs == [alone] * 3
    count = {"ends": 2}.get(output, len(alone)) if isinstance(output, str | None) else len(output)
    assert len(runs[0]) == len(runs[0].time) == len(runs[0].position) == len(runs[0].energy) == count


def test_each_member_may_have_its_own_end_and_integrator():
    u = pytest.importorskip("astropy.units")
    system, state = fullbody.systems.kw4(units=True)
    integrators = [None, fullbody.Verner65(1e-6), fullbody.LieGroupVariational(step=3 * u.min)]
    for until in ([1.0, "0.5 day", 3 * u.h], (1.0, 12.0, 3.0), [1.0, 12.0, 3.0] * u.h):
        runs = integrate_many([(system, state)] * 3, until, output="ends", integrator=integrators)
        assert [float(run.time[-1].value) for run in runs] == [1.0, 12.0, 3.0]
        assert [run.integrator for run in runs] == [fullbody.Verner98(), *integrators[1:]]
    # The length of a generator is known only once it is a list.
    runs = integrate_many(((system, state) for _ in range(3)), [1.0, 2.0, 3.0] * u.h, output="ends")
    assert len(runs) == 3
    assert integrate_many([], [], integrator=[]) == []
    with pytest.raises(InvalidInput, match="until has 2 values; expected one, or 3, one for each member"):
        integrate_many([(system, state)] * 3, [1.0, 2.0])
    with pytest.raises(InvalidInput, match="integrator has 4 values; expected one, or 3, one for each member"):
        integrate_many(((system, state) for _ in range(3)), 1.0, integrator=[None] * 4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"integrator": "verner"}, "integrator is 'verner'; expected one of fullbody's"),
        ({"output": "end"}, "output"),
        ({"until": "tomorrow"}, "until"),
        ({"members": (SYSTEM, STATE)}, "members is one member; expected a list of them"),
        ({"members": 3}, "members is 3; expected an iterable"),
        ({"events": ["no"]}, "events has 'no'"),
        *(
            ({"threads": n}, "^threads is .*; expected a whole number from 1 to 1024")
            for n in (0, -1, 1.0, True, "2", 1025)
        ),
    ],
)
def test_options_that_are_invalid_for_all_members_are_refused(arguments, message):
    refused(message, lambda: integrate_many(**{"members": [(SYSTEM, STATE)], "until": 1.0} | arguments))


# Members that fail.


def test_errors_of_members_equal_those_of_single_runs():
    disc = fullbody.Ellipsoid(1.0, 1.0, 0.02)
    rims = fullbody.System([fullbody.Body(disc, mass=1.0, name=name) for name in ("A", "B")], G=1.0)
    still = np.zeros((2, 3))
    members = {
        "ends": (SYSTEM, STATE),
        "collides": spheres(-1.0),
        "overlaps": (spheres()[0], State([[0, 0, 0], [1.5, 0, 0]], still)),
        "does not converge": (rims, State([[0, 0, 0], [0.3, 0.1, 0.043]], still)),
        "falls": (points(1.0, 3.0), State([[0, 0, 0], [1.5, 0, 0]], still)),
        "is no pair": SYSTEM,
        "is no system": (STATE, SYSTEM),
        "is no state": (SYSTEM, "state"),
        "has another state": (SYSTEM, State([[0, 0, 0]], [[0, 0, 0]])),
        "is not finite": (SYSTEM, STATE),
        "has no units": (SYSTEM, STATE),
        "ends too": (SYSTEM, STATE),
    }
    until = [3.0 if kind == "does not converge" else 9.0 for kind in members]
    until[9:11] = [np.nan, "3 days"]
    answers = dict(zip(members, integrate_many(list(members.values()), until, output=1.0), strict=True))
    errors = {kind: answer for kind, answer in answers.items() if isinstance(answer, Exception)}
    assert answers["ends"] == answers["ends too"] == SYSTEM.integrate(STATE, 9.0, output=1.0)
    assert {kind: type(error).__name__ for kind, error in errors.items()} == {
        "collides": "BodiesOverlap",
        "overlaps": "BodiesOverlap",
        "does not converge": "NotConverged",
        "falls": "StepSizeTooSmall",
        **dict.fromkeys(list(members)[5:11], "InvalidInput"),
    }
    for kind, end in zip(members, until, strict=True):
        if kind in errors and kind not in ("is no pair", "is no system"):
            alone = single(members[kind], end, output=1.0)
            assert str(errors[kind]) == str(alone), kind
    # The surfaces touch after 4 lengths at a speed of 1 and what the fall adds; the run so far is there.
    radii = np.linspace(2.0, 6.0, 4001)
    fall = np.trapezoid(1.0 / np.sqrt(1.0 + 2 * 0.2 * (1 / radii - 1 / 6)), radii)
    assert errors["collides"].time == pytest.approx(fall, abs=1e-6)
    *samples, last = errors["collides"].run.time.tolist()
    assert samples == [0.0, 1.0, 2.0, 3.0]
    assert 3.0 < last < errors["collides"].time
    assert errors["collides"].run.stop_reason == "unfinished"
    assert "at the start" in str(errors["overlaps"])
    assert errors["overlaps"].run is None
    # No frames are kept, which would hold whatever was at hand.
    assert all(error.__traceback__ is None for error in errors.values())
    assert str(errors["is no pair"]).startswith("member 5 is System(")


def test_an_event_fails_only_for_members_that_lack_its_bodies():
    answers = integrate_many([spheres(), (SYSTEM, STATE)], 1.0, events=[events.Contact("A", "B")])
    assert [type(answer).__name__ for answer in answers] == ["Run", "Run"]
    kw4 = fullbody.systems.kw4()
    answers = integrate_many([spheres(), kw4], 1.0, events=[events.Contact("Alpha", "Beta")])
    assert [type(answer).__name__ for answer in answers] == ["InvalidInput", "Run"]
    assert "expected one of A, B" in str(answers[0])


def member_of(number):
    """A member whose first body has this x-coordinate."""
    state = STATE.replace(position=np.add(STATE.position, [number, 0, 0]))
    return SYSTEM, state


class Trouble(Exception):
    """An exception of a caller."""


@pytest.mark.parametrize("threads", THREADS)
def test_exceptions_of_event_functions_reach_the_member_that_raised_them(threads):
    inside = set()

    def f(state):
        inside.add(threading.get_ident())
        number = round(float(state.position.mean(axis=0)[0]))
        if state.time > 3.0 and number % 3 == 1:
            raise Trouble(number)
        return state.time - number

    event = events.Function(f, terminal=True)
    answers = integrate_many([member_of(k) for k in range(12)], 5.5, events=[event], threads=threads)
    assert len(inside) <= threads
    assert threading.get_ident() not in inside
    for number, answer in enumerate(answers):
        if number % 3 == 1 and number > 3:
            assert type(answer) is Trouble
            assert answer.args == (number,)
            assert 0.0 < answer.run.time[-1] < 5.5
        else:
            assert answer.stop_reason == ("end" if number in (0, *range(6, 12)) else "event")
            assert equal(answer, single(member_of(number), 5.5, events=[event]))


@pytest.mark.parametrize("threads", THREADS)
def test_force_functions_in_threads_have_the_values_and_errors_of_single_runs(threads):
    def wind(time, state):
        number = round(float(state.position.mean(axis=0)[0]))
        if time > 1.0 and number % 2:
            raise Trouble(number)
        return -1e-3 * state.velocity

    windy = SYSTEM.with_forces([Function(wind)])
    members = [(windy, member_of(k)[1]) for k in range(8)]
    answers = integrate_many(members, 2.0, threads=threads)
    for number, (member, answer) in enumerate(zip(members, answers, strict=True)):
        assert equal(answer, single(member, 2.0))
        if number % 2:
            assert type(answer) is ForceFailed
            assert answer.__cause__.args == (number,)
            assert answer.run.time[-1] <= 1.0
        else:
            assert answer.work["wind"][-1] < 0.0


# The caller's own side.


def test_a_generator_of_members_is_consumed_as_needed():
    taken, reports = [], []

    def endless():
        while True:
            taken.append(len(taken))
            yield SYSTEM, STATE

    def report(done, total, description):
        reports.append(total)
        if done >= 20:
            raise Trouble

    with pytest.raises(Trouble) as caught:
        integrate_many(endless(), 5.0, output="ends", progress=report, threads=2)
    # Some that were waiting may have gone through before the function was asked.
    runs = caught.value.runs
    assert len(runs) == len(taken)
    complete = [run for run in runs if isinstance(run, fullbody.Run) and run.stop_reason == "end"]
    assert len(complete) >= 20
    assert len(runs) - len(complete) <= 16
    assert set(reports) == {None}


def test_an_error_of_the_generator_keeps_the_runs_so_far():
    def members():
        yield SYSTEM, STATE
        yield SYSTEM, STATE
        raise Trouble("no more")

    with pytest.raises(Trouble, match="no more") as caught:
        integrate_many(members(), 1e7, output="ends")
    assert len(caught.value.runs) == 2
    assert all(run is None or run.stop_reason == "interrupted" for run in caught.value.runs)


def test_progress_counts_members():
    reports = []
    members = [(SYSTEM, STATE)] * 7
    members[3] = "no member"
    integrate_many(members, 300.0, output="ends", progress=lambda *a: reports.append(a), threads=2)
    done, total, description = zip(*reports, strict=True)
    finished = [int(text.removesuffix(" of 7 runs")) for text in description]
    assert finished == sorted(finished)
    assert set(total) == {7}
    assert all(0.0 <= part - complete <= 2.0 for part, complete in zip(done, finished, strict=True))
    assert reports[-1] == (7, 7, "7 of 7 runs")


@pytest.mark.parametrize("reference", [True, False])
def test_the_progress_bar_counts_members(capsys, reference):
    members = [(SYSTEM, STATE)] * 3
    integrate_many(members if reference else iter(members), 5.0, progress="many")
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "many" in captured.err
    assert ("3 of 3 runs" if reference else "3 runs") in captured.err
    assert ("100%" in captured.err) == reference
    integrate_many(members, 5.0)
    assert capsys.readouterr() == ("", "")


def test_warnings_about_starts_are_given_once():
    fast = spheres(1e3)
    with pytest.warns(InconsistentInput) as caught:
        runs = integrate_many([(SYSTEM, STATE), fast, (SYSTEM, STATE), fast, fast], 1e-3)
    assert len(runs) == 5
    assert len(caught) == 1
    assert str(caught[0].message).startswith(
        "the starts of 3 of 5 members are probably a mistake; member 1: A and B start at "
    )
    assert caught[0].filename == __file__
    with warnings.catch_warnings(action="error"), pytest.raises(InconsistentInput) as raised:
        integrate_many([(SYSTEM, STATE), fast], 1e-3)
    assert [type(run) for run in raised.value.runs] == [fullbody.Run] * 2


# Ctrl-C.


def test_ctrl_c_in_a_run_returns_the_finished_members():
    begun = threading.Semaphore(0)

    def f(state):
        if state.time > 2e3 and begun.acquire(blocking=False):
            os.kill(os.getpid(), signal.SIGINT)
        return 1.0

    def report(done, total, description):
        if 2 < done < 3 and not reports:
            reports.append(done)
            begun.release()

    reports = []
    until = [1.0, 2.0, *[1e9] * 30]
    options = {"events": [events.Function(f)], "progress": report, "threads": 2}
    with pytest.raises(KeyboardInterrupt) as caught:
        integrate_many([(SYSTEM, STATE)] * 32, until, output=1e3, **options)
    error = caught.value
    assert type(error) is Interrupted
    assert str(error) == "interrupted with 2 of 32 members done; the runs so far are in .runs"
    assert error.run is None
    assert len(error.runs) == 32
    assert [run.stop_reason for run in error.runs[:4]] == ["end", "end", "interrupted", "interrupted"]
    assert error.runs[4:] == [None] * 28
    for run in error.runs[2:4]:
        assert run.time[0] == 0.0
        assert abs(run.energy_drift).max() < 1e-12
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_in_an_event_function_stops_all_members():
    def f(state):
        if state.time > 3.0:
            raise KeyboardInterrupt
        return 1.0

    with pytest.raises(Interrupted) as caught:
        integrate_many([(SYSTEM, STATE)] * 20, 1e9, output=[], events=[events.Function(f)], threads=2)
    assert {getattr(run, "stop_reason", None) for run in caught.value.runs} <= {"interrupted", None}
    assert len(caught.value.runs) == 20


def test_ctrl_c_in_a_generator_returns_the_finished_members():
    def members():
        yield SYSTEM, STATE
        raise KeyboardInterrupt

    with pytest.raises(Interrupted, match=r"^interrupted with 1 member done; the runs so far are in \.runs$"):
        integrate_many(members(), 1.0, threads=1)
