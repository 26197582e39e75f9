"""Derivatives with other methods of gravity, other integrators, external forces, and at events."""

from dataclasses import replace

import fullbody
import numpy as np
import pytest
from scipy.linalg import expm
from support import pair_of_points, refused, worst
from support.flows import (
    TIGHT,
    central_of_state,
    cross,
    deviation,
    displaced,
    momentum_gradients,
    scales,
    symplectic_form,
    tumbling,
)

STEPS = [
    fullbody.LieGroupVariational(step=0.05),
    fullbody.SymplecticSplitting(step=0.2),
    fullbody.SymplecticSplitting(step=0.2, scheme="leapfrog"),
]


def test_high_degree_series_equals_focal():
    far = 6.0
    both = []
    for gravity in ("multipole:16", "focal"):
        system, state = tumbling(gravity)
        apart = fullbody.State(
            np.array(state.position) * [[1.0], [far]], state.velocity, state.attitude, state.spin, time=state.time
        )
        both.append(system.jacobian(apart))
    for name in ("force_by_position", "force_by_rotation", "torque_by_position", "torque_by_rotation"):
        series, focal = (getattr(jacobian, name) for jacobian in both)
        assert worst(series, focal) < 1e-12


@pytest.mark.parametrize("integrator", STEPS, ids=["lie", "aba864", "leapfrog"])
def test_transition_matrices_of_fixed_steps_are_symplectic(integrator):
    system, state = tumbling()
    size = scales(system, state)
    options = {"output": "ends", "integrator": integrator}
    run = system.integrate(state, 2.0, derivatives=True, **options)
    assert np.array_equal(run[1].position, system.integrate(state, 2.0, **options)[1].position)
    phi = run.transition[1]
    # The map is symplectic by itself, and keeps the angular momentum, whatever the length of its steps.
    kept = phi.T @ symplectic_form(system, run[1]) @ phi
    scaled = [size[:, np.newaxis] * form * size for form in (kept, symplectic_form(system, run[0]))]
    assert worst(*scaled) < 1e-12
    now, then = (momentum_gradients(system, run[i]) for i in (1, 0))
    assert worst(now @ phi * size, then * size) < 1e-12


@pytest.mark.parametrize("integrator", [*STEPS, TIGHT], ids=["lie", "aba864", "leapfrog", "verner98"])
def test_points_turn_evenly(integrator):
    # d theta/dt = dspin - spin x theta and d spin/dt = 0 have constant coefficients: the exponential of their matrix.
    system, state = pair_of_points(0.3)
    spin = np.array([[0.4, -0.2, 0.3], [-1.1, 0.7, 0.5]])
    state = fullbody.State(state.position, state.velocity, state.attitude, spin)
    run = system.integrate(state, 2.0, output="ends", integrator=integrator, derivatives=True)
    for k in range(2):
        rates = np.block([[-cross(spin[k]), np.eye(3)], [np.zeros((3, 6))]])
        turning = slice(12 * k + 6, 12 * k + 12)
        assert worst(run.transition[1][turning, turning], expm(2.0 * rates)) < 1e-13


def test_composites_have_no_density_to_differentiate_by():
    first, second = (fullbody.Part(fullbody.Sphere(0.3), mass=m, position=[x, 0, 0]) for m, x in ((1, -0.2), (2, 0.1)))
    body = fullbody.Body(fullbody.Composite([first, second]), name="A")
    assert body.density is None
    numbers = [
        f"{what} of part {k} of A" for k in (0, 1) for what in ("mass", "position x", "position y", "position z")
    ]
    assert fullbody.System([body], G=1.0).parameters == ("G", "mass of A", *numbers)


def test_love_number_and_lag_of_a_tide_have_derivatives_as_factors_of_a_product():
    system, state = tumbling()
    system = system.with_forces([fullbody.forces.Tide(on="A", by="B", k2=0.3, lag=0.05, name="tide")])
    run = system.integrate(state, 5.0, output="ends", integrator=TIGHT, derivatives=["lag of tide", "k2 of tide"])
    assert worst(run.sensitivity["k2 of tide"][1] * 0.3, run.sensitivity["lag of tide"][1] * 0.05) < 1e-11


def test_derivatives_with_radiation_are_differences():
    system, state = fullbody.systems.kw4()
    yorp = fullbody.forces.Yorp(
        on="Alpha", pole=[0.1, 0.0, 1.0], obliquity=[0.0, 0.5, 1.0, 2.0, np.pi], along=[1e9, 2e9, -1e9, 1e9, 0.5e9],
        across=[2e9, -1e9, 1e9, 2e9, 1e9], name="yorp",
    )  # fmt: skip
    system = system.with_forces([yorp])
    size = scales(system, state)
    bare = fullbody.System(system.bodies, G=system.G).jacobian(state).rates
    actual = (system.jacobian(state).rates - bare)[9:12]
    for k in range(6, 12):
        change = central_of_state(
            lambda by, k=k: yorp_rate(system, displaced(state, 0, k // 3, k % 3, by)), 1e-3 * size[k]
        )
        assert worst(actual[:, k], change, np.abs(actual[:, 6:12]).max()) < 1e-7


def yorp_rate(system, state):
    a, b, c = (1.417 / 2) ** 2, (1.361 / 2) ** 2, (1.183 / 2) ** 2
    moments = system.bodies[0].mass / 5 * np.array([b + c, a + c, a + b])
    return system.loads(state)["yorp"].torque[0] / moments


def test_what_has_no_derivatives_is_refused_by_name():
    system, state = tumbling()
    drag = fullbody.forces.Function(lambda time, state: (np.zeros((2, 3)), np.zeros((2, 3))), name="drag")
    refused("drag", lambda: system.with_forces([drag]).integrate(state, 1.0, derivatives=True))


@pytest.mark.parametrize(
    "event",
    [
        fullbody.events.Apoapsis("A", "B", terminal=True),
        fullbody.events.Function(lambda state: np.sin(state.attitude[0][1]) - 0.3 * state.spin[1][0], terminal=True),
    ],
    ids=["apoapsis", "function"],
)
def test_derivatives_of_times_of_events_are_differences(event):
    system, state = tumbling()
    run = system.integrate(state, 30.0, integrator=TIGHT, events=[event], derivatives=["mass of B"])
    assert run.stop_reason == "event"
    end = run.at_event()
    size = scales(system, state)

    def ended(place, by):
        return system.integrate(displaced(state, *place, by), 30.0, integrator=TIGHT, events=[event], output="ends")

    for place in ((0, 0, 1), (1, 1, 1), (0, 2, 0)):
        column = 12 * place[0] + 3 * place[1] + place[2]
        step = 1e-4 * size[column]
        runs = {k: ended(place, k * step) for k in (-2, -1, 1, 2)}
        times = [float(runs[k].time[-1] - runs[-k].time[-1]) / (2 * k * step) for k in (1, 2)]
        scale = np.abs(end.time * size).max() / size[column]
        assert worst(end.time[column], (4 * times[0] - times[1]) / 3, scale) < 1e-8
        states = [deviation(runs[-k][-1], runs[k][-1]) / (2 * k * step) for k in (1, 2)]
        change = (4 * states[0] - states[1]) / 3
        assert worst(end.transition[:, column] / size, change / size) < 1e-7
    assert "mass of B" in end.time_sensitivity


@pytest.mark.parametrize(
    ("event", "velocity", "name"),
    [
        (fullbody.events.Contact("A", "B", terminal=True), [-0.15, 0.105, 0.1], "semi-axis a of B"),
        (fullbody.events.Escape("A", "B", distance=0.1, terminal=True), [0.1, 0.93, 0.1], "mass of A"),
        (fullbody.events.Escape("A", "B", distance=0.1, terminal=True), [0.1, 0.93, 0.1], "G"),
        (fullbody.events.Escape("A", "B", distance=8.0, terminal=True), [0.9, 0.7, 0.1], "G"),
        (fullbody.events.Escape("A", "B", distance=8.0, terminal=True), [0.9, 0.7, 0.1], "distance of Escape"),
    ],
    ids=["contact", "bound no more", "bound no more, by G", "far", "by distance"],
)
def test_functions_of_events_that_know_the_parameter(event, velocity, name):
    system, state = tumbling()
    state = state.replace(velocity=[state.velocity[0], velocity])

    def ended(by, names=()):
        more = {"mass of A": 0.0, "semi-axis a of B": 0.0, "G": 0.0, name: by}
        happening = replace(event, distance=event.distance + by) if name == "distance of Escape" else event
        first = fullbody.Body(fullbody.Ellipsoid(1.0, 0.8, 0.6), mass=1.0 + more["mass of A"], name="A")
        second = fullbody.Body(fullbody.Ellipsoid(0.4 + more["semi-axis a of B"], 0.7, 0.5), mass=0.4, name="B")
        changed = fullbody.System([first, second], G=1.0 + more["G"])
        return changed.integrate(state, 30.0, integrator=TIGHT, events=[happening], output="ends", derivatives=names)

    run = ended(0.0, [name] if name in system.parameters else True)
    assert run.stop_reason == "event"
    end = run.at_event()
    one, two = (float(ended(h).time[-1] - ended(-h).time[-1]) / (2 * h) for h in (1e-5, 2e-5))
    assert worst(end.time_sensitivity[name], (4 * one - two) / 3) < 1e-7
    moved = deviation(ended(-1e-5)[-1], ended(1e-5)[-1]) / 2e-5
    assert worst(end.sensitivity[name], moved) < 1e-4


def test_parts_of_a_run_and_files_keep_the_derivatives_of_events(tmp_path):
    system, state = tumbling()
    event = fullbody.events.Apoapsis("A", "B", terminal=True)
    run = system.integrate(state, 30.0, events=[event], derivatives=["mass of B"])
    run.save(tmp_path / "run.nc")
    for other in (run[:2], run[::-1], fullbody.load(tmp_path / "run.nc")):
        assert np.array_equal(other.at_event().time, run.at_event().time)
        assert other.at_event().time_sensitivity == run.at_event().time_sensitivity
    refused("one of the 1 events", lambda: run.at_event(1))
    refused("derivatives=True", lambda: system.integrate(state, 30.0, events=[event]).at_event())


def sun_beside_a_composite(of):
    parts = [
        fullbody.Part(fullbody.Sphere(0.5), mass=0.6, position=(0.4, 0.1, 0.2)),
        fullbody.Part(fullbody.Ellipsoid(0.5, 0.4, 0.3), mass=0.4, position=(-0.5, 0.0, -0.1)),
    ]
    bodies = [
        fullbody.Body(fullbody.Composite(parts), name="A"),
        fullbody.Body(fullbody.Sphere(0.3), mass=0.2, name="B"),
    ]
    orbit = fullbody.KeplerElements(40.0, 0.2, 0.3, 0.4, 0.5, 0.6)
    sun = fullbody.forces.ThirdBody(orbit=orbit, of=of, time=0.3, mass=300.0, name="Sun")
    system = fullbody.System(bodies, G=1.0, gravity="multipole:2", forces=[sun])
    state = fullbody.State(
        position=[[-0.5, 0.0, 0.0], [2.5, 0.0, 0.0]],
        velocity=[[0.0, -0.1, 0.0], [0.0, 0.5, 0.1]],
        spin=[[0.1, 0.2, 0.5], [0.0, 0.0, 0.4]],
    )
    return system, state


@pytest.mark.parametrize("of", ["system", "body"])
@pytest.mark.parametrize("integrator", [fullbody.Verner98(1e-12, 1e-12), fullbody.LieGroupVariational(step=0.05)])
def test_each_derivative_is_the_same_alone_and_beside_others(integrator, of):
    system, state = sun_beside_a_composite(of)
    names = [name for name in system.parameters if name.endswith("of Sun")] + ["mass of A", "G"]
    together = system.integrate(state, 4.0, integrator=integrator, derivatives=names).sensitivity
    for name in names:
        alone = system.integrate(state, 4.0, integrator=integrator, derivatives=[name]).sensitivity[name][-1]
        # The steps of an adaptive integrator depend on the derivatives that are asked for.
        np.testing.assert_allclose(together[name][-1], alone, rtol=0, atol=1e-8 * np.abs(alone).max(), err_msg=name)
