"""Binaries from published numbers: Kepler's law and directions worked out by hand."""

import warnings

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import Component, binary
from fullbody.errors import BodiesOverlap, InconsistentInput, InvalidInput
from fullbody.setups import mean_period
from support import refused

INF = float("inf")
NAN = float("nan")
BIG = {"semi_axes": (1.0, 0.9, 0.8), "rotation_period": INF}
SMALL = {"semi_axes": (0.3, 0.2, 0.15)}
FIRST, SECOND = Component(**BIG, mass=3.0), Component(**SMALL, mass=1.0)


def relative(state):
    return state.position[1] - state.position[0], state.velocity[1] - state.velocity[0]


def test_sizes_have_their_closed_forms():
    expected = fullbody.Ellipsoid(1.0, 0.5, 0.25)
    assert Component(semi_axes=(1.0, 0.5, 0.25)).shape == expected
    assert Component(diameters=(2.0, 1.0, 0.5)).shape == expected
    # The sphere of equal volume has the radius (1 * 0.5 * 0.25)^(1/3) = 0.5.
    shape = Component(diameter=1.0, axis_ratios=(2.0, 2.0)).shape
    np.testing.assert_allclose([shape.a, shape.b, shape.c], [1.0, 0.5, 0.25], rtol=1e-15)
    assert Component(diameter=2 * u.km).shape == fullbody.Ellipsoid(1 * u.km, 1 * u.km, 1 * u.km)
    refused("expected one of them", lambda: Component(diameter=1.0, diameters=(1, 1, 1)))
    refused("beside a diameter", lambda: Component(diameters=(1, 1, 1), axis_ratios=(1.2, 1.0)))
    refused("both a mass and a density", lambda: Component(diameter=1.0, mass=1.0, density=1.0))


VOLUMES = 4 / 3 * np.pi * np.array([0.72, 0.009])


@pytest.mark.parametrize(
    ("first", "second", "pair", "expected"),
    [
        ({"mass": 3.0}, {"mass": 1.0}, {}, [3, 1]),
        ({"density": 2.0}, {"density": 1.0}, {}, VOLUMES * [2, 1]),
        ({"mass": 3.0}, {"density": 1.0}, {}, [3, VOLUMES[1]]),
        ({}, {}, {"total_mass": 4.0, "mass_ratio": 1 / 3}, [3, 1]),
        ({}, {}, {"total_mass": 4.0, "equal_density": True}, 4 * VOLUMES / sum(VOLUMES)),
        ({"mass": 3.0}, {}, {"total_mass": 4.0}, [3, 1]),
        ({}, {"mass": 1.0}, {"total_mass": 4.0}, [3, 1]),
        ({"mass": 3.0}, {}, {"mass_ratio": 1 / 3}, [3, 1]),
        ({}, {"mass": 1.0}, {"mass_ratio": 1 / 3}, [3, 1]),
        # By Kepler's law a = 4 and P = 8 pi make G M = 4 pi^2 64 / (64 pi^2) = 4.
        ({}, {}, {"semi_major_axis": 4.0, "period": 8 * np.pi, "mass_ratio": 1 / 3}, [3, 1]),
    ],
)
def test_masses_have_their_closed_forms(first, second, pair, expected):
    pair = {"semi_major_axis": 4.0, "eccentricity": 0.1, "elements": "osculating", **pair}
    system, _ = binary(Component(**BIG, **first), Component(**SMALL, **second), G=1.0, **pair)
    np.testing.assert_allclose(system.masses, expected, rtol=1e-14)


def test_period_and_semi_major_axis_obey_keplers_law():
    for arguments in ({"period": 8 * np.pi}, {"semi_major_axis": 4.0}, {"period": 8 * np.pi, "semi_major_axis": 4.0}):
        system, state = binary(FIRST, SECOND, G=1.0, eccentricity=0.2, elements="osculating", **arguments)
        np.testing.assert_allclose(relative(state)[0], [3.2, 0, 0], atol=1e-14)
        np.testing.assert_allclose(state.spin[1, 2], 0.25, rtol=1e-14)
        np.testing.assert_allclose(system.momentum(state), 0.0, atol=1e-14)


def test_contradictions_are_reported():
    arguments = {"period": 8 * np.pi, "semi_major_axis": 4.04, "eccentricity": 0.1}
    with pytest.warns(InconsistentInput, match=r"semi-major axis is 4 by .* and 4.04 by .* 0.99 %"):
        _, state = binary(FIRST, SECOND, G=1.0, **arguments, elements="osculating")
    np.testing.assert_allclose(relative(state)[0][0], 4.0 * 0.9, rtol=1e-14)
    refused("a difference of 20 %", lambda: binary(FIRST, SECOND, G=1.0, period=8 * np.pi, semi_major_axis=5.0))
    with pytest.raises(InvalidInput, match="total mass is 4 by the components and 5 by total_mass"):
        binary(FIRST, SECOND, G=1.0, period=1.0, total_mass=5.0)
    refused("mass ratio", lambda: binary(FIRST, SECOND, G=1.0, period=1.0, mass_ratio=0.5))
    binary(FIRST, SECOND, G=1.0, period=8 * np.pi, semi_major_axis=4.04, mismatch_warning=0.02)


@pytest.mark.parametrize("name", ["mismatch_warning", "mismatch_error"])
@pytest.mark.parametrize("value", [NAN, -INF, -0.1, "a", None, (0.1, 0.2), 10**400, 0.1 * u.km])
def test_tolerances_that_are_no_numbers_are_refused(name, value):
    expected = f"^{name} (is .*; expected a number, zero or above|has the unit km; expected pure numbers)$"
    for more in ({}, {"period": 8 * np.pi}):
        refused(expected, binary, FIRST, SECOND, G=1.0, semi_major_axis=5.0, **more, **{name: value})


def test_tolerances_of_zero_and_infinity_refuse_all_and_nothing():
    with pytest.raises(InvalidInput, match=r"0\.0999 %; expected agreement to mismatch_error=0$"):
        binary(FIRST, SECOND, G=1.0, period=8 * np.pi, semi_major_axis=4.004, mismatch_error=0)
    with pytest.warns(InconsistentInput, match="a difference of 20 %"):
        binary(FIRST, SECOND, G=1.0, period=8 * np.pi, semi_major_axis=5.0, mismatch_error=INF)


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        ({"period": 1.0}, "the masses are not given"),
        ({"period": 1.0, "total_mass": 1.0}, "shared is not given"),
        ({"total_mass": 1.0, "mass_ratio": 0.1}, "neither period nor"),
        ({"total_mass": -1.0, "mass_ratio": 0.1, "period": 1.0}, "total_mass is -1.0"),
        ({"total_mass": 1.0, "mass_ratio": 0.0, "period": 1.0}, "mass_ratio is 0.0"),
        ({"total_mass": 1.0, "mass_ratio": 0.1, "equal_density": True, "period": 1.0}, "expected one of the two"),
        ({"total_mass": 1.0, "mass_ratio": 0.1, "period": 1.0, "at_rest": "sun"}, "at_rest is 'sun'"),
        ({"total_mass": 1.0 * u.kg, "mass_ratio": 0.1, "period": 1.0}, "no units"),
    ],
)
def test_what_is_missing_or_wrong_is_named(arguments, what):
    refused(what, lambda: binary(Component(**BIG), Component(**SMALL), G=1.0, **arguments))
    with pytest.raises(InvalidInput, match="G is not given"):
        binary(Component(**BIG), Component(**SMALL), period=1.0, total_mass=1.0, mass_ratio=0.1)


def test_poles_and_long_axes_point_where_stated():
    lon, lat = np.radians([310.0, -84.0])
    first = Component(**BIG | {"rotation_period": 2.0, "mass": 3.0, "pole": (1.0, 0.5), "rotation_angle": 0.3})
    orbit = {"semi_major_axis": 4.0, "eccentricity": 0.1, "mean_anomaly": 2.0, "argument_of_periapsis": 0.4}
    system, state = binary(first, SECOND, G=1.0, **orbit, pole=(lon, lat), libration=np.radians(10))
    r, v = relative(state)
    orbit_pole = np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    direction = [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)]
    np.testing.assert_allclose(orbit_pole, direction, atol=1e-14)
    elements = fullbody.KeplerElements.from_cartesian(r, v, system.mu())
    np.testing.assert_allclose([elements.omega, elements.M], [0.4, 2.0], rtol=1e-12)
    x, _, z = state.rotation_matrix[1].T
    np.testing.assert_allclose(z, direction, atol=1e-14)
    towards = -r / np.linalg.norm(r)
    np.testing.assert_allclose(x @ towards, np.cos(np.radians(10)), rtol=1e-13)
    np.testing.assert_allclose(np.cross(towards, x) @ z, np.sin(np.radians(10)), rtol=1e-12)
    np.testing.assert_allclose(state.attitude[0], fullbody.frames.attitude(1.0, 0.5, 0.3), atol=1e-15)
    np.testing.assert_allclose(state.spin[0], [0, 0, np.pi], rtol=1e-15)


def test_a_secondary_that_is_not_synchronous_rotates_as_stated():
    second = Component(**SMALL, mass=1.0, rotation_period=-4.0, rotation_angle=90 * u.deg)
    options = {"synchronous": False, "at_rest": "primary", "mismatch_warning": INF}
    _, state = binary(FIRST, second, G=1.0, semi_major_axis=4.0, **options)
    # Kepler's circle: G (m1 + m2) = 4.
    np.testing.assert_allclose(state.position, [[0, 0, 0], [4, 0, 0]], rtol=1e-15, atol=1e-15)
    np.testing.assert_allclose(state.velocity, [[0, 0, 0], [0, 1, 0]], rtol=1e-15, atol=1e-15)
    np.testing.assert_allclose(state.rotation_matrix[1][:, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(state.spin[1, 2], -np.pi / 2)
    refused("synchronous", binary, FIRST, Component(**SMALL, mass=1.0, rotation_period=1.0), G=1.0, period=1.0)


def test_binaries_have_units():
    first = Component(diameters=(1.53, 1.50, 1.35) * u.km, rotation_period=2.765 * u.hour)
    second = Component(diameters=(0.57, 0.46, 0.35) * u.km)
    orbit = {"total_mass": 2.49e12 * u.kg, "mass_ratio": 0.057, "period": 17.42 * u.hour, "elements": "osculating"}
    sky = {"pole": (105.4 * u.deg, -66 * u.deg), "frame": "ecliptic", "epoch": "2001-05-27 UTC"}
    system, state = binary(first, second, **orbit, **sky, mismatch_warning=INF, units=("m", "s", "kg"))
    # Ostro et al. (2006) publish a = 2.548 km with these.
    np.testing.assert_allclose(np.linalg.norm(relative(state)[0].to_value(u.km)), 2.548, rtol=1e-3)
    assert system.frame == "ecliptic"
    assert state.spin.unit == u.rad / u.s
    assert system.bodies[0].shape.a == 0.765 * u.km
    assert system.integrate(state, 1 * u.hour).dates[0].scale == "utc"


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
    refused("elements is 'true'", lambda: binary(*shapes, period=period, elements="true", **arguments))


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
    stated = mean_period.warning_of_later(*start, period, 16)
    told = "the mean period is the one given over 16 revolutions; 64, to see whether it lasts in, cannot"
    assert stated.startswith(told)
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


def test_a_mean_that_does_not_last_is_told():
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


def test_bodies_that_overlap_at_the_start_are_refused():
    first, second = Component(diameter=2.0, mass=3.0, rotation_period=INF), Component(diameter=1.0, mass=1.0, name="B")
    binary(first, second, G=1.0, semi_major_axis=1.5001)
    for kind in ("osculating", "mean"):
        with pytest.raises(BodiesOverlap, match=r"body 0 and B overlap at the start, their centres 1\.4999 apart"):
            binary(first, second, G=1.0, semi_major_axis=1.4999, elements=kind)
    # At periapsis 1.35, at apoapsis 1.65.
    with pytest.raises(BodiesOverlap, match=r"1\.35 apart"):
        binary(first, second, G=1.0, semi_major_axis=1.5, eccentricity=0.1, gravity="point")
    binary(first, second, G=1.0, semi_major_axis=1.5, eccentricity=0.1, mean_anomaly=180 * u.deg)


def test_densities_that_no_asteroid_has_are_warned_of():
    # A sphere of 1 km across has 0.52360 km^3, in which 5.2360e11 kg make 1000 kg/m^3.
    ball = {"diameter": 1 * u.km, "rotation_period": INF}

    def weigh(mass, **options):
        masses = {"mass": mass, "name": "Ball"}, {"mass": 5.2360e11 * u.kg}
        first, second = (Component(**ball, **m) for m in masses)
        arguments = {"semi_major_axis": 3 * u.km, "synchronous": False, "units": ("km", "hour", "kg")}
        return binary(first, second, **arguments, **options)

    weigh(5.2360e11 * u.kg)
    for mass, density in ((5.2360e9 * u.kg, "10"), (2.0944e10 * u.t, "4e.04")):
        with pytest.warns(InconsistentInput, match=f"^Ball has a density of {density} kg/m3; expected 100"):
            weigh(mass)
    # A density of two is two kilograms a cubic kilometre in the units km, hour and kg.
    first, second = (Component(**ball, density=2.0, name=name) for name in ("Alpha", "Beta"))
    with pytest.warns(InconsistentInput) as caught:
        binary(first, second, semi_major_axis=3 * u.km, units=("km", "hour", "kg"), synchronous=False)
    start = "{} has a density of 2e-09 kg/m3; "
    assert {str(w.message).split("expected")[0] for w in caught} == {start.format("Alpha"), start.format("Beta")}


def test_a_rotation_that_is_not_stated_is_visible():
    still, turning = Component(diameter=2.0, mass=3.0), Component(diameter=2.0, mass=3.0, rotation_period=4.0)
    small = Component(diameter=0.2, mass=0.1, name="Beta")
    arguments = {"G": 1.0, "semi_major_axis": 5.0}
    with pytest.warns(InconsistentInput, match="primary 'body 0' has no rotation_period and starts without"):
        _, state = binary(still, small, **arguments)
    np.testing.assert_array_equal(state.spin[0], 0.0)
    with pytest.warns(InconsistentInput, match="secondary 'Beta' has no rotation_period"):
        _, state = binary(turning, small, synchronous=False, **arguments)
    np.testing.assert_allclose(state.spin, [[0, 0, np.pi / 2], [0, 0, 0]])
    # Said outright, no warning; a synchronous secondary turns with the orbit of n^2 a^3 = G M.
    _, state = binary(Component(diameter=2.0, mass=3.0, rotation_period=INF), small, **arguments)
    np.testing.assert_allclose(state.spin, [[0, 0, 0], [0, 0, np.sqrt(3.1 / 125)]])


@pytest.mark.parametrize("pole", [5, (1, 2, 3), (310.0, -84.0), "north", (0.0, 2.0)])
def test_a_pole_is_two_angles(pole):
    what = r"expected \(longitude, latitude\) in radians, the latitude from -pi/2 to pi/2, or Quantities"
    with pytest.raises(InvalidInput, match=f"^pole is .*{what}"):
        binary(Component(**BIG, mass=3.0), Component(**SMALL, mass=1.0), G=1.0, semi_major_axis=5.0, pole=pole)
    refused(f"^pole of Alpha is .*{what}", lambda: Component(**BIG, mass=3.0, pole=pole, name="Alpha"))


def test_a_tilt_is_from_the_orbits_pole():
    # About the node: with the node at 90 degrees of longitude plus the pole's, along its horizontal axis.
    lon, lat = 0.7, 0.4
    shapes = Component(**BIG, mass=3.0), Component(**SMALL, mass=1.0, tilt="6 deg")
    _, state = binary(*shapes, G=1.0, semi_major_axis=5.0, pole=(lon, lat), elements="mean")
    z = state.rotation_matrix[1][:, 2]
    normal = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
    node = np.array([-np.sin(lon), np.cos(lon), 0.0])
    np.testing.assert_allclose(z, np.cos(np.pi / 30) * normal + np.sin(np.pi / 30) * np.cross(node, normal), atol=1e-14)
    refused("Alpha is given both a pole and a tilt", lambda: Component(**BIG, pole=(0.1, 0.2), tilt=0.1, name="Alpha"))


def test_poles_with_wrong_parts_name_the_part():
    for pole, what in (
        ((1 * u.kg, 0.0), "longitude of pole has the unit kg; expected a unit such as rad"),
        ((0.0, float("nan")), "latitude of pole is nan; expected a finite number"),
        (("x", 0.0), "longitude of pole is 'x'; expected a finite number"),
    ):
        refused(what, binary, FIRST, SECOND, G=1.0, semi_major_axis=5.0, pole=pole)


def test_texts_with_units_are_taken():
    def made(convert):
        sizes, spin = ([*map(convert, texts)] for texts in (("1.53 km", "1.5 km", "1350 m"), ("2.765 hour", "2 g/cm3")))
        first = Component(diameters=sizes, rotation_period=spin[0], density=spin[1])
        second = Component(diameter=convert("0.45 km"), mass=convert("1.35e11 kg"))
        pole, period, anomaly = (convert("105.4 deg"), convert("-66 deg")), convert("17.42 hour"), convert("90 deg")
        return binary(first, second, period=period, pole=pole, mean_anomaly=anomaly, units=("km", "hour", "kg"))

    texts, quantities = made(str), made(u.Quantity)
    np.testing.assert_allclose(texts[0].masses.value, quantities[0].masses.value, rtol=1e-15)
    np.testing.assert_allclose(texts[1].position.value, quantities[1].position.value, rtol=1e-15)


def test_numbers_with_units_are_refused_by_a_system_without():
    sizes = {"diameter": 2 * u.km}, {"diameter": "0.2 km"}, {"diameters": ["2 km", "2 km", "1 km"]}, {"diameter": 2.0}
    for size in sizes:
        first, second = Component(**size, mass=1.0, rotation_period=3.0), Component(diameter=0.1, mass=0.01)
        period = 20 * u.h if size["diameter" if "diameter" in size else "diameters"] == 2.0 else 20.0
        refused(r"have units and the system has none; expected units=\('km', ", binary, first, second, period=period)
    arguments = {"period": 20 * u.h}
    first = Component(diameter=2 * u.km, density=2 * u.g / u.cm**3, rotation_period=3 * u.h)
    second = Component(diameter=0.2 * u.km, density=2 * u.g / u.cm**3)
    usual, same = (binary(first, second, units=units, **arguments)[1] for units in (True, ("km", "hour", "kg")))
    assert usual == same
    refused("^G is not given", binary, FIRST, SECOND, period=20.0)


@pytest.mark.parametrize("e", [1.2, 1.0, -0.1, NAN])
@pytest.mark.parametrize("kind", ["mean", "osculating", None])
def test_orbits_that_do_not_close_are_refused(e, kind):
    told = f"^eccentricity is {e}; expected a number from 0 to below 1$"
    refused(told, binary, FIRST, SECOND, G=1.0, semi_major_axis=5.0, eccentricity=e, elements=kind)


@pytest.mark.parametrize(
    ("options", "part", "what"),
    [
        ({"synchronous": False, "libration": 0.5}, {"rotation_period": 2.0}, r"libration is 0\.5 of a secondary"),
        ({}, {"rotation_angle": 1.0}, r"rotation_angle is 1\.0 of a secondary that is synchronous; expected lib"),
        ({"libration": 10}, {}, "libration is 10; expected radians, a turn at most"),
        ({"bodies": []}, {}, "'bodies' is not an option of binary"),
        ({"peroid": 3.0}, {}, r"'peroid' is not an option of binary; did you mean 'period'\?"),
        ({"period": 30.0, "gravty": "point"}, {}, r"'gravty' is not an option of binary; did you mean 'gravity'\?"),
    ],
)
def test_what_would_be_ignored_is_refused(options, part, what):
    refused(what, binary, FIRST, Component(**SMALL, mass=1.0, **part), G=1.0, **{"semi_major_axis": 5.0} | options)
