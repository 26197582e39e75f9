"""Curves of angles show how fast a body turns."""

import fullbody
import numpy as np
import pytest

#: The axis is 9.28 degrees from the pole of the ecliptic: the angle about that pole varies in speed by 1 / cos - 1.
INCLINED = 1.01 * (1 / np.cos(np.radians(9.28)) - 1)


@pytest.fixture(scope="module")
def system_and_state():
    return fullbody.systems.didymos_after_dart(units=True, gravity="point")


def psi(run):
    """The curve of Didymos' rotation, in turns and hours."""
    (line,) = [line for line in run.plot.angles()[0, 1].lines if line.get_label() == r"$\psi$"]
    time, angle = (np.asarray(values, dtype=float) for values in line.get_data())
    scale = 1.0 if np.nanmax(time) > 200.0 else 24.0
    keep = np.isfinite(angle)
    return scale * time[keep], angle[keep] / 360.0


@pytest.mark.parametrize("dense", [False, True])
def test_the_curve_of_a_fast_rotation_follows_each_turn(system_and_state, dense):
    system, state = system_and_state
    run = system.integrate(state, "10 days", output="15 min", dense=dense)
    time, turns = psi(run)
    step = np.diff(time)
    followed = np.diff(turns) - np.round(np.diff(turns))
    assert np.abs(followed).max() < 1 / 40
    np.testing.assert_allclose((followed / step), -1 / 2.26, rtol=INCLINED)


def test_samples_too_far_apart_bring_a_warning(system_and_state):
    system, state = system_and_state
    run = system.integrate(state, "10 days", output="2 hour")
    with pytest.warns(UserWarning, match=r"Didymos makes up to 0.88 turns between two samples .*dense=True"):
        run.plot.angles()
    dense = system.integrate(state, "10 days", output="2 hour", dense=True)
    time, turns = psi(dense)
    followed = np.diff(turns) - np.round(np.diff(turns))
    np.testing.assert_allclose(followed / np.diff(time), -1 / 2.26, rtol=INCLINED)
