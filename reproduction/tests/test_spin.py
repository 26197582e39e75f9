"""Initial states that reproduce the printed ranges of Beta's spin, found by runs."""

import fullbody
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from reproduction.ho2021 import paper, spin, starts

SYSTEM, STATE = fullbody.systems.kw4_ho2021(gravity="surface")
#: Mean motion of the stated orbit, degrees an hour.
MOTION = np.degrees(np.sqrt(SYSTEM.mu() / 2.548**3))


def spin_ranges(state):
    """Return the ranges (3, 2) of Beta's spin from a start, 1e-5 rad/s, by the surface integrals."""
    run = SYSTEM.integrate(state, 200.0, output=0.02, integrator=fullbody.Verner98(1e-12, 1e-12))
    spin = run.spin[:, 1] * 1e5 / 3600
    return np.stack([spin.min(axis=0), spin.max(axis=0)], axis=1)


def deviation(state):
    """Return the largest difference from the six printed numbers."""
    return np.abs(spin_ranges(state) - [paper.SPIN[axis] for axis in "xyz"]).max()


def rotated(rotation):
    """Return the stated start with another attitude of Beta."""
    attitude = rotation.as_quat(scalar_first=True)
    return STATE.replace(attitude=[STATE.attitude[0], attitude])


def about_normal(degrees):
    normal = np.cross(STATE.position[1], STATE.velocity[1])
    return rotated(Rotation.from_rotvec(degrees * normal / np.linalg.norm(normal), degrees=True))


@pytest.fixture(scope="module")
def best(numbers):
    angles = numbers["search"]["minima"][0]["angles"]
    return Rotation.from_euler("ZYX", angles[::-1], degrees=True)


@pytest.fixture(scope="module")
def readings(numbers):
    return {reading["name"]: reading for reading in numbers["readings"]}


def test_beta_rotated_by_180_degrees_has_the_same_spin():
    """An ellipsoid is symmetric under this rotation about its pole; x and y change their signs."""
    start_of = spin.FAMILIES["Beta rotated about its own pole by"][3]
    first, second = (spin_ranges(start_of(SYSTEM, STATE, angle)) for angle in (-150.0, 30.0))
    assert first[2] == pytest.approx(second[2], abs=1e-9)
    assert first[:2] == pytest.approx(-second[:2, ::-1], abs=1e-9)


def test_advanced_starts_are_the_motion_except_for_beta():
    result = starts.advanced(SYSTEM, STATE, 1.0)
    end = SYSTEM.integrate(STATE, 1.0, output=[1.0])[-1]
    for name in ("position", "velocity", "attitude", "spin"):
        at_end, at_start, values = (getattr(state, name) for state in (end, STATE, result))
        assert np.array_equal(values[0], at_end[0])
        assert np.array_equal(values[1], (at_end if name in ("position", "velocity") else at_start)[1])
    assert result.time == STATE.time
    assert starts.advanced(SYSTEM, STATE, 0.0) == STATE
    without_alpha = starts.advanced(SYSTEM, STATE, 1.0, alpha=False)
    assert np.array_equal(without_alpha.attitude, STATE.attitude)
    assert np.array_equal(without_alpha.position, end.position)


def test_scans_have_finer_steps_near_the_printed_ranges():
    """The misfit is smallest at an hour of mean motion, and no rate of spin has a small one."""
    result = spin.scan("Beta rotated about the orbit's normal by", 6)
    misfits = spin.misfit(result.ranges)
    assert result.best[0] == pytest.approx(-MOTION, abs=0.7)
    assert result.best[1] < 0.01 < misfits[np.abs(result.values + MOTION) > 2.0].min()
    assert np.all(np.diff(result.values) > 0)
    no_start = spin.scan("Beta's rate of spin", 6)
    assert no_start.best[1] > 0.1
    assert np.isnan(no_start.near_range).all()


def test_scans_give_the_interval_near_the_printed_ranges():
    low, high = spin.scan("Beta rotated about the orbit's normal by").near_range
    assert low < -MOTION < high
    for end, sign in ((low, 1), (high, -1)):
        assert deviation(about_normal(end + sign * 0.02)) < spin.NEAR < deviation(about_normal(end - sign * 0.02))


def test_the_best_orientation_gives_all_six_printed_numbers(best):
    result = spin_ranges(rotated(best))
    assert np.round(result, 2).tolist() == [list(paper.SPIN[axis]) for axis in "xyz"]
    # The opposite rotation does not.
    assert deviation(rotated(best.inv())) > 0.5


def test_rounding_leaves_a_range_of_rotation_angles(numbers, best):
    """The range contains an hour of mean motion and the spin rate taken as an angle; outside it a number differs."""
    least, largest = sorted(abs(angle) for angle in numbers["search"]["rotation_range"])
    size = np.degrees(best.magnitude())
    assert least < min(MOTION, size, np.degrees(0.3611))
    assert max(MOTION, size, np.degrees(0.3611)) < largest
    assert 0.2 < largest - least < 0.5
    axis = best.as_rotvec() / best.magnitude()
    for angle in (least - 0.3, largest + 0.3):
        assert deviation(rotated(Rotation.from_rotvec(angle * axis, degrees=True))) > spin.ROUNDING
    normal = np.cross(STATE.position[1], STATE.velocity[1])
    from_normal = np.degrees(np.arccos(-axis @ normal / np.linalg.norm(normal)))
    assert numbers["search"]["minima"][0]["axis_tilt"] == pytest.approx(from_normal, abs=1e-6)
    assert from_normal < numbers["search"]["largest_tilt"] < 2.0
    # Against the motion.
    assert numbers["search"]["minima"][0]["rotation"] == pytest.approx(-size, abs=1e-9)


def test_readings_have_the_misfits_of_their_starts(readings):
    rate = np.degrees(0.3611)
    expected = {
        f"about the orbit's normal by an hour of mean motion, {-MOTION:.2f}": about_normal(-MOTION),
        f"its spin rate taken as an angle, 0.3611 rad, {-rate:.2f}": about_normal(-rate),
        "all but Beta's attitude and spin an hour later": starts.advanced(SYSTEM, STATE, 1.0),
        "positions and velocities alone an hour later": starts.advanced(SYSTEM, STATE, 1.0, alpha=False),
    }
    for name, state in expected.items():
        (result,) = (reading for text, reading in readings.items() if name in text)
        assert result["misfit"] == pytest.approx(deviation(state), abs=2e-4), name
        assert spin.ROUNDING < result["misfit"] < 0.007, name
    (pole,) = (reading for text, reading in readings.items() if "its own pole" in text)
    assert pole["misfit"] == pytest.approx(deviation(rotated(Rotation.from_euler("z", 0.3611))), abs=2e-4)
    assert pole["misfit"] > 0.2


def test_no_other_reading_gives_the_printed_year(readings):
    stated, *others = readings.values()
    printed = paper.YEAR["ellipsoid"].a_mean
    assert stated["a_mean"] == pytest.approx(printed, abs=5e-5)
    assert all(abs(reading["a_mean"] - printed) > 3e-4 for reading in others)
