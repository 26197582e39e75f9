"""Polyhedra of many faces near each other: the sum over fragments against quadrature over few faces."""

from itertools import product

import fullbody
import numpy as np
import pytest
from fullbody import Body, Polyhedron, State, System
from fullbody.errors import BodiesOverlap, NotConverged
from scipy.spatial.transform import Rotation
from support.attraction import attraction
from support.meshes import box, convex_hull, octahedron


def finer(polyhedron, level):
    """Divide each face of a solid into 4**level faces in its plane."""
    vertices, faces = [tuple(v) for v in polyhedron.vertices], [tuple(face) for face in polyhedron.faces]
    for _ in range(level):
        middles: dict = {}

        def middle(i, j, middles=middles):
            key = (min(i, j), max(i, j))
            if key not in middles:
                middles[key] = len(vertices)
                vertices.append(tuple(0.5 * (np.array(vertices[i]) + vertices[j])))
            return middles[key]

        divided = []
        for a, b, c in faces:
            d, e, f = middle(b, c), middle(c, a), middle(a, b)
            divided += [(a, f, e), (f, b, d), (e, d, c), (d, e, f)]
        faces = divided
    return Polyhedron(np.array(vertices), faces)


def hull(rng, count, size):
    points = rng.normal(size=(count, 3))
    points *= size / np.linalg.norm(points, axis=1)[:, None] * rng.uniform(0.8, 1.0, size=(count, 1))
    return convex_hull(points)


def notched():
    """A box with a pyramid cut out of its upper face."""
    base = box(1.0, 0.9, 0.8)
    corners = np.vstack([base.vertices, [[0.05, 0.0, -0.1]]])
    faces = [face for face in base.faces if not all(corners[v][2] > 0.0 for v in face)]
    rim = [4, 5, 7, 6]
    return Polyhedron(corners, np.array([*faces, *[[rim[k], rim[(k + 1) % 4], 8] for k in range(4)]]))


SHAPES = {
    "octahedra": lambda rng: (octahedron(1.0, 0.8, 0.6), octahedron(0.7, 0.6, 0.5)),
    "cubes": lambda rng: (box(1.0, 1.0, 1.0), box(0.6, 0.5, 0.4)),
    "hulls": lambda rng: (hull(rng, 11, 1.0), hull(rng, 9, 0.5)),
    "notched": lambda rng: (notched(), octahedron(0.4, 0.3, 0.3)),
}


def vertices_of(polyhedron):
    """The vertices in the frame of the centre of mass and the principal axes."""
    frame = Body(polyhedron, mass=1.0).working_frame
    return Rotation.from_quat(frame.attitude, scalar_first=True).apply(np.array(polyhedron.vertices)) + frame.position


def triangles(polyhedron, position, rotation):
    """The faces in the inertial frame."""
    return (rotation.apply(vertices_of(polyhedron)) + position)[np.asarray(polyhedron.faces)]


def bodies_of(shapes):
    return [Body(shape, mass=mass, name=name) for shape, mass, name in zip(shapes, (2.0, 0.3), "AB", strict=True)]


def radius(body):
    return np.linalg.norm(vertices_of(body.shape), axis=1).max()


def near(rng, shapes, gap):
    """A random pose beyond contact by this fraction of the smaller body's circumradius."""
    rotations = Rotation.random(2, random_state=rng)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    attitude, zeros = rotations.as_quat(scalar_first=True), np.zeros((2, 3))
    bodies = bodies_of(shapes)
    system = System(bodies, G=1.0)
    low, high = 0.0, sum(radius(body) for body in bodies)

    def at(distance):
        return State([np.zeros(3), distance * direction], zeros, attitude=attitude, spin=zeros)

    for _ in range(30):
        middle = 0.5 * (low + high)
        try:
            system.momentum(at(middle))
        except BodiesOverlap:
            low = middle
        else:
            high = middle
    return at(high + gap * min(radius(body) for body in bodies)), rotations


def errors_of(result, expected, bodies):
    """Errors of the force, and of the torques over the radii, relative to the force."""
    force, *torques = expected
    strength = bodies[0].mass * bodies[1].mass
    size = strength * np.linalg.norm(force)
    errors = [np.linalg.norm(result.force[1] - strength * force) / size]
    for k, body in enumerate(bodies):
        errors.append(np.linalg.norm(result.torque[k] - strength * torques[k]) / size / radius(body))
    return errors


CASES = [
    *product(SHAPES, (0.01, 0.1), (1e-3, 1e-6)),
    ("octahedra", 0.3, 1e-10),
    ("notched", 0.3, 1e-10),
    ("cubes", 0.01, 1e-10),
]


@pytest.mark.parametrize(("kind", "gap", "tolerance"), CASES)
def test_the_error_is_below_its_bound_and_the_bound_below_the_tolerance(kind, gap, tolerance):
    rng = np.random.default_rng(round(100 * gap) + len(kind))
    coarse = SHAPES[kind](rng)
    state, rotations = near(rng, coarse, gap)
    first, second = (triangles(*entry) for entry in zip(coarse, state.position, rotations, strict=True))
    expected = list(attraction(first, second, state.position))
    expected[1:] = [rotation.inv().apply(torque) for rotation, torque in zip(rotations, expected[1:], strict=True)]
    bodies = bodies_of([finer(shape, 3) for shape in coarse])
    result = System(bodies, G=1.0, gravity_tolerance=tolerance).interactions(state)
    assert 0.0 < result.truncation_error <= tolerance
    assert max(errors_of(result, expected, bodies)) <= result.truncation_error + 1e-12


def edge_of_series(system, state, outside):
    """The separations on both sides of the change from the harmonic series, within rounding, along a line."""
    direction = state.position[1] / np.linalg.norm(state.position[1])

    def at(distance):
        return state.replace(position=[np.zeros(3), distance * direction])

    low, high = np.linalg.norm(state.position[1]), outside
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if system.interactions(at(middle)).truncation_error > 0.0 else (low, middle)
    return at(low), at(high)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_the_force_has_no_step_beyond_the_tolerance_where_the_rule_changes(tolerance):
    rng = np.random.default_rng(3)
    coarse = SHAPES["octahedra"](rng)
    bodies = bodies_of([finer(shape, 3) for shape in coarse])
    system = System(bodies, G=1.0, gravity_tolerance=tolerance)
    exact = System(bodies_of(coarse), G=1.0, gravity="surface", gravity_tolerance=1e-13)
    state, _ = near(rng, coarse, 0.3)
    inside, outside = edge_of_series(system, state, 2.6)
    results = [system.interactions(sample) for sample in (inside, outside)]
    assert results[0].truncation_error > 0.0 == results[1].truncation_error
    expected = exact.interactions(inside)
    strength = bodies[0].mass * bodies[1].mass
    scaled = [expected.force[1] / strength, *(expected.torque / strength)]
    errors = [errors_of(sample, scaled, bodies) for sample in results]
    assert np.max(errors) < tolerance
    torques = np.linalg.norm(results[0].torque - results[1].torque, axis=1)
    steps = [np.linalg.norm(results[0].force[1] - results[1].force[1]), *torques]
    sizes = np.array([1.0, radius(bodies[0]), radius(bodies[1])]) * np.linalg.norm(expected.force[1])
    assert (steps / sizes < tolerance).all()
    assert abs(results[0].potential_energy / expected.potential_energy - 1.0) < tolerance
    assert abs(results[1].potential_energy / expected.potential_energy - 1.0) < tolerance


def test_a_run_that_is_resumed_before_the_change_equals_the_unbroken_one_bit_for_bit(tmp_path):
    rng = np.random.default_rng(5)
    coarse = SHAPES["octahedra"](rng)
    system = System(bodies_of([finer(shape, 3) for shape in coarse]), G=1.0, gravity_tolerance=1e-3)
    position, _ = near(rng, coarse, 0.3)
    direction = position.position[1] / np.linalg.norm(position.position[1])
    state = position.replace(position=[np.zeros(3), 1.9 * direction], velocity=[np.zeros(3), -0.9 * direction])
    unbroken, broken = (
        fullbody.Simulation(system, state, integrator=fullbody.Verner98(rtol=1e-5, atol=1e-5)) for _ in range(2)
    )
    for simulation in (unbroken, broken):
        simulation.integrate(0.1)
    broken.save(tmp_path / "run.fullbody")
    resumed = fullbody.Simulation.load(tmp_path / "run.fullbody")
    middles = [simulation.integrate(0.3) for simulation in (unbroken, resumed)]
    resumed.save(tmp_path / "run.fullbody")
    resumed = fullbody.Simulation.load(tmp_path / "run.fullbody")
    for first, second in (middles, [simulation.integrate(0.4) for simulation in (unbroken, resumed)]):
        assert np.array_equal(first.position, second.position)
        assert np.array_equal(first.attitude, second.attitude)
        assert np.array_equal(first.energy, second.energy)
    ends = [system.interactions(sample).truncation_error for sample in (state, unbroken.state)]
    assert ends[0] == 0.0 < ends[1]


@pytest.mark.parametrize("distance", [1.72, 1.75, 1.78])
def test_runs_that_start_just_outside_the_circumscribed_spheres_go_on_inside(distance):
    """The trial of the first step lies where the series has no value: the step has to become shorter, not zero."""
    rng = np.random.default_rng(5)
    coarse = SHAPES["octahedra"](rng)
    system = System(bodies_of([finer(shape, 3) for shape in coarse]), G=1.0, gravity_tolerance=1e-3)
    pose, _ = near(rng, coarse, 0.3)
    direction = pose.position[1] / np.linalg.norm(pose.position[1])
    state = pose.replace(position=[np.zeros(3), distance * direction], velocity=[np.zeros(3), -0.9 * direction])
    simulation = fullbody.Simulation(system, state, integrator=fullbody.Verner98(rtol=1e-5, atol=1e-5))
    assert simulation.quadrature[0]["method"] == "harmonic"
    run = simulation.integrate(0.1)
    assert run.time[-1] == 0.1
    assert abs(run.energy_drift).max() < 1e-3


@pytest.mark.parametrize("kind", ["octahedra", "hulls"])
def test_derivatives_are_those_of_the_rule_over_few_faces(kind):
    rng = np.random.default_rng(8)
    coarse = SHAPES[kind](rng)
    state, _ = near(rng, coarse, 0.2)
    exact = System(bodies_of(coarse), G=1.0, gravity="surface", gravity_tolerance=1e-10)
    result = System(bodies_of([finer(shape, 3) for shape in coarse]), G=1.0, gravity_tolerance=1e-6)
    assert result.interactions(state).truncation_error > 0.0
    names = [name for name in exact.parameters if name.startswith(("scale", "mass", "G"))]
    first, other = exact.jacobian(state, names), result.jacobian(state, names)
    np.testing.assert_allclose(other.rates, first.rates, atol=1e-6 * np.abs(first.rates).max(), rtol=0.0)
    assert any(name.startswith("scale") for name in names)
    for name in names:
        size = np.abs(first.by_parameter[name]).max()
        np.testing.assert_allclose(other.by_parameter[name], first.by_parameter[name], atol=1e-6 * size, rtol=0.0)


def test_the_harmonic_series_alone_does_not_converge_near_by():
    rng = np.random.default_rng(1)
    coarse = SHAPES["cubes"](rng)
    state, _ = near(rng, coarse, 0.05)
    bodies = bodies_of([finer(shape, 3) for shape in coarse])
    with pytest.raises(NotConverged, match=r"harmonic between A and B .* their moments diverges"):
        System(bodies, G=1.0, gravity="harmonic").interactions(state)
