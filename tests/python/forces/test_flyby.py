"""A planet that passes: prescribed, or as a massive body of the system; and the impulse of a fast one."""

import fullbody
import numpy as np
import pytest
from fullbody import events
from fullbody.forces import ThirdBody
from support.scenes import pair, relative

LOOSE = fullbody.Verner98(rtol=1e-11, atol=1e-11)


def passage(periapsis, e=1.5, mu=1e6, reach=6.0):
    """A hyperbola past the pair of mass one, the time of its periapsis, and a time by which it is far again."""
    a = periapsis / (1 - e)
    n = np.sqrt((mu + 1.0) / -(a**3))
    shape = np.arccosh((1 + reach) / e)
    before = (e * np.sinh(shape) - shape) / n
    orbit = fullbody.KeplerElements(a, e, 0.5, 0.7, 1.1, 0.0)
    return ThirdBody(mu=mu, orbit=orbit, of="body", time=before, name="planet"), before, 2 * before


@pytest.mark.parametrize("periapsis", [430.0, 600.0])
def test_a_prescribed_planet_equals_a_massive_body(periapsis):
    """There the planet also moves by what the pair's shape does to it: by a millionth of the deviation of the pair."""
    planet, _, until = passage(periapsis)
    system, state = pair()
    world = system.with_forces([planet])
    place, speed = world.third_body("planet", 0.0)
    bodies = [*system, fullbody.Body(fullbody.PointMass(), mass=planet.mu, name="planet")]
    massive = fullbody.System(bodies, G=system.G)
    start = fullbody.State(
        position=np.vstack([state.position, place]),
        velocity=np.vstack([state.velocity, speed]),
        attitude=np.vstack([state.attitude, [1.0, 0, 0, 0]]),
        spin=np.vstack([state.spin, np.zeros(3)]),
    )
    one = world.integrate(state, until, output=[until], integrator=LOOSE)
    other = massive.integrate(start, until, output=[until], integrator=LOOSE)
    free = system.integrate(state, until, output=[until], integrator=LOOSE)
    effect = np.abs(relative(one) - relative(free)).max()
    assert effect > 1e-2
    assert np.abs(relative(one) - relative(other)).max() < 1e-6 * effect
    turned = np.abs(one.spin - free.spin).max()
    assert np.abs(one.spin - other.spin[:, :2]).max() < 1e-6 * turned
    assert np.abs(one.attitude - other.attitude[:, :2]).max() < 1e-6
    # And where the pair is from the planet, which the nominal barycentre alone would miss.
    path = world.third_body("planet", until)[0]
    from_planet = other.position[0, :2] - other.position[0, 2]
    scale = np.linalg.norm(path)
    assert np.abs(one.position[0] - path - from_planet).max() < 1e-9 * scale
    assert abs(one.energy_drift).max() < 1e-9


def test_the_closest_approach_is_at_periapsis():
    """The pair departs from its nominal barycentre by some 1e-5 of the distance."""
    planet, when, until = passage(600.0)
    system, state = pair()
    watched = [events.ClosestApproach(planet.name)]
    run = system.with_forces([planet]).integrate(state, until, output=[until], integrator=LOOSE, events=watched)
    assert [happened.time for happened in run.events] == [pytest.approx(when, rel=1e-4)]


def test_a_fast_passage_gives_the_impulse_of_a_straight_path():
    """2 mu/(b^2 V) (x, 0, -z) on what is at (x, y, z), for a straight path along y at distance b along x.

    The integral of mu (3 p p^T - p^2)/p^5 over the path. Left out are the motion of the bodies in the time b/V
    and the next order in 1/b.
    """
    mu, b, speed = 1.0, 1e3, 1e5
    time = np.linspace(-300.0, 300.0, 11) * b / speed
    place = np.stack([b + 0 * time, speed * time, 0 * time], axis=1)
    planet = ThirdBody(mu=mu, times=time, positions=place, of="body", name="planet")
    bodies = [fullbody.Body(fullbody.PointMass(), mass=m) for m in (1e-9, 2e-9)]
    x = np.array([3.0, -2.0, 1.5])
    shares = np.array([[-2.0 / 3.0], [1.0 / 3.0]])
    state = fullbody.State(shares * x, np.zeros((2, 3)), time=time[0])
    system = fullbody.System(bodies, G=1e-20, forces=[planet])
    run = system.integrate(state, time[-1], output=[time[-1]])
    change = (run.velocity[0, 1] - run.velocity[0, 0]) * b**2 * speed / (2 * mu)
    np.testing.assert_allclose(change, [x[0], 0.0, -x[2]], rtol=0, atol=5e-3 * 3.0)
    # The path ends at 300 b: what is missing of the sum is (1/300)^2 of it.
    np.testing.assert_allclose(change[0] + change[1] + change[2], x[0] - x[2], atol=2e-2)


def test_a_planet_turns_what_it_passes():
    planet, _, until = passage(430.0)
    system, state = pair()
    run = system.with_forces([planet]).integrate(state, until, output=[0.0, until])
    change = run.angular_momentum[-1] - run.angular_momentum[0]
    np.testing.assert_allclose(run.angular_impulse["planet"][-1], change, rtol=0, atol=1e-12 * np.abs(change).max())
    np.testing.assert_allclose(run.work["planet"][-1], np.diff(run.energy)[0], rtol=1e-9)
    free = system.integrate(state, until, output=[until])
    assert np.abs(run.spin[-1, 1] - free.spin[-1, 1]).max() > 1e-3
