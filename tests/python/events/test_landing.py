"""Polyhedra that are about to touch something, and land on it."""

import fullbody
import numpy as np
import pytest
from fullbody import Body, Ellipsoid, State
from support.meshes import box, close, focal_points, octahedron, with_more_faces

AXES = (0.5, 0.4, 0.2)
Q = np.array([0.9, 0.3, 0.2, -0.1]) / np.linalg.norm([0.9, 0.3, 0.2, -0.1])
UNTURNED = [1.0, 0.0, 0.0, 0.0]
CONTACT = fullbody.events.Contact("A", "B", terminal=True)


def system(first, second, tolerance):
    bodies = [Body(first, mass=1.0, name="A"), Body(second, mass=0.3, name="B")]
    return fullbody.System(bodies, G=1.0, gravity_tolerance=tolerance)


def beside(position, attitude=Q):
    return State([[0.0] * 3, position], np.zeros((2, 3)), attitude=[UNTURNED, attitude], spin=np.zeros((2, 3)))


def support(axes, attitude, n):
    """The distance that an ellipsoid reaches from its centre along a direction of the inertial frame."""
    rotation = beside([9.0, 0.0, 0.0], attitude).rotation_matrix[1]
    return np.linalg.norm(np.array(axes) * (rotation.T @ n))


@pytest.mark.parametrize("normal", [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]], ids=["face", "edge", "corner"])
@pytest.mark.parametrize("axes", [AXES, (0.5, 0.45, 0.12)], ids=["egg", "disc"])
def test_the_force_of_a_polyhedron_near_an_ellipsoid_is_the_focal_integral(normal, axes):
    n = np.array(normal) / np.linalg.norm(normal)
    cube = Body(box(2.0, 2.0, 2.0), mass=1.0, name="A")
    points, weights = focal_points(*axes, n=80, m=320)
    for gap in (0.1, 1e-3, 1e-9):
        # The point of the ellipsoid that is nearest lies above the middle of the face, of the edge, or the corner.
        rotation = beside([9.0, 0.0, 0.0]).rotation_matrix[1]
        nearest = rotation @ (np.array(axes) ** 2 * (rotation.T @ n)) / support(axes, Q, n)
        state = beside(np.sign(normal) + n * gap + nearest)
        arms = points @ rotation.T
        position = state.position[1] + arms
        attraction = cube.gravity(position, G=1.0)
        field, potential = attraction.field, attraction.potential
        force, torque = 0.3 * weights @ field, 0.3 * weights @ np.cross(arms, field) @ rotation
        back = -0.3 * weights @ np.cross(position, field)
        result = system(cube.shape, Ellipsoid(*axes), 1e-13).interactions(state)
        size = np.abs(force).max()
        close(result.force, [-force, force], 3e-14)
        close(result.torque, [back, torque], 3e-14, scale=size)
        close(result.potential_energy, -0.3 * weights @ potential, 3e-14)


@pytest.mark.parametrize("gap", [0.1, 1e-3, 1e-9])
@pytest.mark.parametrize("meeting", ["corners", "corner and face", "edges"])
def test_forces_of_polyhedra_about_to_touch_do_not_depend_on_which_is_summed_over(meeting, gap):
    first, other = octahedron(1.0, 1.0, 1.0), octahedron(0.5, 0.5, 0.5)
    diagonal = np.ones(3) / 3**0.5
    # A turn of a corner of the second one towards the first.
    half = 0.5 * np.arccos(-diagonal[0])
    towards = [np.cos(half), *np.sin(half) * np.cross([1.0, 0.0, 0.0], -diagonal) / np.sin(2.0 * half)]
    if meeting == "corners":
        state = beside([1.5 + gap, 0.0, 0.0], UNTURNED)
    elif meeting == "corner and face":
        state = beside((3**-0.5 + 0.5 + gap) * diagonal, towards)
    else:
        # Edges at right angles: the second one is turned by a right angle about the line of the centres.
        across = np.array([1.0, 1.0, 0.0]) / 2**0.5
        state = beside((0.5**0.5 * 1.5 + gap) * across, [0.5**0.5, *0.5**0.5 * across])
    result = system(first, with_more_faces(other), 1e-11).interactions(state)
    again = system(with_more_faces(first), other, 1e-11).interactions(state)
    size = np.abs(again.force).max()
    close(result.force, again.force, 2e-11)
    close(result.torque, again.torque, 2e-11, scale=size)
    close(result.potential_energy, again.potential_energy, 2e-11)


def test_the_force_between_touching_cubes_is_trefethens():
    """The force between touching cubes is a sum of logarithms and arc tangents (Trefethen 2005)."""
    cube, gap = box(1.0, 1.0, 1.0), 1e-9
    result = system(cube, cube, 1e-7).interactions(beside([1.0 + gap, 0.0, 0.0], UNTURNED))
    close(result.force[0], np.array([0.3 * 0.92598126055729142809, 0.0, 0.0]), 1e-7)


def landing(first, second, tolerance, **options):
    state = State(
        [[0.0] * 3, [2.2, 0.2, 0.1]],
        [[0.0] * 3, [-0.1, 0.05, 0.0]],
        attitude=[UNTURNED, Q],
        spin=[[0.0, 0.0, 0.2], [0.3, -0.2, 0.1]],
    )
    run = system(first, second, tolerance).integrate(state, 20.0, events=[CONTACT], **options)
    assert [event.event for event in run.events] == [CONTACT]
    return run


@pytest.mark.parametrize("axes", [AXES, (0.5, 0.45, 0.06)])
def test_a_tumbling_ellipsoid_lands_when_its_support_touches(axes):
    run = landing(box(2.0, 2.0, 2.0), Ellipsoid(*axes), 1e-12)
    close(run.energy, run.energy[0], 2e-12)
    close(run.angular_momentum, run.angular_momentum[0], 1e-12, scale=np.abs(run.angular_momentum).max())
    rotations, (first, second) = run[-1].rotation_matrix, run.position[-1]
    # It touches a face's plane, above the face.
    extents = [np.linalg.norm(np.array(axes) * (rotations[1].T @ n)) for n in rotations[0].T]
    offset = rotations[0].T @ (second - first)
    k = np.argmax(np.abs(offset))
    assert abs(offset[k]) - extents[k] == pytest.approx(1.0, abs=1e-11)
    assert np.abs(np.delete(offset, k)).max() < 1.0


def test_a_tumbling_polyhedron_lands_when_a_corner_touches():
    quick = fullbody.Verner98(rtol=1e-8, atol=1e-8)
    run = landing(octahedron(1.0, 0.8, 0.6), octahedron(0.5, 0.4, 0.3), 1e-7, integrator=quick)
    close(run.energy, run.energy[0], 1e-7)
    close(run.angular_momentum, run.angular_momentum[0], 1e-7, scale=np.abs(run.angular_momentum).max())


def wedge(angle):
    """A prism with an edge of this angle along z, at x = 1."""
    y = 2.0 * np.tan(angle / 2.0)
    corners = [[x, s * y, z] for x, s in ((1.0, 0.0), (-1.0, 1.0), (-1.0, -1.0)) for z in (-1.0, 1.0)]
    faces = [[0, 2, 3], [0, 3, 1], [0, 1, 5], [0, 5, 4], [2, 4, 5], [2, 5, 3], [0, 4, 2], [1, 3, 5]]
    return fullbody.Polyhedron(corners, faces)


def fates(shape, positions, velocities):
    """The fates of particles that land on a body too light to bend their straight paths, whose frame is put back."""
    body = Body(shape, mass=1e-18, name="A")
    frame = body.working_frame
    rotation = State([[0.0] * 3], [[0.0] * 3], attitude=[frame.attitude]).rotation_matrix[0]
    at_rest = State([[0.0] * 3], [[0.0] * 3])
    start = fullbody.Particles(np.array(frame.position) + positions @ rotation.T, velocities @ rotation.T)
    return fullbody.System([body], G=1.0).fly(at_rest, start, 3.0, output="ends").fate_time


@pytest.mark.parametrize("angle", [10, 30, 60, 100])
def test_a_pass_beyond_a_sharp_edge_is_no_landing(angle):
    heights = np.geomspace(1e-6, 6e-4, 30)
    beside = np.linspace(-0.9, 0.9, 30)
    sides = np.stack([1.0 + heights, -np.ones(30), beside], axis=1)
    assert np.isnan(fates(wedge(np.radians(angle)), sides, np.tile([0.0, 1.0, 0.0], (30, 1)))).all()
    # Within it they land on the first face, where the wedge is so thick.
    heights = np.geomspace(1e-4, 1e-1, 30)
    sides[:, 0] = 1.0 - heights
    result = fates(wedge(np.radians(angle)), sides, np.tile([0.0, 1.0, 0.0], (30, 1)))
    close(result, 1.0 - heights * np.tan(np.radians(angle) / 2.0), 1e-9)
