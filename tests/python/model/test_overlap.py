"""The overlap of ellipsoids is detected exactly at contact, whatever their attitudes."""

import re
from contextlib import suppress

import fullbody
import numpy as np
import pytest
from fullbody.errors import BodiesOverlap, NotConverged
from hypothesis import given
from support import directions, matrix, quaternions, refused, semi_axes


def pair(first, second, position, attitudes=((1, 0, 0, 0), (1, 0, 0, 0)), gravity="focal"):
    bodies = [
        fullbody.Body(fullbody.Ellipsoid(*axes), mass=1.0, name=name)
        for axes, name in ((first, "Alpha"), (second, "Beta"))
    ]
    state = fullbody.State([[0, 0, 0], position], np.zeros((2, 3)), attitudes, time=3.5)
    return fullbody.System(bodies, G=1.0, gravity=gravity), state


def assert_overlap(system, state):
    for call in (system.interactions, system.energy, lambda s: system.integrate(s, s.time + 1.0)):
        with pytest.raises(BodiesOverlap) as caught:
            call(state)
        assert isinstance(caught.value, fullbody.FullbodyError)
        assert caught.value.bodies == ("Alpha", "Beta")
        assert {"Alpha", "Beta"} <= {*re.findall(r"\w+", str(caught.value))}
    assert caught.value.time == 3.5


def touching(first, second, normal, attitudes):
    """Centre of the second body, touching the first from outside with this common normal.

    The point of an ellipsoid with outward normal n is C n / sqrt(n . C n), C = R diag(a^2) R^T.
    """
    frames = [matrix(np.array(q, dtype=float)) for q in attitudes]
    shapes = [frame @ np.diag(np.square(axes)) @ frame.T for frame, axes in zip(frames, (first, second), strict=True)]
    return sum(shape @ normal / np.sqrt(normal @ shape @ normal) for shape in shapes)


@given(semi_axes, semi_axes, directions, quaternions, quaternions)
def test_ellipsoids_touch_where_their_normals_do(first, second, normal, p, q):
    contact = touching(first, second, normal, (p, q))
    # Off by round-off of the contact itself at most.
    system, state = pair(first, second, contact * (1 + 1e-14), (p, q))
    # Sharp rims in contact may be beyond the quadrature, which says so.
    with suppress(NotConverged):
        assert np.isfinite(system.interactions(state).force).all()
    # A thousandth along the normal is a thousandth of depth.
    assert_overlap(*pair(first, second, contact - 1e-3 * normal, (p, q)))


@pytest.mark.parametrize("gravity", ["focal", "surface", "multipole:4", "point"])
def test_spheres_in_touch_attract_and_deeper_ones_overlap(gravity):
    axes = (1.0, 1.0, 1.0)
    system, state = pair(axes, axes, [2.0, 0.0, 0.0], gravity=gravity)
    assert system.interactions(state).force[0] == pytest.approx([0.25, 0, 0], abs=1e-15)
    assert_overlap(*pair(axes, axes, [1.998, 0.0, 0.0], gravity=gravity))


def test_circumscribed_spheres_may_overlap():
    disc = (1.0, 1.0, 0.3)
    system, state = pair(disc, disc, [0.0, 0.0, 0.8])
    assert np.isfinite(system.interactions(state).force).all()
    assert_overlap(*pair(disc, disc, [0.0, 0.0, 0.599]))


def test_a_quadrature_at_its_limit_says_so():
    disc = (1.0, 1.0, 0.02)
    system, state = pair(disc, disc, [0.3, 0.1, 0.043])
    with pytest.raises(NotConverged, match="Alpha and Beta") as caught:
        system.interactions(state)
    assert isinstance(caught.value, RuntimeError)
    assert 'use gravity="focal"' not in str(caught.value)


@pytest.mark.parametrize("point", [[0, 0, 0], [0.3, 0, 0], [0, 0, 0.05]])
def test_nested_bodies_overlap(point):
    assert_overlap(*pair((1.0, 0.8, 0.7), (0.2, 0.1, 0.1), point))
    assert_overlap(*pair((0.2, 0.1, 0.1), (1.0, 0.8, 0.7), point))
    assert_overlap(*pair((1.0, 0.8, 0.7), (1.0, 0.8, 0.7), point))


def test_a_point_overlaps_what_it_is_in_or_at():
    rock = fullbody.Body(fullbody.Ellipsoid(1.0, 0.8, 0.7), mass=1.0, name="Alpha")
    system = fullbody.System([rock, fullbody.Body(fullbody.PointMass(), mass=1.0, name="Beta")], G=1.0)
    for point in ([0, 0, 0], [0.999, 0, 0]):
        assert_overlap(system, fullbody.State([[0, 0, 0], point], np.zeros((2, 3)), time=3.5))
    outside = fullbody.State([[0, 0, 0], [1.001, 0, 0]], np.zeros((2, 3)))
    assert np.isfinite(system.interactions(outside).force).all()
    bodies = [fullbody.Body(fullbody.PointMass(), mass=1.0, name=name) for name in ("Alpha", "Beta")]
    state = fullbody.State(np.ones((2, 3)), np.zeros((2, 3)), time=3.5)
    assert_overlap(fullbody.System(bodies, G=1.0), state)


def test_overlaps_name_the_bodies():
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name=name) for name in ("Sun", "Earth", "Moon")]
    state = fullbody.State([[0, 0, 0], [9, 0, 0], [9, 1, 0]], np.zeros((3, 3)))
    with pytest.raises(BodiesOverlap) as caught:
        fullbody.System(bodies, G=1.0).interactions(state)
    assert caught.value.bodies == ("Earth", "Moon")


def test_bodies_too_thin_to_resolve_are_named():
    disc, attitudes = (1.0, 1.0, 1e-13), [(0.8, 0.36, 0.48, 0.0)] * 2
    normal = matrix(np.array(attitudes[0]))[:, 2]
    system, state = pair(disc, disc, 2.001e-13 * normal, attitudes, gravity="point")
    for call in (system.interactions, lambda s: system.integrate(s, s.time + 1.0)):
        refused(r"gap between Alpha and Beta is .* too thin to tell", call, state)
    assert_overlap(*pair(disc, disc, 1e-13 * normal, attitudes, gravity="point"))
    apart, state = pair(disc, disc, 4e-13 * normal, attitudes, gravity="point")
    assert np.isfinite(apart.energy(state).total)
