"""Derivatives at every event of a run, also with respect to the event's parameters, and of functions of a run."""

import astropy.units as u
import fullbody
import numpy as np
from support import refused, worst
from support.flows import TIGHT, deviation, displaced, scales, tumbling
from support.meshes import octahedron

EVENTS = [
    fullbody.events.Separation("A", "B", 2.5),
    fullbody.events.Periapsis("A", "B"),
    fullbody.events.PlaneCrossing("B", "A", normal=[0.2, 1.0, 0.3]),
]


def test_derivatives_at_every_event_are_differences():
    system, state = tumbling()
    until = -32.0
    size = scales(system, state)
    options = {"output": "ends", "integrator": TIGHT, "events": EVENTS}
    run = system.integrate(state, until, derivatives=["G", "semi-axis a of A"], **options)
    assert len({type(happened.event) for happened in run.events}) == 3
    step = 1e-4 * size[13]
    moved = {k: system.integrate(displaced(state, 1, 0, 1, k * step), until, **options).events for k in (-2, -1, 1, 2)}
    by_g = 1e-4
    heavy = {
        k: fullbody.System(system.bodies, G=1.0 + k * by_g).integrate(state, until, **options).events
        for k in (-2, -1, 1, 2)
    }
    for k in range(len(run.events)):
        end = run.at_event(k)
        for runs, small, time, whole in (
            (moved, step, end.time[13], end.transition[:, 13]),
            (heavy, by_g, end.time_sensitivity["G"], end.sensitivity["G"]),
        ):
            differences = [(runs[j][k].time - runs[-j][k].time) / (2 * j * small) for j in (1, 2)]
            assert (
                worst(time, (4 * differences[0] - differences[1]) / 3, np.abs(end.time * size).max() / size[13]) < 1e-7
            )
            states = [deviation(runs[-j][k].state, runs[j][k].state) / (2 * j * small) for j in (1, 2)]
            assert worst(whole / size, (4 * states[0] - states[1]) / 3 / size) < 1e-6


def test_the_time_of_contact_changes_with_the_scale_of_a_polyhedron():
    system, state = tumbling()
    solid = octahedron(0.8, 0.6, 0.7)

    def ended(by, wanted=False):
        bodies = [
            system.bodies[0],
            fullbody.Body(fullbody.Polyhedron((1.0 + by) * np.array(solid.vertices), solid.faces), mass=0.4, name="B"),
        ]
        start = state.replace(velocity=[state.velocity[0], [-0.4, 0.05, 0.1]])
        contact = fullbody.events.Contact("A", "B", terminal=True)
        return fullbody.System(bodies, G=1.0).integrate(
            start, 10.0, output="ends", events=[contact], derivatives=wanted
        )

    run = ended(0.0, ["scale of B"])
    step = 1e-4
    time = (ended(step).time[-1] - ended(-step).time[-1]) / (2 * step)
    assert worst(run.at_event().time_sensitivity["scale of B"], time) < 1e-6


def measures(run):
    """Mean period by the periapses, mean eccentricity, rate of the node, spread of an attitude's number, and energy."""
    times = np.array([happened.time for happened in run.events])
    elements = run.elements()
    node = np.polyfit(np.asarray(run.time), np.unwrap(elements.Omega), 1)[0]
    return np.array([np.diff(times).mean(), elements.e.mean(), node, np.std(run.attitude[:, 1, 1]), run.energy[-1]])


def test_derivatives_of_functions_of_a_run_are_differences():
    system, state = tumbling()
    options = {"output": 1.0, "integrator": TIGHT, "events": [EVENTS[1]]}
    names = ["mass of A", "semi-axis b of B", "G"]
    run = system.integrate(state, 70.0, derivatives=names, **options)
    found = run.derivative_of(measures)
    assert np.array_equal(found.value, measures(run))
    size = scales(system, state)
    scale = np.abs(found.start * size).max(axis=1)
    for column in (1, 14, 20):
        place = (column // 12, column % 12 // 3, column % 3)
        step = 1e-4 * size[column]
        ends = {
            k: measures(system.integrate(displaced(state, *place, k * step), 70.0, **options)) for k in (-2, -1, 1, 2)
        }
        change = [(ends[k] - ends[-k]) / (2 * k * step) for k in (1, 2)]
        assert (
            worst(
                found.start[:, column] * size[column] / scale,
                (4 * change[0] - change[1]) / 3 * size[column] / scale,
                1.0,
            )
            < 1e-6
        )

    def other(mass=0.0, axis=0.0, G=0.0):
        first, second = system.bodies
        first = fullbody.Body(first.shape, mass=first.mass + mass, name="A")
        second = fullbody.Body(fullbody.Ellipsoid(0.4, 0.7 + axis, 0.5), mass=0.4, name="B")
        changed = fullbody.System([first, second], G=1.0 + G)
        return measures(changed.integrate(state, 70.0, **options))

    for name, which in zip(names, ("mass", "axis", "G"), strict=True):
        ends = [(other(**{which: k * 1e-4}) - other(**{which: -k * 1e-4})) / (2e-4 * k) for k in (1, 2)]
        assert worst(found.by_parameter[name], (4 * ends[0] - ends[1]) / 3) < 1e-6


def test_functions_with_units_and_at_the_end_of_a_range():
    system, state = fullbody.systems.kw4(units=True)
    orbit = fullbody.KeplerElements(1e7 * u.km, 0.0, 0.3, 0.1, 0.2, 0.4)
    sun = fullbody.forces.ThirdBody(mass=2e30 * u.kg, orbit=orbit, of="system", name="Sun")
    run = system.with_forces([sun]).integrate(state, 20.0, output=1.0, derivatives=["e of Sun", "mass of Sun"])
    found = run.derivative_of(lambda run: run.elements().a[-1], start=False)
    assert found.start is None
    assert found.value.unit == u.km
    # The last sample's own derivative, by the chain rule in differences of the elements.
    for name in run.sensitivity:
        columns, step = run.sensitivity[name][-1].reshape(2, 4, 3), 1e-3 / np.abs(run.sensitivity[name][-1]).max()
        ends = []
        for sign in (1, -1):
            position = run[-1].position.value + sign * step * columns[:, 0]
            velocity = run[-1].velocity.value + sign * step * columns[:, 1]
            r, v = position[1] - position[0], velocity[1] - velocity[0]
            ends.append(1.0 / (2.0 / np.linalg.norm(r) - v @ v / system.mu().value))
        assert worst(found.by_parameter[name], (ends[0] - ends[1]) / (2 * step)) < 1e-5


def test_functions_are_refused_what_a_displaced_run_does_not_have():
    system, state = fullbody.systems.kw4()
    tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01, name="tide")
    run = system.with_forces([tide]).integrate(state, 5.0, output=1.0, derivatives=["lag of tide"])
    refused("asks for its work", lambda: run.derivative_of(lambda run: run.work["tide"][-1]))
    refused("no continuous solution", lambda: run.derivative_of(lambda run: run(2.0).position[0]))
    refused("expected a function", lambda: run.derivative_of(3.0))
    refused("derivatives=True", lambda: system.integrate(state, 1.0).derivative_of(len))
