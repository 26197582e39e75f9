"""Polyhedra within each other's reach at the default tolerance, against integrals over the volume of one of them."""

import fullbody
import numpy as np
import pytest
from fullbody import Body, Composite, Part
from support import matrix
from support.meshes import close, octahedron, torus


def force_by_volume(field, solid, mass, place, turn, count):
    """Force on a homogeneous star-shaped solid: Gauss points in the tetrahedra between its origin and its faces."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    r, s, t = np.meshgrid(*[(nodes + 1.0) / 2.0] * 3, indexing="ij")
    weight = np.prod(np.meshgrid(*[weights / 2.0] * 3, indexing="ij"), axis=0)
    force, volume = np.zeros(3), 0.0
    for a, b, c in solid.vertices[solid.faces]:
        r_, s_, t_ = (x[..., None] for x in (r, s, t))
        points = r_ * ((1.0 - s_) * a + s_ * ((1.0 - t_) * b + t_ * c))
        share = (weight * r**2 * s * np.linalg.det([a, b, c])).ravel()
        force += share @ field(points.reshape(-1, 3) @ turn.T + place)
        volume += share.sum()
    return mass * force / volume


@pytest.mark.parametrize("seed", range(12))
def test_force_of_a_large_polyhedron_on_small_parts_keeps_its_digits(seed):
    large, small = octahedron(1.0, 0.8, 0.6), octahedron(0.06, 0.05, 0.04)
    parts = [Part(small, mass=0.5, position=(x, 0.0, 0.0)) for x in (-0.07, 0.07)]
    bodies = [Body(large, mass=2.0, name="large"), Body(Composite(parts), name="pair")]
    rng = np.random.default_rng(seed)
    direction, turn = rng.normal(size=3), rng.normal(size=4)
    place = rng.uniform(1.13, 1.3) * direction / np.linalg.norm(direction)
    attitude = [[1.0, 0.0, 0.0, 0.0], turn / np.linalg.norm(turn)]
    state = fullbody.State([[0.0] * 3, place], np.zeros((2, 3)), attitude, np.zeros((2, 3)))

    def field(points):
        return bodies[0].gravity(points, G=1.0).field

    turn = matrix(attitude[1])
    at = [place + turn @ part.position for part in parts]
    expected = sum(force_by_volume(field, small, 0.5, x, turn, 10) for x in at)
    found = fullbody.System(bodies, G=1.0).interactions(state).force
    close(found, [-expected, expected], 3e-14)


@pytest.mark.parametrize("distance", [1e-1, 1e-3, 1e-6])
def test_force_near_the_centre_of_a_ring_is_exact_to_rounding(distance):
    ring, grain = torus(1.0, 0.3), octahedron(0.3, 0.24, 0.18)
    bodies = [Body(ring, mass=1.0, name="ring"), Body(grain, mass=0.1, name="grain")]
    place = distance * np.array([0.6, -0.48, 0.64])
    state = fullbody.State([[0.0] * 3, place], np.zeros((2, 3)), [[1.0, 0.0, 0.0, 0.0]] * 2, np.zeros((2, 3)))

    def field(points):
        return bodies[0].gravity(points, G=1.0).field

    expected = force_by_volume(field, grain, 0.1, place, np.eye(3), 16)
    found = fullbody.System(bodies, G=1.0).interactions(state).force
    close(found, [-expected, expected], 3e-14, scale=0.1)
