"""The study of Hertha: its data, its model, and a draft of its report."""

import json

import astropy.units as u
import numpy as np
import pytest
from fullbody.frames import pole_angles

from reproduction.hertha import report, study
from reproduction.hertha.model import Curves, setup


def test_the_data_are_the_magnitudes_of_the_file():
    curves = Curves()
    # The file has 32 curves of 1,285 magnitudes, of which the last two are those of surveys.
    assert len(curves.nights) == 923
    assert len(curves.surveys) == 246 + 116
    assert len(curves.nights.nights) == 30
    assert curves.nights.times[0].jd == pytest.approx(2443845.852388, abs=1e-6)
    # The first intensity of the file is 1.062183.
    assert curves.nights.magnitude[0] == pytest.approx(-2.5 * np.log10(1.062183), abs=1e-9)
    earth = curves.nights.geometry.to_observer(curves.nights.times[0]).to_value("au")
    np.testing.assert_allclose(earth, [-0.00167816, -1.63941666, -0.10302199], atol=1e-8)


def test_the_apparition_with_the_most_magnitudes_is_that_of_1985():
    times = Curves().apparition().times
    assert times[0].utc.strftime("%Y") == "1985"
    assert np.ptp(times.jd) < 120.0


def test_the_body_rotates_about_the_pole_that_is_given():
    _, state = setup(272 * u.deg, 52 * u.deg, 8.4 * u.h, np.zeros(8))
    spin = state.rotation_matrix[0] @ state.spin[0].value
    np.testing.assert_allclose(pole_angles(spin), np.radians([272.0, 52.0]), rtol=1e-12)


@pytest.mark.filterwarnings("ignore:the fit was stopped")
def test_a_draft_finds_the_period_and_the_pole(tmp_path):
    path = report.write(tmp_path, draft=True, progress=False)
    numbers = json.loads((tmp_path / "numbers.json").read_text())
    minima = numbers["fits"][study.BEST]["minima"]
    assert minima[0]["period"] == pytest.approx(8.4006, abs=1e-4)
    poles = [(minimum["longitude"], minimum["latitude"]) for minimum in minima]
    assert min(study.angle_between(pole, study.TORPPA_POLES[0]) for pole in poles) < 20.0
    sizes = numbers["sizes"]
    assert set(sizes) >= {f"shape from light, {pole}" for pole in study.POLES[: len(minima)]}
    for name, size in sizes.items():
        assert 60.0 < size["diameter"] < 100.0
        # Of 36 contacts, two numbers are for the offset, one for the diameter, and one for an angle or a ratio of axes.
        assert size["dof"] == 36 - 3 - ("free" in name) - ("ellipsoid" in name)
    for name in ("scans", "curves", "shape", "chords"):
        assert (tmp_path / f"{name}.png").stat().st_size > 2e4
    assert "## Verdicts" in path.read_text()
