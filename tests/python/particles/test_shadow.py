"""The visible part of the Sun's disc, and its radiation, against closed forms and against rays."""

import fullbody
import numpy as np
import pytest
from fullbody.particles import Radiation, Shadow

DISTANCE, RADIUS = 1000.0, 5.0


def lit(shape, strength=0.0, attitude=(1.0, 0.0, 0.0, 0.0), mass=1.0, spin=(0.0, 0.0, 0.0)):
    """One body in the origin under a sun on the x axis that hardly pulls."""
    path = {"times": np.arange(5) * 100.0, "positions": [[DISTANCE, 0.0, 0.0]] * 5}
    sun = fullbody.forces.ThirdBody(mu=1e-30, of="body", name="Sun", **path)
    system = fullbody.System([fullbody.Body(shape, mass=mass, name="A")], G=1.0, forces=[sun])
    zero = [[0.0, 0.0, 0.0]]
    state = fullbody.State(position=zero, velocity=zero, attitude=[attitude], spin=[spin])
    return system, state, Radiation(by="Sun", strength=strength, radius=RADIUS)


def test_umbra_and_penumbra_of_a_sphere_end_on_their_cones():
    system, state, light = lit(fullbody.Sphere(1.0))
    # Lines that touch both spheres: from the tips of the cones the angle has the sine (R_s -+ R)/d.
    behind = np.array([0.5, 10.0, 100.0])
    for sign, cone in ((-1.0, (RADIUS - 1.0) / DISTANCE), (1.0, (RADIUS + 1.0) / DISTANCE)):
        tangent, secant = np.tan(np.arcsin(cone)), 1.0 / np.cos(np.arcsin(cone))
        edge = secant + sign * tangent * behind
        for offset in (-1e-6, 1e-6):
            x = np.stack([-behind, 0.6 * (edge + offset), 0.8 * (edge + offset)], axis=1)
            part = light.visible(system, state, x)
            if sign < 0.0:
                assert (part == 0.0).all() if offset < 0.0 else ((part > 0.0) & (part < 1e-3)).all()
            else:
                assert ((part > 0.99) & (part < 1.0)).all() if offset < 0.0 else (part == 1.0).all()


def test_an_annular_eclipse_leaves_the_ring():
    system, state, light = lit(fullbody.Sphere(1.0))
    behind = np.array([300.0, 1e3, 1e4])
    x = np.stack([-behind, 0 * behind, 0 * behind], axis=1)
    body, sun = np.arcsin(1.0 / behind), np.arcsin(RADIUS / (DISTANCE + behind))
    expected = 1.0 - (np.tan(body) / np.tan(sun)) ** 2
    assert light.visible(system, state, x) == pytest.approx(expected, rel=1e-12)


def test_the_shadow_of_an_ellipsoid_is_that_of_rays():
    rotation = np.array([0.8, 0.3, -0.4, 0.33])
    shape, axes = fullbody.Ellipsoid(2.0, 1.2, 0.7), np.array([2.0, 1.2, 0.7])
    system, state, light = lit(shape, attitude=rotation / np.linalg.norm(rotation))
    matrix = state.rotation_matrix[0]
    u, w = np.meshgrid(*[(np.arange(500) + 0.5) / 250.0 - 1.0] * 2)
    disc = u**2 + w**2 < 1.0
    for x in ([-5.0, 1.1, 0.4], [-1.0, 1.45, 0.9], [-300.0, 1.5, 0.8], [-900.0, 2.5, 0.0], [0.2, 0.9, 1.0]):
        towards = np.array([DISTANCE, 0.0, 0.0]) - x
        distance = np.linalg.norm(towards)
        s = towards / distance
        across = np.cross(s, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(s, [0.0, 0.0, 1.0]))
        size = np.tan(np.arcsin(RADIUS / distance))
        rays = s + size * (u[disc][:, None] * across + w[disc][:, None] * np.cross(s, across))
        p, d = (matrix.T @ np.asarray(x)) / axes, (rays @ matrix) / axes
        b = d @ p
        hidden = (b < 0.0) & (b**2 >= (d**2).sum(1) * (p @ p - 1.0))
        assert light.visible(system, state, x) == pytest.approx(1.0 - hidden.mean(), abs=4e-4)


def test_two_parts_hide_no_more_than_they_cover_together():
    parts = [fullbody.Part(fullbody.Sphere(1.0), mass=0.5, position=(0.0, y, 0.0)) for y in (-0.8, 0.8)]
    system, state, light = lit(fullbody.Composite(parts), mass=None)
    x = np.array([[-400.0, 0.1, 0.0], [-3.0, 0.0, 0.0]])
    both = light.visible(system, state, x)
    assert both[1] == 0.0
    single, still, _ = lit(fullbody.Sphere(1.0))
    ones = light.visible(single, still, x[:1] + np.array([[0.0, 0.8, 0.0], [0.0, -0.8, 0.0]]))
    assert ones.max() - 1.0 + ones.min() < both[0] < ones.min()


def test_radiation_pushes_and_the_shadow_does_not():
    strength, ratio = 2.0, 300.0
    system, state, light = lit(fullbody.Sphere(1.0), strength=strength, mass=1e-12)
    x = [[-20.0, 0.0, 0.0], [-20.0, 3.0, 0.0], [-20.0, 3.0, 0.0]]
    particles = fullbody.Particles(x, np.zeros((3, 3)), area_to_mass=[ratio, ratio, 0.0])
    flight = system.fly(state, particles, 2.0, output="ends", radiation=light)
    moved = flight.position[-1] - x
    force = strength * ratio / (DISTANCE + 20.0) ** 2
    assert moved[1, 0] == pytest.approx(-0.5 * force * 4.0, rel=1e-4)
    assert np.abs(moved[[0, 2]]).max() < 1e-10


def test_entry_into_the_shadow_and_exit_from_it():
    system, state, light = lit(fullbody.Sphere(1.0), mass=1e-12)
    particles = fullbody.Particles([[-10.0, -3.0, 0.0]], [[0.0, 1.0, 0.0]])
    edge = [Shadow(0.5), Shadow(1e-9, direction=-1), Shadow(1.0 - 1e-9, direction=1)]
    flight = system.fly(state, particles, 6.0, radiation=light, events=edge)
    times = [[e.time for e in flight.events if e.event is edge[k]] for k in range(3)]
    # Half of the disc is hidden, but for its curvature, where the line from the Sun's centre touches the sphere.
    tangent = np.arcsin(1.0 / DISTANCE)
    half = 1.0 / np.cos(tangent) + 10.0 * np.tan(tangent)
    assert times[0] == pytest.approx([3.0 - half, 3.0 + half], abs=1e-3)
    umbra, penumbra = (np.arcsin((RADIUS + k) / DISTANCE) for k in (-1.0, 1.0))
    assert times[1] == pytest.approx([3.0 - (1.0 / np.cos(umbra) - 10.0 * np.tan(umbra))], abs=1e-6)
    assert times[2] == pytest.approx([3.0 + (1.0 / np.cos(penumbra) + 10.0 * np.tan(penumbra))], abs=1e-6)
    assert [e.rising for e in flight.events if e.event is edge[0]] == [False, True]
