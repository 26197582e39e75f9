"""Derivatives with other methods of gravity, other integrators, external forces, and at events."""

import fullbody
import numpy as np
import pytest
from fullbody.errors import InvalidInput
from scipy.linalg import expm
from support import pair_of_points, worst
from support.flows import (
    TIGHT,
    central,
    central_of_state,
    cross,
    deviation,
    displaced,
    energy_gradient,
    momentum_gradients,
    rates,
    scales,
    symplectic_form,
    tumbling,
)

STEPS = [
    fullbody.LieGroupVariational(step=0.05),
    fullbody.SymplecticSplitting(step=0.2),
    fullbody.SymplecticSplitting(step=0.2, scheme="leapfrog"),
]


@pytest.mark.parametrize("gravity", ["multipole:2", "multipole:4", "multipole:8"])
def test_derivatives_of_the_series_are_differences(gravity):
    system, state = tumbling(gravity)
    size = scales(system, state)
    actual = system.jacobian(state)
    for k in (0, 4, 7, 14, 20):
        place = (k // 12, k % 12 // 3, k % 3)
        change = central_of_state(lambda by, place=place: rates(system, displaced(state, *place, by)), 1e-3 * size[k])
        if place[1] == 2:
            change[12 * place[0] + 6 : 12 * place[0] + 9] -= np.cross(state.spin[place[0]], np.eye(3)[place[2]])
        assert worst(actual.rates[:, k] / size, change / size) < 1e-9
    assert worst(actual.flow, rates(system, state)) < 1e-14
    run = system.integrate(state, 6.0, output="ends", integrator=TIGHT, derivatives=True)
    now, then = (energy_gradient(system, run[i]) for i in (1, 0))
    assert worst(now @ run.transition[1] * size, then * size) < 1e-11


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
def test_derivatives_of_fixed_steps_are_those_of_the_map(integrator):
    system, state = tumbling()
    size = scales(system, state)
    wanted = ["G", "mass of A", "semi-axis b of B"]
    run = system.integrate(state, 2.0, output="ends", integrator=integrator, derivatives=wanted)
    assert np.array_equal(
        run[1].position, system.integrate(state, 2.0, output="ends", integrator=integrator)[1].position
    )
    phi = run.transition[1]
    # The map is symplectic by itself, and keeps the angular momentum, whatever the length of its steps.
    kept = phi.T @ symplectic_form(system, run[1]) @ phi
    scaled = [size[:, np.newaxis] * form * size for form in (kept, symplectic_form(system, run[0]))]
    assert worst(*scaled) < 1e-12
    now, then = (momentum_gradients(system, run[i]) for i in (1, 0))
    assert worst(now @ phi * size, then * size) < 1e-12

    # It is the derivative of these very steps, which differ from the motion by far more.
    def moved(place, by):
        return system.integrate(displaced(state, *place, by), 2.0, output="ends", integrator=integrator)[-1]

    for place in ((0, 0, 1), (1, 1, 0), (0, 2, 2), (1, 3, 1)):
        column = 12 * place[0] + 3 * place[1] + place[2]
        change = central(lambda by, place=place: moved(place, by), 1e-4 * size[column])
        assert worst(phi[:, column] / size, change / size) < 1e-9

    def other(by, G=0.0, mass=0.0, axis=0.0):
        first, second = system.bodies
        a, b, c = second.shape.a, second.shape.b, second.shape.c
        first = fullbody.Body(first.shape, mass=first.mass + by * mass, name="A")
        second = fullbody.Body(fullbody.Ellipsoid(a, b + by * axis, c), mass=second.mass, name="B")
        changed = fullbody.System([first, second], G=system.G + by * G)
        return changed.integrate(state, 2.0, output="ends", integrator=integrator)[-1]

    for name, which in zip(wanted, ("G", "mass", "axis"), strict=True):
        change = central(lambda by, which=which: other(by, **{which: 1.0}), 1e-4)
        assert worst(run.sensitivity[name][1] / size, change / size) < 1e-9


@pytest.mark.parametrize("integrator", STEPS, ids=["lie", "aba864", "leapfrog"])
@pytest.mark.parametrize("name", ["mass of A", "mass of B", "mu of Sun"])
def test_the_tangent_map_of_fixed_steps_beside_a_third_body(integrator, name):
    # The masses change the shares of both bodies in the barycentre, which the third body moves.
    system, state = tumbling()

    def end(by=0.0, **given):
        masses = [body.mass + (by if name == f"mass of {body.name}" else 0.0) for body in system]
        bodies = [fullbody.Body(b.shape, mass=mass, name=b.name) for b, mass in zip(system, masses, strict=True)]
        mu = 30.0 + (by if name == "mu of Sun" else 0.0)
        path = {"times": [-1.0, 0.0, 1.0, 3.0], "positions": [[20.0, 8.0, 3.0]] * 4}
        sun = fullbody.forces.ThirdBody(mu=mu, of="body", name="Sun", **path)
        changed = fullbody.System(bodies, G=1.0, forces=[sun])
        return changed.integrate(state, 2.0, output="ends", integrator=integrator, **given)

    size = scales(system, state)
    column = end(derivatives=[name]).sensitivity[name][-1]
    change = central(lambda by: end(by)[-1], 1e-3)
    assert worst(column / size, change / size) < 1e-9


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


def outside():
    """Forces of every kind that has derivatives, strong enough to be seen."""
    sun = fullbody.KeplerElements(40.0, 0.2, 0.3, 0.1, 0.2, 0.4)
    return [
        fullbody.forces.ThirdBody(mu=30.0, orbit=sun, of="system", name="Sun"),
        fullbody.forces.Tide(on="A", by="B", k2=0.3, lag=0.05, name="tide"),
    ]


def test_derivatives_with_external_forces_are_differences():
    system, state = tumbling()
    system = system.with_forces(outside())
    size = scales(system, state)
    wanted = ["G", "mass of B", "lag of tide", "k2 of tide", "density of A"]
    run = system.integrate(state, 5.0, output="ends", integrator=TIGHT, derivatives=wanted)

    def moved(place, by):
        return system.integrate(displaced(state, *place, by), 5.0, output="ends", integrator=TIGHT)[-1]

    for place in ((0, 0, 0), (1, 1, 2), (0, 2, 1), (1, 2, 0), (0, 3, 0)):
        column = 12 * place[0] + 3 * place[1] + place[2]
        change = central(lambda by, place=place: moved(place, by), 1e-3 * size[column])
        assert worst(run.transition[1][:, column] / size, change / size) < 1e-8

    def lagging(by):
        forces = [system.forces[0], fullbody.forces.Tide(on="A", by="B", k2=0.3, lag=0.05 + by, name="tide")]
        return system.with_forces(forces).integrate(state, 5.0, output="ends", integrator=TIGHT)[-1]

    change = central(lagging, 1e-3)
    assert worst(run.sensitivity["lag of tide"][1] / size, change / size) < 1e-8
    assert worst(run.sensitivity["k2 of tide"][1] * 0.3, run.sensitivity["lag of tide"][1] * 0.05) < 1e-11
    assert worst(system.jacobian(state).flow[3:6], acceleration(system, state)) < 1e-13


def acceleration(system, state):
    """The acceleration of the first body by the interactions and the loads."""
    force = system.interactions(state).force[0] + sum(load.force[0] for load in system.loads(state).values())
    return force / system.bodies[0].mass


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
    with pytest.raises(InvalidInput, match="drag"):
        system.with_forces([drag]).integrate(state, 1.0, derivatives=True)


@pytest.mark.parametrize(
    "event",
    [
        fullbody.events.Separation("A", "B", 3.0, terminal=True),
        fullbody.events.Apoapsis("A", "B", terminal=True),
        fullbody.events.PlaneCrossing("B", "A", normal=[0, 1, 0.3], terminal=True),
        fullbody.events.Function(lambda state: np.sin(state.attitude[0][1]) - 0.3 * state.spin[1][0], terminal=True),
    ],
    ids=["separation", "apoapsis", "plane", "function"],
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
    ],
    ids=["contact", "bound no more", "bound no more, by G", "far"],
)
def test_functions_of_events_that_know_the_parameter(event, velocity, name):
    _, state = tumbling()
    state = state.replace(velocity=[state.velocity[0], velocity])

    def ended(by, names=()):
        more = {"mass of A": 0.0, "semi-axis a of B": 0.0, "G": 0.0, name: by}
        first = fullbody.Body(fullbody.Ellipsoid(1.0, 0.8, 0.6), mass=1.0 + more["mass of A"], name="A")
        second = fullbody.Body(fullbody.Ellipsoid(0.4 + more["semi-axis a of B"], 0.7, 0.5), mass=0.4, name="B")
        changed = fullbody.System([first, second], G=1.0 + more["G"])
        return changed.integrate(state, 30.0, integrator=TIGHT, events=[event], output="ends", derivatives=names)

    run = ended(0.0, [name])
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
    with pytest.raises(InvalidInput, match="one of the 1 events"):
        run.at_event(1)
    with pytest.raises(InvalidInput, match="derivatives=True"):
        system.integrate(state, 30.0, events=[event]).at_event()
