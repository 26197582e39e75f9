"""Sunlight, shadows and light curves in pictures."""

import base64
import json
import re

import astropy.units as u
import fullbody
import matplotlib
import numpy as np
import pytest
from fullbody import observing
from fullbody.plots.sunlight import NIGHT, Sunlight
from support import refused


@pytest.fixture(scope="module")
def run():
    system, state = fullbody.systems.didymos(units=True, frame="ecliptic")
    return system.integrate(state, 12.0, output=0.5, dense=True)


@pytest.fixture(scope="module")
def geometry():
    vectors = {"to_observer": [0.1, 0.02, 0.0] * u.au, "to_sun": [0.9, 0.5, 0.0] * u.au}
    return observing.Geometry([-1.0, 20.0] * u.h, **vectors)


def test_points_are_lit_where_the_sun_is_up_and_no_body_is_between():
    bodies = [fullbody.Body(fullbody.Sphere(r), mass=1.0, name=n) for r, n in ((2.0, "A"), (1.0, "B"))]
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State(position=[[0, 0, 0], [5.0, 0, 0]], velocity=[[0, 0, 0], [0, 0.3, 0]])
    run = system.integrate(state, 0.1)
    sun = np.array([1.0, 0.0, 0.0])
    light = Sunlight(run, sun, state.position, state.attitude)
    # On the sphere behind the other: the shadow has the radius of the smaller one.
    height = np.array([0.0, 0.99, 1.01, 1.9])
    day = np.stack([np.sqrt(4.0 - height**2), height, 0 * height], axis=1)
    # Cells of one corner, which no shadow divides.
    shades = light.pieces(0, 0, day[:, None], day[:, None])[1]
    np.testing.assert_array_equal(shades[:2], NIGHT)
    np.testing.assert_allclose(shades[2:], NIGHT + (1 - NIGHT) * np.sqrt(4.0 - height[2:] ** 2) / 2.0)
    np.testing.assert_array_equal(light.pieces(0, 0, -day[:, None], -day[:, None])[1], NIGHT)


def test_light_curve_has_a_panel_for_each_body_and_bars_for_events(run, geometry):
    times = np.linspace(1.0, 11.0, 60) * u.h
    axes = run.plot.light_curve(times, geometry, bodies=True)
    assert len(axes) == 3
    np.testing.assert_allclose(axes[0].lines[0].get_ydata(), observing.light_curve(run, times, geometry))
    begun = [event for event in observing.mutual_events(run, geometry) if event.begin is not None]
    edges = [patch.get_x() for patch in axes[0].patches]
    for event in begun:
        if 1.0 < event.begin.value < 11.0:
            assert any(edge == pytest.approx(event.begin.value) for edge in edges)
    assert axes[0].yaxis_inverted()
    alone = run.plot.light_curve(times, geometry, events=False, law=observing.Lambert(), color="r")
    assert not alone.patches
    assert alone.lines[0].get_color() == "r"
    matplotlib.pyplot.close("all")


def test_views_above_a_light_curve_are_at_its_marked_times(run, geometry):
    times = np.linspace(1.0, 11.0, 60) * u.h
    ax = run.plot.light_curve(times, geometry, events=False, views=5)
    assert [view.get_title() for view in ax.child_axes] == ["2", "4", "6", "8", "10"]
    assert [line.get_xdata()[0] for line in ax.lines[1:]] == pytest.approx([2.0, 4.0, 6.0, 8.0, 10.0])
    # One scale for all, with the bodies of each.
    assert len({view.get_xlim() for view in ax.child_axes}) == 1
    assert all(view.collections for view in ax.child_axes)
    first, *remaining = (len(view.texts) for view in ax.child_axes)
    assert (first > 0, remaining) == (True, [0] * 4)
    axes = run.plot.light_curve(times, geometry, bodies=True, views=[5.8, 1.5] * u.h)
    assert [view.get_title() for view in axes[0].child_axes] == ["1.5", "5.8"]
    assert not axes[1].child_axes
    refused(
        "views is -1; expected a whole number, zero or above", lambda: run.plot.light_curve(times, geometry, views=-1)
    )


def test_scene_and_view_take_the_sun_of_a_geometry(run, geometry, tmp_path):
    lit = run.plot.scene(5.0, geometry=geometry, path=False)
    colours = np.concatenate([np.asarray(c.get_facecolor()) for c in lit.collections])
    reference = run.plot.scene(5.0, path=False)
    assert colours[:, :3].max(axis=1).min() < 0.2
    shown = np.concatenate([np.asarray(c.get_facecolor()) for c in reference.collections])
    assert shown[:, :3].max(axis=1).min() > 0.2
    matplotlib.pyplot.close("all")
    page = run.view(geometry=geometry).save_html(tmp_path / "view.html").read_text()
    data = json.loads(re.search(r'\{"names".*\}', page)[0])
    sun = np.frombuffer(base64.b64decode(data["sun"]), "<f4").reshape(-1, 3)
    np.testing.assert_allclose(sun, np.tile([0.9, 0.5, 0.0] / np.hypot(0.9, 0.5), (len(sun), 1)), atol=1e-6)
    assert len(data["casts"]) == 2
    with pytest.warns(UserWarning, match="turns between two pictures"):
        assert run.animate(tmp_path / "film.gif", seconds=0.2, fps=10, geometry=geometry).exists()
