"""A user's own force: in Python and compiled, with units, and all the ways in which it can fail."""

import ctypes
import shutil
import signal
import subprocess
import sys
import threading
import time

import fullbody
import numpy as np
import pytest
from fullbody.errors import ForceFailed, InvalidInput
from fullbody.forces import Function
from support.scenes import pair

SIGNATURE = ctypes.CFUNCTYPE(
    ctypes.c_int, ctypes.c_double, ctypes.c_int64, *[ctypes.POINTER(ctypes.c_double)] * 6, ctypes.c_void_p
)
#: A drag, and a torque against the spin: f = -k v cos(t), M = -k w, with k from the data where there are some.
CODE = """
#include <math.h>
#include <stdint.h>
#define FORCE(name) int name(double time, int64_t bodies, const double *position, const double *velocity, \\
    const double *attitude, const double *spin, double *force, double *torque, void *data)
FORCE(drag)
{
    double k = data ? *(double *)data : 1e-3;
    for (int64_t i = 0; i < 3 * bodies; i++) {
        force[i] = -k * velocity[i] * cos(time);
        torque[i] = -k * spin[i];
    }
    return 0;
}
FORCE(late) { return time > 2.0 ? 7 : 0; }
FORCE(spoilt) { torque[1] = time > 2.0 ? NAN : 0.0; return 0; }
"""


def drag(time, state, k=1e-3):
    return -k * np.cos(time) * state.velocity, -k * state.spin


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The code above, by the C compiler of the machine."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("needs a C compiler")
    folder = tmp_path_factory.mktemp("library")
    (folder / "drag.c").write_text(CODE)
    subprocess.run([compiler, "-O2", "-shared", "-fPIC", "-o", folder / "drag.so", folder / "drag.c"], check=True)
    return ctypes.CDLL(str(folder / "drag.so"))


def run_of(function, until=4.0, **arguments):
    system, state = pair()
    return system.with_forces([Function(function, **arguments)]).integrate(state, until, output=[0.0, until])


def same(item, other):
    np.testing.assert_allclose(item.position, other.position, rtol=0, atol=1e-13)
    np.testing.assert_allclose(item.spin, other.spin, rtol=0, atol=1e-12)


# Functions of Python.


def test_a_rotating_force_and_a_periodic_torque_give_the_motion_of_the_closed_form():
    """As in a field that rotates m v' = A (cos t, sin t, 0) + g z, and C w' = c cos t about z in the sphere's frame."""
    system = fullbody.System([fullbody.Body(fullbody.Sphere(0.5), mass=2.0)], G=1.0)
    state = fullbody.State([[1.0, 2.0, 3.0]], [[0.5, 0.0, -1.0]], spin=[[0.0, 0.0, 1.0]])

    def field(time, state):
        return [[3 * np.cos(time), 3 * np.sin(time), 0.4]], [[0, 0, 0.1 * np.cos(time)]]

    run = system.with_forces([Function(field, depends_on_velocity=False)]).integrate(state, 20.0, output=2.0)
    t = run.time
    expected = [1.0 + 0.5 * t + 1.5 * (1 - np.cos(t)), 2.0 + 1.5 * (t - np.sin(t)), 3.0 - t + 0.1 * t**2]
    np.testing.assert_allclose(run.position[:, 0].T, expected, rtol=0, atol=2e-11)
    np.testing.assert_allclose(run.impulse["field"][:, 2], 0.4 * t, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(run.spin[:, 0, 2], 1.0 + 0.1 / (0.4 * 2 * 0.25) * np.sin(t), rtol=1e-11)


def test_a_force_function_gets_time_and_state_as_copies_with_names():
    calls = []

    def record(time, state):
        calls.append((time, state.time, state.position[1].copy(), state.attitude.shape))
        state.position.flags.writeable and state.position.fill(0.0)
        return np.zeros((2, 3))

    system, state = pair()
    shift, speed = np.array([100.0, 0, 0]), np.array([0, 5.0, 0])
    displaced = fullbody.State(state.position + shift, state.velocity + speed, state.attitude, state.spin, time=3.0)
    run = system.with_forces([Function(record)]).integrate(displaced, 4.0, output=[4.0])
    assert all(time == state_time and shape == (2, 4) and 3.0 <= time <= 4.0 for time, state_time, _, shape in calls)
    np.testing.assert_allclose(calls[0][2], displaced.position[1], rtol=1e-15)
    free = system.integrate(displaced, 4.0, output=[4.0])
    np.testing.assert_allclose(run.position, free.position, rtol=0, atol=1e-12)


def test_force_functions_receive_and_return_quantities():
    from astropy import units as u

    system, state = fullbody.systems.kw4(units=True)
    mass = system.masses

    def push(time, state):
        assert time.unit.is_equivalent(u.s)
        size = 1e-12 * u.m / u.s**2 * np.cos((time / (3 * u.hour)).to_value(u.one))
        return (mass[:, None] * size * state.velocity / np.linalg.norm(state.velocity)).to(u.N), np.zeros(
            (2, 3)
        ) * u.N * u.m

    def bare(time, state):
        size = 1e-12 * 1e-3 * 3600**2 * np.cos(time / 3)
        return mass.value[:, None] * size * state.velocity / np.linalg.norm(state.velocity)

    item = system.with_forces([Function(push, name="push")]).integrate(state, 4 * u.hour, output=[4] * u.hour)
    numbers, start = fullbody.systems.kw4()
    other = numbers.with_forces([Function(bare, name="push")]).integrate(start, 4.0, output=[4.0])
    np.testing.assert_allclose(item.position.to_value(u.km), other.position, rtol=0, atol=1e-12)
    assert item.work["push"].to_value(u.J)[-1] == pytest.approx(other.work["push"][-1] * 1e6 / 3600**2, rel=1e-9)
    wrong = Function(lambda t, s: s.position, name="wrong")
    with pytest.raises(ForceFailed, match="force of wrong has the unit km") as caught:
        system.with_forces([wrong]).integrate(state, 10 * u.hour)
    assert caught.value.force == "wrong"


# Compiled ones.


def test_a_pointer_of_ctypes_is_a_force(library):
    pointer = SIGNATURE(("drag", library))
    same(run_of(pointer, name="drag"), run_of(drag))
    # Also one without types, as a library gives it.
    same(run_of(library.drag, name="drag"), run_of(drag))


def test_a_callable_of_scipy_with_data_is_a_force(library):
    from scipy import LowLevelCallable

    k = ctypes.c_double(2e-3)
    data = ctypes.cast(ctypes.pointer(k), ctypes.c_void_p)
    pointer = SIGNATURE(("drag", library))
    for arguments, strength in (((pointer, data), 2e-3), ((pointer,), 1e-3)):
        same(
            run_of(LowLevelCallable(*arguments), name="drag"),
            run_of(lambda t, s, k=strength: drag(t, s, k), name="drag"),
        )


def test_a_function_of_numba_is_a_force():
    numba = pytest.importorskip("numba", reason="needs numba, of the extra test")
    c = numba.types
    signature = c.intc(c.double, c.int64, *[c.CPointer(c.double)] * 6, c.voidptr)

    @numba.cfunc(signature)
    def compiled(time, bodies, position, velocity, attitude, spin, force, torque, data):
        for i in range(3 * bodies):
            force[i] = -1e-3 * np.cos(time) * velocity[i]
            torque[i] = -1e-3 * spin[i]
        return 0

    same(run_of(compiled, name="drag"), run_of(drag))


def test_compiled_force_functions_run_in_many_threads_at_once(library):
    from concurrent.futures import ThreadPoolExecutor

    pointer = SIGNATURE(("drag", library))
    expected = run_of(pointer, name="drag")
    with ThreadPoolExecutor(3) as pool:
        for run in pool.map(lambda _: run_of(pointer, name="drag"), range(6)):
            assert run == expected or (run.position == expected.position).all()


def test_a_system_keeps_its_force_function_alive(library):
    import gc

    system, state = pair()

    def make():
        k = 1e-3
        return system.with_forces([Function(lambda t, s: drag(t, s, k), name="drag")])

    forced = make()
    gc.collect()
    sim = fullbody.Simulation(forced, state)
    del forced
    gc.collect()
    np.testing.assert_allclose(sim.integrate(4.0, output=[4.0]).position, run_of(drag, 4.0).position[-1:], atol=1e-14)


# Failures.


class Trouble(Exception):
    pass


def failing(failure):
    def force(time, state):
        if time > 2.0:
            return failure(state)
        return 0 * state.position

    return force


def trouble(_):
    raise Trouble("no such wind")


@pytest.mark.parametrize(
    ("failure", "text", "cause"),
    [
        (trouble, "no such wind", Trouble),
        (lambda s: s.position * np.nan, "NaN", InvalidInput),
        (lambda s: np.zeros(3), r"shape \(3,\); expected \(2, 3\)", InvalidInput),
        (lambda s: np.zeros((3, 3)), r"shape \(3, 3\); expected \(2, 3\)", InvalidInput),
        (lambda s: (0 * s.position, np.zeros(4)), r"torque.*shape \(4,\)", InvalidInput),
        (lambda s: None, "None", InvalidInput),
        (lambda s: "north", "north", InvalidInput),
        (lambda s: (0 * s.position,), "returns 1 values; expected forces, or", InvalidInput),
        (lambda s: (0 * s.position, 0 * s.spin, 0), "returns 3 values", InvalidInput),
        (lambda s: 1j * s.position, "complex|j", InvalidInput),
        (lambda s: s.position[0] / 0 + s.nothing, "nothing", AttributeError),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
def test_the_error_of_a_force_function_has_force_time_cause_and_run(failure, text, cause):
    system, state = pair()
    with pytest.raises(ForceFailed, match=f"(?s)wind.*{text}") as caught:
        system.with_forces([Function(failing(failure), name="wind")]).integrate(state, 10.0)
    error = caught.value
    assert error.force == "wind"
    assert 2.0 < error.time < 3.0
    assert error.__cause__ is None or isinstance(error.__cause__, cause)
    run = error.run
    assert len(run) > 3
    assert run.time[-1] <= error.time
    assert run.stop_reason == "unfinished"
    free = system.integrate(state, run.time[-1], output=[run.time[-1]])
    np.testing.assert_allclose(run.position[-1], free.position[-1], rtol=0, atol=1e-11)


@pytest.mark.parametrize(("name", "text"), [("late", "answers 7"), ("spoilt", "gives NaN")])
def test_a_failing_compiled_force_function_is_named(library, name, text):
    system, state = pair()
    pointer = SIGNATURE((name, library))
    with pytest.raises(ForceFailed, match=f"wind.*{text}") as caught:
        system.with_forces([Function(pointer, name="wind")]).integrate(state, 10.0)
    assert caught.value.force == "wind"
    assert caught.value.run.time[-1] <= caught.value.time


def test_force_functions_that_fail_at_the_start_or_in_steps_are_named():
    system, state = pair()
    forced = system.with_forces([Function(lambda t, s: trouble(s), name="wind")])
    for act in (
        lambda: forced.integrate(state, 1.0),
        lambda: forced.loads(state),
        lambda: fullbody.Simulation(forced, state).step(),
    ):
        with pytest.raises(ForceFailed, match=r"wind.*no such wind") as caught:
            act()
        assert isinstance(caught.value.__cause__, Trouble)


def test_a_simulation_continues_after_a_failing_force_function():
    system, state = pair()
    broken = [True]

    def wind(time, state):
        if time > 2.0 and broken[0]:
            trouble(state)
        return 0 * state.position

    sim = fullbody.Simulation(system.with_forces([Function(wind)]), state)
    with pytest.raises(ForceFailed) as caught:
        sim.integrate(5.0)
    assert sim.time == caught.value.run.time[-1]
    broken[0] = False
    run = sim.integrate(5.0)
    free = system.integrate(state, 5.0, output=[5.0])
    np.testing.assert_allclose(run.position[-1], free.position[0], rtol=0, atol=1e-12)


def test_a_force_function_cannot_step_its_simulation():
    system, state = pair()

    def wind(time, state):
        sim.step()
        return 0 * state.position

    sim = fullbody.Simulation(system.with_forces([Function(wind)]), state)
    with pytest.raises(ForceFailed, match="middle of a run"):
        sim.integrate(1.0)


def test_an_exit_within_a_force_function_ends_the_program():
    system, state = pair()
    leaving = system.with_forces([Function(lambda now, state: sys.exit(3), name="leaving")])
    for ask in (lambda: leaving.integrate(state, 1.0), lambda: leaving.loads(state)):
        with pytest.raises(SystemExit) as caught:
            ask()
        assert caught.value.code == 3


@pytest.mark.skipif(sys.platform == "win32", reason="has no pthread_kill")
def test_ctrl_c_within_a_force_function_keeps_the_run():
    system, state = pair()
    entered, ended = threading.Event(), threading.Event()

    def wind(now, state):
        if now > 1.0:
            entered.set()
            # In short pieces: a signal that comes just before a sleep is seen after it.
            for _ in range(1000):
                time.sleep(0.01)
            raise TimeoutError("no signal arrived")
        return 0 * state.position

    def press():
        entered.wait(20.0)
        # As a user does, again if nothing happens: a collector of garbage may swallow the first one.
        while not ended.is_set():
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
            ended.wait(3.0)

    thread = threading.Thread(target=press)
    thread.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        system.with_forces([Function(wind)]).integrate(state, 50.0)
    ended.set()
    thread.join()
    assert caught.value.run.stop_reason == "interrupted"
    assert 0.0 < caught.value.run.time[-1] <= 1.1
