"""What physics leaves unchanged, as property tests: poses and short runs drawn at random, the same ones every time."""

import fullbody
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import angle_between, matrix, pairs, quaternion_product, quaternions, semi_axes, vectors, worst

#: A quarter of a turn or so for the pairs of support.pairs.
SHORT = 2.0


def scale_of(f):
    """Size of the forces and of the torques on the pair: force times a length of order one."""
    return np.abs(f.force).max()


@given(pairs(), quaternions)
def test_rotating_everything_rotates_forces_and_leaves_body_torques(pair, q):
    system, state = pair
    rotated = rotate(state, q)
    previous, rotated_interactions = system.interactions(state), system.interactions(rotated)
    assert worst(rotated_interactions.force, previous.force @ matrix(q).T) < 1e-13
    assert np.abs(rotated_interactions.torque - previous.torque).max() < 1e-13 * scale_of(previous)
    assert rotated_interactions.potential_energy == pytest.approx(previous.potential_energy, rel=1e-13)
    energy = system.energy(state).total
    assert system.energy(rotated).total == pytest.approx(energy, abs=1e-13 * scale_of(previous) * 20)
    momentum = system.angular_momentum(state)
    assert worst(system.angular_momentum(rotated), matrix(q) @ momentum, scale=20.0) < 1e-14


def rotate(state, q):
    frame = matrix(q)
    return state.replace(
        position=state.position @ frame.T,
        velocity=state.velocity @ frame.T,
        attitude=quaternion_product(q, state.attitude),
    )


def run(system, state, until=SHORT):
    return system.integrate(state, until, output=[until])[0]


def assert_same_state(first, other, limit):
    assert np.abs(first.position - other.position).max() < limit
    assert np.abs(first.velocity - other.velocity).max() < limit
    assert np.abs(first.spin - other.spin).max() < limit
    assert angle_between(first.rotation_matrix, other.rotation_matrix).max() < limit


@given(pairs(), quaternions)
@settings(max_examples=10)
def test_a_rotated_start_gives_the_rotated_run(pair, q):
    system, state = pair
    assert_same_state(rotate(run(system, state), q), run(system, rotate(state, q)), 5e-12)


@given(pairs())
@settings(max_examples=10)
def test_relabelling_the_bodies_permutes_the_run(pair):
    system, state = pair
    swapped = fullbody.System(system.bodies[::-1], G=1.0, **system.options)
    swapped_state = fullbody.State(state.position[::-1], state.velocity[::-1], state.attitude[::-1], state.spin[::-1])
    f, g = system.interactions(state), swapped.interactions(swapped_state)
    assert worst(g.force[::-1], f.force) < 1e-13
    assert np.abs(g.torque[::-1] - f.torque).max() < 1e-13 * scale_of(f)
    end = run(swapped, swapped_state)
    back = fullbody.State(end.position[::-1], end.velocity[::-1], end.attitude[::-1], end.spin[::-1])
    assert_same_state(run(system, state), back, 5e-12)


@given(st.permutations(range(3)), st.tuples(*[quaternions] * 3), st.tuples(*[semi_axes] * 3))
@settings(max_examples=8)
def test_relabelling_three_bodies_permutes_their_forces(order, attitudes, axes):
    bodies = [fullbody.Body(fullbody.Ellipsoid(*a), mass=m) for a, m in zip(axes, (1.0, 0.4, 0.7), strict=True)]
    position = np.array([[0.0, 0, 0], [3.0, 0.2, 0], [-0.5, 4.0, 1.0]])
    velocity = np.array([[0.0, 0, 0], [0, 0.6, 0.1], [-0.6, 0, 0]])
    order = list(order)
    reference = run(fullbody.System(bodies, G=1.0), fullbody.State(position, velocity, attitudes))
    part = run(
        fullbody.System([bodies[k] for k in order], G=1.0),
        fullbody.State(position[order], velocity[order], np.array(attitudes)[order]),
    )
    names = ("position", "velocity", "attitude", "spin")
    permuted = fullbody.State(*(getattr(reference, name)[order] for name in names))
    assert_same_state(part, permuted, 5e-12)


@given(pairs(), st.tuples(*[st.floats(-3.0, 3.0)] * 3))
@settings(max_examples=12)
def test_numbers_scale_with_the_units(pair, exponents):
    system, state = pair
    length, time, mass = (10.0**e for e in exponents)
    bodies = [
        fullbody.Body(fullbody.Ellipsoid(*(length * axis for axis in b.shape.semi_axes)), mass=mass * b.mass)
        for b in system.bodies
    ]
    other = fullbody.System(bodies, G=length**3 / time**2 / mass, **system.options)
    speed = length / time

    def scaled(s):
        return s.replace(position=s.position * length, velocity=s.velocity * speed, spin=s.spin / time)

    f, g = system.interactions(state), other.interactions(scaled(state))
    force = mass * length / time**2
    assert worst(g.force / force, f.force) < 1e-13
    assert np.abs(g.torque / (force * length) - f.torque).max() < 1e-13 * scale_of(f)
    assert g.potential_energy / (force * length) == pytest.approx(f.potential_energy, rel=1e-13)
    end = other.integrate(scaled(state), SHORT * time, output=[SHORT * time])[0]
    back = end.replace(position=end.position / length, velocity=end.velocity / speed, spin=end.spin * time)
    assert_same_state(run(system, state), back, 5e-12)


@given(pairs())
@settings(max_examples=10)
def test_integration_back_returns_to_the_start(pair):
    system, state = pair
    end = run(system, state)
    assert_same_state(system.integrate(end.replace(time=SHORT), 0.0, output=[0.0])[0], state, 5e-12)
    mirrored = end.replace(velocity=-end.velocity, spin=-end.spin, time=0.0)
    back = run(system, mirrored)
    assert_same_state(back.replace(velocity=-back.velocity, spin=-back.spin), state, 5e-12)


@given(pairs(), vectors, vectors, st.floats(-100.0, 100.0))
@settings(max_examples=10)
def test_translation_boost_and_the_origin_of_time_change_nothing(pair, shift, boost, start):
    system, state = pair
    moved = state.replace(position=state.position + shift, velocity=state.velocity + boost)
    assert worst(system.interactions(moved).force, system.interactions(state).force) < 1e-13
    end = system.integrate(moved.replace(time=start), start + SHORT, output=[start + SHORT])[0]
    back = end.replace(position=end.position - shift - boost * SHORT, velocity=end.velocity - boost)
    assert_same_state(run(system, state), back, 5e-12)


@given(pairs())
@settings(max_examples=8)
def test_half_turns_of_a_body_about_its_axes_change_nothing(pair):
    system, state = pair
    f = system.interactions(state)
    for flip in np.eye(4)[1:]:
        attitude = np.array([state.attitude[0], quaternion_product(state.attitude[1], flip)])
        g = system.interactions(state.replace(attitude=attitude))
        signs = 2 * flip[1:] - 1
        assert worst(g.force, f.force) < 1e-13
        assert np.abs(g.torque[1] * signs - f.torque[1]).max() < 1e-13 * scale_of(f)
