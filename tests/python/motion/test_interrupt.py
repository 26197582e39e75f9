"""Long calls let other threads work, and stop on Ctrl-C."""

import contextlib
import signal
import sys
import threading
import time

import fullbody
import numpy as np
import pytest
from fullbody import observing
from fullbody.errors import Interrupted
from fullbody.observing.brightness import Epochs, Photometer


@pytest.mark.skipif(sys.platform == "win32", reason="has no pthread_kill")
def test_ctrl_c_stops_a_run_and_leaves_the_simulation_usable():
    """The run would go on for months: that it ends shows that another thread worked during it, and was heard."""
    sim = fullbody.Simulation(*fullbody.systems.kw4_ho2021(gravity="surface"))

    def press():
        with contextlib.suppress(fullbody.FullbodyError):
            while sim.time < 1e9:
                time.sleep(1e-3)
        # The simulation is in its run.
        time.sleep(0.05)
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

    thread = threading.Thread(target=press)
    thread.start()
    with pytest.raises(KeyboardInterrupt, match="interrupted") as caught:
        sim.integrate(1e9)
    thread.join()
    assert type(caught.value) is Interrupted
    assert not isinstance(caught.value, Exception)
    run, stopped = caught.value.run, sim.time
    assert run.time[0] == 0.0
    assert 0.0 < run.time[-1] <= stopped
    assert abs(run.energy_drift).max() < 1e-13
    # It goes on from where it stopped, on the path of an unbroken run.
    more = sim.integrate(stopped + 5.0)
    assert (more.time[0], more.time[-1]) == (stopped, stopped + 5.0)
    reference = sim.system.integrate(run[0], stopped + 5.0, output=[stopped + 5.0])
    assert abs(reference.position[-1] - more.position[-1]).max() < 1e-10
    # The handler of Python is in place again: a second Ctrl-C is a KeyboardInterrupt as ever.
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def lattice(count, shape, **options):
    """Bodies at rest, far from each other."""
    side = int(np.ceil(count ** (1 / 3)))
    positions = 10.0 * np.stack(np.meshgrid(*[np.arange(side)] * 3), axis=-1).reshape(-1, 3)[:count]
    bodies = [fullbody.Body(shape, mass=1.0, name=f"{k}") for k in range(count)]
    return fullbody.System(bodies, G=1.0, **options), fullbody.State(positions, np.zeros((count, 3)))


def fine_quadrature():
    return lattice(30, fullbody.Ellipsoid(1.0, 0.9, 0.8), gravity="surface", order=(150, 300))


def a_step():
    return fullbody.Simulation(*fine_quadrature()).step


def forces_of_lattice():
    system, state = lattice(1500, fullbody.Ellipsoid(1.0, 0.9, 0.8))
    return lambda: system.interactions(state)


def energy_of_lattice():
    system, state = lattice(1500, fullbody.Ellipsoid(1.0, 0.9, 0.8))
    return lambda: system.energy(state)


def simulation_of_lattice():
    system, state = lattice(900, fullbody.Sphere(1.0))
    return lambda: fullbody.Simulation(system, state)


def gravity_at_points():
    system, state = lattice(700, fullbody.Ellipsoid(1.0, 0.9, 0.8))
    positions = np.random.default_rng(0).normal(size=(500_000, 3)) * 30.0
    return lambda: system.gravity(state, positions)


def light_of_rough_surfaces():
    # Each body by the light from 72 places on the disc of the Sun.
    system, state = lattice(300, fullbody.Ellipsoid(1.0, 0.9, 0.8))
    law = observing.Hapke(roughness=0.3)
    return lambda: observing.brightness(system, state, [1, 0.1, 0.2], [1, 0.5, 0.3], law=law, sun_radius=0.01)


def light_of_facets():
    """What hides the faces of the radar shapes is found at their first brightness."""
    system, state = fullbody.systems.kw4(shape="radar")
    return lambda: observing.brightness(system, state, [1, 0.1, 0.2], [1, 0.5, 0.3])


def light_of_binary():
    system = fullbody.System([fullbody.Body(fullbody.Ellipsoid(1.0, 0.9, 0.8), mass=1.0, name=n) for n in "AB"], G=1.0)
    states = fullbody.State([[0, 0, 0], [4.0, 0.3, 0.2]], np.zeros((2, 3)))
    photometer = Photometer(system, observing.Lambert(), 1.0, True, 0.0)
    count = 100_000
    rows = (np.zeros(count), np.tile(states.position, (count, 1, 1)), np.tile(states.attitude, (count, 1, 1)))
    lines = (np.tile([1.0, 0.0, 0.0], (count, 1)), np.tile([1.0, 0.1, 0.0], (count, 1)))
    return lambda: photometer.brightness(Epochs(*rows, *lines))


def orbits(count):
    """The run of two ellipsoids about each other, as points, and a geometry."""
    bodies = [fullbody.Body(fullbody.Ellipsoid(a, 0.9 * a, 0.8 * a), mass=m) for a, m in ((1.0, 0.9), (0.4, 0.1))]
    state = fullbody.State([[-0.3, 0, 0], [2.7, 0, 0]], np.outer([-0.1, 0.9], [0, 3**-0.5, 0]), spin=np.ones((2, 3)))
    until = count * 2 * np.pi * 3**1.5
    run = fullbody.System(bodies, G=1.0, gravity="point").integrate(state, until, dense=True, output=[until])
    view = {"to_observer": [1e4, 0, 0], "to_sun": [1e4, 1e3, 0]}
    return run, observing.Geometry([-1.0, until + 1.0], light_time=False, **view)


def light_curve_by_hapkes_law():
    run, geometry = orbits(2)
    times = np.linspace(0.0, run.time[-1], 500)
    return lambda: observing.light_curve(run, times, geometry, law=observing.Hapke())


def mutual_events_of_orbits():
    run, geometry = orbits(300)
    return lambda: observing.mutual_events(run, geometry)


CALLS = [a_step, forces_of_lattice, energy_of_lattice, simulation_of_lattice, gravity_at_points]
CALLS += [light_of_rough_surfaces, light_of_facets, light_of_binary]
CALLS += [light_curve_by_hapkes_law, mutual_events_of_orbits]


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers that send signals")
@pytest.mark.parametrize("prepare", CALLS)
def test_signals_are_handled_while_a_call_works(prepare):
    call = prepare()
    heard = []

    def handle(number, frame):
        heard.append((frame, frame.f_lasti))
        # Three signals at one place are in one call, not in the lines of Python before it.
        if heard[-3:] == 3 * heard[-1:]:
            raise KeyboardInterrupt

    previous = signal.signal(signal.SIGALRM, handle)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.005, 0.005)
        with pytest.raises(Interrupted):
            call()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, previous)
    if prepare is a_step:
        # It is taken back.
        assert call.__self__.state == fine_quadrature()[1]


def test_runs_in_threads_give_the_same_bits():
    system, state = fullbody.systems.case1()
    expected = system.integrate(state, 100.0)
    runs = [None] * 4

    def work(k):
        runs[k] = system.integrate(state, 100.0)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(run == expected for run in runs)
