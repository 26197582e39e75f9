"""The linear theory of a synchronous body's attitude, and a small map of Dimorphos'."""

import json
import re

import fullbody
import numpy as np
import pytest
from numpy.linalg import eigvals

from reproduction.agrusa2021 import study, theory
from reproduction.agrusa2021.__main__ import main


@pytest.mark.parametrize(("a_b", "b_c"), [(1.05, 1.02), (1.3, 1.2), (1.2, 1.45)])
def test_frequencies_are_those_of_linearised_equations(a_b, b_c):
    """The frequencies are those of Euler's equations with the torque of a far point, linearised by differences."""
    axes = np.array([a_b * b_c, b_c, 1.0]) * 1e-3
    # A mass of 5 has m/5 = 1 in its moments; the orbit is the heavy point's, which is at the unit distance.
    moments = (axes**2).sum() - axes**2
    body = fullbody.Body(fullbody.Ellipsoid(*axes), mass=5.0, name="moon")
    system = fullbody.System([fullbody.Body(fullbody.PointMass(), mass=1.0, name="point"), body], G=1.0)

    def rates(y):
        """Return the rates of a small rotation from the orbit's frame, and of the spin in the body's frame; n = 1."""
        rotation, spin = y[:3], y[3:]
        state = fullbody.State([[0, 0, 0], [1, 0, 0]], np.zeros((2, 3)))
        size = np.linalg.norm(rotation)
        if size:
            state = state.rotated(1, rotation / size, size)
        frame = state.rotation_matrix[1]
        torque = system.interactions(state).torque[1]
        across = np.cross(spin, moments * spin)
        # To first order, a small rotation changes at the rate of the spin relative to the frame.
        relative = spin - frame.T @ [0.0, 0.0, 1.0]
        return np.concatenate([relative, (torque - across) / moments])

    rest, step = np.array([0.0, 0, 0, 0, 0, 1.0]), 1e-6
    jacobian = np.array([(rates(rest + step * e) - rates(rest - step * e)) / (2 * step) for e in np.eye(6)]).T
    values = eigvals(jacobian)
    result = np.sort(np.abs(values.imag))[::2]
    np.testing.assert_allclose(result, np.sort(theory.frequencies(a_b, b_c)), rtol=2e-5)
    assert np.abs(values.real).max() < 1e-4


def test_libration_and_orbit_are_resonant_at_the_axis_ratio_sqrt_2():
    """The condition 3 (B - A)/C = 1 holds at a/b = sqrt(2), whatever b/c is."""
    libration, *remaining = theory.frequencies(np.sqrt(2.0), np.array([1.1, 1.4]))
    np.testing.assert_allclose(theory.RESONANCES["libration = 1"](libration, *remaining), 0.0, atol=1e-15)


def test_the_impact_adds_momentum_and_angular_momentum():
    system, state = study.setup(3.0, 1.2, 1.1)
    _, previous = study.setup(0.0, 1.2, 1.1)
    change = (state.velocity - previous.velocity)[1]
    assert np.linalg.norm(change) / 3600 * 1e6 == pytest.approx(3 * 535 * 6.6e6 / system.masses[1], rel=1e-12)
    direction = previous.velocity[1] / np.linalg.norm(previous.velocity[1])
    assert np.degrees(np.arcsin(change[2] / np.linalg.norm(change))) == pytest.approx(10.0)
    assert change @ direction == pytest.approx(-np.linalg.norm(change) * np.cos(np.radians(10.0)), rel=1e-9)
    # A circle at that distance takes the stated period, but for the figures.
    assert np.linalg.norm(previous.position[1] - previous.position[0]) == pytest.approx(1.19)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dimorphos")
    assert main(["--draft", "--quiet", "--out", str(folder)]) == 0
    return folder


def test_a_small_map_has_unstable_shapes(report):
    numbers = json.loads((report / "numbers.json").read_text())
    weak, strong = numbers["counts"]["1"], numbers["counts"]["3"]
    assert weak["errors"] == strong["errors"] == 0
    assert max(weak["largest_drift"], strong["largest_drift"]) < 1e-10
    # The stronger impact turns the longest of the four shapes over within ten days.
    assert (weak["near"]["all"]["unstable"], strong["near"]["all"]["unstable"]) == (0.0, 0.25)
    assert strong["near"]["all"]["rolls_over"] == 0.25
    assert strong["near"]["libration = 1"]["shapes"] == 2


def test_the_report_has_its_figure(report):
    text = (report / "report.md").read_text()
    assert "a draft" in text
    assert not re.search(r"\b(nan|inf|None)\b", text)
    assert (report / "map.png").stat().st_size > 10000
