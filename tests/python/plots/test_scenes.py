"""Scenes in 3D show the bodies at their poses, also between samples."""

import fullbody
import numpy as np
import pytest
from fullbody.plots._style import rounded
from fullbody.plots.between import poses
from support import refused


@pytest.mark.parametrize(("dense", "close"), [(True, 1e-9), (False, 2e-5)])
def test_a_scene_has_the_surface_of_an_ellipsoid_at_its_pose(kw4_run, dense, close):
    start = kw4_run[0]
    run = kw4_run.system.integrate(start, 50.0, output=0.5, dense=dense)
    state = kw4_run.system.integrate(start, 20.1, output=[20.1])[0]
    ax = run.plot.scene(20.1)
    assert ax.get_title() == "time 20.1 h"
    masses = kw4_run.system.masses.value
    centre = state.position.value - masses @ state.position.value / masses.sum()
    drawn = ax.collections[1]
    # Matplotlib 3.9 has the points in columns.
    surface = np.concatenate(drawn._faces) if hasattr(drawn, "_faces") else drawn._vec[:3].T
    body = (surface - centre[1]) @ state.rotation_matrix[1]
    assert np.allclose(np.sum((body / np.array([0.2975, 0.225, 0.1715])) ** 2, axis=1), 1.0, atol=10 * close)
    x, y, z = ax.lines[-1].get_data_3d()
    ends = (np.stack([x, y, z], axis=1) - centre[1]) @ state.rotation_matrix[1]
    assert np.allclose(ends[:, :2], 0.0, atol=close)
    assert ends[0, 2] == pytest.approx(0.1715, abs=close)
    # The path ends in the body.
    assert np.allclose(np.array(ax.lines[4].get_data_3d())[:, -1], centre[1], atol=close)


def test_scenes_outside_of_the_run_are_refused(kw4_run):
    for time in (-0.1, 50.1):
        refused(rf"time is {time}; expected one within the run, from 0 to 50", kw4_run.plot.scene, time)
    # The continuous solution reaches further than the samples of this run.
    run = kw4_run.system.integrate(kw4_run[0], 3.0, output=[1.0], dense=True)
    assert run.plot.scene(2.5).get_title() == "time 2.5 h"


@pytest.mark.parametrize("until", [9.0, -9.0])
def test_poses_between_samples_follow_the_motion(until):
    bodies = [fullbody.Body(fullbody.Sphere(0.1), mass=m) for m in (1.0, 1e-9)]
    state = fullbody.State([[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 1, 0]], spin=[[0, 0, 0.5], [0, 0, 1.0]])
    run = fullbody.System(bodies, G=1.0).integrate(state, until, output=0.9)
    times = np.linspace(0.0, until, 41)
    centres, attitude = poses(run, times)
    circle = np.stack([np.cos(times), np.sin(times), 0 * times], axis=1)
    assert np.allclose(centres[:, 1], circle, atol=0.9**4 / 384 * 1.1)
    for body, rate in enumerate((0.5, 1.0)):
        even = np.stack([np.cos(rate * times / 2), 0 * times, 0 * times, np.sin(rate * times / 2)], axis=1)
        assert np.allclose(np.abs(np.sum(attitude[:, body] * even, axis=1)), 1.0, atol=1e-12)


def test_samples_far_apart_are_joined_by_straight_lines():
    system, state = fullbody.systems.kw4()
    centres, _ = poses(system.integrate(state, 52.0, output=26.0), np.linspace(0.0, 52.0, 101))
    assert np.linalg.norm(centres[:, 1], axis=1).max() < 2.6


@pytest.mark.parametrize(
    ("time", "text"), [(0.0, "0"), (17.33333, "17.33"), (12345.67, "12346"), (-0.0123456, "-0.01235"), (2.0, "2")]
)
def test_titles_have_four_digits(time, text):
    assert rounded(time) == text


def test_scene_has_equal_scales(kw4_run):
    ax = kw4_run.plot.scene()
    spans = np.ptp([ax.get_xlim(), ax.get_ylim(), ax.get_zlim()], axis=1)
    assert np.allclose(spans / ax._box_aspect, spans[0] / ax._box_aspect[0])
