"""Costly fixtures that many tests share."""

import pickle

import pytest


@pytest.fixture(scope="session")
def ellipsoids():
    """Two ellipsoids without an axis of symmetry; G = 1."""
    import fullbody

    return fullbody.System(
        [
            fullbody.Body(fullbody.Ellipsoid(1.0, 0.9, 0.8), mass=1.0, name="A"),
            fullbody.Body(fullbody.Ellipsoid(0.5, 0.42, 0.37), mass=0.3, name="B"),
        ],
        G=1.0,
    )


@pytest.fixture(scope="session")
def locked(ellipsoids):
    """The relative equilibrium of the two ellipsoids far from the fold."""
    import fullbody

    return fullbody.analysis.relative_equilibrium(ellipsoids, separation=4.0)


@pytest.fixture(scope="session")
def kw4_run():
    """Fifty hours of 1999 KW4 with units."""
    import fullbody

    system, state = fullbody.systems.kw4(units=True)
    return system.integrate(state, 50.0, output=0.5)


@pytest.fixture(scope="session")
def short_run():
    """Two hours of 1999 KW4 with units."""
    import fullbody

    system, state = fullbody.systems.kw4(units=True)
    return system.integrate(state, 2.0, output=0.5)


@pytest.fixture(scope="session")
def case1_run():
    """The paper's case 1, without units."""
    import fullbody

    system, state = fullbody.systems.case1()
    return system.integrate(state, 100.0, output=0.5)


@pytest.fixture(scope="session")
def triple_run():
    """An ellipsoid, a sphere and a point, without units."""
    import fullbody

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


@pytest.fixture(scope="session")
def searches():
    """Results of searches for a mean period, by all that they depend on."""
    return {}


@pytest.fixture
def memoised_searches(searches, monkeypatch):
    """A ready-made system in another frame or in other units needs no other search for its start."""
    from fullbody.setups.elements import start_with_period

    def remembered(system, period, start, locked):
        first = start(period)
        arrays = (first.position, first.velocity, first.attitude, first.spin)
        options = {name: value for name, value in system.options.items() if name not in ("epoch", "frame")}
        described = ([*system], system.forces, system.G, system.units, options, period, locked, arrays)
        key = pickle.dumps(described)
        if key not in searches:
            searches[key] = start_with_period(system, period, start, locked)
        return searches[key]

    monkeypatch.setattr("fullbody.setups.elements.start_with_period", remembered)
