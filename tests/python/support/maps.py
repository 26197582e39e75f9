"""Two points on a circle, whose angle after some time is known, and comparisons of maps."""

import fullbody
import numpy as np

from support import points


def circle(mass=0.5, distance=1.0):
    """A circular orbit with G = 1; the heavier point has the mass 1."""
    if distance > 100.0:
        raise ValueError(f"{distance} is too far")
    speed = np.sqrt((1.0 + mass) / distance)
    state = fullbody.State([[0, 0, 0], [distance, 0, 0]], [[0, 0, 0], [0, speed, 0]])
    return points(1.0, mass), state


def angle(run):
    """The angle of the second point about the first at the end, and both positions there."""
    x, y, _ = run.position[-1, 1] - run.position[-1, 0]
    return {"angle": np.arctan2(y, x), "place": run.position[-1]}


def expected(mass, distance, time):
    """The angle by Kepler's third law."""
    return np.sqrt((1.0 + mass) / distance**3) * time


def assert_same(first, second):
    """Two maps are equal bit for bit."""
    assert first.drop_attrs().identical(second.drop_attrs())
    for name in first.variables:
        assert first[name].dtype == second[name].dtype
        assert first[name].values.tobytes() == second[name].values.tobytes(), name
        assert first[name].attrs == second[name].attrs
