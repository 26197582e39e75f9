"""Derivatives at every event of a run, also with respect to the event's parameters, and of functions of a run."""

import astropy.units as u
import fullbody
import numpy as np
from support import refused, worst
from support.flows import TIGHT, central_of_state, deviation, displaced, scales, tumbling
from support.meshes import octahedron

EVENTS = [
    fullbody.events.Separation("A", "B", 2.5),
    fullbody.events.Periapsis("A", "B"),
    fullbody.events.Apoapsis("A", "B"),
    fullbody.events.PlaneCrossing("B", "A", normal=[0.2, 1.0, 0.3]),
    fullbody.events.Function(lambda state: np.sin(state.attitude[0][1]) - 0.3 * state.spin[1][0]),
]


def test_derivatives_at_every_event_are_differences():
    system, state = tumbling()
    size = scales(system, state)
    options = {"output": "ends", "integrator": TIGHT, "events": EVENTS}
    run = system.integrate(state, -32.0, derivatives=["G", "semi-axis a of A"], **options)
    assert {happened.event for happened in run.events} == {*EVENTS}
    count = len(run.events)

    def happening(by, index=None):
        """Times of the events and the states then, from the ones of the run, in natural sizes."""
        start = state if index is None else displaced(state, *index, by * size[12 * index[0] + 3 * index[1] + index[2]])
        other = fullbody.System(system.bodies, G=1.0 + (by if index is None else 0.0))
        events = other.integrate(start, -32.0, **options).events
        assert len(events) == count
        rows = (deviation(original.state, e.state) / size for original, e in zip(run.events, events, strict=True))
        return np.array([[e.time, *row] for e, row in zip(events, rows, strict=True)])

    ends = [run.at_event(k) for k in range(count)]
    longest = max(np.abs(end.time * size).max() for end in ends)
    for index in (None, (1, 0, 1), (0, 2, 0)):
        expected = central_of_state(lambda by, index=index: happening(by, index), 1e-4)
        for end, (time, *numbers) in zip(ends, expected, strict=True):
            if index is None:
                result, columns = end.time_sensitivity["G"], end.sensitivity["G"]
            else:
                k = 12 * index[0] + 3 * index[1] + index[2]
                result, columns = end.time[k] * size[k], end.transition[:, k] * size[k]
            assert abs(result - time) < 1e-7 * longest
            assert worst(columns / size, numbers) < 1e-6


def test_the_time_of_contact_changes_with_the_scale_of_a_polyhedron():
    system, state = tumbling()
    solid = octahedron(0.8, 0.6, 0.7)

    def ended(by, parameters=False):
        shape = fullbody.Polyhedron((1.0 + by) * np.array(solid.vertices), solid.faces)
        start = state.replace(velocity=[state.velocity[0], [-0.4, 0.05, 0.1]])
        options = {"output": "ends", "events": [fullbody.events.Contact("A", "B", terminal=True)]}
        return system.with_body("B", shape).integrate(start, 10.0, derivatives=parameters, **options)

    run = ended(0.0, ["scale of B"])
    time = (ended(1e-4).time[-1] - ended(-1e-4).time[-1]) / 2e-4
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
    result = run.derivative_of(measures)
    assert np.array_equal(result.value, measures(run))
    size = scales(system, state)
    scale = np.abs(result.start * size).max(axis=1)
    for k in (1, 14, 20):

        def moved(by, k=k):
            start = displaced(state, k // 12, k % 12 // 3, k % 3, by * size[k])
            return measures(system.integrate(start, 70.0, **options))

        assert worst(result.start[:, k] * size[k] / scale, central_of_state(moved, 1e-4) / scale, 1.0) < 1e-6
    for name in names:
        changed = central_of_state(
            lambda by, name=name: measures(system.changed(name, by).integrate(state, 70.0, **options)), 1e-4
        )
        assert worst(result.by_parameter[name], changed) < 1e-6


def test_functions_with_units_and_at_the_end_of_a_range():
    system, state = fullbody.systems.kw4(units=True)
    orbit = fullbody.KeplerElements(1e7 * u.km, 0.0, 0.3, 0.1, 0.2, 0.4)
    sun = fullbody.forces.ThirdBody(mass=2e30 * u.kg, orbit=orbit, of="system", name="Sun")
    run = system.with_forces([sun]).integrate(state, 20.0, output=1.0, derivatives=["e of Sun", "mass of Sun"])
    result = run.derivative_of(lambda run: run.elements().a[-1], start=False)
    assert result.start is None
    assert result.value.unit == u.km
    # The last sample's own derivative, by the chain rule in differences of the elements.
    for name in run.sensitivity:
        columns, step = run.sensitivity[name][-1].reshape(2, 4, 3), 1e-3 / np.abs(run.sensitivity[name][-1]).max()
        ends = []
        for sign in (1, -1):
            position = run[-1].position.value + sign * step * columns[:, 0]
            velocity = run[-1].velocity.value + sign * step * columns[:, 1]
            r, v = position[1] - position[0], velocity[1] - velocity[0]
            ends.append(1.0 / (2.0 / np.linalg.norm(r) - v @ v / system.mu().value))
        assert worst(result.by_parameter[name], (ends[0] - ends[1]) / (2 * step)) < 1e-5


def test_functions_of_a_run_cannot_use_attributes_of_a_displaced_run():
    system, state = fullbody.systems.kw4()
    tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01, name="tide")
    run = system.with_forces([tide]).integrate(state, 5.0, output=1.0, derivatives=["lag of tide"])
    refused("uses its work", lambda: run.derivative_of(lambda run: run.work["tide"][-1]))
    refused("no continuous solution", lambda: run.derivative_of(lambda run: run(2.0).position[0]))
    refused("expected a function", lambda: run.derivative_of(3.0))
    refused("derivatives=True", lambda: system.integrate(state, 1.0).derivative_of(len))
