"""Pictures and tables of external forces."""

import itertools

import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from fullbody import forces
from support import refused


def forced_system(units=True, byorp="1e-3 N"):
    system, state = fullbody.systems.didymos(sun=True, units=units)
    all_forces = [
        *system.forces,
        forces.Tide("Didymos", "Dimorphos", k2=1e-5, lag="5 s" if units else 0.001),
        forces.Byorp("Dimorphos", "Didymos", byorp),
    ]
    return system.with_forces(all_forces), state


@pytest.fixture(scope="module")
def run():
    system, state = forced_system()
    return system.integrate(state, "50 h", output="0.5 h")


def texts(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def test_the_plot_of_work_has_the_numbers_of_the_run(run):
    ax = run.plot.work()
    assert texts(ax) == ["Sun", "tide on Didymos", "BYORP on Dimorphos"]
    for line, name in zip(ax.lines, run.work, strict=True):
        assert np.allclose(line.get_ydata(), run.work[name].to_value("J"), rtol=1e-12)
        assert np.array_equal(line.get_xdata(), run.time.value)
    assert ax.get_xlabel() == "time [h]"
    assert ax.get_ylabel() == "work [J]"
    # The Sun's work is hundreds of times the tide's: that stays in the linear part.
    assert ax.get_yscale() == "symlog"
    least = np.abs(run.work["tide on Didymos"].to_value("J")).max()
    assert least <= ax.yaxis.get_transform().linthresh < 10 * least


def test_the_plot_of_work_is_linear_for_similar_forces_and_names_those_without_work():
    system, state = forced_system(units=False, byorp=0.0)
    run = system.with_forces(system.forces[1:]).integrate(state, 20.0, output=1.0)
    ax = run.plot.work(color="red")
    assert ax.get_yscale() == "linear"
    assert texts(ax) == ["tide on Didymos", "BYORP on Dimorphos: none"]
    assert ax.get_ylabel() == "work [system units]"
    assert ax.lines[0].get_color() == "red"
    caller_axes = ax.figure.add_subplot()
    assert run.plot.work(caller_axes) is caller_axes


def test_without_forces_there_is_no_work_to_draw():
    system, state = fullbody.systems.case1()
    run = system.integrate(state, 5.0, output=1.0)
    refused("the run has no external forces", lambda: run.plot.work())
    assert "work" not in run.plot().axes
    refused("no samples", lambda: run[:0].plot.work())


def test_the_page_names_the_forces(run):
    page = run.plot()
    assert [*page.axes][-2:] == ["energy", "work"]
    assert "with Sun, tide on Didymos, BYORP on Dimorphos" in page.figure._suptitle.get_text()
    # No two tick labels of the work cover each other.
    page.figure.draw_without_rendering()
    ax = page.axes["work"]
    boxes = [label.get_window_extent() for label in ax.get_yticklabels() if label.get_text()]
    inside = [box for box in boxes if ax.bbox.y0 <= (box.y0 + box.y1) / 2 <= ax.bbox.y1]
    assert len(inside) >= 3
    for first, other in itertools.combinations(inside, 2):
        assert min(first.y1, other.y1) - max(first.y0, other.y0) <= 1.0


def test_tables_and_texts_name_the_forces(run):
    system = run.system
    assert "forces=['Sun', 'tide on Didymos', 'BYORP on Dimorphos']" in repr(system)
    page = system._repr_html_()
    assert "<b>Forces</b>" in page
    for text in ("ThirdBody", "the system goes round it, a = ", "by Dimorphos on Didymos, k2 = 1e-05, lag "):
        assert text in page
    assert "12.96 kg km / h2 along the motion" in page
    moon = forces.ThirdBody(mu=1.0, times=[0, 1, 2, 3], positions=np.full((4, 3), 1e3), of="body", name="Moon")
    many = [
        moon,
        forces.Yorp(0, along=2.0, across=1.0),
        forces.Yorp(1, along=[1, 2, 3, 4], obliquity=[0, 1, 2, np.pi]),
        forces.Function(lambda time, state: 0.0 * state.velocity, name="push"),
    ]
    system, _ = fullbody.systems.case1()
    page = system.with_forces(many)._repr_html_()
    for text in (
        "mu = 1; 4 positions from 0 to 3",
        "on A, 2 along and 1 across the spin",
        "on B, torques at 4 obliquities",
        "a function of Python that depends on velocities",
    ):
        assert text in page
    assert "Forces" not in system._repr_html_()
    assert "forces" not in repr(system)


#: The axis is 9.28 degrees from the pole of the ecliptic: the angle about that pole varies in speed by 1 / cos - 1.
INCLINED = 1.01 * (1 / np.cos(np.radians(9.28)) - 1)


def psi(run):
    """The curve of Didymos' rotation, in turns and hours."""
    (line,) = run.plot.angles(axes=plt.subplots(2, 3, figsize=(60.0, 4.0))[1])[0, 2].lines
    time, angle = (np.asarray(values, dtype=float) for values in line.get_data())
    scale = 1.0 if np.nanmax(time) > 200.0 else 24.0
    keep = np.isfinite(angle)
    return scale * time[keep], angle[keep] / 360.0


def test_the_curve_of_a_fast_rotation_follows_each_turn_or_warns():
    system, state = fullbody.systems.didymos_after_dart(units=True, gravity="point")
    for output, dense in (("15 min", False), ("2 hour", True)):
        time, turns = psi(system.integrate(state, "10 days", output=output, dense=dense))
        followed = np.diff(turns) - np.round(np.diff(turns))
        assert np.abs(followed).max() < 1 / 40
        np.testing.assert_allclose(followed / np.diff(time), -1 / 2.26, rtol=INCLINED)
    run = system.integrate(state, "10 days", output="2 hour")
    with pytest.warns(UserWarning, match=r"Didymos makes up to 0.88 turns between two samples .*dense=True"):
        run.plot.angles()
