"""Mutual events: contacts of spheres in closed form, and what is refused."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import observing
from fullbody.errors import InconsistentInput, InvalidInput
from support import body_list, refused
from support.meshes import box

A, R1, R2 = 10.0, 1.5, 1.0
#: Both to the observer and to the Sun along the axis in the orbit's plane.
AXIS = [1.0, 0.0, 0.0]


def circular(inclination=0.0, until=2.4 * np.pi, **options):
    """Two spheres on a circular orbit of period 2 pi, inclined to the direction to the observer; a run and its start.

    Body B begins at its largest distance from the line of sight, moving behind body A.
    """
    bodies = body_list(A=(fullbody.Sphere(R1), 0.7), B=(fullbody.Sphere(R2), 0.3))
    system = fullbody.System(bodies, G=A**3, gravity="point", **options)
    r, v = A * np.array([0.0, 1.0, 0.0]), A * np.array([-np.cos(inclination), 0.0, -np.sin(inclination)])
    state = fullbody.State(position=np.outer([-0.3, 0.7], r), velocity=np.outer([-0.3, 0.7], v))
    return system, state, system.integrate(state, until, dense=True)


def view(span=20.0, **options):
    options = {"to_observer": AXIS, "to_sun": AXIS, "light_time": False} | options
    return observing.Geometry([-span, span], **options)


def contacts(radius, inclination):
    """Times from conjunction at which the centres are `radius` apart in the sky, on the orbit above."""
    # The distance in the sky is a sqrt(sin^2 t + cos^2 t sin^2 i).
    return np.arcsin(np.sqrt((radius**2 / A**2 - np.sin(inclination) ** 2) / np.cos(inclination) ** 2))


@pytest.mark.parametrize("inclination", [0.0, 0.03, 0.15, 0.2])
def test_contacts_of_spheres_on_a_circular_orbit_are_those_of_geometry(inclination):
    _, _, run = circular(inclination)
    result = observing.mutual_events(run, view())
    behind, front = 0.5 * np.pi, 1.5 * np.pi
    half = contacts(R1 + R2, inclination)
    inner = contacts(R1 - R2, inclination) if A * np.sin(inclination) < R1 - R2 else None
    for kind in ("occultation", "eclipse"):
        first, second = (event for event in result if event.kind == kind)
        assert (first.body, first.by, second.body, second.by) == ("B", "A", "A", "B")
        for event, middle in ((first, behind), (second, front)):
            assert event.begin == pytest.approx(middle - half, abs=1e-11)
            assert event.end == pytest.approx(middle + half, abs=1e-11)
            assert event.middle == pytest.approx(middle, abs=1e-11)
        assert second.total_begin is None
        if inner is None:
            assert first.total_begin is None
        else:
            assert first.total_begin == pytest.approx(behind - inner, abs=1e-10)
            assert first.total_end == pytest.approx(behind + inner, abs=1e-10)
    assert [event.begin for event in result] == sorted(event.begin for event in result)


def test_an_event_that_only_grazes_is_found_between_samples():
    for deep, count in ((1e-9, 2), (-1e-9, 0)):
        inclination = np.arcsin((R1 + R2) / A * (1.0 - deep))
        _, _, run = circular(inclination)
        result = observing.mutual_events(run, view(to_sun=None))
        assert len(result) == count
        for event in result:
            assert event.duration == pytest.approx(2 * contacts(R1 + R2, inclination), rel=1e-3)


def test_events_are_the_same_backwards_and_their_ends_are_those_of_the_run():
    system, state, run = circular(0.05)
    forward = observing.mutual_events(run, view())
    back = observing.mutual_events(system.integrate(run[-1], 0.0, dense=True), view())
    assert len(forward) == len(back) == 4
    for first, other in zip(forward, back, strict=True):
        assert (first.kind, first.body) == (other.kind, other.body)
        assert other.begin == pytest.approx(first.begin, abs=1e-9)
    middle = forward[0].middle
    (cut,) = observing.mutual_events(system.integrate(state, middle, dense=True), view(to_sun=None))
    assert cut.begin == pytest.approx(forward[0].begin, abs=1e-11)
    assert cut.end is cut.total_end is cut.duration is cut.middle is None
    (remaining,) = observing.mutual_events(system.integrate(run(middle), middle + 1.0, dense=True), view(to_sun=None))
    assert remaining.begin is remaining.total_begin is None
    assert remaining.end == pytest.approx(forward[0].end, abs=1e-10)


def test_composites_and_polyhedra_of_a_shape_have_nearly_its_events():
    small = fullbody.Body(fullbody.Sphere(0.5), mass=0.3, name="B")
    dumb_bell = fullbody.Composite(
        [fullbody.Part(fullbody.Sphere(1.0), mass=0.35, position=[side, 0, 0]) for side in (-1.0, 1.0)]
    )
    for shape, radius in ((box(2.0, 2.0, 2.0), 1.0), (dumb_bell, 2.0)):
        big = fullbody.Body(shape, **({"mass": 0.7} if radius == 1.0 else {}), name="A")
        system = fullbody.System([big, small], G=A**3, gravity="point")
        # The big body does not turn: its x-axis is across the line of sight, along y.
        still = [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)] if radius == 2.0 else [1.0, 0, 0, 0]
        r, v = [0.0, A, 0.0], [-A, 0.0, 0.0]
        state = fullbody.State(np.outer([-0.3, 0.7], r), np.outer([-0.3, 0.7], v), [still, [1.0, 0, 0, 0]])
        (event,) = observing.mutual_events(system.integrate(state, 3.0, dense=True), view(to_sun=None))
        half = np.arcsin((radius + 0.5) / A)
        assert event.begin == pytest.approx(0.5 * np.pi - half, abs=1e-9)
        assert event.end == pytest.approx(0.5 * np.pi + half, abs=1e-9)
        assert event.total_begin is not None


def test_light_takes_its_time_from_the_sun_past_one_body_to_the_other_and_on():
    # Body B stands still; body A passes between it and the Sun, at rest relative to the barycentre but for that.
    bodies = [fullbody.Body(fullbody.Sphere(r), mass=m, name=n) for r, m, n in ((3e3, 1.0, "A"), (1e3, 1e-9, "B"))]
    system = fullbody.System(bodies, G=1e-30, gravity="point", units=("km", "s", "kg"), frame="ecliptic")
    height, speed = 6.0e6, 500.0
    position = np.array([[0.0, -speed * 100, 0.0], [-height, 0.0, 0.0]])
    velocity = np.array([[0.0, speed, 0.0], [0.0, 0.0, 0.0]])
    with pytest.warns(InconsistentInput, match="speed of escape"):
        run = system.integrate(fullbody.State(position=position, velocity=velocity), 200.0, dense=True)
    c, distance = 299792.458, 3.0e9
    # The barycentre is A's centre: the observer and the Sun go along with it.
    geometry = observing.Geometry(
        [-1e5, 1e5] * u.s, to_observer=[0, 0, distance] * u.km, to_sun=[distance, 0, 0] * u.km
    )
    (event,) = [eclipse for eclipse in observing.mutual_events(run, geometry) if eclipse.kind == "eclipse"]
    for time, side in ((event.begin, 1.0), (event.end, -1.0)):
        # Both are tangent to one ray from the Sun when the light arrives that grazes A: it leaves B then for the
        # observer, who is above A. B is above the axis by 50,000 km - 500 km/s t in the frame of A.
        edge = 4e3
        for _ in range(20):
            edge = (distance + height) * np.tan(
                np.arcsin(3e3 / distance) + np.arcsin(1e3 / np.hypot(distance + height, edge))
            )
        left = 100.0 - side * edge / speed
        length = np.sqrt(distance**2 + height**2 + edge**2)
        assert time.to_value("s") == pytest.approx(left + length / c, abs=1e-7)
    instant = observing.Geometry(
        [-1e5, 1e5] * u.s, to_observer=[0, 0, distance], to_sun=[distance, 0, 0], light_time=False
    )
    (instant,) = (eclipse for eclipse in observing.mutual_events(run, instant) if eclipse.kind == "eclipse")
    assert instant.begin.to_value("s") == pytest.approx(100 - 8.0, abs=1e-6)


def test_a_run_ends_where_an_occultation_begins():
    system, state, run = circular(0.05)
    first = observing.mutual_events(run, view())[0]
    condition = observing.occultation(system, view(), "B", "A", direction=-1, terminal=True)
    stopped = system.integrate(state, 10.0, events=[condition])
    assert stopped.stop_reason == "event"
    assert stopped.time[-1] == pytest.approx(first.begin, abs=1e-11)
    total = fullbody.events.Occultation("B", "A", toward=AXIS, total=True)
    times = [event.time for event in system.integrate(state, 4.0, events=[total]).events]
    np.testing.assert_allclose(times, [first.total_begin, first.total_end], atol=1e-10)
    # The derivative of the time of the event by the start, also where the direction moves.
    times = np.linspace(0.0, 10.0, 41)
    toward = np.stack([np.cos(0.1 * times), np.sin(0.1 * times), 0.0 * times], axis=1)
    for path in ({"toward": AXIS}, {"toward": toward, "times": times}):
        condition = fullbody.events.Occultation("B", "A", **path, direction=-1, terminal=True)
        ended = system.integrate(state, 10.0, events=[condition], derivatives=True).at_event(-1)
        ends = [state.replace(position=np.add(state.position, [[0, 0, 0], [0, by, 0]])) for by in (1e-4, -1e-4)]
        last, first_time = (system.integrate(displaced, 10.0, events=[condition]).time[-1] for displaced in ends)
        assert ended.time[13] == pytest.approx((last - first_time) / 2e-4, rel=1e-6)


def test_time_of_an_occultation_follows_the_semi_axes():
    system, state, _ = circular(0.05)
    condition = fullbody.events.Occultation("B", "A", toward=AXIS, direction=-1, terminal=True)
    names = [f"semi-axis {axis} of {body}" for body in "AB" for axis in "abc"]
    ended = system.integrate(state, 10.0, events=[condition], derivatives=names).at_event(-1)
    # The outlines are in the plane of y and z, and the bodies do not turn: along the line of the centres both radii
    # grow by (y^2 db + z^2 dc) / (y^2 + z^2).
    begin = 0.5 * np.pi - contacts(R1 + R2, 0.05)
    y, z = np.cos(begin), np.sin(begin) * np.sin(0.05)
    share = np.square([0.0, y, z]) / (y * y + z * z)
    # d(half)/d(reach) by the closed form, with reach = R1 + R2.
    slope = (contacts(R1 + R2 + 1e-5, 0.05) - contacts(R1 + R2 - 1e-5, 0.05)) / 2e-5
    expected = -slope * np.tile(share, 2)
    np.testing.assert_allclose([ended.time_sensitivity[name] for name in names], expected, atol=1e-7)


def test_events_are_kept_in_files(tmp_path):
    system, state, _ = circular(0.05)
    table = {"toward": np.array([AXIS] * 5), "times": np.arange(5.0)}
    run = system.integrate(state, 4.0, events=[fullbody.events.Occultation("B", "A", **table)])
    run.save(tmp_path / "run.nc")
    assert fullbody.load(tmp_path / "run.nc").events == run.events


def test_bad_geometries_and_occultations_are_refused():
    system, state, run = circular()
    refused("integrate with dense=True", lambda: observing.mutual_events(system.integrate(state, 1.0), view()))
    with pytest.raises(InvalidInput, match="no time in common"):
        observing.mutual_events(run, observing.Geometry([50.0, 60.0], to_observer=AXIS, light_time=False))
    # At time zero body A is at y = -3.
    inside = view(to_observer=[0.0, -3.2, 0.1])
    refused(r"the observer of the geometry is inside A at time 0\.0", lambda: observing.mutual_events(run, inside))
    refused("the Sun of the geometry is inside A at time", observing.mutual_events, run, view(to_sun=[0.0, -3.2, 0.1]))
    refused("the observer of the geometry is inside A at time", lambda: observing.light_curve(run, [0.5, 0.01], inside))
    refused("kind is 'transit'", lambda: observing.occultation(system, view(), "B", "A", kind="transit"))
    refused("toward of Occultation is not given", lambda: fullbody.events.Occultation(0, 1))
    refused("toward of Occultation has shape", lambda: fullbody.events.Occultation(0, 1, toward=[AXIS, AXIS]))
    short = fullbody.events.Occultation(1, 0, toward=[AXIS] * 4, times=[0.0, 0.5, 1.0, 1.5])
    refused(r"time of Occultation is 1\.5.*; expected one from 0 to 1\.5", system.integrate, state, 3.0, events=[short])
