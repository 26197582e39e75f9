"""Precession of orbits whose plane turns: right for every length of the run, every inclination and every axes.

First order in J2, with p = a (1 - e^2) and the unit n J2 (R/p)^2 (Murray & Dermott 1999, Solar System Dynamics,
Sec. 6.11; Vallado, Fundamentals of Astrodynamics, eqs. 9-38 and 9-40):

    node:                    -3/2 cos i
    argument of periapsis:    3/4 (5 cos^2 i - 1)

A homogeneous spheroid has J2 R^2 = (a^2 - c^2)/5. What first order leaves out is smaller by J2 (R/p)^2, with factors of
a few.
"""

import pickle

import fullbody
import numpy as np
import pytest
from fullbody import observables
from fullbody.errors import InvalidInput

from reproduction.ho2021 import starts

C, SIZE = 0.9, 6.0
J2_R2 = (1 - C * C) / 5


def satellite(inclination, e, revolutions, apart=24, size=SIZE, rotation=None, **options):
    """A light point about a spheroid at rest, G m = 1, and how a rotation turns the whole."""
    bodies = [fullbody.Body(fullbody.Ellipsoid(1.0, 1.0, C), mass=1.0), fullbody.Body(fullbody.PointMass(), mass=1e-12)]
    system = fullbody.System(bodies, G=1.0, gravity="focal")
    r, v = fullbody.KeplerElements(size, e, np.radians(inclination), 0.3, 0.7, 0.0).to_cartesian(1.0)
    attitude = np.array([[1.0, 0, 0, 0]] * 2)
    if rotation is not None:
        matrix = fullbody.State([np.zeros(3)], [np.zeros(3)], [rotation]).rotation_matrix[0]
        r, v, attitude[0] = matrix @ r, matrix @ v, rotation
    period = 2 * np.pi * size**1.5
    state = fullbody.State([0 * r, r], [0 * v, v], attitude)
    options = {"output": period / apart, "integrator": fullbody.Verner98(1e-11, 1e-11), **options}
    return system.integrate(state, revolutions * period, **options)


def textbook(run, inclination):
    """Rates of the node and of the argument of periapsis, and the error of first order, by the run's mean a and e."""
    elements = run.elements(1.0)
    a, e = elements.a.mean(), elements.e.mean()
    small = J2_R2 / (a * (1 - e * e)) ** 2
    unit, cosine = a**-1.5 * small, np.cos(np.radians(inclination))
    node, argument = -1.5 * unit * cosine, 0.75 * unit * (5 * cosine**2 - 1)
    return node, argument, 12 * small * (abs(node) + abs(argument))


def compare(run, inclination):
    node, argument, error = textbook(run, inclination)
    result = observables.orbit_precession(run, axis=[0, 0, 1])
    np.testing.assert_allclose(result.apsidal, argument + node * np.cos(np.radians(inclination)), rtol=0, atol=error)
    np.testing.assert_allclose(result.nodal, node, rtol=0, atol=error)
    np.testing.assert_allclose(result.argument_of_periapsis, argument, rtol=0, atol=error)
    return result


# Prograde, the zero of the apsidal rate (3 cos^2 i = 1), the critical inclination, polar, and retrograde.
@pytest.mark.parametrize("inclination", [3, 30, 54.7356, 63.4349, 90, 116.5651, 150])
@pytest.mark.parametrize(("e", "apart"), [(0.1, 24), (0.4, 48)])
def test_precession_rates_are_those_of_the_textbook(inclination, e, apart):
    run = satellite(inclination, e, 50, apart)
    for revolutions in (20, 50):
        compare(run[: revolutions * apart + 1], inclination)


@pytest.mark.parametrize("inclination", [30, 120])
def test_the_rates_do_not_depend_on_the_length_of_the_run(inclination):
    # At three radii the node turns by more than once in 400 revolutions.
    run = satellite(inclination, 0.1, 400, size=3.0)
    results = [compare(run[: revolutions * 24 + 1], inclination) for revolutions in (20, 100, 200, 400)]
    node, _, error = textbook(run, inclination)
    assert abs(node * run.time[-1]) > 2 * np.pi
    for value in results[:-1]:
        # A sixth of the second order: what is left is the terms that turn with the argument of periapsis.
        np.testing.assert_allclose(value.apsidal, results[-1].apsidal, rtol=0, atol=error / 6)
        np.testing.assert_allclose(value.sidereal_period, results[-1].sidereal_period, rtol=1e-5)
        np.testing.assert_allclose(value.anomalistic_period, results[-1].anomalistic_period, rtol=1e-4)
    rates = observables.element_rates(run).mean_rates
    scale = abs(rates["omega"]) + abs(rates["Omega"])
    np.testing.assert_allclose(results[-1].nodal, rates["Omega"], rtol=0, atol=1e-4 * scale)
    np.testing.assert_allclose(results[-1].argument_of_periapsis, rates["omega"], rtol=0, atol=2e-3 * scale)


def test_an_orbit_in_the_equator_has_an_apsidal_rate_alone():
    # The apses move by 3/2 n J2 (R/p)^2, and there is no node to count from.
    for inclination in (0.0, 180.0):
        run = satellite(inclination, 0.1, 40)
        result = observables.orbit_precession(run, axis=[0, 0, 1])
        node, argument, error = textbook(run, 0.0)
        np.testing.assert_allclose(result.apsidal, argument + node, rtol=0, atol=error)
        assert (result.nodal, result.argument_of_periapsis) == (None, None)


@pytest.mark.parametrize("inclination", [30, 90, 120])
def test_rates_do_not_depend_on_labels_axes_and_direction_of_time(inclination):
    run = satellite(inclination, 0.1, 40)
    reference = observables.orbit_precession(run, axis=[0, 0, 1])
    # The other body's orbit about this one, and other axes, which the apsidal rate and the period know nothing of.
    swapped = observables.orbit_precession(run, axis=[0, 0, 1], body=0, about=1)
    aside = observables.orbit_precession(run, axis=[1.0, -2.0, 0.5])
    rotated_run = satellite(inclination, 0.1, 40, rotation=np.array([0.3, -0.5, 0.7, 0.2]) / np.sqrt(0.87))
    rotated = observables.orbit_precession(rotated_run, axis=rotated_run[0].rotation_matrix[0][:, 2])
    back = observables.orbit_precession(run[::-1], axis=[0, 0, 1])
    scale = 1e-6 * abs(reference.apsidal)
    for other in (swapped, aside, rotated, back):
        np.testing.assert_allclose(other.apsidal, reference.apsidal, rtol=1e-6)
        if other is not back:
            np.testing.assert_allclose(other.sidereal_period, reference.sidereal_period, rtol=1e-9)
            np.testing.assert_allclose(other.anomalistic_period, reference.anomalistic_period, rtol=1e-9)
        if other is not aside:
            np.testing.assert_allclose(other.nodal, reference.nodal, rtol=0, atol=scale)
            np.testing.assert_allclose(other.argument_of_periapsis, reference.argument_of_periapsis, rtol=0, atol=scale)


def windowed(time, values):
    """The slope of a straight line under the third power of a Hann window; numpy squares the weights."""
    return np.polyfit(time, values, 1, w=np.sin(np.pi * (time - time[0]) / (time[-1] - time[0])) ** 3)[0]


def counted(run, event):
    """Times and places at which an event happened."""
    happened = [passage for passage in run.events if passage.event == event]
    positions = [passage.state.position[1] - passage.state.position[0] for passage in happened]
    return np.array([passage.time for passage in happened]), np.array(positions)


@pytest.mark.parametrize(("inclination", "revolutions"), [(30.0, 20), (120.0, 100)])
def test_the_sidereal_period_is_that_of_a_count_of_revolutions(inclination, revolutions):
    # From one passage of the node to the next is a whole turn and cos i times what the node moves.
    crossing = fullbody.events.PlaneCrossing(1, 0, direction=1)
    # A nearly round orbit far out: e of some 5e-4, by which the passages are early or late as periapsis goes round.
    run = satellite(inclination, 1e-4, revolutions, size=10.0, events=[crossing])
    time, positions = counted(run, crossing)
    normal = np.cross(run.position[:, 1] - run.position[:, 0], run.velocity[:, 1] - run.velocity[:, 0])
    node = np.unwrap(np.arctan2(normal[:, 0], -normal[:, 1]))
    cosine = normal[:, 2] / np.linalg.norm(normal, axis=1)
    angle = np.concatenate([[0.0], np.cumsum((cosine[1:] + cosine[:-1]) / 2 * np.diff(node))])
    along = 2 * np.pi * np.arange(len(time)) + np.interp(time, run.time, angle)
    result = observables.orbit_precession(run, axis=[0, 0, 1])
    np.testing.assert_allclose(result.sidereal_period, 2 * np.pi / windowed(time, along), rtol=2e-6)
    longitude = np.unwrap(np.arctan2(positions[:, 1], positions[:, 0]))
    np.testing.assert_allclose(result.nodal, windowed(time, longitude), rtol=1e-3)
    period = observables.mutual_period(run)
    np.testing.assert_allclose(period.mean, result.sidereal_period, rtol=1e-12)
    assert len(period.period) == int(np.ptp(run.time) / period.mean)
    # Each revolution is as long as the mean, but for twice the eccentricity, here the forced one.
    np.testing.assert_allclose(period.period, period.mean, rtol=1e-2)


@pytest.mark.parametrize("inclination", [30.0, 120.0])
def test_the_apsidal_rate_is_that_of_a_count_of_passages(inclination):
    # Periapsides and nodes of the same run, counted: omega moves by what one is faster than the other.
    watched = [fullbody.events.PlaneCrossing(1, 0, direction=1), fullbody.events.Periapsis(0, 1)]
    run = satellite(inclination, 0.1, 400, size=3.0, events=watched)
    nodes, positions = counted(run, watched[0])
    passages, _ = counted(run, watched[1])
    draconic, radial = (windowed(time, 2 * np.pi * np.arange(len(time))) for time in (nodes, passages))
    node = windowed(nodes, np.unwrap(np.arctan2(positions[:, 1], positions[:, 0])))
    result = observables.orbit_precession(run, axis=[0, 0, 1])
    np.testing.assert_allclose(result.anomalistic_period, 2 * np.pi / radial, rtol=5e-5)
    np.testing.assert_allclose(result.argument_of_periapsis, draconic - radial, rtol=0, atol=0.01 * abs(node))
    expected = draconic - radial + node * np.cos(result.inclination.mean())
    np.testing.assert_allclose(result.apsidal, expected, rtol=0, atol=0.01 * abs(node))


def test_the_period_of_an_orbit_whose_plane_turns_over_is_computed():
    system, state = fullbody.systems.kw4_ho2021()
    steep = starts.start(state, system.mu(), i=120.0)
    run = system.integrate(steep, 3000.0, output=0.5, integrator=fullbody.Verner98(1e-10, 1e-10))
    r, v = (name[:, 1] - name[:, 0] for name in (run.position, run.velocity))
    rate = np.linalg.norm(np.cross(r, v), axis=1) / np.sum(r**2, axis=1)
    angle = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2 * 0.5)])
    for count in (500, 2000, 6001):
        result = observables.orbit_precession(run[:count])
        expected = 2 * np.pi / windowed(run.time[:count], angle[:count])
        np.testing.assert_allclose(result.sidereal_period, expected, rtol=1e-6)


@pytest.mark.parametrize("output", [0.1, 0.5, 2.0, 5.0])
def test_angles_that_are_not_defined_have_no_rate(output):
    # The eccentricity of the paper's run winds about zero as often as samples happen to show it.
    system, state = fullbody.systems.kw4_ho2021()
    result = observables.element_rates(system.integrate(state, 480.0, output=output))
    for rates in (result.rates, result.mean_rates, pickle.loads(pickle.dumps(result)).mean_rates):
        assert list(rates) == ["a", "e", "i", "h", "k", "Omega", "L"]
        for name in ("omega", "varpi", "M"):
            with pytest.raises(InvalidInput, match=f"{name} has no rate: the osculating eccentricity of body 1"):
                rates[name]
        with pytest.raises(KeyError):
            rates["Q"]


def test_a_node_that_is_not_defined_has_no_rate():
    system, state = fullbody.systems.kw4()
    state = state.rotated("Alpha", [1, 0, 0], np.radians(8.0)).rotated("Beta", [1, 0, 0], np.radians(6.0))
    for output in (0.5, 2.0):
        run = system.integrate(state, 480.0, output=output)
        rates = observables.element_rates(run).mean_rates
        with pytest.raises(InvalidInput, match="Omega has no rate: the osculating sine of the inclination of body 1"):
            rates["Omega"]
        x, y = (run.position[:, 1] - run.position[:, 0])[:, :2].T
        assert rates["L"] == pytest.approx(windowed(run.time, np.unwrap(np.arctan2(y, x))), rel=2e-4)


def test_rates_do_not_depend_on_the_samples():
    rng = np.random.default_rng(4)
    kept = 0
    for _ in range(8):
        inclination, e = rng.uniform(0.0, 175.0), 10.0 ** rng.uniform(-3.5, -0.5)
        run = satellite(inclination, e, 30, size=3.0)
        frequent, few = (observables.element_rates(run[:: int(step)]) for step in (1, rng.integers(2, 9)))
        for name in few.mean_rates.keys() & frequent.mean_rates.keys() - {"h", "k"}:
            # Less than a hundredth of the node's rate; the periapsis is defined worse by a factor of e.
            error = 3e-5 * frequent.mean_rates["L"] / (e if name in ("omega", "varpi", "M") else 1.0)
            np.testing.assert_allclose(few.mean_rates[name], frequent.mean_rates[name], rtol=0, atol=error)
        kept += "omega" in few.mean_rates
    assert 2 < kept < 8
