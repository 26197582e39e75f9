"""Geopotential, acceleration and slope on surfaces, against closed forms."""

import fullbody
import numpy as np
import pytest
from fullbody import Body, Composite, Ellipsoid, Part, PointMass, Sphere, fields, plots
from fullbody.fields import surface
from support import matrix, refused
from support.meshes import convex_hull, icosphere


def alone(body, spin=(0, 0, 0), attitude=(1, 0, 0, 0), G=1.0):
    """One body at rest."""
    state = fullbody.State(position=[[0, 0, 0]], velocity=[[0, 0, 0]], attitude=[attitude], spin=[spin])
    return fullbody.System([body], G=G), state


def test_a_maclaurin_spheroid_at_its_own_rate_has_no_slope():
    """Its rate is Omega^2 = 2 pi G rho [sqrt(1-e^2)/e^3 (3-2e^2) asin e - 3 (1-e^2)/e^2] (Chandrasekhar 1969)."""
    for c in (0.9, 0.5, 0.2):
        e = np.sqrt(1.0 - c * c)
        rate = 2.0 * np.pi * (np.sqrt(1 - e * e) / e**3 * (3 - 2 * e * e) * np.arcsin(e) - 3 * (1 - e * e) / (e * e))
        body = Body(Ellipsoid(2.0, 2.0, 2.0 * c), density=1.0)
        field = surface(*alone(body, spin=(0, 0, np.sqrt(rate)), attitude=(0.5, 0.1, -0.7, 0.5)), rows=20)
        assert field.slope.max() < 2e-14
        assert np.ptp(field.geopotential) < 1e-14 * np.abs(field.geopotential).max()
        other = surface(*alone(body, spin=(0, 0, 0.9 * np.sqrt(rate))), rows=20)
        assert other.slope.max() > 0.005


def test_the_surface_of_a_rotating_ball_has_the_closed_form():
    """The formulas are a = -(GM/R^2) n + omega^2 rho and V = -GM/R - omega^2 rho^2 / 2."""
    mass, radius, rate = 3.0, 2.0, 0.3
    field = surface(*alone(Body(Sphere(radius), mass=mass), spin=(0, 0, rate)), rows=12)
    across = field.point * [1.0, 1.0, 0.0]
    assert field.acceleration == pytest.approx(-mass / radius**2 * field.normal + rate**2 * across, abs=1e-14)
    expected = -mass / radius - 0.5 * rate**2 * (across**2).sum(axis=1)
    assert field.geopotential == pytest.approx(expected, rel=1e-14)
    up, out = mass / radius**2, rate**2 * radius * np.cos(field.latitude)
    slope = np.arctan2(out * np.abs(np.sin(field.latitude)), up - out * np.cos(field.latitude))
    assert field.slope == pytest.approx(slope, abs=1e-14)
    assert field.surface_acceleration == pytest.approx(np.linalg.norm(field.acceleration, axis=1))
    assert field.area.sum() == pytest.approx(4.0 * np.pi * radius**2, rel=0.02)


def test_the_tide_of_the_other_body_is_newtons():
    """A distant ball has the tide G m [(d - r)/|d - r|^3 - d/d^3]."""
    balls = [Body(Sphere(1.0), mass=1.0, name="A"), Body(Sphere(0.5), mass=0.6, name="B")]
    attitude = np.array([0.8, 0.1, -0.4, 0.3])
    attitude /= np.linalg.norm(attitude)
    d = np.array([2.0, -1.0, 0.5])
    state = fullbody.State(position=[np.zeros(3), d], velocity=np.zeros((2, 3)), attitude=[attitude, attitude])
    field = surface(fullbody.System(balls, G=2.0), state, "A", rows=10)
    offset = d @ matrix(attitude) - field.point
    far = np.linalg.norm(offset, axis=1, keepdims=True)
    tide = 1.2 * (offset / far**3 - d @ matrix(attitude) / np.linalg.norm(d) ** 3)
    assert field.acceleration == pytest.approx(tide - 2.0 * field.normal, abs=1e-13)
    potential = (
        1.2 * (1.0 / far[:, 0] - 1.0 / np.linalg.norm(d))
        - 1.2 * field.point @ (d @ matrix(attitude)) / np.linalg.norm(d) ** 3
    )
    assert field.geopotential == pytest.approx(-2.0 - potential, abs=1e-13)


def test_the_acceleration_is_that_of_a_released_particle():
    system, state = fullbody.systems.kw4()
    state = state.replace(spin=[[0.3, -0.2, 2.2], [0.4, 0.3, 0.2]])
    field = surface(system, state, "Beta", rows=6)
    k = 20
    rotation = matrix(state.attitude[1])
    # A little above the surface: a point on it would touch.
    arm = field.point[k] * (1.0 + 1e-9)
    position = state.position[1] + rotation @ arm
    speed = state.velocity[1] + rotation @ np.cross(state.spin[1], arm)
    dust = Body(PointMass(), mass=1e-20, name="dust")
    both = fullbody.System([*system.bodies, dust], G=system.G)
    joined = fullbody.State(
        position=[*state.position, position],
        velocity=[*state.velocity, speed],
        attitude=[*state.attitude, [1, 0, 0, 0]],
        spin=[*state.spin, [0, 0, 0]],
    )
    load, m = both.interactions(joined), system.masses
    g, centre = load.force[2] / 1e-20, load.force[1] / m[1]
    inertia, omega = system["Beta"].inertia, state.spin[1]
    turning = (load.torque[1] - np.cross(omega, inertia * omega)) / inertia
    expected = rotation.T @ (g - centre) - np.cross(omega, np.cross(omega, arm)) - np.cross(turning, arm)
    assert field.acceleration[k] == pytest.approx(expected, rel=1e-7)


def test_the_surface_of_a_finely_cut_sphere_is_nearly_the_balls():
    field = surface(*alone(Body(icosphere(3), mass=1.0), spin=(0, 0, 0.3)))
    assert field.cells.shape == (1280, 4, 3)
    assert (np.sum(field.normal * field.point, axis=1) > 0.99).all()
    assert field.area.sum() == pytest.approx(4.0 * np.pi, rel=0.01)
    across = field.point * [1.0, 1.0, 0.0]
    assert field.acceleration == pytest.approx(-field.point + 0.09 * across, abs=0.02)


def test_a_composite_has_the_surfaces_of_its_parts_outside_of_each_other():
    """Two balls that overlap have the area of their spheres less the caps, whose area is 2 pi R h."""
    parts = [Part(Sphere(1.0), mass=1.0), Part(Sphere(0.6), mass=0.2, position=(1.2, 0.0, 0.0))]
    body = Body(Composite(parts))
    field = surface(*alone(body), rows=90)
    frame = body.working_frame
    centres = [frame.position + matrix(frame.attitude) @ origin for origin in ([0.0, 0.0, 0.0], [1.2, 0.0, 0.0])]
    for centre, radius in zip(centres, (1.0, 0.6), strict=True):
        assert (np.linalg.norm(field.point - centre, axis=1) > radius - 1e-12).all()
    plane = (1.2**2 + 1.0 - 0.36) / 2.4
    expected = 4.0 * np.pi * 1.36 - 2.0 * np.pi * (1.0 - plane) - 2.0 * np.pi * 0.6 * (0.6 - (1.2 - plane))
    assert field.area.sum() == pytest.approx(expected, rel=0.01)


def test_bodies_without_a_surface_are_refused():
    refused("dust has no surface", lambda: surface(*alone(Body(PointMass(), mass=1.0, name="dust"))))
    refused("rows is 1; expected a whole number", lambda: surface(*alone(Body(Sphere(1.0), mass=1.0)), rows=1))


def hull(vertex_at_pole):
    """A convex polyhedron, with a vertex at one pole or with faces over both."""
    points = np.random.default_rng(1).normal(size=(60, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    if vertex_at_pole:
        points[0] = [0.0, 0.0, 1.0]
    return convex_hull(np.concatenate([points, -points]))


def area(outline):
    x, y = outline.T
    return 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize("shape", [hull(True), hull(False), fullbody.Ellipsoid(1.0, 0.8, 0.7)])
def test_the_cells_of_a_map_cover_the_body_once(shape):
    system = fullbody.System([fullbody.Body(shape, mass=1.0, name="A")], G=1.0)
    field = fields.surface(system, fullbody.State([[0, 0, 0]], [[0, 0, 0]]), rows=12)
    (cells,) = plots.surface_map(field).collections
    outlines = [path.vertices[:-1] for path in cells.get_paths()[: len(field.slope)]]
    assert sum(map(area, outlines)) == pytest.approx(360.0 * 180.0, rel=1e-3)
    # A cell that reaches beyond an edge of the map is repeated at the opposite edge.
    every = np.concatenate([path.vertices for path in cells.get_paths()])
    assert every[:, 0].min() <= -180.0
    assert every[:, 0].max() >= 180.0
    assert np.abs(every[:, 1]).max() == pytest.approx(90.0)


@pytest.fixture(scope="module")
def swinging():
    system, state = fullbody.systems.kw4(units=True)
    return system.integrate(state.rotated("Beta", [0, 0, 1], "10 deg"), "20 h", output="2 h")


def test_surfaces_along_a_run_are_those_of_its_states(swinging):
    result = fields.surface_along(swinging, "Beta", rows=6)
    samples = [fields.surface(swinging.system, swinging[k], "Beta", rows=6) for k in range(len(swinging))]
    for name in ("slope", "surface_acceleration"):
        values = np.array([getattr(field, name).value for field in samples])
        least, greatest = getattr(result, f"least_{name}"), getattr(result, f"greatest_{name}")
        assert least.unit == getattr(samples[0], name).unit
        np.testing.assert_array_equal(least.value, values.min(axis=0))
        np.testing.assert_array_equal(greatest.value, values.max(axis=0))
    np.testing.assert_array_equal(result.point, samples[0].point)
    assert (result.greatest_slope > result.least_slope).all()
    label = plots.surface_map(result, "greatest_slope").child_axes[0].get_ylabel()
    assert label == "greatest slope [deg]"
    refused("quantity is 'slope'; expected 'least_slope'", lambda: plots.surface_map(result, "slope"))
    refused(r"expected a fullbody\.Run with samples", lambda: fields.surface_along(swinging[:0]))


def test_zero_velocity_curves_are_named():
    balls = [fullbody.Body(fullbody.Sphere(0.1), mass=m, name=n) for n, m in (("A", 0.99), ("B", 0.01))]
    state = fullbody.State(position=[[-0.01, 0, 0], [0.99, 0, 0]], velocity=[[0, -0.01, 0], [0, 0.99, 0]])
    pair = fields.Synodic(fullbody.System(balls, G=1.0), state)
    ax = plots.zero_velocity(pair)
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["through L3", "through L2", "through L1", "stable point", "unstable point"]
    # The names of the points stand outside of the bodies.
    ax.figure.canvas.draw()
    to_data = ax.transData.inverted().transform
    for note in ax.texts:
        corners = to_data(note.get_window_extent().corners()[:, :2])
        for centre in pair.position[:, :2]:
            nearest = np.clip(centre, corners.min(axis=0), corners.max(axis=0))
            assert np.linalg.norm(nearest - centre) > 0.1, note.get_text()
