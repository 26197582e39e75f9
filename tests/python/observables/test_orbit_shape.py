"""The shape of an orbit by its distances, its mean eccentricity, and when a body tumbles."""

import astropy.units as u
import fullbody
import numpy as np
import pytest
from fullbody import Component, binary, observables
from support import moon, pair_of_points, ready, refused, rot_x, rot_y, rot_z, with_samples


def oblate(e, size=5.0, c=0.9, revolutions=60, elements="mean", apart=24):
    """A light ball about a spheroid in its equator."""
    primary = Component(semi_axes=(1.0, 1.0, c), rotation_period=np.inf, mass=1.0)
    options = {"semi_major_axis": size, "eccentricity": e, "elements": elements, "mismatch_warning": np.inf}
    system, state = binary(primary, Component(diameter=1e-3, mass=1e-9), G=1.0, **options)
    period = 2 * np.pi * size**1.5
    return system.integrate(state, revolutions * period, output=period / apart)


@pytest.mark.parametrize(
    ("e", "apart", "sense"), [*((e, 40, 1) for e in (0.0, 0.01, 0.3, 0.7, 0.9)), (0.3, 10, -1), (0.7, 10, 1)]
)
def test_the_shape_of_a_kepler_orbit_is_its_elements(e, apart, sense):
    system, state = pair_of_points(e)
    run = system.integrate(state, sense * 20.4 * 2 * np.pi, output=2 * np.pi / apart)
    result = observables.orbit_shape(run)
    assert len(result.time) == 20
    np.testing.assert_allclose(result.a, 1.0, rtol=1e-11)
    np.testing.assert_allclose(result.e, e, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(result.periapsis, 1 - e, rtol=1e-10)
    np.testing.assert_allclose(result.apoapsis, 1 + e, rtol=1e-11)
    mean = observables.eccentricity(run)
    assert (mean.free is None) == (e == 0.0)
    np.testing.assert_allclose(mean.free or 0.0, e, rtol=1e-9)
    np.testing.assert_allclose(mean.osculating, e, rtol=1e-9, atol=1e-13)
    # The apsidal rate of a short run is as good as this.
    assert mean.forced < 1e-4


@pytest.mark.parametrize(
    ("degrees", "apart"), [*((angle, 24) for angle in (0.0, 6.0, 90.0, 174.0, 180.0, 354.0)), (186.0, 24.3), (6.0, 9)]
)
def test_each_revolution_contains_its_periapsis(degrees, apart):
    orbit = fullbody.KeplerElements(10.0, 0.3, 0.0, 0.0, 0.0, np.radians(degrees))
    r, v = orbit.to_cartesian(mu=1.0)
    system, _ = pair_of_points(0.3)
    half = np.array([-0.5, 0.5])[:, None]
    period = 2 * np.pi * 10.0**1.5
    run = system.integrate(fullbody.State(half * r, half * v), 5.4 * period, output=period / apart)
    result = observables.orbit_shape(run)
    assert len(result.e) == 5
    np.testing.assert_allclose(result.e, 0.3, rtol=1e-9)
    np.testing.assert_allclose(result.a, 10.0, rtol=1e-9)


@pytest.mark.parametrize(("e", "size"), [*((e, 5.0) for e in (0.0, 0.005, 0.02, 0.1)), (0.02, 10.0)])
def test_free_and_forced_eccentricity_are_separated(e, size):
    # A circle's osculating eccentricity is 3/2 J2 (R/a)^2.
    run = oblate(e, size)
    forced = 1.5 * (1 - 0.9**2) / 5 / size**2
    result, shape = observables.eccentricity(run), observables.orbit_shape(run)
    # The second order of J2 (R/a)^2, and e^2 times a few.
    np.testing.assert_allclose(result.forced, forced, rtol=3 * forced + 4 * e**2)
    np.testing.assert_allclose(shape.e, e, rtol=forced, atol=1e-12)
    np.testing.assert_allclose(shape.a, size, rtol=forced)
    if e == 0.0:
        assert result.free is None
        np.testing.assert_allclose(result.osculating, forced, rtol=3 * forced)
        return
    np.testing.assert_allclose(result.free, e, rtol=forced)
    # The mean length of the sum of two vectors that turn against each other, by a quadrature of its own.
    angle = np.linspace(0, 2 * np.pi, 10001)[:-1]
    np.testing.assert_allclose(result.osculating, np.abs(e + forced * np.exp(1j * angle)).mean(), rtol=0.01)
    elements = run.elements()
    assert elements.e.min() < e < elements.e.max()


def test_a_periapsis_that_precesses_across_the_ends_of_revolutions():
    # The error is at most a tenth of the square of what the periapsis moves in a revolution, 6 pi/2 J2 (R/p)^2.
    run = oblate(0.2, size=3.0, c=0.7, revolutions=80)
    moved = 3 * np.pi * (1 - 0.7**2) / 5 / (3.0 * (1 - 0.04)) ** 2
    e = observables.orbit_shape(run).e
    assert moved > 0.1
    assert np.ptp(e) < 0.1 * moved**2 * 0.2
    assert 80 * moved > 2 * np.pi, "the periapsis has not gone round"


def test_orbit_shapes_have_units_and_names_of_bodies():
    system, state = ready("didymos_after_dart", gravity="multipole:4", units=True)
    run = system.integrate(state, "10 day", output="0.5 hour")
    result = observables.orbit_shape(run, body="Dimorphos", about="Didymos")
    assert result.a.unit == u.km
    assert result.time.unit == u.hour
    assert isinstance(result.e, np.ndarray)
    distance = np.linalg.norm(run.position[:, 1] - run.position[:, 0], axis=1)
    np.testing.assert_allclose(result.periapsis.min().value, distance.min().value, rtol=1e-4)
    np.testing.assert_allclose(result.apoapsis.max().value, distance.max().value, rtol=1e-4)
    np.testing.assert_allclose(result.a.value, (distance.min() + distance.max()).value / 2, rtol=2e-3)
    other = observables.orbit_shape(run, body=0, about=1)
    np.testing.assert_allclose(other.e, result.e, rtol=1e-9)
    mean = observables.eccentricity(run, mu=system.mu())
    assert mean == observables.eccentricity(run)
    refused("mu has the unit km", lambda: observables.eccentricity(run, mu=1 * u.km))


def test_runs_too_short_for_a_shape_are_refused():
    system, state = pair_of_points(0.1)
    run = system.integrate(state, 2 * np.pi * 0.9, output=0.1)
    refused(r"0\.878 revolutions; an orbit's shape needs 1 or more", lambda: observables.orbit_shape(run))
    refused(r"0\.878 revolutions; an eccentricity needs 5 or more", lambda: observables.eccentricity(run))


def turning(roll, pitch, yaw, span=100.0, apart=0.5, half_turn=None):
    """A made-up record of a body on a circle with these angles (radians, of time) in the frame of its orbit."""
    system, state = moon((0.02, 0.015, 0.01), name="Beta")
    run = system.integrate(state, span, output=apart)
    attitude = run.attitude.copy()
    for k, time in enumerate(run.time):
        r = run.position[k, 1] - run.position[k, 0]
        x = -r / np.linalg.norm(r)
        frame = np.stack([x, np.cross([0, 0, 1], x), [0, 0, 1]], axis=1)
        matrix = frame @ rot_z(yaw(time)) @ rot_y(pitch(time)) @ rot_x(roll(time))
        if half_turn is not None:
            matrix = matrix @ np.diag(half_turn)
        attitude[k, 1] = fullbody.base.rotations.quaternion(matrix)
    return with_samples(run, attitude=attitude)


def still(time):
    return 0.0 * time


@pytest.mark.parametrize("half_turn", [None, [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
def test_a_roll_of_370_degrees_has_tumbled(half_turn):
    rate = np.radians(370) / 100
    run = turning(lambda t: rate * t, still, still, half_turn=half_turn)
    result = observables.tumbles(run, limit=np.radians(45))
    assert result.angle == "roll"
    np.testing.assert_allclose(result.time, np.radians(45) / rate, rtol=1e-9)
    np.testing.assert_allclose(np.degrees(result.largest), [370, 0, 0], atol=1e-6)
    assert observables.tumbles(run, body="Beta", about="body 0").time == pytest.approx(np.pi / 2 / rate)


@pytest.mark.parametrize(("name", "frequency"), [("roll", 0.3), ("pitch", 0.25), ("yaw", 0.2)])
def test_the_angle_that_passes_the_limit_first_is_named(name, frequency):
    def swing(size):
        return lambda time: size * np.sin(frequency * time)

    run = turning(*(swing(0.7 if angle == name else 0.3) for angle in ("roll", "pitch", "yaw")))
    result = observables.tumbles(run, limit=0.5)
    assert result.angle == name
    # Where 0.7 sin reaches 0.5; a cubic through samples an eighth of a radian of phase apart.
    np.testing.assert_allclose(result.time, np.arcsin(0.5 / 0.7) / frequency, rtol=1e-4)
    none = observables.tumbles(run, limit=0.71)
    assert (none.time, none.angle) == (None, None)
    np.testing.assert_allclose(none.largest, result.largest)
    assert none.largest.argmax() == ("roll", "pitch", "yaw").index(name)


def test_tumbling_is_found_at_the_start_and_in_backward_runs():
    run = turning(still, still, lambda t: 0.5 - 0.01 * t)
    result = observables.tumbles(run, limit=0.4)
    assert (result.time, result.angle) == (0.0, "yaw")
    back = run[::-1]
    # Backwards, the angle goes from -0.44 at time 94 through zero to 0.45 at time 5.
    assert observables.tumbles(back[12:], limit=0.45).time == pytest.approx(5.0)


def test_bad_limits_of_tumbling_are_refused():
    run = turning(still, still, still, span=5.0)
    for limit in (0.0, -0.1, 1.6, np.nan, np.inf, None, "90", "90 km", 90, [0.1, 0.2]):
        refused("limit", observables.tumbles, run, limit=limit)


def test_limits_of_tumbling_have_units():
    system, state = ready("didymos_after_dart", gravity="multipole:4", units=True)
    run = system.integrate(state, "2 day", output="0.5 hour")
    result = observables.tumbles(run, limit=15 * u.deg)
    assert result.angle == "yaw"
    assert result.time.unit == u.hour
    assert result.largest.unit == u.rad
    assert observables.tumbles(run, limit="15 deg") == result
