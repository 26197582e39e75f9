"""Observables of short or sparsely sampled runs are right, or refused."""

import fullbody
import numpy as np
import pytest
from fullbody import observables
from fullbody.errors import InvalidInput
from support import OF_REVOLUTIONS, moon, pair_of_points, points, refused


def about_an_oblate_body(e, revolutions, apart):
    """A light point about a spheroid, sampled every ``apart`` of a period; and its apsidal and nodal rate."""
    a, c, size, i = 1.0, 0.95, 20.0, 0.3
    bodies = [fullbody.Body(fullbody.Ellipsoid(a, a, c), mass=1.0), fullbody.Body(fullbody.PointMass(), mass=1e-9)]
    system = fullbody.System(bodies, G=1.0)
    r, v = fullbody.KeplerElements(size, e, i, 0.5, 0.7, 0.3).to_cartesian(1.0)
    period = 2 * np.pi * size**1.5
    run = system.integrate(fullbody.State([0 * r, r], [0 * v, v]), revolutions * period, output=apart * period)
    # Murray & Dermott (1999), Sec. 6.11.
    unit = 2 * np.pi / period * (a**2 - c**2) / 5 / (size * (1 - e**2)) ** 2
    nodal = -1.5 * unit * np.cos(i)
    return run, 0.75 * unit * (5 * np.cos(i) ** 2 - 1) + nodal * np.cos(i), nodal


@pytest.mark.parametrize(
    ("e", "revolutions", "apart"),
    [(0.1, 20, 0.4), (0.5, 50, 0.1), (0.5, 50, 0.2), (0.8, 50, 0.05), (0.8, 50, 0.1), (0.9, 30, 0.02)],
)
def test_precession_by_few_samples_is_that_of_the_textbook(e, revolutions, apart):
    # Spacings that fit into the period fold an ellipse's harmonics onto its first one.
    run, apsidal, nodal = about_an_oblate_body(e, revolutions, apart)
    result = observables.orbit_precession(run, axis=[0, 0, 1])
    # What is left is of the second order in J2 (R/p)^2, 1e-3 at e = 0.8 and 5e-3 at 0.9, times a few.
    np.testing.assert_allclose(result.apsidal, apsidal, rtol=0.005 if e < 0.9 else 0.02)
    np.testing.assert_allclose(result.nodal, nodal, rtol=0.01 if e < 0.9 else 0.02)


def test_samples_too_few_for_the_precession_are_refused():
    run, _, _ = about_an_oblate_body(0.5, 50, 0.48)
    # A tenth of the period of 562.
    with pytest.raises(
        InvalidInput,
        match=r"apsidal rate is .* by all .* by every second one; .* closer together \(output= 56\.0 or less",
    ):
        observables.orbit_precession(run)
    # The plane of this orbit hardly moves: what is wrong is the samples.
    with pytest.raises(InvalidInput, match=r"several samples in each \(output= 5\d\.0 or less\)"):
        observables.orbit_precession(about_an_oblate_body(0.9, 50, 0.6)[0])


@pytest.mark.parametrize("e", [0.3, 0.6, 0.8])
def test_the_period_of_a_kepler_orbit_by_few_samples_is_keplers(e):
    system, state = pair_of_points(e)
    run = system.integrate(state, 2 * np.pi * 20.3, output=2 * np.pi * 0.37)
    np.testing.assert_allclose(observables.mutual_period(run).period, 2 * np.pi, rtol=1e-9)
    np.testing.assert_allclose(observables.mutual_period(run).mean, 2 * np.pi, rtol=1e-7)


def test_motion_that_is_no_kepler_orbit_is_followed_by_its_samples_alone():
    # The inner of two satellites as seen from the outer one, at a = 4: mostly where the planet is, so 16 pi a turn.
    system = points(1.0, 1e-12, 1e-12)
    state = fullbody.State([[0, 0, 0], [1, 0, 0], [4, 0, 0]], [[0, 0, 0], [0, 1, 0], [0, 0.5, 0]])
    run = system.integrate(state, 16 * np.pi * 20, output=0.5)
    np.testing.assert_allclose(observables.mutual_period(run, body=1, about=2).mean, 16 * np.pi, rtol=1e-6)
    coarse = system.integrate(state, 16 * np.pi * 20, output=16 * np.pi / 5)
    with pytest.raises(InvalidInput, match=r"not near to a Kepler orbit; .* \(output= 1\.8 or less\)"):
        observables.mutual_period(coarse, body=1, about=2)


def test_libration_by_few_samples_has_the_equation_of_the_centre():
    # The equation of the centre, 2 e sin M + 5/4 e^2 sin 2M, is in the angle; sampled at 0.3 of the period, its second
    # harmonic folds to 4/3 of the mean motion.
    e = 0.1
    system, state = moon((0.00100, 0.00099, 0.0008), eccentricity=e, libration=0.0)
    result = observables.libration(system.integrate(state, 120 * np.pi, output=2 * np.pi * 0.3))
    harmonics = [result.frequencies[np.argmin(abs(result.frequencies - k))] for k in (1, 2)]
    np.testing.assert_allclose(harmonics, [1, 2], rtol=1e-3)


@pytest.mark.parametrize("function", OF_REVOLUTIONS)
def test_runs_too_short_for_a_mean_are_refused(function):
    system, state = pair_of_points(0.0)
    least = 5 if function is observables.orbit_precession else 2
    for revolutions in (0.3, least - 0.03):
        run = system.integrate(state, 2 * np.pi * revolutions, output=0.1)
        what = f"the run covers {revolutions} revolutions; .* needs {least} or more"
        refused(what, function, run)
    run = system.integrate(state, 4.02 * np.pi, output=0.1)
    if function in (observables.element_rates, observables.mutual_period):
        function(run)
    refused("the run has 2 samples", lambda: function(system.integrate(state, 4.02 * np.pi, output=4.02 * np.pi)))


@pytest.mark.parametrize("function", OF_REVOLUTIONS)
def test_samples_too_far_apart_to_count_revolutions_are_refused(function):
    system, state = pair_of_points(0.0)
    run = system.integrate(state, 2 * np.pi * 60, output=2 * np.pi * 0.6)
    refused(r"between its samples at 0\.0 and 3\.76.* about 0\.6 revol.* several samples in each", function, run)
    # One gap among many samples loses a revolution as well.
    times = np.r_[np.arange(0.0, 31.0, 0.25), np.arange(36.0, 60.0, 0.25)]
    with pytest.raises(InvalidInput, match=r"between its samples at 30\.75 and 36\.0 .* about 0\.84 revol"):
        function(system.integrate(state, 60.0, output=times))


@pytest.mark.parametrize("e", [0.0, 0.3, 0.7])
@pytest.mark.parametrize("revolutions", [2.1, 3.3, 5.2, 8.4, 30.7])
def test_kepler_orbits_of_any_length_have_their_elements(e, revolutions):
    system, state = pair_of_points(e)
    run = system.integrate(state, 2 * np.pi * revolutions, output=2 * np.pi / 40)
    result = observables.mutual_period(run)
    if revolutions < 5:
        np.testing.assert_allclose(result.mean, 2 * np.pi, rtol=1e-12)
        return
    leaks = 10 * revolutions**-7.0 * 2 * e
    np.testing.assert_allclose(result.mean, 2 * np.pi, rtol=max(leaks, 1e-12))
    precession = observables.orbit_precession(run)
    np.testing.assert_allclose(precession.sidereal_period, 2 * np.pi, rtol=max(leaks, 1e-12))
    np.testing.assert_allclose(observables.element_rates(run).mean_rates["L"], 1.0, rtol=max(leaks, 1e-12))
    if e == 0.0:
        assert (precession.apsidal, precession.anomalistic_period) == (None, None)
    else:
        assert abs(precession.apsidal) < 5e-4 if revolutions < 9 else 1e-6
