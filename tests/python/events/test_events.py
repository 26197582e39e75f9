"""Events and dense output through Python, against closed forms."""

import fullbody
import numpy as np
import pytest
from fullbody import events, forces
from support import points, refused, worst

CASE1 = fullbody.systems.case1()


def ellipse(e=0.4, mean_anomaly=0.0, inclination=0.0, **options):
    """Two points with a = 1 and mu = 1, so that one turn takes 2 pi; the centre of mass rests at the origin."""
    system = points(0.6, 0.4, **options)
    orbit = fullbody.KeplerElements(a=1.0, e=e, i=inclination, Omega=0.0, omega=0.0, M=mean_anomaly)
    r, v = orbit.to_cartesian(1.0)
    return system, fullbody.State(np.outer([-0.4, 0.6], r), np.outer([-0.4, 0.6], v))


def times(run, event=None):
    return np.array([float(o.time) for o in run.events if event is None or o.event is event])


def test_apsides_of_an_ellipse_are_at_keplers_times():
    system, state = ellipse(mean_anomaly=-1.0)
    near, far = events.Periapsis(0, 1), events.Apoapsis(0, 1)
    run = system.integrate(state, 20.0, output=[20.0], events=[near, far])
    assert times(run, near) == pytest.approx(1.0 + 2 * np.pi * np.arange(4), abs=1e-11)
    assert times(run, far) == pytest.approx(1.0 + np.pi + 2 * np.pi * np.arange(3), abs=1e-11)
    for occurrence in run.events:
        distance = np.linalg.norm(occurrence.state.position[1] - occurrence.state.position[0])
        assert distance == pytest.approx(0.6 if occurrence.event is near else 1.4, abs=1e-12)
    assert run.stop_reason == "end"


def test_events_come_in_order_of_time():
    system, state = ellipse(mean_anomaly=-1.0)
    watched = [
        events.Apoapsis(),
        events.Separation(value=1.2),
        events.Function(lambda s: s.velocity[0, 0]),
        events.Separation(value=0.8),
        events.Periapsis(),
    ]
    run = system.integrate(state, 40.0, output=[], events=watched)
    assert (np.diff(times(run)) > 0).all()
    assert {id(o.event) for o in run.events} == {id(event) for event in watched}
    back = system.integrate(state, -40.0, output=[], events=watched)
    assert (np.diff(times(back)) < 0).all()
    # Together or alone: an event is found at the same time.
    for event in watched:
        alone = system.integrate(state, 40.0, output=[], events=[event])
        assert times(alone) == pytest.approx(times(run, event), abs=1e-12)


def kepler_time(r, e=0.4):
    """Time from periapsis to a distance, on the way out."""
    E = np.arccos((1 - r) / e)
    return E - e * np.sin(E)


def test_separation_is_passed_at_keplers_time_in_its_direction():
    system, state = ellipse()
    out, period = kepler_time(1.2), 2 * np.pi
    for direction, expected in ((0, [out, period - out, period + out]), (1, [out, period + out]), (-1, [period - out])):
        run = system.integrate(state, 9.0, events=[events.Separation(0, 1, 1.2, direction=direction)])
        assert times(run) == pytest.approx(expected, abs=1e-12)
    # Backwards the same zeros; a direction is that of growing time.
    for direction, expected in ((0, [-out, out - period]), (1, [out - period]), (-1, [-out])):
        run = system.integrate(state, -7.0, events=[events.Separation(0, 1, 1.2, direction=direction)])
        assert times(run) == pytest.approx(expected, abs=1e-12)


def test_separation_with_units():
    from astropy import units as u

    mass = (6e24 * u.kg / 2).to(u.kg)
    system = fullbody.System([fullbody.Body(fullbody.PointMass(), mass=mass)] * 2, units=("km", "hour", "kg"))
    a = 50000 * u.km
    r, v = fullbody.KeplerElements(a, 0.4, 0, 0, 0, 0).to_cartesian(system.mu())
    state = fullbody.State([-0.5 * r, 0.5 * r], [-0.5 * v, 0.5 * v])
    unit = np.sqrt(a**3 / system.mu()).to(u.h)
    for value in (60000 * u.km, 6e7 * u.m, 60000.0):
        run = system.integrate(state, 3 * unit, events=[events.Separation(0, 1, value, terminal=True)])
        (occurrence,) = run.events
        assert occurrence.time.unit == u.h
        assert (occurrence.time / unit).to_value("") == pytest.approx(kepler_time(1.2), abs=1e-12)
        assert run.time[-1] == occurrence.time


def falling(shape=None):
    """Two spheres of radii 0.3 and 0.2 and mu = 2 at rest, 2 apart; and the time at which they touch."""
    bodies = [fullbody.Body(fullbody.Sphere(0.3), mass=1.5), fullbody.Body(shape or fullbody.Sphere(0.2), mass=0.5)]
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State([[-0.5, 0, 0], [1.5, 0, 0]], np.zeros((2, 3)), time=3.0)
    x = 0.5 / 2.0
    return system, state, 3.0 + np.sqrt(2.0**3 / (2 * 2.0)) * (np.arccos(np.sqrt(x)) + np.sqrt(x * (1 - x)))


@pytest.mark.parametrize("shape", [fullbody.Sphere(0.2), fullbody.Ellipsoid(0.2, 0.2, 0.2)], ids=["ball", "ellipsoid"])
def test_radial_fall_ends_by_contact(shape):
    system, state, expected = falling(shape)
    contact = events.Contact(0, 1, terminal=True)
    run = system.integrate(state, 100.0, events=[events.Separation(0, 1, 1.0), contact])
    assert run.stop_reason == "event"
    assert run.events[-1].event is contact
    assert run.events[-1].time == pytest.approx(expected, abs=1e-12)
    assert run.time[-1] == run.events[-1].time
    assert run[-1] == run.events[-1].state
    assert np.ptp(run.position[-1, :, 0]) == pytest.approx(0.5, abs=1e-12)
    # Energy of the fall from rest.
    assert np.ptp(run.velocity[-1, :, 0]) == pytest.approx(np.sqrt(2 * 2.0 * (1 / 0.5 - 1 / 2.0)), rel=1e-12)
    # Samples before the event remain.
    same = system.integrate(state, 100.0, output=[3.5, 4.0, 100.0], events=[contact])
    assert same.time.tolist() == [3.5, 4.0, same.events[-1].time]


@pytest.mark.parametrize("name", fullbody.record.integrators.__all__)
def test_events_of_every_integrator(name):
    make = getattr(fullbody.record.integrators, name)
    integrator = make(1e-11, 1e-11) if hasattr(make, "rtol") else make(0.002)
    system, state = ellipse(mean_anomaly=-1.0)
    near = events.Periapsis(terminal=True)
    run = system.integrate(state, 20.0, integrator=integrator, events=[near])
    assert run.stop_reason == "event"
    assert run.events[-1].event is near
    assert run.events[-1].time == pytest.approx(1.0, abs=1e-4 if name == "LieGroupVariational" else 1e-8)


def test_function_receives_a_state_and_may_give_a_quantity():
    from astropy import units as u

    system, state = fullbody.systems.kw4(units=True)
    seen = []

    def height(present):
        assert isinstance(present, fullbody.State)
        seen.append(present.time)
        return present.position[1, 0] - present.position[0, 0]

    crossing = events.Function(height, terminal=True)
    run = system.integrate(state, 30 * u.h, events=[crossing])
    assert all(time.unit == u.h for time in seen)
    assert run.events[0].event is crossing
    relative = run.events[0].state.position[1] - run.events[0].state.position[0]
    assert relative.unit == u.km
    assert abs(relative[0]).to_value(u.km) < 1e-13
    assert run.time[-1] == run.events[0].time


def test_an_exception_in_a_function_propagates():
    class Enough(Exception):
        pass

    def fail(state):
        if state.time > 5.0:
            raise Enough(state.time)
        return 1.0

    sim = fullbody.Simulation(*CASE1)
    with pytest.raises(Enough):
        sim.integrate(20.0, events=[events.Function(fail)])
    # Stopped, not broken.
    assert 0.0 < sim.time < 20.0
    run = sim.integrate(20.0, output=[20.0])
    expected = CASE1[0].integrate(CASE1[1], 20.0, output=[20.0])
    assert worst(run.position, expected.position) < 1e-12
    for value, message in (
        (None, "value of the function .*<lambda> is None; expected numbers"),
        ("x", "value of the function .*<lambda> is 'x'; expected numbers"),
        (np.ones(2), r"value of the function .*<lambda> has shape \(2,\); expected a single number"),
        (np.nan, r"value of the function .*<lambda> is nan at time 2\d.*; expected a finite number"),
        (np.inf, r"value of the function .*<lambda> is inf at time 2\d.*; expected a finite number"),
    ):
        watched = [events.Function(lambda s, value=value: value)]
        refused(message, lambda watched=watched: sim.integrate(30.0, events=watched))


def test_nodes_of_an_inclined_circle_are_half_turns_apart():
    # The height on the circle is z = sin(i) sin(t).
    system, state = ellipse(e=0.0, inclination=0.7, mean_anomaly=-0.5)
    for direction, first in ((1, 0.5), (-1, 0.5 + np.pi)):
        node = events.PlaneCrossing(1, 0, direction=direction)
        run = system.integrate(state, 13.0, output=[], events=[node])
        assert times(run) == pytest.approx(np.arange(first, 13.0, 2 * np.pi), abs=1e-11)
    # Any plane and any length of its normal; body 0 about the origin is opposite.
    x_zero = events.PlaneCrossing(0, None, normal=[-250.0, 0.0, 0.0], direction=1)
    run = system.integrate(state, 13.0, output=[], events=[x_zero])
    assert times(run) == pytest.approx(0.5 + 1.5 * np.pi + 2 * np.pi * np.arange(2), abs=1e-11)


def test_escape_on_a_hyperbola_is_at_keplers_time_and_never_on_an_ellipse():
    # With a = 1 and e = 1.5, r = e cosh H - 1 at t = e sinh H - H.
    system = points(0.6, 0.4)
    r, v = np.array([0.5, 0, 0]), np.array([0, np.sqrt(2.5 / 0.5), 0])
    state = fullbody.State(np.outer([-0.4, 0.6], r), np.outer([-0.4, 0.6], v))
    escape = events.Escape(0, 1, 8.0, terminal=True)
    run = system.integrate(state, 100.0, events=[escape])
    H = np.arccosh(9.0 / 1.5)
    assert run.stop_reason == "event"
    assert run.time[-1] == pytest.approx(1.5 * np.sinh(H) - H, abs=1e-12)
    bound, start = ellipse(e=0.9)
    assert bound.integrate(start, 10.0, events=[events.Escape(0, 1, 1.5)]).events == []


def test_a_free_rotator_is_aligned_every_half_turn():
    bodies = [fullbody.Body(fullbody.Ellipsoid(1.0, 0.8, 0.7), mass=1.0), fullbody.Body(fullbody.PointMass(), mass=1.0)]
    system = fullbody.System(bodies, G=1e-18)
    spin = [[0, 0, 0.5], [0, 0, 0]]
    state = fullbody.State.from_tait_bryan([[0, 0, 0], [9, 0, 0]], np.zeros((2, 3)), [[0, 0, -1.0], [0, 0, 0]], spin)
    run = system.integrate(state, 20.0, output=[], events=[events.Alignment(0, 1)])
    assert times(run) == pytest.approx(np.arange(2.0, 20.0, 2 * np.pi), abs=1e-11)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: events.Contact(0, 5), "about of Contact is 5; expected 0 to 1, one of the 2 bodies"),
        (lambda: events.Contact(1, 1), "bodies of Contact is 1 twice; expected two bodies"),
        (lambda: events.Contact(-1, 1), "body of Contact is -1; expected 0 to 1"),
        (lambda: events.Contact(10**30, 1), "body of Contact is 1000000.*; expected 0 to 1"),
        (lambda: events.Contact(0, 1.0), "about of Contact is 1.0; expected 0 to 1"),
        (lambda: events.PlaneCrossing("Beta"), "body of PlaneCrossing is 'Beta'; expected one of "),
        (lambda: events.PlaneCrossing(1, 1), "bodies of PlaneCrossing is 1 twice; expected two bodies"),
        (lambda: events.PlaneCrossing(normal=[0, 1]), r"normal of PlaneCrossing has shape \(2,\); expected \(3,\)"),
        (lambda: events.PlaneCrossing(normal=[0, 0, 0]), "normal of PlaneCrossing is .* not all zero"),
        (lambda: events.PlaneCrossing(normal=[0, np.inf, 0]), "normal of PlaneCrossing is .*inf.*; expected finite"),
        (lambda: events.Alignment(0, 1), r"shape of A is .*; expected one longest axis"),
        (lambda: events.Function(None), "f of Function is None; expected a function of a State"),
        (lambda: events.Contact(direction=2), "direction of Contact is 2; expected -1, 0 or 1"),
        (lambda: events.Contact(direction=1.0), "direction of Contact is 1.0; expected -1, 0 or 1"),
        (lambda: events.Contact(direction=np.ones(2)), "direction of Contact is array.*; expected -1, 0 or 1"),
        (lambda: events.Periapsis(direction=-1), "direction of Periapsis is -1; expected 0 or 1"),
        (lambda: events.Apoapsis(direction=1), "direction of Apoapsis is 1; expected 0 or -1"),
        (lambda: "contact", "events has 'contact'; expected fullbody.events"),
        (lambda: events.ClosestApproach("Earth"), "expected a ThirdBody of the system, which has none"),
    ],
)
def test_bad_events_are_refused(make, message):
    system, state = CASE1
    refused(message, lambda: system.integrate(state, 1.0, events=[make()]))
    refused(r"events is .*; expected a list", lambda: system.integrate(state, 1.0, events=events.Contact()))


def test_a_function_event_needs_its_function():
    with pytest.raises(TypeError, match="'f'"):
        events.Function()


def test_numpy_integers_are_indices_of_bodies():
    system, state = ellipse()
    event = events.Periapsis(np.int64(0), np.int32(1), direction=np.int8(1))
    assert len(system.integrate(state, 7.0, events=[event]).events) == 1


def test_a_thinned_run_keeps_its_events():
    system, state = ellipse(mean_anomaly=-1.0)
    run = system.integrate(state, 20.0, events=[events.Periapsis(terminal=True)], dense=True)
    thin = run[::2]
    assert thin.events == run.events
    assert thin.stop_reason == "event"
    assert thin(0.5) == run(0.5)


# Dense output


@pytest.mark.parametrize("chart", ["quaternion", "tait_bryan"])
@pytest.mark.parametrize("until", [40.0, -40.0])
def test_the_continuous_solution_equals_a_run_of_tight_tolerance(chart, until):
    system, state = fullbody.systems.case1(attitude_chart=chart)
    run = system.integrate(state, until, output=[], integrator=fullbody.Verner98(1e-11, 1e-11), dense=True)
    t = np.linspace(0.0, until, 101)
    tight = system.integrate(state, until, output=t, integrator=fullbody.Verner98(1e-14, 1e-14))
    samples = run(t)
    assert worst(samples.position, tight.position) < 1e-9
    assert worst(samples.attitude, tight.attitude, 1.0) < 1e-9
    assert run.dense.range == (0.0, until)
    # The steps are those of a run that keeps nothing.
    free = system.integrate(state, until, output=[until], integrator=fullbody.Verner98(1e-11, 1e-11))
    assert run.statistics.steps == free.statistics.steps
    assert worst(run(until).position, free.position[-1]) < 1e-14


def test_the_continuous_solution_has_units():
    from astropy import units as u

    system, state = fullbody.systems.kw4(units=True)
    run = system.integrate(state, 1 * u.day, dense=True)
    assert run.dense.range == (0 * u.h, 24 * u.h)
    assert run(90 * u.min) == run(1.5 * u.h) == run(1.5)
    samples = run([30, 90] * u.min)
    assert samples.time.unit == u.h
    assert samples.position.unit == u.km
    assert samples.velocity.unit == u.km / u.h
    assert (samples.position[1] == run(1.5).position).all()
    refused("time has the unit km; expected a unit such as h", lambda: run(1 * u.km))


def test_the_continuous_solution_refuses_times_outside_it():
    system, state = CASE1
    run = system.integrate(state, 10.0, dense=True)
    for time in (10.0 + 1e-9, -1e-9, np.nan, np.inf, [1.0, 11.0]):
        refused(r"time is .*; expected one from 0.0 to 10.0, since the run does not cover", lambda time=time: run(time))
    refused(r"time has shape \(1, 1\); expected a number or \(K,\)", lambda: run([[1.0]]))
    refused("time is 'noon'; expected numbers", lambda: run("noon"))
    assert run([]).position.shape[0] == 0
    refused("integrate with dense=True", lambda: system.integrate(state, 1.0)(0.5))
    assert "MB" in repr(run.dense)


MU = 3.986e5 * 3600.0**2


def passing(of="body"):
    """1999 KW4 with the Earth on a hyperbola of 80,000 km, nearest at 10 h."""
    system, state = fullbody.systems.kw4()
    orbit = fullbody.KeplerElements(a=-1.0e4, e=9.0, i=0.4, Omega=1.0, omega=2.0, M=0.0)
    earth = forces.ThirdBody(mu=MU, orbit=orbit, of=of, time=10.0, name="Earth")
    tide = forces.Tide("Alpha", "Beta", k2=1e-5, lag=0.01)
    return system.with_forces([tide, earth]), state


@pytest.mark.parametrize("of", ["body", "system"])
def test_the_closest_approach_is_the_periapsis_of_the_orbit_and_may_end_the_run(of):
    system, state = passing(of)
    approach = events.ClosestApproach("Earth", terminal=True)
    for start, until in ((0.0, 30.0), (30.0, 0.0)):
        run = system.integrate(state.replace(time=start), until, events=[approach])
        (happened,) = run.events
        # The pull on the pair's quadrupole moves the barycentre by less than the tolerance.
        assert abs(happened.time - 10.0) < 1e-7
        assert run.time[-1] == happened.time
        assert run.stop_reason == "event"
    distance = np.linalg.norm(system.third_body("Earth", happened.time)[0])
    assert distance == pytest.approx(1.0e4 * 8.0, rel=1e-12)
