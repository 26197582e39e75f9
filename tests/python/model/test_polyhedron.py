"""Polyhedra: against closed forms, exact integrals, arbitrary precision and another program."""

import astropy.units as u
import fullbody
import mpmath
import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, Part, PointMass, Polyhedron, Sphere
from fullbody.errors import InvalidInput, NotConverged
from support import matrix, reference, worst
from support.meshes import CORNERS, CUBE, box, close, focal_points, icosphere, octahedron, pose, torus


def test_a_box_has_its_moments_and_working_frame():
    rotation = matrix(np.array([0.8, 0.1, -0.3, 0.2]) / np.sqrt(0.78))
    point, sides = np.array([3.0, -2.0, 5.0]), np.array([2.0, 1.4, 0.6])
    body = Body(Polyhedron((CORNERS - 0.5) * sides @ rotation.T + point, CUBE), density=2.0)
    close(body.mass, 2.0 * sides.prod(), 1e-14)
    close(body.inertia, (np.sum(sides**2) - sides**2) * body.mass / 12.0, 1e-14)
    frame = body.working_frame
    close(matrix(frame.attitude) @ point + frame.position, 0.0, 4e-15, scale=1.0)
    close(matrix(frame.attitude) @ rotation, np.eye(3), 4e-15)
    close(np.array(body.fitted_ellipsoid().semi_axes), sides * (5.0 / 12.0) ** 0.5, 1e-14)
    # A degenerate principal frame is kept.
    cube = Body(Polyhedron(CORNERS, CUBE), mass=1.0)
    assert cube.working_frame.attitude.tolist() == [1.0, 0.0, 0.0, 0.0]
    tall = Body(box(1.0, 1.0, 3.0), mass=1.0)
    assert tall.working_frame.attitude.tolist() == [1.0, 0.0, 0.0, 0.0]


def werner_scheeres(vertices, faces, volume, x):
    """Potential and field in 50 digits, by the formulas as they stand in the paper."""
    with mpmath.workdps(50):
        exact = np.vectorize(mpmath.mpf, otypes=[object])

        def norm(a):
            return mpmath.sqrt(a @ a)

        vertices = exact(np.asarray(vertices)) - exact(np.asarray(x))
        potential, field = 0, 0
        for a, b, c in (vertices[face] for face in faces):
            n = np.cross(b - a, c - a)
            n = n / norm(n)
            height = n @ a
            p, q, r = map(norm, (a, b, c))
            half = mpmath.atan2(a @ np.cross(b, c), p * q * r + p * (b @ c) + q * (c @ a) + r * (a @ b))
            total = -height * 2 * half
            for p, q in ((a, b), (b, c), (c, a)):
                e = norm(q - p)
                outward = np.cross(q - p, n) / e
                total += (outward @ p) * mpmath.log((norm(p) + norm(q) + e) / (norm(p) + norm(q) - e))
            potential += height * total / 2
            field -= n * total
        return float(potential / volume), (field / volume).astype(float)


@pytest.mark.parametrize(
    "x",
    [
        (0.2, 0.1, 0.05),
        (1.3, 0.4, -0.2),
        (0.5001, 0.4, 0.0),
        (0.5 + 1e-9, 0.4 + 1e-9, 0.1),
        (2.0, 1.0, 3.0),
        (9.0, -4.0, 6.0),
        (300.0, 200.0, -500.0),
        (3e6, 2e6, -5e6),
    ],
)
def test_the_field_has_all_digits_near_edges_and_far_away(x):
    solid = box(1.0, 0.8, 0.6)
    x = np.array(x)
    potential, field = werner_scheeres(solid.vertices, solid.faces, 0.48, x)
    body = Body(solid, mass=1.0)
    # Near a surface some digits of the point itself are lost, in the differences to its corners.
    result = body.gravity(x, G=1.0)
    close(result.potential, potential, 3e-14)
    close(result.field, field, 3e-14)


def test_the_field_is_that_of_another_program():
    peer = pytest.importorskip("polyhedral_gravity")
    solid = icosphere(2, (1.0, 0.8, 0.6))
    body = Body(solid, mass=1.0)
    rng = np.random.default_rng(5)
    directions = rng.normal(size=(50, 3))
    points = directions / np.linalg.norm(directions, axis=1)[:, None] * rng.uniform(0.2, 1.5, size=(50, 1))
    other = peer.Polyhedron(
        polyhedral_source=(solid.vertices, solid.faces),
        density=1.0 / solid.volume,
        normal_orientation=peer.NormalOrientation.OUTWARDS,
        integrity_check=peer.PolyhedronIntegrity.DISABLE,
    )
    rows = peer.evaluate(polyhedron=other, computation_points=points, parallel=False)
    # Its G is that of CODATA 2018, and its acceleration has one sign or the other, by its version.
    potential, field = (np.array([row[k] for row in rows]) / 6.67430e-11 for k in (0, 1))
    result = body.gravity(points, G=1.0)
    close(result.potential, potential, 1e-12)
    close(result.field, np.sign(np.sum(field * result.field)) * field, 1e-12)


def test_two_octahedra_have_the_interactions_of_a_volume_integral():
    references = reference("octahedra")
    bodies = [Body(octahedron(*references[f"half_diagonals_{k}"]), mass=1.0, name=k) for k in "ab"]
    state = fullbody.State.from_tait_bryan(
        [[0.0, 0.0, 0.0], references["separation"]], np.zeros((2, 3)), [references["angles_a"], references["angles_b"]]
    )
    result = fullbody.System(bodies, G=1.0).interactions(state)
    force = np.array(references["force_on_a_inertial"], dtype=float)
    close(result.force, [force, -force], 1e-14)
    close(result.potential_energy, float(references["potential_energy"]), 1e-14)
    torques = np.array([references[f"torque_on_{k}_body"] for k in "ab"], dtype=float)
    close(result.torque, torques, 1e-14, scale=np.abs(force).max())


@pytest.mark.parametrize("other", [octahedron(0.5, 0.4, 0.3), Ellipsoid(0.5, 0.4, 0.3), PointMass()], ids=repr)
def test_the_mutual_expansion_converges_to_the_exact_interactions(other):
    ball = icosphere(0, (1.0, 0.9, 0.7))
    lump = Polyhedron(ball.vertices**3 + 0.3, ball.faces)
    bodies = [Body(lump, mass=1.0, name="A"), Body(other, mass=2.0, name="B")]
    state = pose([1.9, -2.4, 2.6])

    def loads(**options):
        f = fullbody.System(bodies, G=1.0, **options).interactions(state)
        return np.concatenate([np.ravel(f.force), np.ravel(f.torque), [f.potential_energy]])

    exact = loads()
    errors = [worst(loads(gravity=f"multipole:{n}"), exact, np.abs(exact[:6]).max()) for n in (2, 4, 8, 12, 16)]
    assert errors[1] < 0.2 * errors[0], errors
    assert errors[2] < 0.2 * errors[1], errors
    assert errors[-1] < 3e-14, errors


def test_a_series_that_diverges_says_so():
    bodies = [Body(octahedron(*[size] * 3), mass=1.0, name=name) for size, name in ((1.0, "A"), (0.9, "B"))]
    with pytest.raises(NotConverged, match=r"multipole:4 between A and B .* diverges"):
        fullbody.System(bodies, G=1.0, gravity="multipole:4").interactions(pose([0.9, -0.9, 0.8]))


@pytest.mark.parametrize("mesh", [True, False])
@pytest.mark.parametrize("distance", [4.0, 8.0])
def test_a_series_states_its_truncation_error(mesh, distance):
    shapes = (box(1.0, 0.8, 0.5), octahedron(0.7, 0.5, 0.3)) if mesh else (Ellipsoid(1, 0.8, 0.6), Sphere(0.5))
    lobes = Composite([Part(Ellipsoid(0.5, 0.4, 0.4), mass=2.0), Part(Sphere(0.3), mass=1.0, position=[0.7, 0, 0])])
    for second in (shapes[1], lobes):
        bodies = [Body(shapes[0], mass=2.0, name="A"), Body(second, mass=None if second is lobes else 1.0, name="B")]
        state = pose([0.6 * distance, 0.64 * distance, 0.48 * distance])
        exact = fullbody.System(bodies, G=1.0).interactions(state)
        assert exact.truncation_error == 0.0
        size = np.linalg.norm(exact.force[0])
        for degree in (2, 4, 6):
            result = fullbody.System(bodies, G=3.0, gravity=f"multipole:{degree}").interactions(state)
            error = np.linalg.norm(result.force[0] / 3.0 - exact.force[0]) / size
            torque = np.linalg.norm(result.torque / 3.0 - exact.torque, axis=1).max() / size
            # The torque is counted by the bodies' radii, which are not far from one.
            assert 0.7 * max(error, torque) < result.truncation_error < 6.0 * max(error, torque), (
                degree,
                error,
                torque,
            )
    highest = fullbody.System(bodies, G=1.0, gravity="multipole:16").interactions(state)
    assert 0.0 <= highest.truncation_error < 1e-7


def test_layers_of_a_polyhedron_attract_as_the_difference_of_two():
    # A pyramid on a parallelogram, whose centre of mass is a quarter of the way from the base's centre to the apex.
    corners = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [2.3, 1.6, 0.1], [0.3, 1.5, 0.1], [0.2, 0.4, 1.2]]) + 5.0
    faces = [[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]
    smaller = 0.4 * (0.75 * corners[:4].mean(axis=0) + 0.25 * corners[4]) + 0.6 * corners
    shell = Composite.layers(Polyhedron(corners, faces), fractions=(1.0, 0.6), densities=(3.0, 0.0))
    close(shell.parts[1].shape.vertices, smaller, 1e-15)
    bodies = [Body(shell, name="A"), *(Body(Polyhedron(c, faces), density=3.0, name="A") for c in (corners, smaller))]
    assert bodies[0].mass == pytest.approx(bodies[1].mass - bodies[2].mass, rel=1e-13)
    state = fullbody.State([[0, 0, 0], [1.5, 1.2, -1.8]], np.zeros((2, 3)))
    # The three have one centre and one principal frame.
    ball = Body(Sphere(0.1), mass=2.0, name="B")
    result, complete, core = (fullbody.System([body, ball], G=1.0).interactions(state) for body in bodies)
    size = np.abs(complete.force).max()
    for name in ("force", "torque", "potential_energy"):
        close(getattr(result, name), getattr(complete, name) - getattr(core, name), 1e-13, scale=size)
    with_units = Polyhedron(corners * u.km, faces)
    layers = Composite.layers(with_units, fractions=(1.0, 0.6), densities=(3.0 * u.kg / u.km**3, 5.0 * u.kg / u.km**3))
    assert Body(layers).mass.to_value("kg") == pytest.approx((3.0 + 2.0 * 0.6**3) * with_units.volume.value, rel=1e-13)


def test_layers_of_a_polyhedron_that_is_not_seen_from_its_centre_are_refused():
    # An arrow head: two blocks that meet at a right angle have their centre of mass in the notch.
    outline = np.array([[0, 0], [3, 0], [3, 0.2], [0.2, 0.2], [0.2, 3], [0, 3]])
    corners = np.concatenate([np.column_stack([outline, np.full(6, z)]) for z in (0.0, 0.2)])
    cap = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    sides = [f for k in range(6) for f in ([k, (k + 1) % 6, (k + 1) % 6 + 6], [k, (k + 1) % 6 + 6, k + 6])]
    angle = Polyhedron(corners, np.concatenate([cap[:, ::-1], cap + 6, sides]))
    with pytest.raises(InvalidInput, match=r"face \d+ points away from its centre of mass"):
        Composite.layers(angle, fractions=(1.0, 0.5), densities=(1.0, 2.0))


@pytest.mark.parametrize("distance", [1.7, 2.4, 5.0, 40.0, 3000.0])
@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_polyhedron_and_ellipsoid_attract_each_other_equally(distance, order):
    axes = (0.9, 0.7, 0.5)
    bodies = [Body(box(1.0, 0.9, 0.7), mass=1.0, name="box"), Body(Ellipsoid(*axes), mass=2.0, name="egg")]
    state = pose(distance * np.array([0.48, -0.6, 0.64]))
    matrices = state.rotation_matrix
    points, weights = focal_points(*axes)
    arms = points @ matrices[1].T
    result = bodies[0].gravity((state.position[1] + arms) @ matrices[0], G=1.0)
    field, potential = result.field @ matrices[0].T, result.potential
    force = 2.0 * weights @ field
    torque = 2.0 * weights @ np.cross(arms, field) @ matrices[1]
    back = -2.0 * weights @ np.cross(state.position[1] + arms, field) @ matrices[0]
    state = fullbody.State(state.position[order], state.velocity, state.attitude[order])
    result = fullbody.System([bodies[k] for k in order], G=1.0).interactions(state)
    close(result.force[order], [-force, force], 2e-14)
    close(result.torque[order], [back, torque], 2e-14, scale=np.abs(force).max() * max(1.0, 3.0 * distance * 1e-2))
    close(result.potential_energy, -2.0 * weights @ potential, 2e-14)


@pytest.mark.parametrize("other", [Sphere(0.4), PointMass(), "composite"])
def test_polyhedra_attract_spheres_points_and_composites_by_their_field(other):
    body, state, centres = Body(box(1.0, 0.9, 0.7), mass=1.5, name="A"), pose([0.9, -0.7, 0.6]), [np.zeros(3)]
    if other == "composite":
        locations = np.array([[x, 0.2 * x, 0.0] for x in (-0.2, 0.3)])
        probe = Body(Composite([Part(Sphere(0.1), mass=1.0, position=point) for point in locations]), name="B")
        centres = locations @ matrix(probe.working_frame.attitude).T + probe.working_frame.position
    else:
        probe = Body(other, mass=2.0, name="B")
    result = fullbody.System([body, probe], G=1.0).interactions(state)
    matrices = state.rotation_matrix
    arms = centres @ matrices[1].T
    pulls = 2.0 / len(arms) * body.gravity((state.position[1] + arms) @ matrices[0], G=1.0).field @ matrices[0].T
    force, torque = pulls.sum(axis=0), np.cross(arms, pulls).sum(axis=0)
    close(result.force, [-force, force], 1e-14)
    close(result.torque[1], matrices[1].T @ torque, 1e-14, scale=np.abs(force).max())


def test_two_halves_of_a_box_attract_as_the_box():
    complete = Body(box(1.2, 0.8, 0.6), density=2.0, name="A")
    half = Polyhedron((CORNERS - [1.0, 0.5, 0.5]) * [0.6, 0.8, 0.6], CUBE)
    parts = [Part(half, density=2.0), Part(half, density=2.0, position=(0.6, 0.0, 0.0))]
    halves = Body(Composite(parts), name="A")
    close(halves.inertia, complete.inertia, 1e-14)
    probe = Body(Ellipsoid(0.5, 0.4, 0.3), mass=1.0, name="B")
    state = pose([1.1, 0.9, -0.8])
    item, two = (fullbody.System([body, probe], G=1.0).interactions(state) for body in (complete, halves))
    close(two.force, item.force, 2e-14)
    close(two.torque, item.torque, 2e-14, scale=np.abs(item.force).max())


def test_numbering_turning_and_units_change_nothing():
    solid = icosphere(1, (1.0, 0.7, 0.5))
    probe = Body(Ellipsoid(0.5, 0.4, 0.3), mass=1.0, name="B")
    state = pose([1.6, 0.9, -1.1])
    expected = fullbody.System([Body(solid, mass=1.0, name="A"), probe], G=1.0).interactions(state)
    rng = np.random.default_rng(1)
    order = rng.permutation(len(solid.vertices))
    faces = np.argsort(order)[np.roll(solid.faces, 1, axis=1)][rng.permutation(len(solid.faces))]
    again = Polyhedron(solid.vertices[order], faces)
    result = fullbody.System([Body(again, mass=1.0, name="A"), probe], G=1.0).interactions(state)
    close(result.force, expected.force, 5e-15)
    with_units = Polyhedron(solid.vertices * 1000.0 * u.m, solid.faces)
    body = Body(with_units, mass=3.0 * u.kg)
    unitless = Body(solid, mass=3.0)
    G = 6.0e-11
    points = np.array([[1.5, 0.2, 0.1], [20.0, 1.0, 3.0]])
    field = body.gravity(points * u.km, G=G * u.m**3 / u.kg / u.s**2).field
    close(field.to_value(u.km / u.s**2), unitless.gravity(points, G=G * 1e-9).field, 1e-14)
    close(body.inertia.to_value(u.kg * u.km**2), unitless.inertia, 1e-14)
    close(with_units.volume.to_value(u.km**3), solid.volume, 1e-14)


@pytest.mark.parametrize(
    "integrator",
    [
        fullbody.Verner98(),
        fullbody.Verner87(rtol=1e-12, atol=1e-12),
        fullbody.Verner76(rtol=1e-12, atol=1e-12),
        fullbody.Verner65(rtol=1e-11, atol=1e-11),
        fullbody.DormandPrince54(rtol=1e-11, atol=1e-11),
        fullbody.LieGroupVariational(step=0.05),
        fullbody.SymplecticSplitting(step=0.05),
    ],
    ids=lambda i: type(i).__name__,
)
def test_octahedra_keep_energy_and_momenta(integrator):
    # The binary is that of Fahnestock and Scheeres (2006).
    bodies = [Body(octahedron(1.0, 0.8, 0.6), mass=1.0, name="A"), Body(octahedron(0.5, 0.4, 0.3), mass=0.2, name="B")]
    system = fullbody.System(bodies, G=1.0, gravity_tolerance=1e-10)
    start = fullbody.State.from_tait_bryan(
        [[-0.5, 0.0, 0.0], [2.5, 0.0, 0.0]],
        [[0.0, -0.1, 0.0], [0.0, 0.5, 0.02]],
        [[0.2, 0.3, -0.4], [1.1, -0.5, 0.6]],
        [[0.05, 0.1, 0.4], [0.1, -0.1, 0.3]],
    )
    run = system.integrate(start, 3.0, integrator=integrator, output=0.5)
    fixed = hasattr(integrator, "step")
    # A step's own error is none of the forces'; both momenta do not know it.
    close(run.energy, run.energy[0], 2e-3 if fixed else 1e-10)
    close(run.angular_momentum, run.angular_momentum[0], 1e-10, scale=np.abs(run.angular_momentum[0]).max())
    momentum = sum(body.mass * run.velocity[:, k] for k, body in enumerate(bodies))
    close(momentum, momentum[0], 1e-14, scale=0.1)


@pytest.mark.parametrize(("distance", "speed", "across"), [(12.0, -1.2, 0.2), (3.0, 1.2, 0.6)], ids=["in", "out"])
def test_two_polyhedra_of_one_size_keep_energy_whichever_is_integrated_over(distance, speed, across):
    # On the way the two take turns as the body that is integrated over, with layers of equal order.
    bodies = [Body(octahedron(1.0, 0.8, 0.6), mass=1.0, name="A"), Body(box(1.2, 1.0, 1.1), mass=0.5, name="B")]
    start = fullbody.State(
        [[0.0, 0.0, 0.0], [distance, 0.5, 0.3]],
        [[0.0, 0.0, 0.0], [speed, across, 0.1]],
        [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5]],
        [[0.1, 0.2, 0.3], [0.3, 0.1, 0.0]],
    )
    integrator = fullbody.DormandPrince54(rtol=1e-11, atol=1e-11)
    simulation = fullbody.Simulation(fullbody.System(bodies, G=1.0, gravity="surface"), start, integrator=integrator)
    integrated, drifts = [], []
    while simulation.time < 3.0:
        simulation.step()
        integrated.append(simulation.quadrature[0]["integrated"])
        drifts.append(abs(simulation.energy_drift))
    assert set(integrated) == {"A", "B"}
    assert max(drifts) < 1e-10


@pytest.mark.parametrize("thin", [1e-6, 1e-9, 1e-11])
def test_thin_faces_in_a_plane_change_nothing(thin):
    # A face cut at a point beside one of its corners: two of the three new faces are slivers.
    vertices = np.array([[1.03, 0.11, 0.21], [-0.42, 0.93, 0.14], [-0.51, -0.72, 0.33], [0.12, 0.07, -0.81]])
    faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]
    new = vertices[0] + thin * (vertices[1] + vertices[2] - 2 * vertices[0])
    divided = [*faces[1:], [0, 1, 4], [1, 2, 4], [2, 0, 4]]
    shapes = Polyhedron(vertices, faces), Polyhedron([*vertices, new], divided)
    points = [[2.0, 0.3, 0.4], [1.2, 0.1, 0.1], [0.5, 0.6, 0.7], [0.0, 0.1, 0.05]]
    expected, result = (Body(shape, mass=1.0).gravity(points, G=1.0) for shape in shapes)
    for k in range(4):
        close(result.potential[k], expected.potential[k], 1e-13)
        close(result.field[k], expected.field[k], 1e-13)


@pytest.mark.parametrize("far", [50.0, 1e6, 1e12])
def test_vertices_without_a_face_do_not_count(far):
    shape = octahedron(1.0, 0.8, 0.6)
    other = Polyhedron(np.vstack([shape.vertices, [far, far, 0.0]]), shape.faces)
    assert other.volume == shape.volume
    first, second = (Body(s, mass=1.0).gravity([1.3, 0.2, 0.1], G=1.0) for s in (shape, other))
    assert np.array_equal(first.field, second.field)


def force_by_volume(body, solid, mass, point, rotation, count):
    """A body's force on a star-shaped solid: Gauss points in the tetrahedra between its origin and faces."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    r, s, t = np.meshgrid(*[(nodes + 1.0) / 2.0] * 3, indexing="ij")
    weight = np.prod(np.meshgrid(*[weights / 2.0] * 3, indexing="ij"), axis=0)
    force, volume = np.zeros(3), 0.0
    for a, b, c in solid.vertices[solid.faces]:
        r_, s_, t_ = (x[..., None] for x in (r, s, t))
        points = r_ * ((1.0 - s_) * a + s_ * ((1.0 - t_) * b + t_ * c))
        share = (weight * r**2 * s * np.linalg.det([a, b, c])).ravel()
        force += share @ body.gravity(points.reshape(-1, 3) @ rotation.T + point, G=1.0).field
        volume += share.sum()
    return mass * force / volume


@pytest.mark.parametrize("seed", range(12))
def test_force_of_a_large_polyhedron_on_small_parts_keeps_its_digits(seed):
    large, small = octahedron(1.0, 0.8, 0.6), octahedron(0.06, 0.05, 0.04)
    parts = [Part(small, mass=0.5, position=(x, 0.0, 0.0)) for x in (-0.07, 0.07)]
    bodies = [Body(large, mass=2.0, name="large"), Body(Composite(parts), name="pair")]
    rng = np.random.default_rng(seed)
    direction, rotation = rng.normal(size=3), rng.normal(size=4)
    point = rng.uniform(1.13, 1.3) * direction / np.linalg.norm(direction)
    attitude = [[1.0, 0.0, 0.0, 0.0], rotation / np.linalg.norm(rotation)]
    state = fullbody.State([[0.0] * 3, point], np.zeros((2, 3)), attitude, np.zeros((2, 3)))

    rotation = matrix(attitude[1])
    at = [point + rotation @ part.position for part in parts]
    expected = sum(force_by_volume(bodies[0], small, 0.5, x, rotation, 10) for x in at)
    result = fullbody.System(bodies, G=1.0).interactions(state).force
    close(result, [-expected, expected], 3e-14)


@pytest.mark.parametrize("distance", [1e-1, 1e-3, 1e-6])
def test_force_near_the_centre_of_a_ring_is_exact_to_rounding(distance):
    ring, grain = torus(1.0, 0.3), octahedron(0.3, 0.24, 0.18)
    bodies = [Body(ring, mass=1.0, name="ring"), Body(grain, mass=0.1, name="grain")]
    point = distance * np.array([0.6, -0.48, 0.64])
    state = fullbody.State([[0.0] * 3, point], np.zeros((2, 3)), [[1.0, 0.0, 0.0, 0.0]] * 2, np.zeros((2, 3)))

    expected = force_by_volume(bodies[0], grain, 0.1, point, np.eye(3), 16)
    result = fullbody.System(bodies, G=1.0).interactions(state).force
    close(result, [-expected, expected], 3e-14, scale=0.1)
