"""The measures of the report, against closed forms and other programs."""

import fullbody
import numpy as np
import pytest

from reproduction.ho2021 import cases, paper, physical, symmetry, years
from reproduction.ho2021.judging import as_printed

DEGREE = np.pi / 180


def test_rounding_follows_the_printed_decimals():
    assert as_printed(0.01256, "0.0126") == "0.0126"
    assert as_printed(17.41149, "17.4116") == "17.4115"
    assert as_printed(3928.5, "3900") == "3928"


def test_rotational_energy_of_case_2_dominates():
    """Case 2 starts with 2 * 1/2 I w^2 of rotation, I = 2/5 m a^2, and the least it can have is nearly that."""
    run, _ = cases.case(2)
    measured = cases.measure(run, cases.fine(run))
    assert measured.rotational_range[0] == pytest.approx(2 * 0.5 * (2 / 5 * 2.0) * 2.0**2, rel=1e-5)
    assert measured.tilt == pytest.approx(np.pi / 32, rel=0.01)


@pytest.mark.parametrize("theta", [np.pi / 16, np.pi / 8])
def test_growth_with_the_tilt_follows_the_sine_of_twice_the_angle(theta):
    assert cases.growth(theta) == pytest.approx(np.sin(2 * theta) / np.sin(np.pi / 16), rel=0.06)


def test_fine_samples_contain_all_peaks():
    """Case 2's spins vary fast: the accepted steps alone miss the largest by a hundredth."""
    run, _ = cases.case(2)
    dense = run.system.integrate(run[0], 200.0, dense=True)
    largest = np.abs(dense(np.linspace(0.0, 200.0, 40001)).spin[..., :2]).max()
    assert cases.measure(run, cases.fine(run)).transverse == pytest.approx(largest, rel=2e-4)
    assert np.abs(run.spin[..., :2]).max() < 0.995 * largest


def test_motion_along_z_by_arithmetic():
    curves, run = symmetry.z_motion(150.0)
    for name in ("compensated", "double"):
        assert 0.0 < curves[name].z.max() < 1e-13
    assert 5e-12 < curves["seeded"].z.max() < 5e-10
    assert np.abs(run.position[:, 0, 2]).max() == curves["compensated"].z.max()


def test_dop853_agrees_with_the_default_integrator():
    """An independent integrator, started off the symmetry, finds the same motion along z."""
    system, state = fullbody.systems.case1()
    state = state.replace(position=np.add(state.position, [[0, 0, 1e-3], [0, 0, -1e-3]]))
    times, z = symmetry.dop853(system, state, 50.0, False)
    run = system.integrate(state, 50.0, output=[50.0])
    assert times[-1] == 50.0
    assert z[-1] == pytest.approx(run.position[0, 0, 2], rel=1e-6)


@pytest.mark.parametrize("inclination", [150.0, 179.0])
def test_the_node_precesses_by_the_quadrupole(inclination):
    """Spin S and orbit L precess about J = S + L at 3/2 (G m_B (C - A)/a^3) cos J/(L S) by the mean quadrupole."""
    (result,) = years.nodal("spheroid", np.array([inclination])).period
    system, _ = fullbody.systems.kw4_ho2021("spheroid")
    m, axes = [b.mass for b in system.bodies], [b.shape.semi_axes for b in system.bodies]
    a, reduced, G = 2.5477, m[0] * m[1] / sum(m), system.G
    # C - A of Alpha; Beta's share is left out, as its own pole turns.
    flattening = m[0] * (axes[0][0] ** 2 - axes[0][2] ** 2) / 5
    orbit = reduced * np.sqrt(G * sum(m) * a)
    spin = 2 / 5 * m[0] * axes[0][0] ** 2 * 2.2728
    normal = np.array([0.0, np.sin(inclination * DEGREE), np.cos(inclination * DEGREE)])
    cosine = np.cos(inclination * DEGREE)
    total = np.linalg.norm(orbit * normal + np.array([0.0, 0.0, spin]))
    rate = 1.5 * G * m[1] * flattening / a**3 * abs(cosine) * total / (orbit * spin)
    assert result == pytest.approx(2 * np.pi / rate, rel=0.06)


def test_physical_states(drafted):
    _, results = drafted
    motions, runs = results.physical, results.runs.physical
    assert motions["relaxed"].libration < 0.5 < motions["nominal"].libration < motions["excited"].libration
    assert motions["excited"].e[1] > paper.EXCITED_E
    assert np.isnan(motions[physical.PAPER].libration)
    # Two starts: the same angles with the orbit in the plane of Beta's equator, and the same orbit with that equator
    # in its plane.
    assert np.abs(motions[physical.ORBIT_IN_EQUATOR].spin[:2]).max() < 0.05
    assert np.abs(motions[physical.EQUATOR_IN_ORBIT].spin[:2]).max() < 0.1
    assert np.array_equal(runs[physical.EQUATOR_IN_ORBIT][0].position, runs[physical.PAPER][0].position)
    # Prograde: Beta's pole stays; retrograde and inclined: it does not.
    assert np.abs(motions["excited"].spin[:2]).max() < 0.2 < 2.0 < np.abs(motions[physical.PAPER].spin[:2]).max()
    # A circular orbit's osculating eccentricity is what the quadrupoles add to the attraction: Alpha's 3/2 J2 (R/r)^2,
    # and 3/2 (B + C - 2A)/(m r^2) of Beta, whose long axis points at Alpha.
    system, _ = fullbody.systems.kw4_ho2021()
    (a, b, c), (p, q, r) = (body.shape.semi_axes for body in system.bodies)
    forced = 1.5 / 5 * (((a * a + b * b) / 2 - c * c) + (2 * p * p - q * q - r * r)) / 2.547**2
    assert np.mean(motions["relaxed"].e) == pytest.approx(forced, rel=0.05)


def test_the_rounded_axes_of_table_2_change_digits_of_the_year(numbers):
    """With them the year differs in digits that the unrounded axes reproduce; the range of the spin is the same."""
    rounded, year = (numbers["year"][run]["ellipsoid"] for run in ("printed_axes", "surface"))
    assert as_printed(rounded["a_min"], "2.5418") != "2.5418" == as_printed(year["a_min"], "2.5418")
    assert rounded["spin_z"] == pytest.approx(year["spin_z"], abs=0.02)


def test_all_methods_give_the_same_spin(numbers):
    ranges = np.array([variant["ranges"] for variant in numbers["variants"]])
    assert len(ranges) == 6
    assert np.ptp(ranges, axis=0).max() < 1e-9
