"""Gravity at many points: of bodies, systems and runs, outside and inside, against values from elsewhere."""

import os
import subprocess
import sys

import astropy.units as u
import fullbody
import mpmath
import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, Part, PointMass, Sphere
from support import matrix, reference, refused
from support.meshes import box

AXES = (1.0, 0.8, 0.5)
CUBE = box(2.0, 2.0, 2.0)


@pytest.fixture(scope="module")
def flown():
    """1999 KW4 for some hours, with its continuous solution."""
    system, state = fullbody.systems.kw4()
    return system.integrate(state, 6.0, output=2.0, dense=True)


def resting(position, attitude=None):
    return fullbody.State(position, np.zeros((len(position), 3)), attitude)


def within(result, expected, tolerance):
    """Arrays of vectors or matrices alike, relative to the size of each."""
    axes = tuple(range(1, np.ndim(expected)))
    size = np.sqrt(np.sum(np.square(expected), axis=axes, keepdims=True))
    assert (np.abs(result - expected) <= tolerance * size).all(), np.abs((result - expected) / size).max()


def test_gravity_at_points_has_the_values_of_44_digits():
    for case in reference("derivatives")["fields"]:
        body = Body(Ellipsoid(*map(float, case["axes"])), mass=1.0)
        result = body.gravity([float(x) for x in case["point"]], G=1.0)
        assert float(result.potential) == pytest.approx(float(case["potential"]), rel=4e-15)
        within(result.field[None], np.array([case["field"]], dtype=float), 4e-15)
        within(result.gradient[None], np.array([case["gradient"]], dtype=float), 4e-15)


def by_integrals(x):
    """Potential, field and gradient inside the ellipsoid of unit GM: Dirichlet's integrals in 30 digits."""
    with mpmath.workdps(30):
        squares = [mpmath.mpf(a) ** 2 for a in AXES]

        def integral(over):
            root = lambda s: mpmath.sqrt(mpmath.fprod(a + s for a in squares))  # noqa: E731
            return mpmath.quad(lambda s: 1 / (root(s) * over(s)), [0, 1, mpmath.inf])

        parts = np.array([integral(lambda s, a=a: a + s) for a in squares])
        potential = 0.75 * (integral(lambda s: 1) - parts @ np.square(x))
    factors = -1.5 * parts.astype(float)
    return float(potential), factors * x, np.diag(factors)


@pytest.mark.parametrize("x", [(0.0, 0.0, 0.0), (0.3, -0.4, 0.1), (0.9, 0.1, -0.1)])
def test_gravity_inside_an_ellipsoid_is_dirichlets(x):
    result = Body(Ellipsoid(*AXES), mass=1.0).gravity(x, G=1.0)
    potential, field, gradient = by_integrals(np.array(x))
    assert float(result.potential) == pytest.approx(potential, rel=1e-15)
    assert result.field == pytest.approx(field, rel=1e-14)
    within(result.gradient[None], gradient[None], 2e-15)
    # Poisson's equation.
    assert np.trace(result.gradient) == pytest.approx(-3.0 / np.prod(AXES), rel=1e-14)


def test_the_gradient_of_a_polyhedron_is_that_of_differences():
    # Its trace is Laplace's or Poisson's.
    body, h = Body(CUBE, mass=8.0), 1e-3
    for x, trace in (((1.7, 0.4, -0.3), 0.0), ((0.2, -0.5, 0.3), -4.0 * np.pi), ((30.0, 20.0, -50.0), 0.0)):
        steps = np.array(x) + h * np.array([-2, -1, 1, 2])[:, None, None] * np.eye(3)
        a, b, c, d = body.gravity(steps, G=1.0).field
        result = body.gravity(x, G=1.0).gradient
        size = np.abs(result).max()
        assert result == pytest.approx((8.0 * (c - b) - (d - a)) / (12.0 * h), abs=1e-9 * size + 1e-12)
        assert np.trace(result) == pytest.approx(trace, abs=1e-13)


def test_a_system_is_the_sum_of_its_bodies_where_they_are():
    club = Composite(
        [
            Part(Sphere(1.0), mass=2.0),
            Part(Ellipsoid(0.5, 0.4, 0.3), mass=1.0, position=(0.9, 0.2, 0.1), attitude=(0.9, 0.1, 0.2, 0.3)),
        ]
    )
    shapes = [Body(Ellipsoid(*AXES), mass=1.5), Body(club), Body(CUBE, mass=0.7), Body(PointMass(), mass=0.2)]
    system = fullbody.System(shapes, G=2.0)
    rng = np.random.default_rng(4)
    attitudes = rng.normal(size=(4, 4))
    attitudes /= np.linalg.norm(attitudes, axis=1, keepdims=True)
    state = resting([[0, 0, 0], [6, 1, 0], [-5, 4, 2], [1, -7, 3]], attitudes)
    points = rng.normal(size=(7, 11, 3)) * 5.0
    # Some inside.
    points[0, :4] = state.position + rng.normal(size=(4, 3)) * 0.2
    total = system.gravity(state, points)
    sums = [0.0, 0.0, 0.0]
    for k, body in enumerate(shapes):
        rotation = matrix(state.attitude[k])
        body_gravity = body.gravity((points - state.position[k]) @ rotation, G=2.0)
        parts = body_gravity.potential, body_gravity.field @ rotation.T, rotation @ body_gravity.gradient @ rotation.T
        item = system.gravity(state, points, body=k)
        for result, expected in zip((item.potential, item.field, item.gradient), parts, strict=True):
            within(result.reshape(77, -1), expected.reshape(77, -1), 2e-13)
        sums = [total + part for total, part in zip(sums, parts, strict=True)]
    assert total.potential.shape == (7, 11)
    for result, expected in zip((total.potential, total.field, total.gradient), sums, strict=True):
        within(result.reshape(77, -1), expected.reshape(77, -1), 2e-13)


def test_the_third_law_gives_the_force_on_a_point():
    # A point of mass m in the state feels m g by the mutual forces, which are another code.
    system, state = fullbody.systems.kw4()
    probe = Body(PointMass(), mass=1.0, name="probe")
    with_probe = fullbody.System([*system.bodies, probe], G=system.G)
    point = np.array([1.9, -1.2, 0.7])
    force = with_probe.interactions(resting([*state.position, point], [*state.attitude, [1, 0, 0, 0]])).force[2]
    within(system.gravity(state, point).field[None], force[None], 1e-14)


def test_gravity_along_a_run_is_that_of_its_states(flown):
    points = np.array([[3.0, 1.0, 0.5], [0.0, 2.0, 2.0], [0.1, 0.1, 0.1]])
    result = flown.gravity([[1.0], [2.5]], points, body="Alpha")
    assert result.field.shape == (2, 3, 3)
    for row, time in enumerate((1.0, 2.5)):
        assert np.array_equal(result.field[row], flown.system.gravity(flown(time), points, body=0).field)
    track = flown.gravity([1.0, 2.5, 1.0], points)
    assert np.array_equal(track.potential[1], flown.system.gravity(flown(2.5), points[1]).potential)
    assert np.array_equal(track.gradient[2], flown.system.gravity(flown(1.0), points[2]).gradient)
    # Samples need no continuous solution.
    bare = flown[:]
    bare.dense = None
    assert np.array_equal(bare.gravity(2.0, points).field, flown.system.gravity(flown[1], points).field)
    refused(r"time is 2\.5, of no sample; .* dense=True", lambda: bare.gravity(2.5, points))
    refused("time is 7", lambda: flown.gravity(7.0, points))
    refused(r"times of shape \(2,\) and points of shape \(3, 3\)", lambda: flown.gravity([1.0, 2.0], points))


def test_gravity_at_points_has_units_and_the_shape_of_the_points():
    unitless, state = fullbody.systems.kw4()
    system, with_units = fullbody.systems.kw4(units=True)
    expected = unitless.gravity(state, [2.0, 1.0, 0.5])
    result = system.gravity(with_units, [2000.0, 1000.0, 500.0] * u.m)
    assert result.potential.to_value("km2/hour2") == pytest.approx(expected.potential, rel=1e-14)
    assert result.field.to_value("km/hour2") == pytest.approx(expected.field, rel=1e-13)
    assert result.gradient.unit == u.hour**-2
    assert result.gradient.to_value("hour-2") == pytest.approx(expected.gradient, rel=1e-12)
    result = Body(Sphere(1.0), mass=1.0).gravity(np.zeros((0, 3)), G=1.0)
    assert (result.potential.shape, result.field.shape, result.gradient.shape) == ((0,), (0, 3), (0, 3, 3))


def test_bad_points_are_refused_by_index():
    system = fullbody.System([Body(CUBE, mass=1.0, name="cube"), Body(PointMass(), mass=0.1, name="dust")], G=1.0)
    state = resting([[0, 0, 0], [0, 0, 4.0]])
    for points, words in (
        ([[1, 2, 3], [4, np.nan, 6]], r"point 1, component 1, is NaN; expected a finite number"),
        ([[[1, 2, 3], [0, 0, 4.0]]], r"point \(0, 1\) is \[0, 0, 4\]; expected one away from the point mass of dust"),
        (np.zeros((3, 2)), r"points has shape \(3, 2\); expected \(\.\.\., 3\)"),
    ):
        refused(words, system.gravity, state, points)
    result = system.gravity(state, [[9, 9, 9], [1.0, 0.3, 0.2]])
    assert np.isfinite(result.field).all()
    refused(r"point 1 is \[1, 0.3, 0.2\]; expected one off the surface of cube", lambda: result.gradient)
    refused("body is 'Gamma'", system.gravity, state, [1, 2, 3], body="Gamma")
    refused("state has 1 bodies; expected 2", system.gravity, resting([[0, 0, 0]]), [1, 2, 3])


HASH = """
import hashlib, fullbody, numpy as np
system, state = fullbody.systems.kw4()
cloud = np.random.default_rng(0).normal(size=(9000, 3)) * 2.0
found = system.gravity(state, cloud)
digest = hashlib.sha256(b"".join(a.tobytes() for a in (found.potential, found.field, found.gradient))).hexdigest()
"""


def test_threads_and_crowds_change_no_bit():
    environment = os.environ | {"RAYON_NUM_THREADS": "3" if os.cpu_count() == 1 else "1"}
    command = [sys.executable, "-c", HASH + "print(digest)"]
    output = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout
    namespace: dict = {}
    exec(HASH, namespace)
    assert output.strip() == namespace["digest"]
    system, state, cloud, complete = (namespace[name] for name in ("system", "state", "cloud", "found"))
    for some in (slice(0, 1), slice(17, 18), slice(1000, 1700), slice(None, None, -1)):
        part = system.gravity(state, cloud[some])
        for name in ("potential", "field", "gradient"):
            assert np.array_equal(getattr(part, name), getattr(complete, name)[some])
