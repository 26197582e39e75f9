"""Starts of binaries: mean periods, forced eccentricities, and the attraction that the bodies start in."""

import warnings

import fullbody
import numpy as np
import pytest
from fullbody import Component, binary
from fullbody.errors import BodiesOverlap, InconsistentInput
from fullbody.setups import elements
from support.ready_systems import relative

INF = float("inf")


def test_mean_elements_keep_the_period():
    # The osculating start loses 3 J2 (R/a)^2 of the period.
    a, c, size = 1.0, 0.8, 5.0
    arguments = {"G": 1.0, "mass_ratio": 1e-6, "total_mass": 1.0, "mismatch_warning": INF}
    shapes = (Component(semi_axes=(a, a, c), rotation_period=3.0), Component(diameter=0.1))
    period = 2 * np.pi * size**1.5
    j2 = (a**2 - c**2) / 5 / a**2
    loss = 1.5 * j2 / size**2
    runs = {}
    for kind in ("osculating", "mean"):
        system, state = binary(*shapes, period=period, elements=kind, **arguments)
        run = system.integrate(state, 20 * period, output=period / 30)
        runs[kind] = fullbody.observables.mutual_period(run).mean
    np.testing.assert_allclose(runs["mean"], period, rtol=1e-9)
    np.testing.assert_allclose(runs["osculating"], period * (1 - 2 * loss), rtol=0.1 * loss)
    # The other way round: the semi-major axis is kept, and n^2 a^3 = G M (1 + 3/2 J2/a^2 - 15/8 J4/a^4), with
    # J4 = -3/35 (1 - c^2)^2 of a homogeneous spheroid of radius one.
    system, state = binary(*shapes, semi_major_axis=size, elements="mean", **arguments)
    np.testing.assert_allclose(relative(state)[0], [size, 0, 0], atol=1e-14)
    rate = np.linalg.norm(relative(state)[1]) / size
    fourth = 15 / 8 * 3 / 35 * (a**2 - c**2) ** 2 / size**4
    np.testing.assert_allclose(rate**2 * size**3, 1 + loss + fourth, rtol=1e-6)
    np.testing.assert_allclose(state.spin[1, 2], rate, rtol=1e-12)


def test_an_observed_period_is_a_mean():
    first = Component(semi_axes=(1.0, 0.95, 0.8), rotation_period=3.0, pole=(0.3, 1.4))
    shapes = first, Component(semi_axes=(0.2, 0.17, 0.15))
    arguments = {"G": 1.0, "mass_ratio": 0.01, "total_mass": 1.0, "eccentricity": 0.05, "mean_anomaly": 1.0}
    period, errors = 2 * np.pi * 4.0**1.5, []
    for options in ({}, {"semi_major_axis": 4.0}, {"elements": "osculating"}):
        system, state = binary(*shapes, period=period, **arguments, **options)
        run = system.integrate(state, 30 * period, output=period / 30)
        errors.append(abs(fullbody.observables.mutual_period(run).mean / period - 1))
        np.testing.assert_allclose(state.spin[1, 2], 2 * np.pi / period, rtol=1e-15)
    assert max(errors[:2]) < 3e-5
    assert 1e-3 < errors[2] < 0.1
    mean = binary(*shapes, period=period, **arguments)[1].position
    for gravity in ("surface", "multipole:4"):
        _, other = binary(*shapes, period=period, gravity=gravity, **arguments)
        np.testing.assert_allclose(other.position, mean, rtol=2e-4)
    system, state = binary(*shapes, semi_major_axis=4.0, **arguments)
    assert fullbody.KeplerElements.from_cartesian(*relative(state), system.mu()).a == pytest.approx(4.0, rel=1e-14)


def test_bodies_that_meet_have_keplers_orbit_in_the_attraction_they_start_in():
    # A long body that turns into its neighbour within the 16 revolutions: 1.5 and 0.5 reach over the distance.
    size = 1.85
    ball = Component(diameter=1.0, rotation_period=INF)
    long = Component(semi_axes=(1.5, 0.5, 0.5), rotation_period=30.0, rotation_angle=np.pi / 2)
    pair = {"G": 1.0, "total_mass": 1.0, "mass_ratio": 0.1, "synchronous": False}
    period = 2 * np.pi * size**1.5
    with pytest.warns(InconsistentInput, match="16 revolutions, .*, cannot be run: body 0 and body 1 meet in them"):
        system, state = binary(ball, long, period=period, **pair)
    with pytest.raises(BodiesOverlap):
        system.integrate(state, 60.0)
    force = system.interactions(state).force[1]
    r, v = relative(state)
    np.testing.assert_allclose(force @ force, (v @ v / np.linalg.norm(r) * 0.1 / 1.21) ** 2, rtol=1e-9)
    start = binary(ball, long, semi_major_axis=size, mismatch_warning=INF, **pair)
    stated = elements.drift_warning(*start, period, 16)
    message = "the mean period is the one given over 16 revolutions; 64, to see whether it lasts in, cannot"
    assert stated.startswith(message)
    assert stated.endswith("be run: body 0 and body 1 meet in them")


LONG = {"semi_axes": (1, 0.7, 0.6), "rotation_period": 16 * np.pi}
BALL = {"diameter": 0.2}


@pytest.mark.parametrize(
    ("first", "second", "arguments"),
    [
        ({"semi_axes": (1, 1, 0.8), "rotation_period": 3.0}, BALL, {"eccentricity": 0.5, "mean_anomaly": 2}),
        (LONG, {"semi_axes": (1, 0.8, 0.7)}, {"mass_ratio": 0.6}),
        (LONG | {"rotation_period": 3.0, "pole": (0, -np.pi / 2)}, BALL, {}),
        (LONG | {"pole": (0, -np.pi / 2)}, BALL, {}),
        ({"semi_axes": (1, 1, 0.8), "rotation_period": 5.0}, {"semi_axes": (1, 0.97, 0.8)}, {"libration": 0.3}),
    ],
    ids=["eccentric", "doubly locked", "retrograde", "retrograde at the orbit's rate", "slow libration"],
)
def test_the_mean_period_of_regular_motion_is_kept(first, second, arguments):
    period = 16 * np.pi
    arguments = {"G": 1.0, "mass_ratio": 0.02, "total_mass": 1.0, **arguments}
    system, state = binary(Component(**first), Component(**second), period=period, **arguments)
    run = system.integrate(state, 40.5 * period, output=period / 40)
    result = fullbody.observables.mutual_period(run)
    assert abs(result.mean / period - 1) < 2e-4
    if "eccentricity" not in arguments:
        assert abs(result.period.mean() / period - 1) < 5e-4


def test_irregular_motion_has_no_mean_period_and_says_so():
    shapes = Component(semi_axes=(1, 0.95, 0.8), rotation_period=3.0), Component(semi_axes=(0.3, 0.22, 0.2))
    arguments = {"G": 1.0, "mass_ratio": 0.01, "total_mass": 1.0, "eccentricity": 0.3, "mean_anomaly": 2.0}
    period = 16 * np.pi
    with pytest.warns(InconsistentInput, match="too irregular for a start to have it") as caught:
        system, state = binary(*shapes, period=period, **arguments)
    stated = float(str(caught[0].message).split(" given by ")[1].split()[0])
    run = system.integrate(state, 16 * period, output=period / 32)
    result = fullbody.observables.mutual_period(run).mean / period - 1
    assert 1e-6 < abs(result) < 0.05
    assert result == pytest.approx(stated, rel=0.5)


def sidereal(run, revolutions, period):
    """The mean period by a plain straight line through the angle in the mean plane."""
    count = revolutions * 32 + 1
    r, v = ((name[:count, 1] - name[:count, 0]) for name in (run.position, run.velocity))
    normal = np.cross(r, v).mean(axis=0)
    x = np.cross(normal, [0.0, 1.0, 0.0])
    y = np.cross(normal, x) / np.linalg.norm(normal)
    return 2 * np.pi / np.polyfit(run.time[:count], np.unwrap(np.arctan2(r @ y, r @ x)), 1)[0] / period - 1


OBLATE, MOON = {"semi_axes": (0.4, 0.38, 0.31), "rotation_period": 2.5}, {"semi_axes": (0.1, 0.08, 0.07)}
#: Arguments in km, hours and kg.
KILOMETRES = {"G": 8.6498928e-13, "total_mass": 5e11, "equal_density": True, "period": 12.0}


def test_a_mean_period_that_does_not_last_causes_a_warning():
    # A long secondary on an eccentric orbit: the start has the period over 16 revolutions, and not over 32. Irregular
    # motion over 64 revolutions is another one with every rounding.
    shapes, e = (Component(**OBLATE), Component(**MOON)), {"eccentricity": 0.1, "mean_anomaly": np.pi / 2}
    with pytest.warns(InconsistentInput, match="given over 16 revolutions and differs by .* no mean") as caught:
        system, state = binary(*shapes, **KILOMETRES, **e)
    run = system.integrate(state, 32 * 12.0, output=12.0 / 32)
    assert abs(sidereal(run, 16, 12.0)) < 1e-4
    stated = float(str(caught[0].message).split(" of it over 32")[0].split()[-1])
    # Without a window more is left of what recurs.
    assert sidereal(run, 32, 12.0) == pytest.approx(stated, rel=0.5)
    assert abs(sidereal(run, 32, 12.0)) > 1e-4


@pytest.mark.parametrize("tilt", [np.pi / 6, np.pi / 2, 2.5])
def test_the_mean_period_lasts_where_the_plane_of_the_orbit_precesses(tilt):
    system, state = binary(Component(**OBLATE, tilt=tilt), Component(**MOON), **KILOMETRES)
    run = system.integrate(state, 64 * 12.0, output=12.0 / 32)
    r, v = (name[:, 1] - name[:, 0] for name in (run.position, run.velocity))
    rate = np.linalg.norm(np.cross(r, v), axis=1) / np.sum(r**2, axis=1)
    angle = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(run.time))])
    normal = np.cross(r, v)
    rotated = np.degrees(np.arccos(normal[0] @ normal[-1] / np.linalg.norm(normal[0]) / np.linalg.norm(normal[-1])))
    assert rotated > 5 or tilt == np.pi / 2
    for revolutions in (16, 32, 64):
        time, swept = run.time[: revolutions * 32 + 1], angle[: revolutions * 32 + 1]
        slope = np.polyfit(time, swept, 1, w=np.sin(np.pi * time / time[-1]) ** 3)[0]
        assert abs(2 * np.pi / slope / 12.0 - 1) < 2e-6


def warned(e, anomaly=0.0, size=5.0, **options):
    """A light ball about a spheroid, and the warning of its eccentricity."""
    primary = Component(semi_axes=(1.0, 1.0, 0.9), rotation_period=INF, mass=1.0)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        arguments = {"semi_major_axis": size, "eccentricity": e, "mean_anomaly": anomaly, "elements": "osculating"}
        made = binary(primary, Component(diameter=1e-3, mass=1e-9), G=1.0, **{**arguments, **options})
    return made, [str(warning.message) for warning in caught]


def test_an_osculating_eccentricity_below_the_forced_one_is_warned_of():
    # J2 R^2 = (a^2 - c^2)/5: a circle has the osculating eccentricity 3/2 J2 (R/r)^2, and a start with e at periapsis
    # varies in distance as an ellipse of the difference.
    size = 5.0
    forced = 1.5 * (1 - 0.9**2) / 5 / size**2
    for e, anomaly, free in (
        (0.0, 0.0, forced),
        (forced / 2, 0.0, forced / 2),
        (forced / 2, np.pi, 1.5 * forced),
        (forced / 2, np.pi / 2, np.hypot(forced, forced / 2)),
    ):
        (system, state), stated = warned(e, anomaly)
        assert len(stated) == 1
        assert "elements='mean'" in stated[0]
        words = ("that of ", "ellipse of eccentricity ")
        numbers = [float(stated[0].split(previous)[1].split()[0].strip(";")) for previous in words]
        # What is left is of the second order: J4, 1 % of the first.
        np.testing.assert_allclose(numbers, [forced, free], rtol=0.02)
        run = system.integrate(state, 40 * 2 * np.pi * size**1.5, output=2.0)
        np.testing.assert_allclose(fullbody.observables.orbit_shape(run).e, free, rtol=0.02)
    quiet = {"elements": "mean"}, {"mismatch_warning": INF}, {"size": 20.0}, {"gravity": "point"}
    for e, options in ((0.1, {}), (forced, {}), *((0.0, options) for options in quiet)):
        assert warned(e, **options)[1] == []


@pytest.mark.parametrize("seed", range(8))
def test_the_mean_of_ordinary_binaries_lasts(seed):
    random = np.random.default_rng(seed)
    ratios, period, tilt = 1 + random.uniform(0.0, [0.12, 0.25]), random.uniform(2.0, 6.0), random.uniform(0.0, 0.1)
    primary = Component(diameter=2.0, axis_ratios=ratios, rotation_period=period, tilt=tilt)
    secondary = Component(diameter=random.uniform(0.3, 1.0), axis_ratios=1 + random.uniform(0.0, 0.4, 2))
    period = 2 * np.pi * random.uniform(2.5, 6.0) ** 1.5
    orbit = {"eccentricity": random.uniform(0.0, 0.03), "mean_anomaly": random.uniform(0.0, 6.0)}
    system, state = binary(primary, secondary, G=1.0, total_mass=1.0, equal_density=True, period=period, **orbit)
    run = system.integrate(state, 64 * period, output=period / 32)
    assert abs(sidereal(run, 64, period)) < 1e-4


def test_the_attraction_is_the_mean_over_a_rotation():
    shapes = Component(semi_axes=(1.0, 0.8, 0.6), rotation_period=0.5), Component(diameter=0.02, rotation_period=INF)
    arguments = {"G": 1.0, "mass_ratio": 1e-9, "total_mass": 1.0, "elements": "mean", "semi_major_axis": 3.0}
    system, state = binary(*shapes, **arguments, synchronous=False)
    v = relative(state)[1]
    series = system.with_options(gravity="multipole:12")
    pulls = []
    for angle in np.linspace(0.0, np.pi, 48, endpoint=False):
        rotated = [[np.cos(angle / 2), 0, 0, np.sin(angle / 2)], state.attitude[1]]
        pulls.append(-series.interactions(state.replace(attitude=rotated)).force[1, 0] / system.masses[1])
    np.testing.assert_allclose(v @ v / 3.0, np.mean(pulls), rtol=1e-6)
    assert np.ptp(pulls) > 0.01 * np.mean(pulls)
    # A body so long that it would reach the other in a turn is taken as it stands.
    long = Component(semi_axes=(2.0, 0.5, 0.5), rotation_period=1000.0, rotation_angle=np.pi / 2)
    arguments = {"G": 1.0, "mass_ratio": 1e-3, "total_mass": 1.0, "elements": "mean", "semi_major_axis": 1.8}
    system, state = binary(long, Component(diameter=0.2), **arguments)
    v = relative(state)[1]
    pull = -system.interactions(state).force[1, 0] / system.masses[1]
    np.testing.assert_allclose(v @ v / 1.8, pull * 1.001, rtol=1e-9)
