"""Systems that the tests of this room share."""

import fullbody
import pytest


@pytest.fixture(scope="session")
def pair():
    """Two ellipsoids without an axis of symmetry; G = 1."""
    return fullbody.System(
        [
            fullbody.Body(fullbody.Ellipsoid(1.0, 0.9, 0.8), mass=1.0, name="A"),
            fullbody.Body(fullbody.Ellipsoid(0.5, 0.42, 0.37), mass=0.3, name="B"),
        ],
        G=1.0,
    )


@pytest.fixture(scope="session")
def locked(pair):
    """Both of them locked, far from the fold."""
    return fullbody.analysis.relative_equilibrium(pair, separation=4.0)
