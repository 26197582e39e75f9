"""Pictures of sweeps and of tracks on the sky show the numbers, and mark what failed."""

import astropy.units as u
import fullbody
import matplotlib.pyplot as plt
import numpy as np
import pytest
from fullbody import observing, plots
from support import refused
from support.fits import VIEW, kw4, pair

GRID = {"speed": [0.0, 0.1, 0.2], "factor": [1.0, 2.0]}


def kicked(speed, factor):
    """Case 1 with a kick; one pair of parameters is refused."""
    system, state = fullbody.systems.case1()
    if speed == 0.2 and factor == 2.0:
        raise ValueError("refused")
    return system, state.kick("B", [factor * speed, 0.0, 0.0])


def start(run):
    """The speed at the start, which is that of the kick, and in words."""
    speed = float(run.velocity[0, 1, 0] - fullbody.systems.case1()[1].velocity[1, 0])
    return {"speed_at_start": speed, "kind": "fast" if speed > 0.15 else "slow"}


def swept(parameters, **options):
    return fullbody.sweep(kicked, parameters, 0.5, output=0.5, measure=start, **options)


@pytest.fixture(scope="module")
def found():
    return swept(GRID)


def test_a_heat_map_has_the_values_and_marks_failed_members(found):
    ax = plots.sweep(found, "speed_at_start")
    (mesh,) = ax.collections
    values = np.asarray(mesh.get_array()).reshape(2, 3)
    expected = np.outer(GRID["factor"], GRID["speed"])
    assert values[:, :2] == pytest.approx(expected[:, :2], abs=1e-14)
    assert np.ma.getmaskarray(mesh.get_array()).reshape(2, 3)[1, 2]
    (mark,) = ax.lines
    assert (mark.get_xdata().tolist(), mark.get_ydata().tolist()) == ([0.2], [2.0])
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["failed: ValueError"]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("speed", "factor")
    assert [other.get_ylabel() for other in ax.figure.axes[1:]] == ["speed at start"]


def test_a_curve_has_the_values_and_marks_failed_members_at_its_foot(found):
    caller_axes = plt.subplots()[1]
    ax = plots.sweep(found.isel(factor=1), "speed_at_start", caller_axes, color="red")
    assert ax is caller_axes
    curve, mark = ax.lines
    assert curve.get_color() == "red"
    assert curve.get_xdata().tolist() == [0.0, 0.1]
    assert curve.get_ydata() == pytest.approx([0.0, 0.2], abs=1e-14)
    assert mark.get_xdata().tolist() == [0.2]
    assert mark.get_transform() == ax.get_xaxis_transform()


def test_texts_are_drawn_as_named_colours(found):
    ax = plots.sweep(found, "kind")
    bar = ax.figure.axes[1]
    assert [text.get_text() for text in bar.get_yticklabels()] == ["fast", "slow"]
    codes = np.ma.filled(ax.collections[0].get_array(), np.nan).reshape(2, 3)
    np.testing.assert_array_equal(codes, [[1.0, 1.0, 0.0], [1.0, 0.0, np.nan]])


def test_paired_parameters_are_drawn_as_dots():
    rows = fullbody.ensembles.paired(speed=[0.2, 0.0, 0.1], factor=[1.0, 2.0, 2.0])
    ax = plots.sweep(swept(rows), "speed_at_start", x="speed", y="factor")
    (dots,) = ax.collections
    assert dots.get_offsets().tolist() == [[0.2, 1.0], [0.0, 2.0], [0.1, 2.0]]
    assert np.asarray(dots.get_array()) == pytest.approx([0.2, 0.0, 0.2], abs=1e-14)
    line = plots.sweep(swept(rows), "speed_at_start", x="speed").lines[0]
    assert line.get_linestyle() == "None"


def test_sweeps_that_cannot_be_drawn_are_refused(found):
    refused("measure is 'error'; expected 'speed_at_start' or 'kind'", lambda: plots.sweep(found, "error"))
    refused("x is 'mass'; expected 'factor' or 'speed'", lambda: plots.sweep(found, "kind", x="mass"))
    single = found.isel(speed=0, factor=0)
    refused("the sweep has the dimensions none; expected one or two", lambda: plots.sweep(single, "kind"))
    long = found.expand_dims("third").assign(error=found.error.expand_dims("third"))
    refused(r"dimensions third, speed, factor; expected one or two, such as a part", lambda: plots.sweep(long, "kind"))


def observed(run, times, **options):
    """Astrometry with errors of 1e-4 that lies on the track."""
    options_of_data = {"body": 1, "about": 0, "geometry": VIEW, "frame": "equatorial", **options}
    zero = np.zeros(len(times))
    exact = observing.Astrometry(times, zero, zero, 1e-4, **options_of_data).predict(run)
    return observing.Astrometry(times, *exact.T, 1e-4, **options_of_data)


def framed():
    system, state = pair()
    return fullbody.System([*system], G=1.0, gravity="point", frame="equatorial"), state


def test_a_track_passes_through_exact_observations_with_east_to_the_left():
    system, state = framed()
    run = system.integrate(state, 40.0, dense=True)
    data = observed(run, np.linspace(1.0, 15.0, 6))
    ax = plots.sky_track(run, data)
    track = np.transpose(ax.lines[0].get_data())
    apart = np.linalg.norm(track[None] - np.stack([data.east, data.north], axis=1)[:, None], axis=2).min(axis=1)
    # Points of the track are a two-hundredth of a turn apart.
    assert (apart < 0.02 * np.ptp(data.east)).all()
    assert ax.xaxis_inverted()
    assert not ax.yaxis_inverted()
    assert ax.get_xlabel() == "offset to the east [rad]"


def test_one_revolution_of_many_is_drawn():
    system, state = framed()
    run = system.integrate(state, 99.0, dense=True)
    ax = plots.sky_track(run, observed(run, np.linspace(1.0, 95.0, 30)))
    east, north = ax.lines[0].get_data()
    assert ax.lines[0].get_label() == "one turn of the track"
    # It begins and ends at one place, to the change of the osculating orbit within a turn.
    assert np.hypot(east[-1] - east[0], north[-1] - north[0]) < 0.05 * np.ptp(east)
    angle = np.unwrap(np.arctan2(north, east))
    assert abs(angle[-1] - angle[0]) == pytest.approx(2 * np.pi, rel=0.05)


def test_units_of_observations_are_those_of_the_axes():
    system, state = kw4()
    run = system.integrate(state, 20.0, dense=True)
    view = observing.Geometry([-1.0, 30.0] * u.h, to_observer=[0.05, 0.0, 0.02] * u.au, frame="ecliptic")
    zero = np.zeros(3) * u.mas
    data = observing.Astrometry([1.0, 3.0, 5.0] * u.h, zero, zero, 1.0 * u.mas, body=1, about=0, geometry=view)
    ax = plots.sky_track(run, data)
    assert ax.get_ylabel() == "offset to the north [mas]"
    refused("data is 3; expected an observing.Astrometry", lambda: plots.sky_track(run, 3))


def test_plots_of_a_fit_show_its_astrometry():
    system, state = framed()
    data = observed(system.integrate(state, 30.0, dense=True), np.linspace(1.0, 25.0, 6))

    def setup(a):
        return framed()[0], pair(a=a)[1]

    fit = fullbody.fit(setup, {"a": 2.55}, data)
    assert fit.plot.sky().get_legend().get_texts()[0].get_text() == "track"
    names = [text.get_text() for text in fit.plot.residuals()[0].get_legend().get_texts()]
    assert names == ["east", "north"]
    assert repr(fit.plot) == "<plots of a fit: residuals, sky, corner>"
    refused("no astrometry to draw for data=1; expected the index 0", lambda: fit.plot.sky(data=1))
