"""Initial states that reproduce the printed ranges of Beta's spin, found by runs."""

import fullbody
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from reproduction.ho2021 import paper, spin, starts

SYSTEM, STATE = fullbody.systems.kw4_ho2021(gravity="surface")
#: Mean motion of the stated orbit, degrees an hour.
MOTION = np.degrees(np.sqrt(SYSTEM.mu() / 2.548**3))


def six(state):
    """Return Beta's six numbers from a start (3, 2), 1e-5 rad/s, by the surface integrals."""
    run = SYSTEM.integrate(state, 200.0, output=0.02, integrator=fullbody.Verner98(1e-12, 1e-12))
    spin = run.spin[:, 1] * 1e5 / 3600
    return np.stack([spin.min(axis=0), spin.max(axis=0)], axis=1)


def off(state):
    """Return the largest difference from the printed six."""
    return np.abs(six(state) - [paper.SPIN[axis] for axis in "xyz"]).max()


def rotated(rotation):
    """Return the stated start with Beta turned."""
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


def test_beta_rotated_by_half_a_revolution_spins_alike():
    """An ellipsoid is its own image under a half turn about its pole; x and y change their signs."""
    make = spin.FAMILIES["Beta rotated about its own pole by"][3]
    first, second = (six(make(SYSTEM, STATE, angle)) for angle in (-150.0, 30.0))
    assert first[2] == pytest.approx(second[2], abs=1e-9)
    assert first[:2] == pytest.approx(-second[:2, ::-1], abs=1e-9)


def test_starts_ahead_are_the_motion_but_for_beta():
    made = starts.ahead(SYSTEM, STATE, 1.0)
    later = SYSTEM.integrate(STATE, 1.0, output=[1.0])[-1]
    for name in ("position", "velocity", "attitude", "spin"):
        moved, at_first, new = (getattr(state, name) for state in (later, STATE, made))
        kept = 0 if name in ("position", "velocity") else 1
        assert np.array_equal(new[0], moved[0])
        assert np.array_equal(new[1], (moved if kept == 0 else at_first)[1])
    assert made.time == STATE.time
    assert starts.ahead(SYSTEM, STATE, 0.0) == STATE
    alone = starts.ahead(SYSTEM, STATE, 1.0, alpha=False)
    assert np.array_equal(alone.attitude, STATE.attitude)
    assert np.array_equal(alone.position, later.position)


def test_scans_come_closer_near_the_printed_ranges():
    """Half a degree either way of the mean motion's hour the misfit is larger, and no rate of spin comes near."""
    result = spin.scan("Beta rotated about the orbit's normal by", 6)
    misfits = spin.misfit(result.ranges)
    assert result.best[0] == pytest.approx(-MOTION, abs=0.7)
    assert result.best[1] < 0.01 < misfits[np.abs(result.values + MOTION) > 2.0].min()
    assert np.all(np.diff(result.values) > 0)
    none = spin.scan("Beta's rate of spin", 6)
    assert none.best[1] > 0.1
    assert np.isnan(none.near).all()


def test_scans_tell_how_far_the_ranges_are_near():
    low, high = spin.scan("Beta rotated about the orbit's normal by").near
    assert low < -MOTION < high
    for end, sign in ((low, 1), (high, -1)):
        assert off(about_normal(end + sign * 0.02)) < spin.NEAR < off(about_normal(end - sign * 0.02))


def test_an_orientation_gives_all_six_printed_numbers(best):
    result = six(rotated(best))
    assert np.round(result, 2).tolist() == [list(paper.SPIN[axis]) for axis in "xyz"]
    # A turn the other way does not.
    assert off(rotated(best.inv())) > 0.5


def test_rounding_leaves_a_range_of_rotation_angles(numbers, best):
    """The range holds an hour of mean motion and the spin rate taken as an angle; beyond it a number differs."""
    least, largest = sorted(abs(angle) for angle in numbers["search"]["turn"])
    size = np.degrees(best.magnitude())
    assert least < min(MOTION, size, np.degrees(0.3611))
    assert max(MOTION, size, np.degrees(0.3611)) < largest
    assert 0.2 < largest - least < 0.5
    axis = best.as_rotvec() / best.magnitude()
    for angle in (least - 0.3, largest + 0.3):
        assert off(rotated(Rotation.from_rotvec(angle * axis, degrees=True))) > spin.ROUNDING
    normal = np.cross(STATE.position[1], STATE.velocity[1])
    from_normal = np.degrees(np.arccos(-axis @ normal / np.linalg.norm(normal)))
    assert numbers["search"]["minima"][0]["off_normal"] == pytest.approx(from_normal, abs=1e-6)
    assert from_normal < numbers["search"]["off_normal"] < 2.0
    # Against the motion.
    assert numbers["search"]["minima"][0]["turn"] == pytest.approx(-size, abs=1e-9)


def test_rivals_stand_side_by_side(readings):
    rate = np.degrees(0.3611)
    hour = {
        f"about the orbit's normal by an hour of mean motion, {-MOTION:.2f}": about_normal(-MOTION),
        f"its spin rate taken as an angle, 0.3611 rad, {-rate:.2f}": about_normal(-rate),
        "all but Beta's attitude and spin an hour later": starts.ahead(SYSTEM, STATE, 1.0),
        "positions and velocities alone an hour later": starts.ahead(SYSTEM, STATE, 1.0, alpha=False),
    }
    for name, state in hour.items():
        (result,) = (reading for text, reading in readings.items() if name in text)
        assert result["misfit"] == pytest.approx(off(state), abs=2e-4), name
        assert spin.ROUNDING < result["misfit"] < 0.007, name
    (pole,) = (reading for text, reading in readings.items() if "its own pole" in text)
    assert pole["misfit"] == pytest.approx(off(rotated(Rotation.from_euler("z", 0.3611))), abs=2e-4)
    assert pole["misfit"] > 0.2


def test_no_rival_gives_the_printed_year(readings):
    stated, *rivals = readings.values()
    printed = paper.YEAR["ellipsoid"].a_mean
    assert stated["a_mean"] == pytest.approx(printed, abs=5e-5)
    assert all(abs(reading["a_mean"] - printed) > 3e-4 for reading in rivals)
