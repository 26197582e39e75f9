"""Impacts, bounces, rest and escape against closed forms."""

import fullbody
import numpy as np
import pytest
from scipy.optimize import brentq
from support import body_list


def lone(radius=1.0, mass=1.0, spin=(0.0, 0.0, 0.0), shape=None):
    """One body at rest in the origin, G = 1."""
    shape = fullbody.Sphere(radius) if shape is None else shape
    system = fullbody.System([fullbody.Body(shape, mass=mass, name="A")], G=1.0)
    zero = [[0.0, 0.0, 0.0]]
    return system, fullbody.State(position=zero, velocity=zero, attitude=[[1.0, 0.0, 0.0, 0.0]], spin=[spin])


def test_a_fall_from_rest_has_keplers_time_and_speed_of_impact():
    system, state = lone()
    flight = system.fly(state, fullbody.Particles([[3.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]]), 20.0)
    # A radial ellipse of a = 3/2: r = a (1 + cos E) and t = sqrt(a^3) (E + sin E) from its apoapsis.
    e = np.arccos(1.0 / 1.5 - 1.0)
    assert flight.fate_time[0] == pytest.approx(1.5**1.5 * (e + np.sin(e)), rel=1e-11)
    assert flight.speed[0] == pytest.approx(np.sqrt(2.0 * (1.0 - 1.0 / 3.0)), rel=1e-11)
    assert flight.fate.tolist() == ["impact"]
    assert [flight.fate_body[0], flight.longitude[0], flight.latitude[0], flight.incidence[0]] == [0, 0, 0, 0]


def test_impacts_on_a_rotating_body_have_the_position_speed_and_incidence_of_geometry():
    system, state = lone(spin=(0.0, 0.0, 0.5))
    flight = system.fly(state, fullbody.Particles([[0.0, 3.0, 0.0]], [[0.0, 0.0, 0.0]]), 20.0)
    time, fall, surface = flight.fate_time[0], np.sqrt(4.0 / 3.0), 0.5
    assert flight.longitude[0] == pytest.approx(np.pi / 2.0 - 0.5 * time, abs=1e-10)
    assert flight.speed[0] == pytest.approx(np.hypot(fall, surface), rel=1e-10)
    assert flight.incidence[0] == pytest.approx(np.arctan2(surface, fall), rel=1e-10)


@pytest.mark.parametrize("depth", [1e-3, 1e-6, 1e-9])
def test_a_grazing_impact_is_detected(depth):
    system, state = lone(radius=1.0, mass=1.0)
    # Hyperbolas whose periapsis is a little below or above the surface.
    fates = []
    for periapsis in (1.0 - depth, 1.0 + depth):
        speed = np.sqrt(1.0 + 2.0 / 10.0)
        size = 1.0 / (speed**2 - 2.0 / 10.0)
        b = periapsis * np.sqrt(1.0 + 2.0 * size / periapsis)
        momentum = b * np.sqrt(1.0 / size)
        across = momentum / 10.0
        velocity = [-np.sqrt(speed**2 - across**2), across, 0.0]
        particles = fullbody.Particles([[10.0, 0.0, 0.0]], [velocity])
        fates += system.fly(state, particles, 30.0, integrator=fullbody.Verner98(1e-13, 1e-13)).fate.tolist()
    assert fates == ["impact", "flying"]


def test_a_fast_impact_on_a_rim_between_steps_is_detected():
    # Faster than the body's gravity by far: a step is much longer than the body.
    system, state = lone(radius=1e-3, mass=1e-12)
    hit = fullbody.Particles([[-5.0, 0.999e-3, 0.0], [-5.0, 1.001e-3, 0.0]], [[100.0, 0.0, 0.0]] * 2)
    flight = system.fly(state, hit, 1.0)
    assert flight.fate.tolist() == ["impact", "flying"]
    chord = np.sqrt(1e-6 - 0.999e-3**2)
    assert flight.fate_time[0] == pytest.approx((5.0 - chord) / 100.0, rel=1e-12)


def test_the_heights_of_bounces_fall_as_the_square_of_the_coefficient():
    system, state = lone()
    bounce = fullbody.particles.Bounce(normal=0.6, rest_speed=1e-3)
    start = fullbody.Particles([[1.02, 0.0, 0.0]], [[0.0, 0.0, 0.0]])
    top = [fullbody.particles.ParticleFunction(lambda t, x, v: v[0], direction=-1)]
    flight = system.fly(state, start, 3.0, contact=bounce, events=top)
    # From the energy: v^2/2 = 1 - 1/r at the surface, times the square of the coefficient each time.
    energy = 1.0 - 1.0 / 1.02
    heights = [event.position[0] for event in flight.events]
    assert len(heights) >= 3
    for count, height in enumerate(heights, 1):
        assert 1.0 - 1.0 / height == pytest.approx(energy * 0.36**count, rel=1e-9)


def test_a_particle_comes_to_rest_and_rotates_with_its_body():
    system, state = lone(spin=(0.0, 0.0, 0.3))
    bounce = fullbody.particles.Bounce(normal=0.5, tangential=0.5, rest_speed=1e-3)
    particles = fullbody.Particles([[1.01, 0.0, 0.2]], [[0.0, 0.3, 0.0]])
    flight = system.fly(state, particles, 20.0, output=[15.0, 20.0], contact=bounce)
    assert flight.fate.tolist() == ["rest"]
    first, last = flight.position[:, 0]
    assert np.linalg.norm(first) == pytest.approx(1.0, rel=1e-12)
    angle = 0.3 * 5.0
    c, s = np.cos(angle), np.sin(angle)
    assert last == pytest.approx([c * first[0] - s * first[1], s * first[0] + c * first[1], first[2]], rel=1e-11)
    assert flight.velocity[1, 0] == pytest.approx([-0.3 * last[1], 0.3 * last[0], 0.0], abs=1e-11)


def test_bounces_on_a_body_that_spins_too_fast_for_rest_end():
    system, state = lone(spin=(0.0, 0.0, 1.2))
    start = fullbody.Particles([[1.001, 0.0, 0.0]], [[0.0, 0.0, 0.0]])
    bounce = fullbody.particles.Bounce(normal=0.5, rest_speed=1e-3)
    flight = system.fly(state, start, 2.0, output="ends", contact=bounce)
    # It strikes at 0.0447, and at half of the speed before each time, until it leaves at less than 0.001.
    assert flight.strikes.tolist() == [6]
    assert flight.fate.tolist() == ["flying"]
    position, velocity = flight.position[-1, 0], flight.velocity[-1, 0]
    assert np.cross(position, velocity)[2] == pytest.approx(1.2, rel=1e-9)
    assert velocity @ velocity / 2.0 - 1.0 / np.linalg.norm(position) == pytest.approx(1.2**2 / 2.0 - 1.0, rel=1e-9)


def test_a_resting_particle_lifts_off_under_a_passing_mass():
    bodies = body_list(A=(fullbody.Sphere(1.0), 0.02), B=(fullbody.PointMass(), 1.0))
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State(
        position=[[0.0, 0.0, 0.0], [9.0, 0.0, 0.0]],
        velocity=[[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        attitude=[[1.0, 0.0, 0.0, 0.0]] * 2,
        spin=np.zeros((2, 3)),
    )
    run = system.integrate(state, 27.0, dense=True)
    lying = fullbody.Particles.from_surface(system, state, "A", longitude=0.0, latitude=0.0, speed=1e-3)
    flight = run.fly(lying, output=run.time[-1:], contact=fullbody.particles.Bounce(normal=0.5, rest_speed=1e-2))

    # It lifts off where 1/(d - 1)^2 - 1/d^2 = m/1^2, and is ahead of the surface from then on.
    def force(time):
        d = run(float(time)).position
        d = d[1, 0] - d[0, 0]
        return 1.0 / (d - 1.0) ** 2 - 1.0 / d**2 - 0.02

    lift = brentq(force, 0.5, 26.9)
    earlier = run.fly(lying, lift - 1e-3, contact=fullbody.particles.Bounce(normal=0.5, rest_speed=1e-2))
    assert earlier.fate.tolist() == ["rest"]
    assert flight.fate.tolist() == ["flying"]
    height = np.linalg.norm(flight.position[0, 0] - run[-1].position[0]) - 1.0
    assert height > 1e-3


def test_particles_escape_by_distance_or_energy():
    system, state = lone()
    particles = fullbody.Particles([[2.0, 0.0, 0.0]] * 2, [[0.95, 0.0, 0.0], [1.05, 0.0, 0.0]])
    near = system.fly(state, particles, 100.0, escape=fullbody.particles.EscapeDistance(5.0))
    assert near.fate.tolist() == ["escape", "escape"]
    assert np.linalg.norm(near.last_position, axis=1) == pytest.approx(5.0, rel=1e-13)
    unbound = system.fly(state, particles, 100.0, escape=fullbody.particles.EscapeDistance(5.0, unbound=True))
    assert unbound.fate.tolist() == ["flying", "escape"]
    assert unbound.last_time[1] == near.last_time[1] == near.fate_time[1]


def test_stopped_particles_keep_their_position_and_removed_ones_have_none():
    system, state = lone(spin=(0.0, 0.0, 0.5))
    particles = fullbody.Particles([[1.5, 0.0, 0.0]], [[0.0, 0.0, 0.0]])
    stays = system.fly(state, particles, 10.0, output=5.0)
    gone = system.fly(state, particles, 10.0, output=5.0, contact="remove")
    assert np.linalg.norm(stays.position[:, 0], axis=1) == pytest.approx([1.5, 1.0, 1.0])
    assert np.isnan(gone.position[1:]).all()
    assert np.array_equal(gone.position[0], stays.position[0])
    assert stays.fate_time == gone.fate_time == gone.last_time


def test_periapses_of_particles_are_keplers():
    system, state = lone(radius=0.1)
    particles = fullbody.Particles([[1.5, 0.0, 0.0]], [[0.0, np.sqrt(2.0 / 1.5 - 1.0), 0.0]])
    flight = system.fly(state, particles, 20.0, events=[fullbody.particles.ParticlePeriapsis("A")])
    assert [event.time for event in flight.events] == pytest.approx(np.pi * np.array([1.0, 3.0, 5.0]), rel=1e-10)
    assert np.linalg.norm(flight.events[0].position) == pytest.approx(0.5, rel=1e-10)


def test_particles_are_launched_with_the_velocity_of_the_surface():
    system, state = lone(shape=fullbody.Ellipsoid(3.0, 2.0, 1.0), spin=(0.1, 0.2, 0.3))
    lon, lat = 0.7, 0.4
    direction = {"longitude": lon, "latitude": lat, "azimuth": 0.3, "elevation": 0.8}
    up = fullbody.Particles.from_surface(system, state, "A", speed=0.5, **direction)
    position = up.position[0]
    axes = np.array([3.0, 2.0, 1.0])
    assert ((position / axes) ** 2).sum() == pytest.approx(1.0, rel=1e-14)
    assert np.arctan2(position[1], position[0]) == pytest.approx(lon)
    assert np.arcsin(position[2] / np.linalg.norm(position)) == pytest.approx(lat)
    normal = position / axes**2 / np.linalg.norm(position / axes**2)
    east = np.cross([0.0, 0.0, 1.0], normal)
    east /= np.linalg.norm(east)
    relative = up.velocity[0] - np.cross([0.1, 0.2, 0.3], position)
    results = [relative @ normal, relative @ east, relative @ np.cross(normal, east)]
    level = 0.5 * np.cos(0.8)
    assert results == pytest.approx([0.5 * np.sin(0.8), level * np.sin(0.3), level * np.cos(0.3)], rel=1e-12)


def test_ejecta_leave_on_a_cone():
    system, state = lone()
    options = {"longitude": 0.0, "latitude": 0.0, "speed": 0.2, "n": 500, "rng": 3}
    mantle = fullbody.Particles.ejecta(system, state, 0, opening_angle=1.2, **options)
    assert mantle.velocity[:, 0] == pytest.approx(0.2 * np.cos(0.6), rel=1e-12)
    filled = fullbody.Particles.ejecta(system, state, 0, opening_angle=1.2, filled=True, **options)
    assert 0.2 * np.cos(0.6) - 1e-15 <= filled.velocity[:, 0].min()
    # Even in solid angle: even in the cosine.
    assert filled.velocity[:, 0].mean() == pytest.approx(0.1 * (1.0 + np.cos(0.6)), rel=5e-3)
    again = fullbody.Particles.ejecta(system, state, 0, opening_angle=1.2, **options)
    assert np.array_equal(again.velocity, mantle.velocity)


@pytest.mark.parametrize("speed", [1e2, 1e4, 1e7])
def test_the_fastest_particles_have_impacts(speed):
    bodies = body_list((fullbody.Ellipsoid(1, 0.6, 0.3), 1e-12), (fullbody.Sphere(1e-3), 1e-12))
    state = fullbody.State(position=[[0, 0, 0], [1e4, 0, 0]], velocity=np.zeros((2, 3)))
    positions = np.random.default_rng(0).normal(size=(50, 3))
    positions *= 5 / np.linalg.norm(positions, axis=1)[:, None]
    particles = fullbody.Particles(positions, -positions / 5 * speed)
    flight = fullbody.System(bodies, G=1.0).fly(state, particles, 12 / speed)
    assert np.all(flight.fate == "impact")
    # Straight on to the surface, towards the centre.
    surface = 1 / np.linalg.norm(positions / 5 / [1, 0.6, 0.3], axis=1)
    assert np.allclose(flight.fate_time * speed, 5 - surface, rtol=1e-9)


@pytest.mark.parametrize("excess", [0.0, 2.3e-16, -1e-15, 1e-13, -1e-13, 1e-12])
def test_a_particle_on_an_equator_at_orbital_speed_comes_to_rest(excess):
    # Rounding alone presses it down or lifts it: it must neither bounce at one instant nor follow the surface.
    system, state = lone(spin=(0.0, 0.0, 1.0 + excess))
    bounce = fullbody.particles.Bounce(normal=0.3, tangential=0.5, rest_speed=5.8e-3)
    start = fullbody.Particles([[1.0, 0.0, 0.0]], [[0.0, 1.0 + excess, 0.0]])
    flight = system.fly(state, start, 2.0, output="ends", contact=bounce)
    assert flight.fate.tolist() == ["rest"]
    assert flight.strikes[0] < 10
    assert flight.position[-1, 0] == pytest.approx([np.cos(2.0), np.sin(2.0), 0.0], abs=1e-9)


@pytest.mark.parametrize("width", [0.03, 0.01])
@pytest.mark.parametrize("direction", [0, 1, -1])
def test_two_zeros_near_a_minimum_are_found_for_bodies_and_particles(width, direction):
    """The function (t - 5)^2 - w^2 falls through zero at 5 - w and rises at 5 + w, within a step."""
    expected = {0: [5.0 - width, 5.0 + width], 1: [5.0 + width], -1: [5.0 - width]}[direction]
    system, state = fullbody.systems.kw4_ho2021()
    parabola = fullbody.events.Function(lambda s: (s.time - 5.0) ** 2 - width**2, direction=direction)
    run = system.integrate(state, 24.0, output=24.0, events=[parabola], dense=True)
    assert [event.time for event in run.events] == pytest.approx(expected, rel=1e-13)
    # Thirty kilometres away a particle takes steps of several hours.
    particles = fullbody.Particles([[30.0, 0.0, 0.0]], [[0.0, 2.0e-3, 0.0]])
    watched = fullbody.particles.ParticleFunction(lambda t, x, v: (t - 5.0) ** 2 - width**2, direction=direction)
    flight = run.fly(particles, events=[watched])
    assert [event.time for event in flight.events] == pytest.approx(expected, rel=1e-13)


def test_a_zero_where_two_steps_meet_is_found_once():
    """The function vanishes at the end of a step: it belongs to that step, and not to the next one too."""
    system, state = fullbody.systems.kw4_ho2021()
    run = system.integrate(state, 24.0, output=24.0, dense=True)
    ends = []

    def clock(time, position, velocity):
        ends.append(time)
        return 1.0

    particles = fullbody.Particles([[5.0, 0.0, 0.0]], [[0.0, 0.5, 0.0]])
    run.fly(particles, events=[fullbody.particles.ParticleFunction(clock)])
    joints = sorted({time for time in ends if 0.0 < time < 24.0 and ends.count(time) > 1})
    assert len(joints) > 3
    for joint in joints[:4]:
        event = fullbody.particles.ParticleFunction(lambda t, x, v, joint=joint: t - joint)
        assert [result.time for result in run.fly(particles, events=[event]).events] == [joint]
