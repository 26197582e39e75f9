"""Sudden changes of one body, by the equations of Clohessy and Wiltshire, vis-viva and the momentum of a projectile."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import observables
from support import body_list, matrix, points, ready, refused, rot_x, rot_y, rot_z

Q = np.array([0.3, -0.5, 0.7, 0.2]) / np.linalg.norm([0.3, -0.5, 0.7, 0.2])


def circle(n=1.0):
    """A light point on a circle of radius one about a heavy one, in a plane that is none of the axes'."""
    system = points(1.0 - 1e-9, 1e-9, G=n**2)
    r, v = fullbody.KeplerElements(1.0, 0.0, 0.7, 0.4, 0.0, 0.3).to_cartesian(n**2)
    return system, fullbody.State([0 * r, r], [0 * v, v])


def local(run, other):
    """The second body of a run from that of another, in the other's radial, transverse and normal axes."""
    r, v = (name[:, 1] - name[:, 0] for name in (other.position, other.velocity))
    radial = r / np.linalg.norm(r, axis=1)[:, None]
    normal = np.cross(r, v)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    axes = np.stack([radial, np.cross(normal, radial), normal], axis=2)
    return np.einsum("kji,kj->ki", axes, run.position[:, 1] - run.position[:, 0] - r)


@pytest.mark.parametrize("point", [0, 1, 2])
def test_a_kick_starts_the_motion_of_clohessy_and_wiltshire(point):
    """The chaser starts with a velocity alone (Clohessy & Wiltshire 1960, J. Aerosp. Sci. 27, 653)."""
    n, speed = 1.3, 1e-6
    system, state = circle(n)
    dv = speed * np.eye(3)[point]
    run, unitless = (system.integrate(start, 10.0, output=0.25) for start in (state.kick(1, dv, along="orbit"), state))
    t = unitless.time
    s, c, o = np.sin(n * t), np.cos(n * t), 0 * t
    expected = [
        np.stack([s, 2 * (c - 1), o], axis=1),
        np.stack([2 * (1 - c), 4 * s - 3 * n * t, o], axis=1),
        np.stack([o, o, s], axis=1),
    ][point] * (speed / n)
    # What first order leaves out is its square, with the time.
    np.testing.assert_allclose(local(run, unitless), expected, rtol=0, atol=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize("dv", [-0.1, 0.05, 0.3])
def test_a_kick_along_the_motion_changes_the_semi_major_axis_by_vis_viva(dv):
    system, state = circle()
    kicked_state = state.kick(1, [0.0, dv, 0.0], along="orbit", about=0)
    r, v = kicked_state.position[1] - kicked_state.position[0], kicked_state.velocity[1] - kicked_state.velocity[0]
    orbit = fullbody.KeplerElements.from_cartesian(r, v, 1.0)
    a = 1 / (2 - (1 + dv) ** 2)
    np.testing.assert_allclose([orbit.a, orbit.e], [a, abs(1 - 1 / a)], rtol=1e-12)
    np.testing.assert_allclose(orbit.i, 0.7, rtol=1e-12)
    run = system.integrate(kicked_state, 12 * np.pi, output=0.2)
    np.testing.assert_allclose(observables.orbit_shape(run).a, a, rtol=1e-9)


def test_a_kick_of_dart_changes_the_period_by_its_share():
    # The period of a light body changes by dP/P = 3 dv/v.
    system, previous = fullbody.systems.didymos(units=True, gravity="point")
    dv = -2.70 * u.mm / u.s
    kicked_state = previous.kick("Dimorphos", [0 * dv, dv, 0 * dv], along="orbit")
    assert kicked_state.velocity.unit == previous.velocity.unit
    gained = (system.momentum(kicked_state) - system.momentum(previous)).to_value(u.kg * u.mm / u.s)
    mass = system.masses[1].to_value(u.kg)
    np.testing.assert_allclose(np.linalg.norm(gained), mass * 2.70, rtol=1e-9)
    np.testing.assert_array_equal(kicked_state.velocity[0], previous.velocity[0])
    for name in ("position", "attitude", "spin"):
        np.testing.assert_array_equal(getattr(kicked_state, name), getattr(previous, name))
    speed = np.linalg.norm(previous.velocity[1] - previous.velocity[0]).to_value(u.mm / u.s)
    periods = [
        observables.mutual_period(system.integrate(state, "20 day", output="0.5 hour")).mean.value
        for state in (previous, kicked_state)
    ]
    np.testing.assert_allclose(periods[1] / periods[0] - 1, -3 * 2.70 / speed, rtol=0.05)


def test_kicks_may_be_given_in_body_or_inertial_axes():
    state = fullbody.State([[0, 0, 0], [2, 0, 0]], [[0, 0, 0], [0, 1, 0]], [[1, 0, 0, 0], Q], [[0, 0, 1], [1, 2, 3]])
    dv = np.array([0.1, -0.2, 0.3])
    for along, expected in (("inertial", dv), ("body", matrix(Q) @ dv), ("orbit", dv)):
        kicked = state.kick(1, dv, along=along)
        np.testing.assert_allclose(kicked.velocity[1] - state.velocity[1], expected, atol=1e-15)
        np.testing.assert_array_equal(kicked.velocity[0], state.velocity[0])
    # The radial direction of the heavier one points away from the other: here against x.
    kicked = state.kick(0, dv, along="orbit")
    np.testing.assert_allclose(kicked.velocity[0], dv * [-1, -1, 1], atol=1e-15)
    assert state.kick(1, dv) == state.kick(1, dv, along="inertial")
    assert state.kick(1, [0, 0, 0]) == state


@pytest.mark.parametrize("angle", [0.3, -2.0, 6.0])
def test_rotations_act_about_inertial_or_body_axes(angle):
    q = Q
    state = fullbody.State([[0, 0, 0], [0, 2, 0]], [[0, 0, 0], [-1, 0, 0]], [[1, 0, 0, 0], q], [[0, 0, 1], [1, 2, 3]])
    for axis, rotation in (([5, 0, 0], rot_x), ([0, 1e-200, 0], rot_y), ([0, 0, 1e200], rot_z)):
        by_body = state.rotated(1, axis, angle)
        np.testing.assert_allclose(by_body.rotation_matrix[1], matrix(q) @ rotation(angle), atol=1e-14)
        inertial = state.rotated(1, axis, angle, along="inertial")
        np.testing.assert_allclose(inertial.rotation_matrix[1], rotation(angle) @ matrix(q), atol=1e-14)
        for rotated_state in (by_body, inertial):
            np.testing.assert_array_equal(rotated_state.spin, state.spin)
            np.testing.assert_array_equal(rotated_state.attitude[0], state.attitude[0])
            np.testing.assert_array_equal(rotated_state.position, state.position)
            np.testing.assert_allclose(np.linalg.norm(rotated_state.attitude, axis=1), 1.0, rtol=1e-15)
    # Radial is y here, transverse is -x.
    orbit = state.rotated(1, [1, 0, 0], angle, along="orbit")
    np.testing.assert_allclose(orbit.rotation_matrix[1], rot_y(angle) @ matrix(q), atol=1e-14)
    orbit = state.rotated(1, [0, 1, 0], angle, along="orbit", about=0)
    np.testing.assert_allclose(orbit.rotation_matrix[1], rot_x(-angle) @ matrix(q), atol=1e-14)
    # Arguments may be Quantities.
    assert state.rotated(1, [1, 0, 0] * u.km, angle * u.rad) == state.rotated(1, [1, 0, 0], angle)
    np.testing.assert_allclose(
        state.rotated(1, [0, 0, 1], "90 deg").rotation_matrix[1], matrix(q) @ rot_z(np.pi / 2), atol=1e-14
    )


def test_rotations_are_roll_pitch_and_yaw():
    system, state = ready("didymos")
    for axis in np.eye(3):
        run = system.integrate(state.rotated("Dimorphos", axis, 0.2), 0.01)
        np.testing.assert_allclose(observables.roll_pitch_yaw(run)[0], 0.2 * axis, atol=1e-12)


def test_states_know_the_names_of_their_bodies():
    system, state = fullbody.systems.sn263_2001(gravity="point")
    dv = [1e-3, 0.0, 0.0]
    run = system.integrate(state, 1.0, dense=True, events=[fullbody.events.Separation(0, 2, 3.8)])
    simulation = fullbody.Simulation(system, state)
    for start in (state, run[0], simulation.state, run(0.5), state.replace(time=1.0), state.kick("Beta", dv)):
        assert start.kick("Gamma", dv, along="orbit", about="Alpha") == start.kick(2, dv, along="orbit", about=0)
    for happened in run.events:
        happened.state.kick("Gamma", dv)
    unitless = fullbody.State(state.position, state.velocity)
    refused(r"body of kick is 'Gamma', and this state does not know .* 0 to 2", lambda: unitless.kick("Gamma", dv))
    refused(r"body of kick is 'gamma'; did you mean 'Gamma'\?", lambda: state.kick("gamma", dv))
    # Names are no part of what a state is.
    assert unitless == state.replace(attitude=unitless.attitude, spin=unitless.spin)


@pytest.mark.parametrize(
    ("call", "what"),
    [
        (lambda s: s.kick(3, [0, 0, 1]), "body of kick is 3; expected 0 to 2, one of the 3 bodies"),
        (lambda s: s.kick(True, [0, 0, 1]), "body of kick is True; expected 0 to 2"),
        (lambda s: s.kick(1, [0, 1]), r"dv has shape \(2,\); expected \(3,\)"),
        (lambda s: s.kick(1, [0, 1, np.nan]), "dv is .*; expected finite numbers"),
        (lambda s: s.kick(1, 1.0), r"dv has shape \(\); expected \(3,\)"),
        (lambda s: s.kick(1, [0, 1, 0] * u.km / u.s), "dv has the unit km / s, but the state has none"),
        (lambda s: s.kick(1, [0, 1, 0], along="velocity"), "along of kick is 'velocity'; expected 'inertial', 'body'"),
        (lambda s: s.kick(1, [0, 1, 0], along=np.ones(2)), "along of kick is array"),
        (lambda s: s.kick(1, [0, 1, 0], about=0), "about of kick is 0, along is 'inertial'; expected about with"),
        (lambda s: s.kick(1, [0, 1, 0], along="orbit"), "about of kick is not given, and there are 2 other bodies"),
        (lambda s: s.kick(1, [0, 1, 0], along="orbit", about=1), "about of kick is 1, the body itself"),
        (lambda s: s.kick(1, [0, 1, 0], along="orbit", about=7), "about of kick is 7; expected 0 to 2"),
        (lambda s: s.kick(2, [0, 1, 0], along="orbit", about=0), "body 2 moves along its line to body 0, or not at"),
        (lambda s: s.rotated(1, [0, 0, 0], 1.0), "axis is .*; expected three numbers that are not all zero"),
        (lambda s: s.rotated(1, [0, 0, 1], np.inf), "angle is inf; expected a finite number"),
        (lambda s: s.rotated(1, [0, 0, 1], 1 * u.km), "angle has the unit km"),
        (lambda s: s.rotated(9, [0, 0, 1], 1.0), "body of rotated is 9; expected 0 to 2"),
        (lambda s: s.rotated(1, [0, 0, 1], 1.0, along="orbit"), "about of rotated is not given"),
    ],
)
def test_bad_kicks_are_refused(call, what):
    state = fullbody.State([[0, 0, 0], [2, 0, 0], [4, 0, 0]], [[0, 0, 0], [0, 1, 0], [1, 0, 0]])
    refused(what, lambda: call(state))


def test_kicks_have_units():
    still = fullbody.State([[0, 0, 0], [2, 0, 0]] * u.km, np.zeros((2, 3)))
    kicked = still.kick(1, [0, 1, 0] * u.m / u.s)
    np.testing.assert_allclose(kicked.velocity[1].to_value(u.m / u.s), [0, 1, 0])
    again = kicked.kick(1, ["0 km/h", "3.6 km/h", "0 km/h"], along="orbit")
    np.testing.assert_allclose(again.velocity[1].to_value(u.m / u.s), [0, 2, 0])
    assert again.kick(0, [0, 0, 0]) == again
    assert still.kick(0, [0, 0, 0]) == still
    refused(r"the state has units such as .*, but dv has none; expected both", lambda: kicked.kick(1, [0, 1, 0]))
    refused("dv has the unit km; expected a unit such as m / s", lambda: kicked.kick(1, [0, 1, 0] * u.km))
    _, state = fullbody.systems.kw4(units=("m", "s", "kg"))
    change = state.kick("Beta", [0, 0, 1] * u.km / u.hour).velocity - state.velocity
    np.testing.assert_allclose(change[1].to_value(u.m / u.s), [0, 0, 1 / 3.6])


def ellipsoid_beside_ball():
    bodies = body_list(A=(fullbody.Sphere(1.0), 8.0), B=(fullbody.Ellipsoid(0.5, 0.4, 0.3), 1.0))
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State.from_tait_bryan(
        [[0, 0, 0], [4, 0.5, 0.2]], [[0, 0, 0], [0.1, 1.5, 0.3]], [[0, 0, 0], [0.3, -0.2, 1.1]],
        [[0, 0, 0.1], [0.2, 0.1, 0.4]],
    )  # fmt: skip
    return system, state


@pytest.mark.parametrize(("longitude", "latitude"), [(0.3, 0.2), (-2.0, -1.0), (1.0, np.pi / 2)])
def test_momentum_and_angular_momentum_are_conserved(longitude, latitude):
    system, state = ellipsoid_beside_ball()
    direction = np.array([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)])
    point = state.rotation_matrix[1] @ (direction / np.sqrt((direction**2 / np.array([0.5, 0.4, 0.3]) ** 2).sum()))
    velocity = -50.0 * point + [1.0, 2.0, -3.0]
    struck = state.impact(system, 1, mass=1e-3, velocity=velocity, longitude=longitude, latitude=latitude)
    # The body keeps its mass: the projectile gives what it has relative to the ground, which goes on.
    ground = state.velocity[1] + np.cross(state.rotation_matrix[1] @ state.spin[1], point)
    momentum = 1e-3 * (state.velocity[1] + velocity - ground)
    np.testing.assert_allclose(system.momentum(struck) - system.momentum(state), momentum, rtol=1e-11, atol=1e-13)
    rotated = system.angular_momentum(struck) - system.angular_momentum(state)
    np.testing.assert_allclose(rotated, np.cross(state.position[1] + point, momentum), rtol=1e-10, atol=1e-13)
    np.testing.assert_array_equal(struck.position, state.position)
    np.testing.assert_array_equal(struck.velocity[0], state.velocity[0])
    assert (struck.spin[1] != state.spin[1]).any()


def test_ejecta_enhance_the_momentum_along_their_direction():
    # Head on, the momentum is enhanced by beta; aslant, along the normal or a direction that is given.
    ball = fullbody.System([fullbody.Body(fullbody.Sphere(2.0), mass=5.0, name="A")], G=1.0)
    state = fullbody.State([[0, 0, 0]], [[0, 0, 0]])
    options = {"mass": 1e-3, "longitude": 0.0, "latitude": 0.0}
    head_on = state.impact(ball, 0, velocity=[-6.0, 0, 0], beta=3.5, **options)
    np.testing.assert_allclose(head_on.velocity[0], [-3.5 * 6e-3 / 5, 0, 0], rtol=1e-14)
    assert not head_on.spin.any()
    aslant = {"velocity": [-6.0, 3.0, 0], "beta": 2.0, **options}
    np.testing.assert_allclose(5e3 * state.impact(ball, 0, **aslant).velocity[0], [-12.0, 3.0, 0], rtol=1e-13)
    # Straight back where it came from.
    back = state.impact(ball, 0, ejecta=[60.0, -30.0, 0], **aslant)
    np.testing.assert_allclose(5e3 * back.velocity[0], [-12.0, 6.0, 0], rtol=1e-13)
    # A sphere's moment of inertia is 2/5 m r^2.
    np.testing.assert_allclose(back.spin[0], [0, 0, 2.0 * 6e-3 / (0.4 * 5 * 4)], rtol=1e-13)


def test_the_velocity_of_the_ground_counts():
    ball = fullbody.System([fullbody.Body(fullbody.Sphere(2.0), mass=5.0, name="A")], G=1.0)
    turning = fullbody.State([[0, 0, 0]], [[0.3, 0.2, 0.1]], spin=[[0, 0, 0.5]])
    # It comes down along the normal as the ground has it.
    struck = turning.impact(ball, 0, mass=1e-3, velocity=[-6.0, 1.0, 0], longitude=0.0, latitude=0.0)
    np.testing.assert_allclose(struck.spin, turning.spin, rtol=1e-15)


def test_impacts_have_units_and_axes_of_the_orbit():
    system, state = fullbody.systems.didymos(units=True)
    options = {"mass": 579.4 * u.kg, "longitude": "-90 deg", "latitude": 0.0, "beta": 3.61, "along": "orbit"}
    struck = state.impact(system, "Dimorphos", velocity=["0 km/s", "-6.14 km/s", "0 km/s"], **options)
    change = (struck.velocity - state.velocity)[1].to_value("mm/s")
    expected = 3.61 * 579.4 * 6.14e6 / system.masses[1].to_value("kg")
    assert np.linalg.norm(change) == pytest.approx(expected, rel=1e-6)
    assert change @ state.velocity[1].value < 0.0
    kicked = state.kick("Dimorphos", [0, -expected, 0] * u.mm / u.s, along="orbit")
    np.testing.assert_allclose(kicked.velocity.value, struck.velocity.value, rtol=0.0, atol=2e-8)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"velocity": [6.0, 0, 0]}, "leaves the surface there at .* along the normal; expected one that comes"),
        ({"mass": 0.0}, "mass of the projectile is 0.0; expected a finite number above zero"),
        ({"latitude": 2.0}, "latitude is 2.0; expected angles from"),
        ({"beta": np.nan}, "beta is nan; expected a finite number"),
        ({"velocity": [1.0, 2.0]}, r"velocity of the projectile has shape \(2,\); expected \(3,\), finite numbers"),
        ({"body": "C"}, "body of impact is 'C'"),
    ],
)
def test_what_is_no_impact_is_refused(change, text):
    system, state = ellipsoid_beside_ball()
    options = {"body": 0, "mass": 1.0, "velocity": [-6.0, 0, 0], "longitude": 0.0, "latitude": 0.0} | change
    refused(text, lambda: state.impact(system, **options))
