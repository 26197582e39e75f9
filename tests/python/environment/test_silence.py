"""Forces where they lose their meaning: a word instead of a wrong number or a run without end."""

import fullbody
import numpy as np
import pytest
from fullbody import ForceFailed, InvalidInput, forces
from scenes import differential, pair

POINTS = [fullbody.Body(fullbody.PointMass(), mass=mass, name=name) for mass, name in ((0.99, "A"), (0.01, "B"))]
SPHERES = [
    fullbody.Body(fullbody.Sphere(radius), mass=mass, name=name)
    for radius, mass, name in ((0.3, 0.99, "A"), (0.1, 0.01, "B"))
]


def table(first, last, count, place, mu=1e-3):
    times = np.linspace(first, last, count)
    return forces.ThirdBody(mu=mu, times=times, positions=[place(time) for time in times], of="body", name="bullet")


@pytest.mark.parametrize("gap", [1e-9, -1e-9, 1e-12, -1e-12, 1e-14, -1e-14])
def test_orbits_near_a_parabola(gap):
    """What acts is at the place that the orbit has: the pull on a point, by the plain difference in longdouble."""
    e = 1.0 - gap
    orbit = fullbody.KeplerElements(100.0 / (1.0 - e), e, 0.3, 0.4, 0.5, 0.0)
    comet = forces.ThirdBody(mu=1e4, orbit=orbit, of="body", name="comet")
    system = fullbody.System(POINTS, G=1.0, forces=[comet])
    for time in np.linspace(-40.0, 41.0, 13):
        state = fullbody.State(position=[[-0.01, 0, 0], [0.99, 0, 0]], velocity=np.zeros((2, 3)), time=time)
        expected = differential([0.99, 0, 0], system.third_body("comet", time)[0], 1e4)
        found = system.loads(state)["comet"].force[1] / 0.01
        assert np.linalg.norm(found - expected) < 1e-13 * np.linalg.norm(expected)
