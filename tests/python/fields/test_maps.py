"""Maps of surfaces cover the whole body; surfaces along a run."""

import fullbody
import numpy as np
import pytest
from fullbody import fields, plots
from scipy.spatial import ConvexHull
from support import refused


def hull(vertex_at_pole):
    """A convex polyhedron, with a vertex at one pole or with faces over both."""
    points = np.random.default_rng(1).normal(size=(60, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    if vertex_at_pole:
        points[0] = [0.0, 0.0, 1.0]
    points = np.concatenate([points, -points])
    faces = ConvexHull(points).simplices
    corners = points[faces]
    inward = np.linalg.det(corners) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return fullbody.Polyhedron(points, faces)


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
    # Whatever reaches beyond an edge of the map stands at the other one, too.
    every = np.concatenate([path.vertices for path in cells.get_paths()])
    assert every[:, 0].min() <= -180.0
    assert every[:, 0].max() >= 180.0
    assert np.abs(every[:, 1]).max() == pytest.approx(90.0)


@pytest.fixture(scope="module")
def swinging():
    system, state = fullbody.systems.kw4(units=True)
    return system.integrate(state.rotated("Beta", [0, 0, 1], "10 deg"), "20 h", output="2 h")


def test_surfaces_along_a_run_are_those_of_its_states(swinging):
    found = fields.surface_along(swinging, "Beta", rows=6)
    each = [fields.surface(swinging.system, swinging[k], "Beta", rows=6) for k in range(len(swinging))]
    for name in ("slope", "surface_acceleration"):
        values = np.array([getattr(field, name).value for field in each])
        least, greatest = getattr(found, f"least_{name}"), getattr(found, f"greatest_{name}")
        assert least.unit == getattr(each[0], name).unit
        np.testing.assert_array_equal(least.value, values.min(axis=0))
        np.testing.assert_array_equal(greatest.value, values.max(axis=0))
    np.testing.assert_array_equal(found.point, each[0].point)
    assert (found.greatest_slope > found.least_slope).all()
    label = plots.surface_map(found, "greatest_slope").child_axes[0].get_ylabel()
    assert label == "greatest slope [deg]"
    refused("quantity is 'slope'; expected 'least_slope'", lambda: plots.surface_map(found, "slope"))
    refused(r"expected a fullbody\.Run with samples", lambda: fields.surface_along(swinging[:0]))


def test_zero_velocity_curves_are_named():
    balls = [fullbody.Body(fullbody.Sphere(0.1), mass=m, name=n) for n, m in (("A", 0.99), ("B", 0.01))]
    state = fullbody.State(position=[[-0.01, 0, 0], [0.99, 0, 0]], velocity=[[0, -0.01, 0], [0, 0.99, 0]])
    pair = fields.Synodic(fullbody.System(balls, G=1.0), state)
    ax = plots.zero_velocity(pair)
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["through L4, L5", "through L3", "through L2", "through L1", "stable point", "unstable point"]
    # The names of the points stand outside of the bodies.
    ax.figure.canvas.draw()
    to_data = ax.transData.inverted().transform
    for note in ax.texts:
        corners = to_data(note.get_window_extent().corners()[:, :2])
        for centre in pair.position[:, :2]:
            nearest = np.clip(centre, corners.min(axis=0), corners.max(axis=0))
            assert np.linalg.norm(nearest - centre) > 0.1, note.get_text()
