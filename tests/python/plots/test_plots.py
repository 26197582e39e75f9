"""Plots show the run's own numbers, with units, on the axes they are given."""

import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from astropy import units as u
from fullbody import observables
from fullbody.plots.lines import degrees
from matplotlib.text import Text
from support import body_list, points, refused, rot_z
from support.legibility import faults


def drawn(line):
    """The points that a line shows, without the gaps where an angle jumps."""
    y = np.asarray(line.get_ydata(), dtype=float)
    return y[~np.isnan(y)]


def at_samples(line, samples):
    """The values of a line at the times of samples, which are among its points."""
    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    x, y = x[np.isfinite(y)], y[np.isfinite(y)]
    index = np.searchsorted(x, samples)
    assert np.array_equal(x[index], samples)
    return y[index]


def passes_through(line, points):
    """Whether all of some points (K, 2) are among those of a line."""
    apart = np.linalg.norm(np.transpose(line.get_data())[None] - points[:, None], axis=2)
    return apart.min(axis=1).max() < 1e-12 * np.abs(points).max()


def test_orbit_shows_the_relative_position(kw4_run):
    ax = kw4_run.plot.orbit(plane="xz", shapes=False)
    (line,) = ax.lines
    relative = (kw4_run.position[:, 1] - kw4_run.position[:, 0]).to_value("km")
    assert passes_through(line, relative[:, [0, 2]])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x from Alpha [km]", "z from Alpha [km]")
    assert ax.get_legend().get_texts()[0].get_text() == "Beta"


def test_orbit_outline_is_the_shadow_of_the_body():
    bodies = body_list((fullbody.Ellipsoid(3.0, 2.0, 1.0), 1.0), (fullbody.PointMass(), 1e-6))
    angle = np.deg2rad(30.0)
    state = fullbody.State.from_tait_bryan([[0, 0, 0], [9, 0, 0]], np.zeros((2, 3)), [[0, 0, angle], [0, 0, 0]])
    run = fullbody.System(bodies, G=1e-12).integrate(state, 0.001, output=[0.0])
    edge = run.plot.orbit().patches[0].get_xy() @ rot_z(angle)[:2, :2]
    assert np.allclose((edge[:, 0] / 3.0) ** 2 + (edge[:, 1] / 2.0) ** 2, 1.0, atol=1e-9)


def test_an_orbit_of_three_bodies_is_about_the_requested_one(triple_run):
    ax = triple_run.plot.orbit(about=2, shapes=False)
    assert [line.get_label() for line in ax.lines] == ["big", "body 1"]
    assert passes_through(ax.lines[1], (triple_run.position[:, 1] - triple_run.position[:, 2])[:, :2])
    assert ax.get_xlabel() == "x from a name as l… [system units]"


def test_plotted_elements_are_those_of_the_run(kw4_run):
    axes = kw4_run.plot.elements()
    values = kw4_run.elements()
    assert axes.shape == (3, 2)
    assert np.array_equal(axes.flat[0].lines[0].get_ydata(), values.a.to_value("km"))
    assert np.array_equal(axes.flat[1].lines[0].get_ydata(), values.e)
    for ax, name in zip(list(axes.flat)[2:], ("i", "Omega", "omega", "M"), strict=True):
        apart = drawn(ax.lines[0]) - np.rad2deg(getattr(values, name).to_value("rad"))
        # The mean anomaly oscillates about zero and is drawn without jumps between 0 and 360 degrees.
        assert np.abs(apart - 360.0 * np.round(apart / 360.0)).max() < 1e-12, name
    labels = [ax.get_ylabel() for ax in axes.flat]
    assert labels == ["$a$ [km]", "$e$", "$i$ [deg]", r"$\Omega$ [deg]", r"$\omega$ [deg]", "$M$ [deg]"]
    assert axes[2, 0].get_xlabel() == "time [h]"


#: Low and high ends of an axis, and the step of its ticks. The anomaly of a hyperbola goes on and on: five or fewer
#: whole turns of whole numbers of them.
TICKS = [
    *((0, 360, 90), (-180, 180, 90), (-90, 90, 45), (0, 90, 30), (40, 95, 15), (0, 8, 2)),
    *((0, 1000, 360), (-2000, 2000, 1080), (0, 30000, 7200), (-5e6, 5e6, 3.6e6)),
]


def test_ticks_of_angles_are_parts_of_a_turn():
    for low, high, step in TICKS:
        ax = plt.figure().add_subplot()
        ax.plot([0, 1], [low, high])
        degrees(ax)
        ticks = [tick for tick in ax.get_yticks() if low - 0.05 * step <= tick <= high + 0.05 * step]
        assert np.array_equal(np.unique(np.diff(ticks)), [step]), (low, high)
        assert np.all(np.mod(ticks, step) == 0)


def test_curves_within_rounding_are_shown_as_constant(case1_run):
    state = fullbody.State([[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, np.sqrt(1.001), 0]])
    run = points(1.0, 1e-3).integrate(state, 50.0, output=0.5)
    ax = run.plot.elements()[0, 1]
    ax.figure.draw_without_rendering()
    assert 0 < run.elements().e.max() < 1e-11
    assert ax.yaxis.get_offset_text().get_text() == ""
    assert np.ptp(ax.get_ylim()) > 0.01
    assert np.ptp(case1_run.plot.elements()[1, 0].get_ylim()) > 1.0


def test_lines_of_angles_have_gaps_at_jumps(kw4_run, triple_run):
    line = kw4_run.plot.elements()[2, 0].lines[0]
    steps = np.abs(np.diff(line.get_ydata()))
    assert np.nanmax(steps) < 180.0
    assert np.isnan(steps).any()
    axes = triple_run.plot.angles(bodies=[1])
    (phi,), (theta,) = (ax.lines for ax in axes[0, :2])
    assert np.nanmax(np.abs(np.diff(phi.get_ydata()))) < 1.0
    assert np.isnan(phi.get_ydata()).sum() == 2
    assert np.nanmax(theta.get_ydata()) > 80.0


def test_plotted_spins_are_those_of_the_run_in_both_frames(kw4_run):
    axes = kw4_run.plot.spins()
    assert len(axes) == 2
    for body, ax in enumerate(axes):
        assert len(ax.lines) == 3
        for component, line in enumerate(ax.lines):
            assert np.array_equal(line.get_xdata(), kw4_run.time.value)
            assert np.array_equal(line.get_ydata(), kw4_run.spin.value[:, body, component])
        assert ax.get_ylabel() == "spin [rad h⁻¹]"
    rotated_lines = kw4_run.plot.spins(frame="inertial")[0].lines
    expected = kw4_run[7].rotation_matrix[0] @ kw4_run.spin.value[7, 0]
    assert np.allclose([line.get_ydata()[7] for line in rotated_lines], expected, rtol=0, atol=1e-15)


def test_plots_show_the_requested_bodies(triple_run):
    _, ax = plt.subplots()
    triple_run.plot.spins(axes=ax, bodies=[1])
    assert ax.get_title(loc="left") == "body 1, body frame"
    assert np.array_equal(ax.lines[1].get_ydata(), triple_run.spin[:, 1, 1])
    assert triple_run.plot.angles(bodies=[2, 0]).shape == (2, 3)
    refused("one of bodies is 3; expected 0 to 2", lambda: triple_run.plot.spins(bodies=[3]))
    refused("bodies is empty", lambda: triple_run.plot.angles(bodies=[]))


def test_angles_are_the_states_tait_bryan_angles(case1_run):
    axes = case1_run.plot.angles()
    expected = np.rad2deg([state.tait_bryan for state in case1_run])
    assert axes.shape == (2, 3)
    for body in range(2):
        for column in range(3):
            (line,) = axes[body, column].lines
            assert np.allclose(at_samples(line, case1_run.time), expected[:, body, column], rtol=0, atol=1e-12)


def test_plotted_librations_are_the_observables(kw4_run):
    ax = kw4_run.plot.libration()
    expected = np.rad2deg(observables.roll_pitch_yaw(kw4_run).to_value("rad")).T
    assert [line.get_label() for line in ax.lines] == ["roll", "pitch", "yaw"]
    for line, values in zip(ax.lines, expected, strict=True):
        assert np.array_equal(line.get_ydata(), values)
    ax = kw4_run.plot.libration(body="Alpha", about="Beta")
    pole = np.array([state.rotation_matrix[0] @ [0, 0, 1] for state in kw4_run])
    normal = np.cross(*(np.diff(x.value, axis=1)[:, 0] for x in (kw4_run.position, kw4_run.velocity)))
    cosine = np.sum(pole * normal, axis=1) / np.linalg.norm(normal, axis=1)
    assert np.allclose(ax.lines[0].get_ydata(), np.rad2deg(np.arccos(cosine)), rtol=1e-10)
    assert ax.get_title(loc="left") == "Alpha, z-axis from the orbit's normal"
    refused("expected two bodies", lambda: kw4_run.plot.libration(body=1, about=1))


@pytest.mark.parametrize(
    ("until", "label", "end"), [(900 * u.hour, "h", 900), (100 * u.day, "days", 100), (4 * u.yr, "years", 4)]
)
def test_the_axis_of_long_times_is_in_days_or_years(until, label, end):
    system = points(2.4e12 * u.kg, 1e11 * u.kg, G=None, units=("km", "hour", "kg"))
    r, v = fullbody.KeplerElements(2.5, 0.1, 0, 0, 0, 0).to_cartesian(system.mu().value)
    run = system.integrate(fullbody.State([0 * r, r], [0 * v, v]), until, output=until / 10)
    for ax in (run.plot.energy(), run.plot.spins()[-1]):
        assert ax.get_xlabel() == f"time [{label}]"
    assert ax.lines[0].get_xdata()[-1] == pytest.approx(end, rel=1e-12)


def test_a_distant_body_does_not_set_the_scale():
    shapes = {"A": (fullbody.Sphere(0.7), 2.4), "B": (fullbody.Sphere(0.2), 0.1), "star": (fullbody.PointMass(), 1e-9)}
    state = fullbody.State([[0, 0, 0], [2.5, 0, 0], [1e8, 0, 0]], [[0, 0, 0], [0, 1, 0], [0, 0.04, 0]])
    run = fullbody.System(body_list(**shapes), G=1.0).integrate(state, 5.0, output=0.1)
    ax = run.plot.orbit()
    ax.figure.draw_without_rendering()
    assert np.ptp(ax.get_xlim()) < 10.0
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["B", "star: outside, 1e+08"]
    ax = run.plot.scene()
    assert np.ptp(ax.get_xlim()) < 10.0
    # The pair's own barycentre is the picture's middle.
    assert abs(np.mean(ax.get_xlim())) < 3.0
    assert "star: outside, 1e+08" in [text.get_text() for text in ax.get_legend().get_texts()]
    # Seen from the star both of the pair are near each other, and both are drawn.
    assert len(run.plot.orbit(about="star", shapes=False).lines) == 2


def test_a_page_is_shown_once_by_a_notebook(kw4_run):
    from IPython.core.interactiveshell import InteractiveShell

    shown = InteractiveShell.instance().display_formatter.format(kw4_run.plot())[0]
    assert set(shown) == {"text/plain"}
    assert shown["text/plain"].startswith("<page of 9 plots: orbit, a, e, i, spin of Alpha")


def test_energy_shows_both_drifts(kw4_run):
    ax = kw4_run.plot.energy()
    drifts = (kw4_run.energy_drift, kw4_run.energy_drift_orbital, kw4_run.angular_momentum_drift)
    for line, drift in zip(ax.lines, drifts, strict=True):
        size = np.abs(drift)
        assert np.array_equal(drawn(line), size[size > 0])
        assert size[size > 0].size > 10
    assert [line.get_label() for line in ax.lines] == ["energy / total", "energy / orbital", "angular momentum"]
    # Where a sample's drift is exactly zero the line goes on to the next.
    assert not any(np.isnan(line.get_ydata()).any() for line in ax.lines)
    assert ax.get_yscale() == "log"
    assert ax.get_ylim()[1] > np.max(drifts)
    still = fullbody.System([fullbody.Body(fullbody.Sphere(1.0), mass=1.0)], G=1.0)
    run = still.integrate(fullbody.State([[0, 0, 0]], [[1, 0, 0]]), 1.0)
    labels = [line.get_label() for line in run.plot.energy().lines]
    assert labels == ["energy / total: no change", "energy / orbital: no change"]


@pytest.mark.parametrize("which", ["kw4_run", "triple_run"])
def test_the_summary_has_all_plots_and_is_legible(which, request, tmp_path):
    run = request.getfixturevalue(which)
    page = run.plot()
    figure = page.figure
    names = [f"{what} of {name}" for what in ("spin", "attitude") for name in run.system.names]
    assert list(page.axes) == ["orbit", "a", "e", "i", *names, "energy"]
    assert list(page.axes.values()) == figure.axes
    assert faults(figure) == ([], [])
    # It has been laid out.
    figure.set_layout_engine("none")
    figure.savefig(tmp_path / "page.png")
    assert (tmp_path / "page.png").stat().st_size > 20_000


def test_the_checks_of_legibility_find_faults_and_lines_differ_in_grey(kw4_run):
    ax = kw4_run.plot.energy()
    ax.text(0.0, 1.0, "covers the legend and leaves the page " * 4, transform=ax.transAxes, in_layout=False)
    assert all(faults(ax.figure))
    for ax in (*kw4_run.plot.spins(), kw4_run.plot.energy()):
        dashes = {str(line._unscaled_dash_pattern) for line in ax.lines}
        assert len(dashes) == len(ax.lines) == 3


@pytest.mark.parametrize("name", ["orbit", "elements", "spins", "angles", "libration", "energy", "scene"])
@pytest.mark.parametrize("which", ["kw4_run", "triple_run"])
def test_single_plots_are_legible_and_labelled(name, which, request):
    axes_of_plot = np.atleast_1d(getattr(request.getfixturevalue(which).plot, name)())
    figure = axes_of_plot.flat[0].figure
    assert faults(figure) == ([], [])
    for ax in axes_of_plot.flat:
        assert ax.get_ylabel()
    assert axes_of_plot.flat[-1].get_xlabel()
    assert name != "scene" or axes_of_plot.flat[0].get_zlabel().startswith("z [")


def test_given_axes_are_used_and_returned(kw4_run, triple_run):
    _, ax = plt.subplots()
    assert kw4_run.plot.orbit(ax=ax, color="red", linewidth=3) is ax
    assert ax.lines[0].get_color() == "red"
    assert ax.lines[0].get_linewidth() == 3
    assert kw4_run.plot.energy(ax=plt.figure().add_subplot(), lw=2).lines[0].get_linewidth() == 2
    _, axes = plt.subplots(3, 2)
    assert kw4_run.plot.elements(ax=axes) is axes
    assert axes[0, 0].lines
    _, axes = plt.subplots(3)
    assert triple_run.plot.spins(ax=axes) is axes
    _, axes = plt.subplots(2, 3)
    assert kw4_run.plot.angles(ax=axes) is axes
    ax = plt.figure().add_subplot(projection="3d")
    assert kw4_run.plot.scene(ax=ax, alpha=0.5) is ax
    figure = plt.figure(figsize=(12, 10), layout="constrained")
    assert kw4_run.plot(figure).figure is figure


@pytest.mark.parametrize("first", ["points", "ellipsoids"])
def test_two_runs_fit_on_the_same_axes(kw4_run, first):
    other = kw4_run.system.with_options(gravity="point").integrate(kw4_run[0], 50.0, output=0.5)
    runs = [other, kw4_run] if first == "points" else [kw4_run, other]
    axes = runs[0].plot.elements()
    runs[1].plot.elements(axes=axes)
    e = kw4_run.elements().e
    low, high = axes[0, 1].get_ylim()
    assert low <= e.min() < e.max() <= high < 2 * e.max()
    ax = runs[1].plot.energy(ax=runs[0].plot.energy())
    assert ax.get_ylim()[1] > max(run.energy_drift_orbital.max() for run in runs)


@pytest.mark.parametrize("name", ["orbit", "elements", "spins", "angles", "libration", "energy"])
def test_options_have_matplotlibs_short_names_too(kw4_run, name):
    for options in ({"lw": 3.5}, {"linewidth": 3.5}):
        for ax in np.ravel(getattr(kw4_run.plot, name)(ls=":", c="red", mec="blue", **options)):
            lines = [line for line in ax.lines if line.get_marker() == "None"]
            assert all(line.get_linewidth() == 3.5 and line.get_color() == "red" for line in lines)
            assert all(line.get_markeredgecolor() == "blue" for line in ax.lines if line.get_color() == "red")
    assert kw4_run.plot.scene(lw=2.5, ec="red").collections[0].get_linewidth()[0] == 2.5


def test_objects_other_than_axes_or_figures_are_refused(kw4_run):
    flat, deep = plt.figure().add_subplot(), plt.figure().add_subplot(projection="3d")
    plot = kw4_run.plot
    for call, argument in ((plot.orbit, 3), (plot.orbit, deep), (plot.energy, "axes"), (plot.spins, [flat, 3])):
        refused(r"(ax|one of axes) is .*; expected matplotlib axes in 2D", call, argument)
    for argument in (flat, 3):
        refused(r"ax is .*; expected matplotlib axes in 3D", plot.scene, 3.0 * u.hour, ax=argument)
        refused(r"figure is .*; expected a matplotlib Figure or SubFigure", plot, figure=argument)


def test_the_anomaly_of_a_hyperbola_is_one_line_with_few_ticks():
    # The mean anomaly is M = n t with n = sqrt(mu/|a|^3) = 1, sampled every 400 degrees.
    r, v = fullbody.KeplerElements(-1.0, 3.0, 0.1, 0.2, 0.3, np.deg2rad(-2000.0)).to_cartesian(1.0 + 1e-12)
    state = fullbody.State([0 * r, r], [0 * v, v])
    run = points(1.0, 1e-12).integrate(state, np.deg2rad(4000.0), output=np.deg2rad(400.0))
    ax = run.plot.elements()[2, 1]
    np.testing.assert_allclose(ax.lines[0].get_ydata(), np.arange(-2000, 2001, 400), atol=1e-6)
    assert 4 <= len(ax.get_yticks()) <= 7
    assert faults(ax.figure) == ([], [])


def test_names_are_drawn_without_formulas():
    names = [r"$\frac{", "a_b^$x"]
    bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0, name=name) for name in names]
    state = fullbody.State([[0, 0, 0], [9, 0, 0]], [[0, 0, 0], [0, 0.4, 0]])
    run = fullbody.System(bodies, G=1.0).integrate(state, 5.0, output=1.0)
    figure, scene = run.plot().figure, run.plot.scene()
    for drawn_figure in (figure, scene.figure):
        drawn_figure.draw_without_rendering()

    def shown(text):
        """The text as matplotlib preprocesses it before it draws, and whether it is a formula."""
        return text._preprocess_math(text.get_text())

    titles = {shown(ax._left_title) for ax in figure.axes}
    assert {(f"{name}, body frame", False) for name in names} | {(f"{names[0]}, in its orbit's frame", False)} <= titles
    assert shown(figure._suptitle)[0].startswith(f"{names[0]} and {names[1]}: ")
    assert [shown(text) for text in scene.get_legend().get_texts()[:2]] == [(name, False) for name in names]


def test_motion_along_a_line_is_drawn_without_elements():
    state = fullbody.State([[0, 0, 0], [10, 0, 0]], [[0, 0, 0], [0.1, 0, 0]])
    run = points(1.0, 0.1).integrate(state, 10.0, output=0.5)
    figure = run.plot().figure
    notes = [text.get_text().replace("\n", " ") for text in figure.findobj(Text) if "element" in text.get_text()]
    assert len(notes) == 1
    assert "no elements: " in notes[0]
    assert "motion along a straight line has no Kepler elements" in notes[0]
    assert len(figure.axes) == 4
    assert passes_through(figure.axes[0].lines[0], run.position[:, 1, :2] - run.position[:, 0, :2])
    assert faults(figure) == ([], [])
    refused("both body 0; expected two bodies", lambda: run.plot(body=0, about=0))


def test_bad_arguments_of_plots_are_refused(kw4_run):
    refused("plane is 'ab'; expected ", lambda: kw4_run.plot.orbit(plane="ab"))
    refused("about is 2; expected 0 to 1", lambda: kw4_run.plot.orbit(about=2))
    refused("axes has 3 axes; expected 2", lambda: kw4_run.plot.spins(axes=plt.subplots(3)[1]))
    refused("frame is 'sky'", lambda: kw4_run.plot.spins(frame="sky"))
    refused("time has the unit km", lambda: kw4_run.plot.scene(kw4_run.position[0, 0, 0]))


def test_a_single_sample_can_be_drawn(kw4_run):
    kw4_run[:1].plot().figure.draw_without_rendering()
