"""Initial states of rotational fission, and a small map of their fates."""

import json
import re

import fullbody
import numpy as np
import pytest
from fullbody.errors import BodiesOverlap
from scipy.spatial.distance import cdist

from reproduction.ho2022 import paper, study
from reproduction.ho2022.__main__ import main
from reproduction.ho2022.starts import CASES, DENSITY, PRIMARY, centre_distance, fission, spin_limit


def test_the_distance_of_centres_is_the_sum_of_the_gap_and_of_the_semi_axes_in_line():
    second = (0.5, 0.4, 0.3)
    assert centre_distance(PRIMARY, second, 0.0, 0.01) == pytest.approx(1.0 + 0.5 + 0.01, abs=1e-12)
    assert centre_distance(PRIMARY, second, np.pi / 2, 0.01) == pytest.approx(1.0 + 0.3 + 0.01, abs=1e-12)


def test_the_gap_to_a_tilted_body_is_the_least_distance_of_the_surfaces():
    """The least distance is that of many points of both surfaces, also off the plane y = 0."""
    second, tilt, gap = (0.5, 0.4, 0.3), 0.7, 0.05
    distance = centre_distance(PRIMARY, second, tilt, gap)
    u, v = np.meshgrid(np.linspace(0.0, np.pi, 91), np.linspace(-0.5, 0.5, 41))
    points = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1).reshape(-1, 3)
    rotation = np.array([[np.cos(tilt), 0, np.sin(tilt)], [0, 1, 0], [-np.sin(tilt), 0, np.cos(tilt)]])
    facing = points * [-1, 1, 1] * second @ rotation.T + [distance, 0, 0]
    result = cdist(points * PRIMARY, facing).min()
    assert gap <= result < gap + 2e-3


@pytest.mark.parametrize("case", CASES)
def test_a_start_has_the_fission_rate_and_the_gap(case):
    system, state = fission(case, 0.2, 30.0)
    first, second = system.masses
    assert second / first == pytest.approx(0.2, rel=1e-14)
    assert first == pytest.approx(4 / 3 * np.pi * 0.7 * 0.65 * 2e12, rel=1e-14)
    # Both bodies rotate about z at one rate, in the inertial frame, and the total momentum is zero.
    spins = np.einsum("nij,nj->ni", state.rotation_matrix, state.spin)
    np.testing.assert_allclose(spins, [[0, 0, spins[0, 2]]] * 2, atol=1e-15)
    np.testing.assert_allclose(state.velocity, np.cross(spins, state.position), rtol=1e-14)
    assert np.abs(system.masses @ state.velocity).max() < 1e-12 * first
    # Along the line of the centres, the attraction is the centripetal force.
    pull = system.interactions(state).force[1, 0]
    assert pull == pytest.approx(-second * spins[0, 2] ** 2 * state.position[1, 0], rel=1e-13)
    # The gap is 1 cm along the common normal, which is not far from the line of the centres.
    for closer, overlap in ((0.99e-5, False), (1.2e-5, True)):
        closer_state = state.replace(position=state.position - [[0, 0, 0], [closer, 0, 0]])
        try:
            system.interactions(closer_state)
            assert not overlap
        except BodiesOverlap:
            assert overlap


def test_the_spin_limit_of_a_sphere_is_the_closed_form_and_that_of_an_elongated_body_lower():
    """The square of the limit is 4/3 pi G rho; that of an elongated body is lower."""
    limit = np.sqrt(4 / 3 * np.pi * paper.G * DENSITY)
    assert spin_limit((1.0, 1.0, 1.0), DENSITY) == pytest.approx(limit, rel=1e-14)
    assert spin_limit((1.0, 0.5, 0.5), DENSITY) < limit


def test_the_spin_limit_of_an_ellipsoid_balances_the_attraction_at_its_tip():
    """The attraction is the force that the package computes on a point mass at the end of the long axis."""
    axes, density = (0.5, 0.4, 0.3), 2e12
    body = fullbody.Body(fullbody.Ellipsoid(*axes), density=density)
    particle = fullbody.Body(fullbody.PointMass(), mass=1.0)
    state = fullbody.State([[0, 0, 0], [0.5 * (1 + 1e-9), 0, 0]], np.zeros((2, 3)))
    pull = fullbody.System([body, particle], G=paper.G).interactions(state).force[1, 0]
    assert spin_limit(axes, density) ** 2 * 0.5 == pytest.approx(-pull, rel=1e-7)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fission")
    assert main(["--draft", "--quiet", "--out", str(folder)]) == 0
    return folder


def test_a_small_map_counts_all_fates(report):
    numbers = json.loads((report / "numbers.json").read_text())
    for part in numbers["counts"].values():
        for entry in part.values():
            assert entry["impact"] + entry["escape"] + entry["bound"] == pytest.approx(1.0)
            assert entry["errors"] == 0.0
            assert entry["largest_drift"] < 1e-9
    # At the fission limit (excess 0) the aligned starts, a third of all, stay aligned and apart; all others collide.
    assert numbers["counts"]["0"]["all"]["impact"] == pytest.approx(2 / 3)
    assert numbers["counts"]["0.01"]["all"]["impact"] < numbers["counts"]["0"]["all"]["impact"]
    assert {row["verdict"] for row in numbers["verdicts"]} <= {"holds", "differs", "open"}


def test_the_report_has_its_figures_and_no_missing_numbers(report):
    text = (report / "report.md").read_text()
    assert "a draft" in text
    assert not re.search(r"\b(nan|inf|None)\b", text)
    for name in re.findall(r"\]\((\S+\.png)\)", text):
        assert (report / name).stat().st_size > 10000
    names = ["fates-0.png", "fates-1.png", "fission.png", "map.nc", "numbers.json", "report.md"]
    assert sorted(path.name for path in report.iterdir()) == names


def test_the_full_grid_has_as_many_starts_as_the_paper():
    grid = study.GRID
    assert len(grid["case"]) * len(grid["mass_ratio"]) * len(grid["tilt"]) == 9990
