"""Runs that several tests look at; pictures go to no screen."""

import fullbody
import matplotlib
import pytest

matplotlib.use("agg")


@pytest.fixture(autouse=True)
def close_figures():
    yield
    import matplotlib.pyplot as plt

    plt.close("all")


@pytest.fixture(scope="session")
def kw4_run():
    """Fifty hours of 1999 KW4 with units."""
    system, state = fullbody.systems.kw4(units=True)
    return system.integrate(state, 50.0, output=0.5)


@pytest.fixture(scope="session")
def case1_run():
    """The paper's case 1, without units."""
    system, state = fullbody.systems.case1()
    return system.integrate(state, 100.0, output=0.5)


@pytest.fixture(scope="session")
def triple_run():
    """An ellipsoid, a sphere and a point, without units."""
    bodies = [
        fullbody.Body(fullbody.Ellipsoid(1.0, 0.8, 0.6), mass=10.0, name="big"),
        fullbody.Body(fullbody.Sphere(0.2), mass=0.1),
        fullbody.Body(fullbody.PointMass(), mass=0.01, name="a name as long as this"),
    ]
    system = fullbody.System(bodies, G=1.0)
    state = fullbody.State(
        position=[[0, 0, 0], [4, 0, 0], [0, 12, 0]],
        velocity=[[0, 0, 0], [0, 1.6, 0], [-0.9, 0, 0.1]],
        spin=[[0, 0, 1], [0, 0.3, 0], [0, 0, 0]],
    )
    return system.integrate(state, 20.0, output=0.5)
