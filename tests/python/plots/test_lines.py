"""Fast oscillations are drawn as envelopes, fast turns as departures from a uniform one, and paths without corners."""

import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from fullbody.plots import lines
from fullbody.plots.between import poses, relative_path
from support import points

TIME = np.linspace(0.0, 100.0, 20_001)


def axes(width=5.0):
    return plt.subplots(figsize=(width, 3.0))[1]


def drawn_as(ax):
    """Lines, bands and texts of the legend of axes."""
    return len(ax.lines), len(ax.collections), ax.get_legend_handles_labels()[1]


def test_an_envelope_is_the_range_and_the_mean_of_a_fast_oscillation():
    ax = axes()
    trend = 0.02 * TIME
    line = lines.draw(ax, TIME, trend + 0.5 * np.sin(2 * np.pi * 10.0 * TIME), {"label": "x", "color": "red"})
    assert drawn_as(ax) == (1, 1, ["x", "range"])
    inside = (line.get_xdata() > 1.0) & (line.get_xdata() < 99.0)
    # The mean of a few periods, and the trend of two percent of the amplitude within them.
    assert line.get_ydata()[inside] == pytest.approx(0.02 * line.get_xdata()[inside], abs=2e-3)
    edge = ax.collections[0].get_paths()[0].vertices
    middle = edge[(edge[:, 0] > 1.0) & (edge[:, 0] < 99.0)]
    assert np.abs(middle[:, 1] - 0.02 * middle[:, 0]) == pytest.approx(0.5, abs=1e-2)


@pytest.mark.parametrize(
    ("values", "width"),
    [
        (np.sin(2 * np.pi * 0.2 * TIME), 5.0),
        (TIME**2 + 1e-3 * np.sin(2 * np.pi * 10.0 * TIME), 5.0),
        (np.sin(2 * np.pi * 0.8 * TIME), 10.0),
        (np.full(len(TIME), 3.0), 5.0),
        (3.0 + 1e-14 * np.sin(2 * np.pi * 10.0 * TIME), 5.0),
    ],
    ids=["slow", "small", "wide axes", "constant", "rounding"],
)
def test_slow_or_small_oscillations_are_drawn_as_lines(values, width):
    ax = axes(width)
    line = lines.draw(ax, TIME, values, {})
    assert drawn_as(ax) == (1, 0, [])
    np.testing.assert_array_equal(line.get_ydata(), values)


def test_the_legend_names_the_band_once():
    ax = axes()
    for name, size in (("x", 1.0), ("y", 2.0)):
        lines.draw(ax, TIME, size * np.sin(2 * np.pi * 10.0 * TIME), {"label": name})
    assert drawn_as(ax) == (2, 2, ["x", "range", "y"])


def test_an_angle_of_many_turns_is_drawn_without_its_uniform_turn():
    ax = axes()
    rotation = 720.0 * TIME + 5.0 * np.sin(2 * np.pi * 0.05 * TIME)
    name = lines.draw_angle(ax, TIME, (rotation + 180.0) % 360.0 - 180.0, {}, r"$\psi$", "h")
    assert name == r"$\psi$ $-\,\nu t$"
    assert ax.get_legend_handles_labels()[1] == [r"$\nu$ = 720°/h"]
    assert ax.lines[0].get_ydata() == pytest.approx(5.0 * np.sin(2 * np.pi * 0.05 * TIME), abs=1e-9)


def test_an_angle_near_zero_is_drawn_without_jumps():
    ax = axes()
    angle = 5.0 * np.sin(2 * np.pi * 0.1 * TIME)
    assert lines.draw_angle(ax, TIME, angle % 360.0, {}, "$M$", "h") == "$M$"
    assert ax.lines[0].get_ydata() == pytest.approx(angle, abs=1e-9)


def test_an_angle_that_its_samples_do_not_follow_is_drawn_as_dots():
    ax = axes()
    time = np.arange(500.0)
    lines.draw_angle(ax, time, 170.0 * time % 360.0, {}, "$M$", "h")
    assert (ax.lines[0].get_linestyle(), ax.lines[0].get_marker()) == ("None", ".")


@pytest.mark.parametrize("spacing", [0.4, 0.2])
def test_attitudes_between_samples_follow_the_spins_to_fourth_order(spacing):
    body = fullbody.Body(fullbody.Ellipsoid(1.5, 1.0, 0.6), mass=1.0)
    system = fullbody.System([body], G=1e-9)
    state = fullbody.State([[0, 0, 0]], [[0, 0, 0]], spin=[[0.3, 1.0, 0.2]])
    run = system.integrate(state, 8.0, output=spacing)
    times = np.linspace(0.0, 8.0, 97)
    exact = system.integrate(state, 8.0, output=times)
    overlap = np.abs(np.sum(poses(run, times)[1][:, 0] * exact.attitude[:, 0], axis=1))
    error = 2.0 * np.arccos(np.minimum(overlap, 1.0)).max()
    # The rates change by about one in a unit of time: a cubic's error is of the order of h^4 / 384.
    assert error < 6.0 * spacing**4 / 384.0


def test_paths_between_samples_are_smooth_and_samples_too_far_apart_are_dots():
    system, r = points(1.0, 1e-9), 1.0
    state = fullbody.State([[0, 0, 0], [r, 0, 0]], [[0, 0, 0], [0, 1, 0]])
    run = system.integrate(state, 12.0, output=0.6)
    path, joined = relative_path(run, 1, 0)
    assert joined
    # Chords between the samples have their middles nearer by 1 - cos 0.3, 0.045.
    assert np.linalg.norm(path, axis=1) == pytest.approx(1.0, abs=5e-4)
    far = system.integrate(state, 40.0, output=4.0)
    path, joined = relative_path(far, 1, 0)
    assert not joined
    np.testing.assert_array_equal(path, far.position[:, 1] - far.position[:, 0])
    (dots,) = far.plot.orbit(shapes=False).lines
    assert (dots.get_linestyle(), dots.get_marker()) == ("None", ".")
    dense = system.integrate(state, 40.0, output=4.0, dense=True)
    path, joined = relative_path(dense, 1, 0)
    assert joined
    assert np.linalg.norm(path, axis=1) == pytest.approx(1.0, abs=1e-8)
