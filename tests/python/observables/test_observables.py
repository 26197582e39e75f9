"""Observables of runs against REBOUND's elements and the closed forms of celestial mechanics."""

import re
import sys

import astropy.units as u
import fullbody
import numpy as np
import pytest
import rebound
from fullbody import Component, analysis, binary, observables
from fullbody.errors import InvalidInput
from support import OF_REVOLUTIONS, inertia, moon, pair_of_points, points, ready, refused, with_samples

OF_SAMPLES = (observables.obliquity, observables.roll_pitch_yaw)
OF_SHAPE = (observables.orbit_shape, observables.eccentricity, observables.tumbles)


def test_elements_are_those_of_rebound():
    sim = rebound.Simulation()
    sim.add(m=1.0)
    sim.add(m=0.01, a=1.0, e=0.2, inc=0.3, Omega=1.0, omega=0.5, M=0.1)
    sim.add(m=0.005, a=4.0, e=0.1, inc=0.1)
    system, state = fullbody.from_rebound(sim)
    times = np.linspace(0.0, 30.0, 301)
    run = system.integrate(state, 30.0, output=times)
    result = observables.element_rates(run)
    orbits = []
    for time in times:
        sim.integrate(time)
        orbits.append(sim.particles[1].orbit(primary=sim.particles[0]))
    for ours, theirs in (("a", "a"), ("e", "e"), ("i", "inc")):
        expected = [getattr(orbit, theirs) for orbit in orbits]
        np.testing.assert_allclose(getattr(result.elements, ours), expected, rtol=1e-9)
    np.testing.assert_allclose(result.rates["a"][50], (orbits[51].a - orbits[49].a) / 0.2, rtol=1e-6)
    for name, error in (("Omega", 1e-4), ("omega", 1e-4), ("M", 1e-4), ("l", 1e-6)):
        angle = np.unwrap([getattr(orbit, name) for orbit in orbits])
        # Slopes by numpy's own fit; its weights are squared.
        slope = np.polyfit(times, angle, 1, w=np.sin(np.pi * times / 30.0))[0]
        np.testing.assert_allclose(result.mean_rates[name.replace("l", "L")], slope, rtol=error)
        if name != "l":
            difference = getattr(result.elements, name) - angle
            np.testing.assert_allclose(difference, 2 * np.pi * round(difference[0] / (2 * np.pi)), atol=1e-7)


def test_passages_at_samples_are_found():
    system, state = pair_of_points(0.0)
    run = system.integrate(state, 60 * 2 * np.pi, output=2 * np.pi / 40)
    result = observables.mutual_period(run)
    np.testing.assert_allclose(result.period, 2 * np.pi, rtol=1e-10)
    assert len(result.period) in (59, 60)
    assert abs(result.drift) < 1e-12


@pytest.mark.parametrize("until", [100.0, -100.0])
def test_a_kepler_orbit_has_one_period(until):
    system, state = pair_of_points(0.4)
    run = system.integrate(state, until, output=0.2)
    result = observables.mutual_period(run)
    assert len(result.period) == 15
    np.testing.assert_allclose(result.period, 2 * np.pi, rtol=2e-5)
    np.testing.assert_allclose(result.mean, 2 * np.pi, rtol=1e-4)
    assert abs(result.drift) < 1e-5


def test_a_drift_of_the_period_is_found():
    system, state = pair_of_points(0.0)
    run = system.integrate(state, 100.0, output=0.1)
    time = run.time
    # P = 2 pi (1 + k t): the longitude is the integral of 2 pi/P.
    k = 1e-3
    longitude, rate = np.log1p(k * time) / k, 1 / (1 + k * time)
    position, velocity = np.zeros_like(run.position), np.zeros_like(run.velocity)
    direction = np.stack([np.cos(longitude), np.sin(longitude), 0 * time], axis=1)
    across = np.stack([-np.sin(longitude), np.cos(longitude), 0 * time], axis=1)
    position[:, 1], velocity[:, 1] = direction, across * rate[:, None]
    made_up = with_samples(run, position=position, velocity=velocity)
    # From one passage to the next the time grows by the factor exp(2 pi k).
    growth = np.exp(2 * np.pi * k)
    result = observables.mutual_period(made_up)
    np.testing.assert_allclose(result.period[1:] / result.period[:-1], growth, rtol=1e-7)
    np.testing.assert_allclose(result.drift, (growth - 1) / growth, rtol=1e-5)
    # The mean is that of the window; numpy squares the weights.
    slope = np.polyfit(time, longitude, 1, w=np.sin(np.pi * time / 100.0) ** 3)[0]
    np.testing.assert_allclose(result.mean, 2 * np.pi / slope, rtol=1e-6)
    assert abs(result.mean - result.period.mean()) > 1e-4


@pytest.mark.parametrize("frame", ["ecliptic", "orbit"])
def test_a_planar_orbit_has_no_node(frame):
    system, state = ready("didymos", frame=frame, gravity="multipole:4")
    run = system.integrate(state, 70.0, output=0.5)
    result = observables.orbit_precession(run)
    assert result.nodal is None
    assert result.inclination.shape == (2,)
    assert 0.0 <= result.inclination[0] <= result.inclination[1] < 1e-13
    for body, about in ((0, 1), (1, 0)):
        with pytest.raises(InvalidInput, match=rf"pole of body {body} \(.*\) stays within .* rad of the axis"):
            observables.spin_precession(run, body=body, about=about)
    # About an axis of one's own they lie still.
    normal = np.cross(state.position[1] - state.position[0], state.velocity[1] - state.velocity[0])
    beside = np.linalg.cross(normal, [1.0, 0.3, 0.0])
    result = observables.orbit_precession(run, axis=beside)
    assert abs(result.nodal) < 1e-13
    np.testing.assert_allclose(result.inclination, np.pi / 2, rtol=1e-12)


def librating(e, offset, time, mass=1e-9):
    """A small moon of some mass about a sphere of mass one, n = 1; the run and the frequency of free libration."""
    axes = np.array([0.0010, 0.0009, 0.0008])
    system, state = moon(axes, mass, eccentricity=e, libration=offset)
    # The formula is that of the docstring.
    formula = re.search(r"``w = (n \* sqrt\(.*\))``", observables.libration.__doc__).group(1)
    moments = dict(zip("ABC", inertia(mass, axes), strict=True))
    frequency = eval(formula, {"sqrt": np.sqrt, "n": 1.0, "m": mass, "M": 1.0, **moments})
    return system.integrate(state, time, output=0.25), frequency


@pytest.mark.parametrize("mass", [1e-9, 1.0, 10.0])
def test_libration_has_the_linear_frequency_and_amplitude_whatever_the_moons_mass(mass):
    run, frequency = librating(0.0, 1e-3, 400.0, mass)
    assert mass < 1.0 or frequency < np.sqrt(3 * (100 - 81) / (100 + 81)) / np.sqrt(1 + 0.99 * mass)
    result = observables.libration(run, n=1)
    np.testing.assert_allclose(result.frequencies[0], frequency, rtol=1e-4)
    np.testing.assert_allclose(result.amplitudes[0], 1e-3, rtol=1e-3)
    np.testing.assert_allclose([result.amplitude, result.angle[0]], 1e-3, rtol=1e-2)
    angles = observables.roll_pitch_yaw(run)
    np.testing.assert_allclose(angles[:, 2], result.angle, atol=1e-12)
    np.testing.assert_allclose(angles[:, :2], 0.0, atol=1e-9)
    e = 1e-3
    run, frequency = librating(e, 0.0, 600.0, mass)
    result = observables.libration(run, n=2)
    forced = np.argmin(np.abs(result.frequencies - 1.0))
    np.testing.assert_allclose(result.frequencies[[forced, 1 - forced]], [1.0, frequency], rtol=1e-3)
    np.testing.assert_allclose(result.amplitudes[forced], 2 * e / (1 - frequency**2), rtol=0.01)


def test_a_circulating_body_does_not_librate_and_one_without_an_axis_is_refused():
    ball = Component(diameter=0.2, mass=1.0, rotation_period=np.inf)
    egg = Component(semi_axes=(0.02, 0.015, 0.01), mass=1e-3, rotation_period=2.0)
    system, state = binary(ball, egg, G=1.0, semi_major_axis=1.0, synchronous=False)
    run = system.integrate(state, 20.0, output=0.1)
    result = observables.libration(run)
    # It gains 2 pi (1/2 - 1/P) on the line to the primary.
    period = 2 * np.pi / np.sqrt(1.001)
    np.testing.assert_allclose(result.angle[-1] - result.angle[0], 2 * np.pi * 20 * (0.5 - 1 / period), rtol=0.1)
    refused("longest", lambda: observables.libration(run, body=0, about=1))
    both, start = pair_of_points(0.0)
    refused("point", observables.libration, both.integrate(start, 20.0, output=0.1))


def test_roll_pitch_and_yaw_are_those_of_the_start():
    r, v = np.array([3.0, 0.0, 0.0]), np.array([0.0, 0.5, 0.0])
    system = fullbody.System(
        [fullbody.Body(fullbody.Sphere(0.5), mass=1.0), fullbody.Body(fullbody.Ellipsoid(0.3, 0.2, 0.1), mass=0.1)],
        G=1.0,
    )
    angles = np.array([0.1, -0.2, 0.3])
    # The orbit's frame is the inertial one turned by pi about z; half a turn of the body counts for nothing.
    for alternative in (angles + np.array([0, 0, np.pi]), angles * [-1, -1, 1]):
        state = fullbody.State.from_tait_bryan([0 * r, r], [0 * v, v], [[0, 0, 0], alternative], [[0, 0, 1]] * 2)
        run = system.integrate(state, 0.01)
        np.testing.assert_allclose(observables.roll_pitch_yaw(run)[0], angles, atol=1e-12)


def test_poles_of_spin_and_orbit_precess_about_their_sum():
    a, c, tilt, spin, size = 1.0, 0.9, 0.3, 0.5, 8.0
    pole = (0.4, np.pi / 2 - tilt)
    top = Component(semi_axes=(a, a, c), mass=1.0, rotation_period=2 * np.pi / spin, pole=pole)
    ball = Component(diameter=1.0, mass=1.0, rotation_period=1e9)
    system, state = binary(top, ball, G=1.0, semi_major_axis=size, synchronous=False)
    n = np.sqrt(2 / size**3)
    run = system.integrate(state, 40 * 2 * np.pi / n, output=4.0)
    np.testing.assert_allclose(observables.obliquity(run, body=0, about=1)[0], tilt, rtol=1e-12)
    np.testing.assert_allclose(observables.obliquity(run, body=0, about=1), tilt, rtol=0.02)
    moment = 0.4 * a**2
    about_normal = -1.5 * n**2 * 0.5 * (a**2 - c**2) / (2 * a**2) / spin * np.cos(tilt)
    orbital = 0.5 * np.sqrt(2 * size)
    total = np.linalg.norm(system.angular_momentum(state))
    np.testing.assert_allclose(total, np.hypot(orbital + moment * spin * np.cos(tilt), moment * spin * np.sin(tilt)))
    np.testing.assert_allclose(observables.spin_precession(run), about_normal * total / orbital, rtol=0.02)
    nodal = observables.orbit_precession(run).nodal
    np.testing.assert_allclose(nodal, about_normal * total / orbital, rtol=0.02)


def sampled(times):
    """A run of one body at rest with samples at these times."""
    return points(1.0).integrate(fullbody.State(np.zeros((1, 3)), np.zeros((1, 3))), times[-1], output=times)


def test_frequencies_of_two_sinusoids_are_found():
    time = np.linspace(0.0, 200.0, 1501)
    expected = [0.73, 1.91, 2.2]
    signal = 0.5 + 2 * np.cos(0.73 * time + 1) + 0.3 * np.sin(1.91 * time) + 0.1 * np.cos(2.2 * time)
    result = analysis.frequencies(sampled(time), signal, n=3)
    np.testing.assert_allclose(result.frequency, expected, rtol=1e-4)
    np.testing.assert_allclose(result.amplitude, [2, 0.3, 0.1], rtol=1e-3)
    # Uneven times give the same frequencies.
    uneven = time + 0.03 * np.sin(time)
    signal = 2 * np.cos(0.73 * uneven) + 0.3 * np.sin(1.91 * uneven)
    np.testing.assert_allclose(analysis.frequencies(sampled(uneven), signal, n=2).frequency, expected[:2], rtol=1e-4)


def test_terms_too_close_to_tell_apart_are_one():
    time = np.linspace(0.0, 100.0, 1001)
    # One term whose frequency drifts by a fiftieth, less than the window resolves: no sum of large ones that cancel.
    result = analysis.frequencies(sampled(time), np.cos(time + 1e-4 * time**2), n=3)
    assert result.frequency[0] == pytest.approx(1.01, rel=1e-3)
    assert result.amplitude[0] == pytest.approx(1.0, rel=0.01)
    assert np.all(result.amplitude[1:] < 0.05)
    assert np.diff(np.sort(result.frequency)).min() > 2 * np.pi / 100.0
    # A signal of hardly two periods has no room for many.
    few = analysis.frequencies(sampled(time[:130]), np.cos(time[:130]), n=50)
    assert 1 <= len(few.frequency) < 50


def test_observables_have_units():
    system, state = ready("didymos", units=True)
    run = system.integrate(state, 200 * u.hour, output=0.25 * u.hour)
    period = observables.mutual_period(run)
    assert period.mean.unit == u.hour
    np.testing.assert_allclose(period.mean.to_value(u.hour), 11.921473, rtol=2e-4)
    assert observables.obliquity(run).unit == u.rad
    assert observables.orbit_precession(run).apsidal.unit.is_equivalent(u.deg / u.day)
    assert observables.element_rates(run).rates["a"].unit.is_equivalent(u.m / u.s)
    assert observables.element_rates(run).rates["e"].unit.is_equivalent(1 / u.s)
    swings = observables.libration(run)
    assert swings.amplitude.to_value(u.deg) < 1
    assert swings.frequencies.unit.is_equivalent(u.rad / u.s)


@pytest.mark.parametrize("function", [*OF_REVOLUTIONS, *OF_SAMPLES, *OF_SHAPE])
def test_values_that_are_no_run_or_body_are_refused(function):
    system, state = pair_of_points(0.1)
    run = system.integrate(state, 20.0, output=0.1)
    refused(r"is a State; expected a fullbody\.Run", lambda: function(state))
    for body in (2, -1, 1.0, None, True):
        refused(f"body of .* is {body!r}; expected 0 to 1, one of the 2 bodies", function, run, body=body)
    refused(r"about of .* is 7; expected 0 to 1, one of the 2 bodies", lambda: function(run, about=7))
    refused(r"body and about of .* are 1 and 1, both", lambda: function(run, body=1, about=1))


def test_observables_without_a_meaning_are_refused():
    system, state = pair_of_points(0.1)
    run = system.integrate(state, 40.0, output=0.1)
    for function, options in ((observables.obliquity, {}), (observables.spin_precession, {"body": 1, "about": 0})):
        refused("does not spin", function, run, **options)
    for axis in ([0, 0, 0], [0, 0], "z", [0, 0, np.nan]):
        refused("axis", observables.orbit_precession, run, axis=axis)
    for count in (0, -1, 1.5, None):
        refused(r"n is .*; expected a whole number", observables.libration, run, n=count)
    system, state = moon((0.0008, 0.0009, 0.0010))
    with pytest.raises(InvalidInput, match=r"longest axis of body 1 .* the orbit's normal"):
        observables.libration(system.integrate(state, 20.0, output=0.25))


def test_there_is_no_periapsis_among_similar_terms_of_the_distance():
    # The distance also swings with a secondary that librates, at w = n sqrt(3 (B - A)/C), and with a primary that
    # turns beneath it, at 2 (spin - n); what is left of the apsidal rate is the terms of J2 and C22 at most.
    period = 2 * np.pi * 8.0
    for first, second, remaining in (
        ({"semi_axes": (1, 1, 0.8), "rotation_period": 7.0}, {"semi_axes": (0.3, 0.23, 0.2)}, {"libration": 0.2}),
        ({"semi_axes": (1, 0.9, 0.8), "rotation_period": period / 1.3}, {"diameter": 0.2}, {}),
    ):
        options = {"G": 1.0, "total_mass": 1.0, "mass_ratio": 0.02, "period": period}
        system, state = binary(Component(**first), Component(**second), **options, **remaining)
        run = system.integrate(state, 60 * period, output=period / 40)
        result = observables.orbit_precession(run)
        assert result.apsidal is None or abs(result.apsidal) < 0.05 * 2 * np.pi / period
        np.testing.assert_allclose(result.sidereal_period, period, rtol=1e-3)
    system, state = fullbody.systems.antiope()
    result = observables.orbit_precession(system.integrate(state, 60 * 16.5, output=0.5))
    assert (result.apsidal, result.anomalistic_period) == (None, None)
    assert np.isfinite(result.sidereal_period)


def test_motion_along_a_line_has_no_orbit():
    system, state = pair_of_points(0.0)
    falling = state.replace(velocity=[[0, 0, 0], 0.5 * (state.position[1] - state.position[0])])
    run = system.integrate(falling, 0.1, output=0.05)
    for function in OF_SAMPLES:
        refused(r"body 1 .* moves along its line to body 0, or not at all", function, run)


def test_the_longest_axis_is_found_in_any_unit():
    ball = Component(diameter=1 * u.km, mass=1e12 * u.kg, rotation_period=5 * u.h)
    egg = Component(semi_axes=(0.1 * u.km, 90 * u.m, 0.08 * u.km), mass=6e9 * u.kg)
    system, state = binary(ball, egg, semi_major_axis=5 * u.km, libration=0.1, units=True)
    system = system.with_body(1, fullbody.Ellipsoid(0.1 * u.km, 90 * u.m, 80 * u.m))
    run = system.integrate(state, 1000.0, output=2.0)
    assert observables.libration(run).angle[0].value == pytest.approx(0.1, abs=1e-12)


def test_libration_counts_from_the_nearer_end_of_the_axis():
    system, state = moon((0.0010, 0.0009, 0.0008), libration=np.pi + 0.1)
    run = system.integrate(state, 100.0, output=0.25)
    assert observables.libration(run).angle[0] == pytest.approx(0.1, abs=1e-9)
    assert observables.libration(run).amplitude == pytest.approx(0.1, rel=0.02)
    # Faster than the separatrix, n sqrt(3 (B - A)/C) = 0.56 n above n.
    fast = state.replace(spin=state.spin * 2)
    result = observables.libration(system.integrate(fast, 100.0, output=0.25))
    assert result.amplitude is None
    assert len(result.frequencies) == len(result.amplitudes) == 0
    assert np.diff(result.angle).min() > 0
    np.testing.assert_allclose(np.diff(result.angle).mean(), 0.25 * 0.9, rtol=0.1)
    # Sampled so that the axis goes by more than a quarter turn, there is no telling which way.
    with pytest.raises(InvalidInput, match=r"turns by about 1\.\d+ rad in the orbit's frame .* less than 1\.57"):
        observables.libration(system.integrate(state.replace(spin=4.5 * state.spin), 100.0, output=0.5))
    with pytest.raises(InvalidInput, match=r"turns by about 3\.\d+ rad in the orbit's frame .* less than 3\.14"):
        observables.roll_pitch_yaw(system.integrate(state.replace(spin=8 * state.spin), 100.0, output=0.5))


def test_results_are_short_to_read_and_compare():
    run, _ = librating(0.01, 0.0, 100.0)
    for function in OF_REVOLUTIONS:
        if function is observables.spin_precession:
            continue
        result, again = function(run), function(run)
        assert len(repr(result)) < 1000
        assert "\n" not in repr(result)
        assert result == again
        assert result not in (function(run[5:]), "found")
    assert "angle=<(401,), " in repr(observables.libration(run))
    swings = observables.libration(run)
    assert f"amplitude={swings.amplitude}" in repr(swings)


def test_without_scipy_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.interpolate", None)
    system, state = pair_of_points(0.0)
    with pytest.raises(ImportError, match="pip install scipy"):
        observables.mutual_period(system.integrate(state, 20.0, output=0.5))
