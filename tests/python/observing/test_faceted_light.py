"""Light of polyhedra and composites compared with convex bodies in pieces, rays, and spheres behind plates."""

import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, HarmonicShape, Part, Sphere, State, System, observing
from fullbody.base import rotations
from fullbody.observing.brightness import Epochs, Photometer
from scipy.spatial import ConvexHull, HalfspaceIntersection
from support.meshes import box, convex_hull
from support.strips import strips


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def light(body, e, s, **options):
    """The brightness of a body that has the attitude in which its shape was given; e and s are in the same axes."""
    frame = body.working_frame
    attitude = [1, 0, 0, 0] if frame is None else np.array(frame.attitude) * [1, -1, -1, -1]
    state = State([[0, 0, 0]], [[0, 0, 0]], [attitude])
    return observing.brightness(System([body], G=1.0), state, e, s, **options)[0]


def convex_light(hull, e, s):
    """The sum of Lommel-Seeliger's law over the facets of a convex hull, none of which hides another."""
    a, b, c = (hull.points[hull.simplices[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    mu, mu0 = (np.maximum(hull.equations[:, :3] @ d, 0.0) for d in (e, s))
    return np.sum(np.divide(mu * mu0, mu + mu0, out=np.zeros_like(mu), where=mu + mu0 > 0) * area)


def test_convex_bodies_in_overlapping_pieces_are_as_bright_as_undivided_ones():
    rng = np.random.default_rng(3)
    divided = 0
    for _ in range(60):
        reference = ConvexHull(unit(rng.normal(size=(int(rng.integers(6, 30)), 3))) * rng.uniform(0.5, 2.0, 3))
        n, (low, high) = unit(rng.normal(size=3)), np.sort(rng.uniform(-0.3, 0.3, 2))
        # The layer between the two planes is part of both pieces.
        planes = [np.vstack([reference.equations, [*side * n, -side * at]]) for side, at in ((1, high), (-1, low))]
        inside = reference.points.mean(axis=0)
        inside = inside + n * (0.5 * (low + high) - n @ inside)
        if np.max(reference.equations[:, :3] @ inside + reference.equations[:, 3]) > -1e-3 or high - low < 1e-3:
            continue
        pieces = [convex_hull(HalfspaceIntersection(plane, inside).intersections) for plane in planes]
        if rng.random() < 0.5:
            pieces.append(convex_hull(HalfspaceIntersection(np.vstack(planes), inside).intersections))
        parts = [Part(piece, density=1.0) for piece in rng.permutation(np.array(pieces, dtype=object))]
        e, s = unit(rng.normal(size=(2, 3)))
        expected = convex_light(reference, e, s)
        result = light(Body(Composite(parts)), e, s)
        divided += light(Body(parts[0].shape, density=1.0), e, s) < 0.9 * expected
        assert abs(result - expected) < 2e-8 * reference.area, (result, expected)
    # In many of the bodies a single piece has much less light than the whole.
    assert divided > 20


def boxes_by_rays(low, high, e, s, n):
    """The light of a union of boxes with corners low and high (B, 3), by rays from n x n cells of each side."""
    total = 0.0
    cells = (np.arange(n) + 0.5) / n
    for index in range(len(low)):
        for axis, side in ((axis, side) for axis in range(3) for side in (0, 1)):
            normal = np.zeros(3)
            normal[axis] = 2.0 * side - 1.0
            mu, mu0 = normal @ e, normal @ s
            if min(mu, mu0) <= 0.0:
                continue
            b, c = (axis + 1) % 3, (axis + 2) % 3
            x = np.empty((n * n, 3))
            x[:, axis] = (low, high)[side][index, axis]
            p, q = np.meshgrid(cells, cells)
            x[:, b] = low[index, b] + (high - low)[index, b] * p.ravel()
            x[:, c] = low[index, c] + (high - low)[index, c] * q.ravel()
            # Where sides of several boxes coincide, that of the first box counts.
            earlier = [o for o in range(index) if (low, high)[side][o, axis] == x[0, axis]]
            hidden = np.zeros(n * n, dtype=bool)
            for o in earlier:
                hidden |= np.all((x[:, [b, c]] > low[o, [b, c]]) & (x[:, [b, c]] < high[o, [b, c]]), axis=1)
            for o, d in ((o, d) for o in range(len(low)) if o != index for d in (e, s)):
                ends = np.sort([(low[o] - x) / d, (high[o] - x) / d], axis=0)
                nearest, farthest = ends[0].max(axis=1), ends[1].min(axis=1)
                hidden |= (nearest < farthest) & (farthest > 1e-9)
            area = np.prod((high - low)[index, [b, c]])
            total += mu * mu0 / (mu + mu0) * area * np.mean(~hidden)
    return total


def test_light_of_boxes_on_a_grid_is_that_of_rays():
    rng = np.random.default_rng(8)
    for _ in range(12):
        count = int(rng.integers(2, 5))
        low = rng.integers(0, 3, (count, 3)).astype(float)
        high = low + rng.integers(1, 4, (count, 3))
        boxes = zip(low, high, rng.choice([1.0, 2.0], count), strict=True)
        parts = [Part(box(*(b - a)), density=float(density), position=0.5 * (a + b)) for a, b, density in boxes]
        e, s = unit(rng.normal(size=(2, 3)))
        if e @ s < -0.8:
            # Too little of the boxes is both lit and visible.
            continue
        expected = boxes_by_rays(low, high, e, s, 60)
        result = light(Body(Composite(parts)), e, s)
        assert abs(result - expected) < 0.01 * expected + 0.02, (result, expected)


def test_voids_and_blocks_inside_a_body_that_touch_its_surface_change_no_light():
    reference = Body(box(2.0, 2.0, 2.0), density=1.0)
    e, s = unit(np.array([[0.3, 0.5, 1.0], [0.1, 0.2, 1.0]]))
    expected = light(reference, e, s)
    for density in (-0.5, 3.0):
        parts = [Part(box(2.0, 2.0, 2.0), density=1.0), Part(box(1.0, 1.0, 1.0), density=density, position=[0, 0, 0.5])]
        for order in (parts, parts[::-1]):
            assert abs(light(Body(Composite(order)), e, s) / expected - 1) < 1e-8


#: Phase angles.
PHASES = np.radians([0.0, 60.0, 120.0, 150.0, 178.0])


@pytest.mark.parametrize("phase", PHASES)
def test_an_ellipsoid_wholly_hidden_by_a_polyhedron_is_dark(phase):
    e, s = [0, 0, 1.0], [np.sin(phase), 0, np.cos(phase)]
    plate, ball = Body(box(100.0, 100.0, 2.0), mass=1.0), Body(Ellipsoid(1.0, 0.8, 0.7), mass=1.0)
    state = State([[0, 0, 0], [0, 0, 10.0]], np.zeros((2, 3)))
    system = System([ball, plate], G=1.0)
    result, alone = (observing.brightness(system, state, e, s, mutual=mutual)[0] for mutual in (True, False))
    assert result < 1e-9 * alone


@pytest.mark.parametrize("phase", PHASES)
def test_a_core_adds_no_light_to_a_box(phase):
    e, s = [0, 0, 1.0], [np.sin(phase), 0, np.cos(phase)]
    shell = box(2.0, 2.0, 2.0)
    cored = Composite([Part(shell, density=1.0), Part(Sphere(0.6), density=1.0, position=[0.3, 0, 0])])
    assert abs(light(Body(cored), e, s) - light(Body(shell, mass=1.0), e, s)) < 1e-12


@pytest.mark.parametrize("phase", PHASES[::2])
def test_the_light_of_a_sphere_partly_behind_a_plate_is_a_sum_over_strips(phase):
    e, s = np.array([0, 0, 1.0]), np.array([np.sin(phase), 0, np.cos(phase)])
    ball, plate = Body(Sphere(1.0), mass=1.0), Body(box(100.0, 100.0, 2.0), mass=1.0)
    # The plate leaves x < edge or y < edge visible, and shades only what it hides, if anything.
    for axis, edge in ((0, 0.3), (0, -0.2), (0, 0.995), (1, 0.3), (1, -0.6)):
        position = np.array([0, 0, 200.0])
        position[axis] = edge + 50.0
        state = State([[0, 0, 0], position], np.zeros((2, 3)))
        system = System([ball, plate], G=1.0)
        result, alone = (observing.brightness(system, state, e, s, mutual=mutual)[0] for mutual in (True, False))
        # The edge is that of a disc with a very large radius.
        expected = strips(1e9, edge, s if axis == 0 else s[[1, 0, 2]], "seeliger")
        assert abs(result - expected) < 2e-3 * alone, (axis, edge, result, expected, alone)


def test_derivatives_with_respect_to_vertices_scale_as_an_area():
    # Brightness is an area: scaling all lengths by 1 + h changes it by 2 h, and so do all vertices and positions.
    rng = np.random.default_rng(4)
    bodies = [Body(box(2.0, 1.5, 1.0), mass=1.0), Body(convex_hull(unit(rng.normal(size=(20, 3)))), mass=0.1)]
    state = State([[0, 0, 0], [3.0, 0.4, 0.3]], np.zeros((2, 3)), [[0.8, 0.2, 0.4, 0.4], [1, 0, 0, 0]])
    system = System(bodies, G=1.0)
    result = observing.brightness_derivatives(system, state, [1, 0, 0], [0.8, 0.3, 0.4])
    alone = observing.brightness(system, state, [1, 0, 0], [0.8, 0.3, 0.4], mutual=False)
    growth = np.einsum("ijx,jx->i", result.position, state.position)
    for body, by in zip(bodies, result.vertices, strict=True):
        frame = body.working_frame
        rotation = rotations.matrices(np.asarray(frame.attitude)[None])[0]
        growth = growth + np.einsum("ivx,vx->i", by, body.shape.vertices @ rotation.T + frame.position)
    assert result.brightness[0] < 0.95 * alone[0]
    np.testing.assert_allclose(growth, 2.0 * result.brightness, rtol=1e-12)
    assert result.vertices[1].shape == (2, len(bodies[1].shape.vertices), 3)


@pytest.mark.parametrize("seed", [2, 19])
def test_derivatives_are_finite_where_a_side_of_a_shadow_has_no_length(seed):
    # One of these thousand views of a body with hollows has such a side, for which the derivative must not be 0 / 0.
    rng = np.random.default_rng(seed)
    coefficients = np.concatenate([np.zeros(4), rng.normal(scale=0.12, size=12)])
    system = System([Body(HarmonicShape(coefficients, faces=320), mass=1.0)], G=1.0)
    e = unit(rng.normal(size=(1000, 3)))
    s = unit(e + 0.5 * rng.normal(size=(1000, 3)))
    views = Epochs(np.zeros(1000), np.zeros((1000, 1, 3)), np.tile(np.eye(1, 4), (1000, 1, 1)), e, s)
    result = Photometer(system, observing.LommelSeeliger(), 1.0, False, 0.0).derivatives(views, vertices=True)
    assert np.isfinite(result.vertices[0]).all()
    assert np.isfinite(result.rotation).all()
