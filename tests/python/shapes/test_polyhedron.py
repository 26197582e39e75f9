"""Polyhedra: against closed forms, exact integrals, arbitrary precision and another program."""

import json
from itertools import permutations

import astropy.units as u
import fullbody
import mpmath
import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, Part, PointMass, Polyhedron, Sphere
from support import DATA, matrix, reference

CUBE = np.array([0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4]).reshape(6, 3)
CUBE = np.concatenate([CUBE, [[2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5]]])
CORNERS = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], dtype=float)


def box(*sides):
    """A box about the origin."""
    return Polyhedron((CORNERS - 0.5) * sides, CUBE)


def octahedron(a, b, c):
    ends = np.repeat(np.diag([a, b, c]), 2, axis=0) * np.tile([1.0, -1.0], 3)[:, None]
    faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    return Polyhedron(ends, faces)


def icosphere(level, axes=(1.0, 1.0, 1.0)):
    """20 * 4**level triangles with corners on an ellipsoid."""
    golden = (1.0 + 5.0**0.5) / 2.0
    points = [(0.0, s, t * golden) for s in (1, -1) for t in (1, -1)]
    points = [np.roll(p, k) for k in range(3) for p in points]
    points = [p / np.linalg.norm(p) for p in points]
    edge = min(np.linalg.norm(p - q) for p in points for q in points if p is not q)

    def near(*corners):
        return all(np.linalg.norm(points[i] - points[j]) < 1.01 * edge for i in corners for j in corners)

    faces = [
        (i, j, k)
        for i, j, k in permutations(range(12), 3)
        if i < min(j, k) and near(i, j, k) and np.linalg.det([points[i], points[j], points[k]]) > 0.0
    ]
    for _ in range(level):
        middles: dict = {}

        def middle(i, j, middles=middles):
            key = (min(i, j), max(i, j))
            if key not in middles:
                middles[key] = len(points)
                points.append((points[i] + points[j]) / np.linalg.norm(points[i] + points[j]))
            return middles[key]

        split = []
        for i, j, k in faces:
            p, q, r = middle(i, j), middle(j, k), middle(k, i)
            split += [(i, p, r), (p, j, q), (r, q, k), (p, q, r)]
        faces = split
    return Polyhedron(np.array(points) * axes, faces)


def close(found, expected, tolerance, scale=None):
    size = np.abs(expected).max() if scale is None else scale
    assert np.abs(np.asarray(found) - expected).max() <= tolerance * size, (found, expected)


def pose(separation, seed=3, spin=0.0):
    rng = np.random.default_rng(seed)
    attitude = rng.normal(size=(2, 4))
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    position = np.array([np.zeros(3), separation])
    return fullbody.State(position, np.zeros((2, 3)), attitude=attitude, spin=spin * rng.normal(size=(2, 3)))


def test_a_box_has_its_moments_and_tells_its_working_frame():
    q = np.array([0.8, 0.1, -0.3, 0.2])
    q /= np.linalg.norm(q)
    place = np.array([3.0, -2.0, 5.0])
    sides = np.array([2.0, 1.4, 0.6])
    corners = (CORNERS - 0.5) * sides
    body = Body(Polyhedron(corners @ matrix(q).T + place, CUBE), density=2.0)
    close(body.mass, 2.0 * sides.prod(), 1e-14)
    own = (np.sum(sides**2) - sides**2) * body.mass / 12.0
    close(body.inertia, own, 1e-14)
    frame = body.working_frame
    close(matrix(frame.attitude) @ place + frame.position, 0.0, 4e-15, scale=1.0)
    close(matrix(frame.attitude) @ matrix(q), np.eye(3), 4e-15)
    close(np.array(body.fitted_ellipsoid().semi_axes), sides * (5.0 / 12.0) ** 0.5, 1e-14)


def test_a_degenerate_principal_frame_is_kept():
    cube = Body(Polyhedron(CORNERS, CUBE), mass=1.0)
    assert cube.working_frame.attitude.tolist() == [1.0, 0.0, 0.0, 0.0]
    tall = Body(box(1.0, 1.0, 3.0), mass=1.0)
    assert tall.working_frame.attitude.tolist() == [1.0, 0.0, 0.0, 0.0]


def werner_scheeres(vertices, faces, volume, x):
    """Potential and field in 50 digits, by the formulas as they stand in the paper."""
    with mpmath.workdps(50):
        vertices = [[mpmath.mpf(float(c)) - mpmath.mpf(float(y)) for c, y in zip(v, x, strict=True)] for v in vertices]

        def dot(a, b):
            return sum(p * q for p, q in zip(a, b, strict=True))

        def minus(a, b):
            return [p - q for p, q in zip(a, b, strict=True)]

        def cross(a, b):
            return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

        def norm(a):
            return mpmath.sqrt(dot(a, a))

        potential, field = mpmath.mpf(0), [mpmath.mpf(0)] * 3
        for face in faces:
            corners = [vertices[v] for v in face]
            n = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]))
            n = [c / norm(n) for c in n]
            height = dot(n, corners[0])
            a, b, c = corners
            p, q, r = map(norm, corners)
            half = mpmath.atan2(dot(a, cross(b, c)), p * q * r + p * dot(b, c) + q * dot(c, a) + r * dot(a, b))
            total = -height * 2 * half
            for k in range(3):
                p, q = corners[k], corners[(k + 1) % 3]
                along = minus(q, p)
                e = norm(along)
                outward = [c / e for c in cross(along, n)]
                total += dot(outward, p) * mpmath.log((norm(p) + norm(q) + e) / (norm(p) + norm(q) - e))
            potential += height * total / 2
            field = [f - c * total for f, c in zip(field, n, strict=True)]
        return float(potential / volume), np.array([float(f / volume) for f in field])


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
    close(body.potential(x, G=1.0, inside=True), potential, 3e-14)
    close(body.field(x, G=1.0, inside=True), field, 3e-14)


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
    # Its G is that of CODATA 2018, its acceleration has the opposite sign.
    potential = np.array([row[0] for row in rows]) / 6.67430e-11
    field = -np.array([row[1] for row in rows]) / 6.67430e-11
    sign = np.sign(np.sum(field * body.field(points, G=1.0, inside=True)))
    close(body.potential(points, G=1.0, inside=True), potential, 1e-12)
    close(body.field(points, G=1.0, inside=True), sign * field, 1e-12)


def test_icospheres_converge_to_the_ellipsoid_by_the_number_of_faces():
    axes = (1.0, 0.8, 0.6)
    probe = Body(Ellipsoid(0.3, 0.25, 0.2), mass=0.1, name="probe")
    state = pose([1.2, -0.9, 1.1])

    def interactions(shape):
        system = fullbody.System([Body(shape, mass=1.0, name="A"), probe], G=1.0, gravity_tolerance=1e-10)
        return system.interactions(state)

    exact = interactions(Ellipsoid(*axes))
    errors = []
    for level in (1, 2, 3):
        found = interactions(icosphere(level, axes))
        errors.append(
            [np.linalg.norm(getattr(found, name)[1] - getattr(exact, name)[1]) for name in ("force", "torque")]
        )
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    assert ((ratios > 3.5) & (ratios < 4.6)).all(), ratios


def test_two_octahedra_have_the_interactions_of_a_volume_integral():
    known = reference("octahedra")
    bodies = [Body(octahedron(*known[f"half_diagonals_{k}"]), mass=1.0, name=k) for k in "ab"]
    state = fullbody.State.from_tait_bryan(
        position=[[0.0, 0.0, 0.0], known["separation"]],
        velocity=np.zeros((2, 3)),
        angles=[known["angles_a"], known["angles_b"]],
        spin=np.zeros((2, 3)),
    )
    found = fullbody.System(bodies, G=1.0).interactions(state)
    force = np.array(known["force_on_a_inertial"], dtype=float)
    close(found.force, [force, -force], 1e-14)
    close(found.potential_energy, float(known["potential_energy"]), 1e-14)
    torques = np.array([known["torque_on_a_body"], known["torque_on_b_body"]], dtype=float)
    close(found.torque, torques, 1e-14, scale=np.abs(force).max())


@pytest.mark.parametrize("other", [octahedron(0.5, 0.4, 0.3), Ellipsoid(0.5, 0.4, 0.3), PointMass()], ids=repr)
def test_the_mutual_expansion_converges_to_the_exact_interactions(other):
    bodies = [Body(icosphere(0, (1.0, 0.9, 0.7)), mass=1.0, name="A"), Body(other, mass=2.0, name="B")]
    bodies[0] = Body(Polyhedron(bodies[0].shape.vertices ** 3 + 0.3, bodies[0].shape.faces), mass=1.0, name="A")
    state = pose([1.9, -2.4, 2.6])
    exact = fullbody.System(bodies, G=1.0).interactions(state)
    errors = []
    for degree in (2, 4, 8, 12, 16):
        found = fullbody.System(bodies, G=1.0, gravity=f"multipole:{degree}").interactions(state)
        parts = [
            found.force - exact.force,
            found.torque - exact.torque,
            found.potential_energy - exact.potential_energy,
        ]
        errors.append([np.abs(part).max() / np.abs(exact.force).max() for part in parts])
    errors = np.array(errors)
    assert (errors[1:3] < 0.2 * errors[:2]).all(), errors
    assert (errors[-1] < 3e-14).all(), errors
    near = pose([0.9, -0.9, 0.8])
    with pytest.raises(fullbody.NotConverged, match=r"multipole:4 between A and B .* diverges"):
        fullbody.System(
            [Body(octahedron(1.0, 1.0, 1.0), mass=1.0, name="A"), Body(octahedron(0.9, 0.9, 0.9), mass=1.0, name="B")],
            G=1.0,
            gravity="multipole:4",
        ).interactions(near)


@pytest.mark.parametrize("mesh", [True, False])
@pytest.mark.parametrize("distance", [4.0, 8.0])
def test_a_series_tells_what_it_leaves_out(mesh, distance):
    shapes = (box(1.0, 0.8, 0.5), octahedron(0.7, 0.5, 0.3)) if mesh else (Ellipsoid(1, 0.8, 0.6), Sphere(0.5))
    lobes = Composite([Part(Ellipsoid(0.5, 0.4, 0.4), mass=2.0), Part(Sphere(0.3), mass=1.0, position=[0.7, 0, 0])])
    for second in (shapes[1], lobes):
        bodies = [Body(shapes[0], mass=2.0, name="A"), Body(second, mass=None if second is lobes else 1.0, name="B")]
        state = pose([0.6 * distance, 0.64 * distance, 0.48 * distance])
        exact = fullbody.System(bodies, G=1.0).interactions(state)
        assert exact.left_out == 0.0
        size = np.linalg.norm(exact.force[0])
        for degree in (2, 4, 6):
            found = fullbody.System(bodies, G=3.0, gravity=f"multipole:{degree}").interactions(state)
            error = np.linalg.norm(found.force[0] / 3.0 - exact.force[0]) / size
            torque = np.linalg.norm(found.torque / 3.0 - exact.torque, axis=1).max() / size
            # The torque is counted by the bodies' radii, which are not far from one.
            assert 0.7 * max(error, torque) < found.left_out < 6.0 * max(error, torque), (degree, error, torque)
    highest = fullbody.System(bodies, G=1.0, gravity="multipole:16").interactions(state)
    assert 0.0 <= highest.left_out < 1e-7


@pytest.mark.parametrize("unit", [None, u.km])
def test_layers_of_a_polyhedron_attract_as_the_difference_of_two(unit):
    # A tetrahedron, whose centre of mass is the mean of its corners.
    corners = np.array([[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.3, 1.5, 0.1], [0.2, 0.4, 1.2]]) + 5.0
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    centre = corners.mean(axis=0)
    smaller = centre + 0.6 * (corners - centre)
    given = Polyhedron(corners if unit is None else corners * unit, faces)
    density = (3.0, 5.0) if unit is None else (3.0 * u.kg / u.km**3, 5.0 * u.kg / u.km**3)
    layers = Composite.layers(given, fractions=(1.0, 0.6), densities=density)
    assert (
        np.abs(
            np.asarray(getattr(layers.parts[1].shape.vertices, "value", layers.parts[1].shape.vertices)) - smaller
        ).max()
        < 1e-14
    )
    if unit is not None:
        assert Body(layers).mass.to_value("kg") == pytest.approx((3.0 + 2.0 * 0.6**3) * given.volume.value, rel=1e-13)
        return
    shell = Body(Composite.layers(given, fractions=(1.0, 0.6), densities=(3.0, 0.0)), name="A")
    ball = Body(Sphere(0.1), mass=2.0, name="B")
    solids = [Body(Polyhedron(c, faces), density=3.0, name="A") for c in (corners, smaller)]
    assert shell.mass == pytest.approx(solids[0].mass - solids[1].mass, rel=1e-13)
    state = fullbody.State([[0, 0, 0], [1.1, 0.9, -1.3]], np.zeros((2, 3)))
    # The three have one centre and one principal frame.
    found, whole, core = (fullbody.System([body, ball], G=1.0).interactions(state) for body in (shell, *solids))
    size = np.abs(whole.force).max()
    np.testing.assert_allclose(found.force, whole.force - core.force, atol=1e-13 * size)
    np.testing.assert_allclose(found.torque, whole.torque - core.torque, atol=1e-13 * size)
    np.testing.assert_allclose(found.potential_energy, whole.potential_energy - core.potential_energy, rtol=1e-13)


def test_layers_of_a_polyhedron_that_is_not_seen_from_its_centre_are_refused():
    # An arrow head: two blocks that meet at a right angle have their centre of mass in the notch.
    outline = np.array([[0, 0], [3, 0], [3, 0.2], [0.2, 0.2], [0.2, 3], [0, 3]])
    corners = np.concatenate([np.column_stack([outline, np.full(6, z)]) for z in (0.0, 0.2)])
    cap = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
    sides = [f for k in range(6) for f in ([k, (k + 1) % 6, (k + 1) % 6 + 6], [k, (k + 1) % 6 + 6, k + 6])]
    angle = Polyhedron(corners, np.concatenate([cap[:, ::-1], cap + 6, sides]))
    with pytest.raises(fullbody.InvalidInput, match=r"face \d+ is turned away from its centre of mass"):
        Composite.layers(angle, fractions=(1.0, 0.5), densities=(1.0, 2.0))


def focal_points(a, b, c, n=12, m=48):
    """Points and weights that attract like an ellipsoid (Maclaurin's theorem)."""
    t, w = np.polynomial.legendre.leggauss(2 * n + 1)
    t, w = t[t > 1e-9], w[t > 1e-9]
    alpha = 2.0 * np.pi * (np.arange(m) + 0.5) / m
    ring = np.sqrt(1.0 - t * t)[:, None] * np.array([np.cos(alpha), np.sin(alpha)])[:, None]
    points = np.stack([(a * a - c * c) ** 0.5 * ring[0], (b * b - c * c) ** 0.5 * ring[1], 0.0 * ring[0]], axis=-1)
    return points.reshape(-1, 3), np.repeat(3.0 * t * t * w / m, m)


@pytest.mark.parametrize("distance", [1.7, 2.4, 5.0, 40.0, 3000.0])
@pytest.mark.parametrize("swapped", [False, True])
def test_beside_an_ellipsoid_it_is_attracted_as_it_attracts(distance, swapped):
    """The forces on the polyhedron by its surface or its layer, those on the ellipsoid by the polyhedron's field."""
    axes = (0.9, 0.7, 0.5)
    bodies = [Body(box(1.0, 0.9, 0.7), mass=1.0, name="box"), Body(Ellipsoid(*axes), mass=2.0, name="egg")]
    state = pose(distance * np.array([0.48, -0.6, 0.64]))
    turns = state.rotation_matrix
    points, weights = focal_points(*axes)
    arms = points @ turns[1].T
    field = bodies[0].field((state.position[1] + arms) @ turns[0], G=1.0) @ turns[0].T
    potential = bodies[0].potential((state.position[1] + arms) @ turns[0], G=1.0)
    force = 2.0 * weights @ field
    torque = 2.0 * weights @ np.cross(arms, field) @ turns[1]
    back = -2.0 * weights @ np.cross(state.position[1] + arms, field) @ turns[0]
    order = [1, 0] if swapped else [0, 1]
    if swapped:
        state = fullbody.State(
            state.position[::-1], state.velocity, attitude=state.attitude[::-1], spin=state.spin, time=0.0
        )
    found = fullbody.System([bodies[k] for k in order], G=1.0).interactions(state)
    size = np.abs(force).max()
    close(found.force[order], [-force, force], 2e-14)
    close(found.torque[order], [back, torque], 2e-14, scale=size * max(1.0, 3.0 * distance * 1e-2))
    close(found.potential_energy, -2.0 * weights @ potential, 2e-14)


@pytest.mark.parametrize("other", [Sphere(0.4), PointMass(), "composite"])
def test_beside_spheres_points_and_composites(other):
    probe = (
        Body(Composite([Part(Sphere(0.1), mass=1.0, position=(x, 0.2 * x, 0.0)) for x in (-0.2, 0.3)]), name="B")
        if other == "composite"
        else Body(other, mass=2.0, name="B")
    )
    body = Body(box(1.0, 0.9, 0.7), mass=1.5, name="A")
    state = pose([0.9, -0.7, 0.6])
    found = fullbody.System([body, probe], G=1.0).interactions(state)
    turns = state.rotation_matrix
    centres = [np.zeros(3)] if other != "composite" else [np.array([x, 0.2 * x, 0.0]) for x in (-0.25, 0.25)]
    if other == "composite":
        frame = probe.working_frame
        centres = [matrix(frame.attitude) @ np.array([x, 0.2 * x, 0.0]) + frame.position for x in (-0.2, 0.3)]
    force, torque = np.zeros(3), np.zeros(3)
    for centre in centres:
        arm = turns[1] @ centre
        pull = 2.0 / len(centres) * turns[0] @ body.field(turns[0].T @ (state.position[1] + arm), G=1.0)
        force += pull
        torque += np.cross(arm, pull)
    close(found.force, [-force, force], 1e-14)
    close(found.torque[1], turns[1].T @ torque, 1e-14, scale=np.abs(force).max())


def test_parts_of_a_cut_box_are_the_box():
    whole = Body(box(1.2, 0.8, 0.6), density=2.0, name="A")
    half = Polyhedron((CORNERS - [1.0, 0.5, 0.5]) * [0.6, 0.8, 0.6], CUBE)
    parts = [Part(half, density=2.0), Part(half, density=2.0, position=(0.6, 0.0, 0.0))]
    cut = Body(Composite(parts), name="A")
    close(cut.inertia, whole.inertia, 1e-14)
    probe = Body(Ellipsoid(0.5, 0.4, 0.3), mass=1.0, name="B")
    state = pose([1.1, 0.9, -0.8])
    one, two = (fullbody.System([body, probe], G=1.0).interactions(state) for body in (whole, cut))
    close(two.force, one.force, 2e-14)
    close(two.torque, one.torque, 2e-14, scale=np.abs(one.force).max())


def test_numbering_turning_and_units_change_nothing():
    solid = icosphere(1, (1.0, 0.7, 0.5))
    probe = Body(Ellipsoid(0.5, 0.4, 0.3), mass=1.0, name="B")
    state = pose([1.6, 0.9, -1.1])
    expected = fullbody.System([Body(solid, mass=1.0, name="A"), probe], G=1.0).interactions(state)
    rng = np.random.default_rng(1)
    order = rng.permutation(len(solid.vertices))
    faces = np.argsort(order)[np.roll(solid.faces, 1, axis=1)][rng.permutation(len(solid.faces))]
    again = Polyhedron(solid.vertices[order], faces)
    found = fullbody.System([Body(again, mass=1.0, name="A"), probe], G=1.0).interactions(state)
    close(found.force, expected.force, 5e-15)
    with_units = Polyhedron(solid.vertices * 1000.0 * u.m, solid.faces)
    body = Body(with_units, mass=3.0 * u.kg)
    plain = Body(solid, mass=3.0)
    G = 6.0e-11
    points = np.array([[1.5, 0.2, 0.1], [20.0, 1.0, 3.0]])
    united = body.field(points * u.km, G=G * u.m**3 / u.kg / u.s**2)
    close(united.to_value(u.km / u.s**2), plain.field(points, G=G * 1e-9), 1e-14)
    close(body.inertia.to_value(u.kg * u.km**2), plain.inertia, 1e-14)
    close(with_units.volume.to_value(u.km**3), solid.volume, 1e-14)


@pytest.mark.parametrize(
    "integrator",
    [
        fullbody.Verner98(),
        fullbody.DormandPrince54(rtol=1e-11, atol=1e-11),
        fullbody.LieGroupVariational(step=0.05),
        fullbody.SymplecticSplitting(step=0.05),
    ],
    ids=lambda i: type(i).__name__,
)
def test_octahedra_keep_energy_and_momenta(integrator):
    """A binary of two octahedra, as in Fahnestock and Scheeres (2006)."""
    bodies = [Body(octahedron(1.0, 0.8, 0.6), mass=1.0, name="A"), Body(octahedron(0.5, 0.4, 0.3), mass=0.2, name="B")]
    system = fullbody.System(bodies, G=1.0, gravity_tolerance=1e-10)
    start = fullbody.State.from_tait_bryan(
        position=[[-0.5, 0.0, 0.0], [2.5, 0.0, 0.0]],
        velocity=[[0.0, -0.1, 0.0], [0.0, 0.5, 0.02]],
        angles=[[0.2, 0.3, -0.4], [1.1, -0.5, 0.6]],
        spin=[[0.05, 0.1, 0.4], [0.1, -0.1, 0.3]],
    )
    run = system.integrate(start, 3.0, integrator=integrator, output=0.5)
    fixed = hasattr(integrator, "step")
    # A step's own error is none of the forces'; both momenta do not know it.
    close(run.energy, run.energy[0], 2e-3 if fixed else 1e-10)
    close(run.angular_momentum, run.angular_momentum[0], 1e-10, scale=np.abs(run.angular_momentum[0]).max())
    momentum = sum(body.mass * run.velocity[:, k] for k, body in enumerate(bodies))
    close(momentum, momentum[0], 1e-14, scale=0.1)


@pytest.mark.filterwarnings("ignore::fullbody.InconsistentInput")
def test_a_ball_touches_a_face_an_edge_and_a_corner_when_it_should():
    cube = Body(box(2.0, 2.0, 2.0), mass=1e-9, name="cube")
    ball = Body(Sphere(0.5), mass=1e-9, name="ball")
    system = fullbody.System([cube, ball], G=1.0, gravity_tolerance=1e-8)
    for direction in ([1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]):
        n = np.array(direction) / np.linalg.norm(direction)
        state = fullbody.State(
            [[0.0] * 3, 5.0 * n], [[0.0] * 3, -2.0 * n], attitude=[[1.0, 0, 0, 0]] * 2, spin=np.zeros((2, 3))
        )
        run = system.integrate(state, 3.0, events=[fullbody.events.Contact("cube", "ball", terminal=True)])
        touching = np.linalg.norm(direction) + 0.5
        assert run.events[0].time == pytest.approx((5.0 - touching) / 2.0, abs=1e-8)
        with pytest.raises(fullbody.BodiesOverlap):
            system.integrate(state, 3.0)


@pytest.mark.filterwarnings("ignore::fullbody.InconsistentInput")
def test_a_quick_pass_through_a_corner_is_seen():
    """The step is many times longer than the time of overlap."""
    cube = Body(box(2.0, 2.0, 2.0), mass=1e-9, name="cube")
    ball = Body(Sphere(0.5), mass=1e-9, name="ball")
    system = fullbody.System([cube, ball], G=1.0, gravity_tolerance=1e-8)
    for miss, met in ((0.499, True), (0.5001, False)):
        # Past the edge x = y = 1, at a right angle to its outward direction.
        n, along = np.array([1.0, 1.0, 0.0]) / 2**0.5, np.array([1.0, -1.0, 0.0]) / 2**0.5
        state = fullbody.State(
            [[0.0] * 3, (2**0.5 + miss) * n - 10.0 * along],
            [[0.0] * 3, 100.0 * along],
            attitude=[[1.0, 0, 0, 0]] * 2,
            spin=np.zeros((2, 3)),
        )
        if met:
            with pytest.raises(fullbody.BodiesOverlap):
                system.integrate(state, 0.2)
        else:
            assert len(system.integrate(state, 0.2)) > 1


def test_a_third_body_turns_it_as_a_distant_point_mass_does():
    solid = Body(box(1.0, 0.9, 0.5), mass=1.0, name="A")
    far = np.array([30.0, 40.0, -20.0])
    state = fullbody.State([[0.0] * 3], [[0.0] * 3], attitude=pose([1, 1, 1]).attitude[:1], spin=np.zeros((1, 3)))
    times = np.linspace(-10.0, 10.0, 9)
    sun = fullbody.forces.ThirdBody(mass=50.0, times=times, positions=np.tile(far, (9, 1)), of="body", name="Sun")
    found = fullbody.System([solid], G=1.0, forces=[sun]).loads(state)["Sun"]
    point = Body(PointMass(), mass=50.0, name="Sun")
    both = fullbody.State(
        [[0.0] * 3, far], np.zeros((2, 3)), attitude=[state.attitude[0], [1.0, 0, 0, 0]], spin=np.zeros((2, 3))
    )
    expected = fullbody.System([solid, point], G=1.0).interactions(both)
    close(found.torque[0], expected.torque[0], 1e-11)


def write(path, solid, kind):
    vertices, faces = solid.vertices, solid.faces
    if kind == "obj":
        rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
        rows += [f"f {i + 1} {j + 1} {k + 1}" for i, j, k in faces.tolist()]
    elif kind == "tab":
        rows = [f"{len(vertices)} {len(faces)}"]
        rows += [f"{n + 1} {x!r} {y!r} {z!r}" for n, (x, y, z) in enumerate(vertices.tolist())]
        rows += [f"{n + 1} {i + 1} {j + 1} {k + 1}" for n, (i, j, k) in enumerate(faces.tolist())]
    elif kind == "stl":
        rows = ["solid box"]
        for face in faces:
            corners = [f"vertex {x!r} {y!r} {z!r}" for x, y, z in vertices[face].tolist()]
            rows += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
        rows.append("endsolid box")
    else:
        rows = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
        rows += [f"property double {c}" for c in "xyz"] + [f"element face {len(faces)}"]
        rows += ["property list uchar int vertex_indices", "end_header"]
        rows += [f"{x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
        rows += [f"3 {i} {j} {k}" for i, j, k in faces.tolist()]
    path.write_text("\n".join(rows) + "\n")


@pytest.mark.parametrize("kind", ["tab", "obj", "ply", "stl"])
def test_shapes_are_read_from_files(tmp_path, kind):
    if kind != "tab":
        pytest.importorskip("trimesh")
    solid = octahedron(1.0, 0.75, 0.5)
    path = tmp_path / f"shape.{kind}"
    write(path, solid, kind)
    found = Polyhedron.load(path, unit="km")
    assert found.volume.to_value(u.km**3) == pytest.approx(solid.volume, rel=1e-6 if kind == "stl" else 1e-14)
    assert len(found.faces) == 8
    if kind != "stl":
        assert Polyhedron.load(path) == solid
    for unit in ("kg", "kilometre-ish", 3, ("km",)):
        with pytest.raises(fullbody.InvalidInput, match="expected a length, such as 'km'"):
            Polyhedron.load(path, unit=unit)


def test_files_that_are_no_shapes_are_refused(tmp_path):
    path = tmp_path / "shape.tab"
    with pytest.raises(FileNotFoundError, match=r"shape\.tab"):
        Polyhedron.load(path)
    path.write_text("three vertices\n")
    with pytest.raises(fullbody.InvalidInput, match="first row"):
        Polyhedron.load(path)
    path.write_text("3 1\n0 0 0\n1 0 0\n0 1 0\n1 2 3\n")
    with pytest.raises(fullbody.InvalidInput, match=r"shape\.tab: number of faces is 1"):
        Polyhedron.load(path)
    solid = box(1.0, 1.0, 1.0)
    inside_out = Polyhedron.__new__(Polyhedron)
    inside_out._vertices, inside_out._faces = solid.vertices, solid.faces[:, ::-1]
    write(path, inside_out, "tab")
    with pytest.raises(fullbody.InvalidInput, match="face 0 is turned inward"):
        Polyhedron.load(path)
    pytest.importorskip("trimesh")
    assert Polyhedron.load(path, heal=True).volume == pytest.approx(1.0)


def test_runs_toml_and_archives_keep_polyhedra(tmp_path):
    solid = icosphere(0, (1.0, 0.8, 0.6))
    system = fullbody.System(
        [Body(solid, density=2.0, name="A"), Body(Composite([Part(box(0.2, 0.3, 0.4), mass=0.1)]), name="B")], G=1.0
    )
    state = pose([1.9, 1.5, -1.6], spin=0.1)
    simulation = fullbody.Simulation(system, state)
    run = simulation.integrate(0.5)
    run.save(tmp_path / "run.nc")
    again = fullbody.load(tmp_path / "run.nc")
    assert again.system == system
    assert again.system.bodies[0].shape == solid
    simulation.save(tmp_path / "simulation")
    resumed = fullbody.Simulation.load(tmp_path / "simulation")
    assert resumed.system == system
    assert np.array_equal(resumed.integrate(1.0).position, simulation.integrate(1.0).position)
    write(tmp_path / "a.tab", solid, "tab")
    mesh = f"{{ vertices = {box(1.0, 1.0, 1.0).vertices.tolist()}, faces = {CUBE.tolist()} }}"
    (tmp_path / "system.toml").write_text(
        "[system]\nG = 1.0\n"
        '[[body]]\nname = "A"\npolyhedron = "a.tab"\nmass = 2.0\n'
        f'[[body]]\nname = "B"\npolyhedron = {mesh}\ndensity = 3.0\nposition = [4, 0, 0]\n'
        "[run]\nuntil = 1.0\n"
    )
    setup = fullbody.read_toml(tmp_path / "system.toml")
    assert setup.system.bodies[0] == Body(solid, mass=2.0, name="A")
    assert setup.system.bodies[1].mass == pytest.approx(3.0)


def test_pictures_show_polyhedra(tmp_path):
    pytest.importorskip("matplotlib")
    bodies = [Body(octahedron(1.0, 0.8, 0.6), mass=1.0, name="A"), Body(Sphere(0.3), mass=0.2, name="B")]
    run = fullbody.System(bodies, G=1.0).integrate(pose([2.9, 1.5, -1.6]), 0.1)
    drawn = [c for c in run.plot.scene().collections if type(c).__name__ == "Poly3DCollection"]
    assert any(len(c._faces if hasattr(c, "_faces") else c._vec) for c in drawn)
    run.plot.orbit()
    page = run.view().to_html()
    assert json.dumps("triangles") in page
    for thing in (run, run.system, bodies[0]):
        assert "8 faces" in thing._repr_html_().replace('faces</td><td style="text-align:left">8', "8 faces")


def test_what_is_not_done_is_refused():
    bodies = [Body(octahedron(1.0, 0.8, 0.6), mass=1.0, name="A"), Body(Sphere(0.3), mass=0.2, name="B")]
    with pytest.raises(fullbody.InvalidInput, match="beside A, a polyhedron"):
        fullbody.System(bodies, G=1.0, order=(8, 8))
    touching = [Body(octahedron(1.0, 1.0, 1.0), mass=1.0, name=name) for name in "AB"]
    state = fullbody.State([[0.0] * 3, [2.0 + 1e-9, 0.0, 0.0]], np.zeros((2, 3)), attitude=[[1.0, 0, 0, 0]] * 2)
    with pytest.raises(fullbody.NotConverged, match="over the faces"):
        fullbody.System(touching, G=1.0).interactions(state)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0.0, 0.0]], CUBE, "vertices"),
        (CORNERS, CUBE[:, :2], "faces is of shape"),
        (CORNERS, CUBE + 0.5, "faces is of shape"),
        (CORNERS, CUBE * np.nan, "and type float64; expected whole numbers"),
        (CORNERS, CUBE > 2, "and type bool; expected whole numbers"),
        (CORNERS, [[0, 1, 2], [1, 2]], "faces is no table of numbers"),
        (CORNERS, CUBE - 1, "face 0, vertex 0"),
        (CORNERS, CUBE[:-1], "expected a closed surface"),
        (CORNERS, CUBE[:, ::-1], "turned inward"),
        (CORNERS * [1.0, 1.0, 0.0], CUBE, "face"),
        (CORNERS * np.nan, CUBE, "vert"),
    ],
)
def test_bad_meshes_are_refused(vertices, faces, message):
    with pytest.raises(fullbody.InvalidInput, match=message):
        Polyhedron(vertices, faces)


def test_gubas_polyhedra_are_read(tmp_path):
    """Tables of vertices in metres and of faces turned anyhow, in other axes than the principal ones."""
    text = (DATA / "peers" / "gubas_pair.cfg").read_text()
    text = text.replace("Primary Shape Flag: 1", "Primary Shape Flag: 2")
    path = tmp_path / "pair.cfg"
    path.write_text(text)
    with pytest.raises(fullbody.InvalidInput, match=r"line \d+: no file 'none' of a polyhedron"):
        fullbody.read_gubas(path)
    for name, file in (("Vertex", "vertices.csv"), ("Tetrahedron", "faces.csv")):
        text = text.replace(f"Primary {name} File: none", f"Primary {name} File: {file}")
    path.write_text(text)
    q = np.array([np.cos(0.2), 0.0, 0.0, np.sin(0.2)])
    corners = (CORNERS - 0.5) * [400.0, 300.0, 200.0] @ matrix(q).T
    rows = [f"{k},{x!r},{y!r},{z!r}" for k, (x, y, z) in enumerate(corners.tolist())]
    (tmp_path / "vertices.csv").write_text("\n".join(rows) + "\n")
    faces = np.where(np.arange(12)[:, None] % 2, CUBE, CUBE[:, ::-1]) + 1
    (tmp_path / "faces.csv").write_text("\n".join(f"{i},{j},{k},," for i, j, k in faces) + "\n")
    with pytest.warns(UserWarning, match=r"turned by 22\.9 degrees"):
        system, state = fullbody.read_gubas(path)
    plain_path = tmp_path / "plain.cfg"
    plain_path.write_text((DATA / "peers" / "gubas_pair.cfg").read_text())
    plain, other = fullbody.read_gubas(plain_path)
    primary = system.bodies[0]
    close(primary.mass, primary.density * 0.4 * 0.3 * 0.2, 1e-13)
    close(primary.inertia, primary.mass / 12.0 * np.array([0.13, 0.2, 0.25]), 1e-13)
    # The vertices are where they were, and turn as they did.
    close(state.rotation_matrix[0], other.rotation_matrix[0] @ matrix(q), 1e-14)
    spin = other.rotation_matrix[0] @ other.spin[0]
    close(state.rotation_matrix[0] @ state.spin[0], spin, 1e-14)
    assert plain.bodies[1] == system.bodies[1]


def test_sians_polyhedra_are_read(tmp_path):
    pytest.importorskip("trimesh")
    text = (DATA / "peers" / "sians_pair.txt").read_text()
    plain, other = fullbody.read_sians(DATA / "peers" / "sians_pair.txt")
    (tmp_path / "initial_values").mkdir()
    write(tmp_path / "box.obj", box(1.0, 0.8, 0.6), "obj")
    head, _, rest = text.partition("@ Semi")
    line, _, rest = rest.partition("\n")
    _, _, rest = rest.partition("\n")
    path = tmp_path / "initial_values" / "pair.txt"
    path.write_text(f"{head}@ Semi{line}\nbox.obj 0.5\n{rest}")
    system, state = fullbody.read_sians(path)
    close(system.bodies[0].shape.volume, 0.48 / 8.0, 1e-14)
    assert system.bodies[1] == plain.bodies[1]
    close(state.rotation_matrix, other.rotation_matrix, 1e-14)
    close(state.spin, other.spin, 1e-14)
