"""A planet that passes: prescribed, or as a massive body of the system."""

import fullbody
import numpy as np
import pytest
from fullbody.forces import ThirdBody
from support.scenes import pair, relative

LOOSE = fullbody.Verner98(rtol=1e-11, atol=1e-11)


def passage(periapsis, e=1.5, mu=1e6, span=6.0):
    """A hyperbola past the pair of mass one, the time of its periapsis, and a time by which it is far again."""
    a = periapsis / (1 - e)
    n = np.sqrt((mu + 1.0) / -(a**3))
    shape = np.arccosh((1 + span) / e)
    previous = (e * np.sinh(shape) - shape) / n
    orbit = fullbody.KeplerElements(a, e, 0.5, 0.7, 1.1, 0.0)
    return ThirdBody(mu=mu, orbit=orbit, of="body", time=previous, name="planet"), previous, 2 * previous


@pytest.mark.parametrize("periapsis", [430.0, 600.0])
def test_a_prescribed_planet_equals_a_massive_body(periapsis):
    """There the planet also moves by what the pair's shape does to it: by a millionth of the deviation of the pair."""
    planet, _, until = passage(periapsis)
    system, state = pair()
    world = system.with_forces([planet])
    point, speed = world.third_body("planet", 0.0)
    bodies = [*system, fullbody.Body(fullbody.PointMass(), mass=planet.mu, name="planet")]
    massive = fullbody.System(bodies, G=system.G)
    start = fullbody.State(
        position=np.vstack([state.position, point]),
        velocity=np.vstack([state.velocity, speed]),
        attitude=np.vstack([state.attitude, [1.0, 0, 0, 0]]),
        spin=np.vstack([state.spin, np.zeros(3)]),
    )
    item = world.integrate(state, until, output=[until], integrator=LOOSE)
    other = massive.integrate(start, until, output=[until], integrator=LOOSE)
    free = system.integrate(state, until, output=[until], integrator=LOOSE)
    effect = np.abs(relative(item) - relative(free)).max()
    assert effect > 1e-2
    assert np.abs(relative(item) - relative(other)).max() < 1e-6 * effect
    rotated = np.abs(item.spin - free.spin).max()
    assert np.abs(item.spin - other.spin[:, :2]).max() < 1e-6 * rotated
    assert np.abs(item.attitude - other.attitude[:, :2]).max() < 1e-6
    # And where the pair is from the planet, which the nominal barycentre alone would miss.
    path = world.third_body("planet", until)[0]
    from_planet = other.position[0, :2] - other.position[0, 2]
    scale = np.linalg.norm(path)
    assert np.abs(item.position[0] - path - from_planet).max() < 1e-9 * scale
    assert abs(item.energy_drift).max() < 1e-9
