"""The study of Kalliope and Linus: its model, its data, and a draft of its report."""

import json

import numpy as np
import pytest

from reproduction.kalliope import report, study
from reproduction.kalliope.model import AXES, EPOCH, PERIOD, START, A, Light, setup


def test_the_start_is_the_published_circle_about_the_published_pole():
    system, state = setup(**START)
    apart, moving = (np.diff(value, axis=0)[0] for value in (state.position, state.velocity))
    apart, moving = (np.asarray(getattr(value, "value", value)) for value in (apart, moving))
    assert np.linalg.norm(apart) == pytest.approx(A, rel=1e-12)
    assert np.linalg.norm(moving) * PERIOD == pytest.approx(2 * np.pi * A, rel=1e-12)
    normal = np.cross(apart, moving) / np.linalg.norm(np.cross(apart, moving))
    longitude, latitude = np.radians([195.6, 2.2])
    expected = [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)]
    np.testing.assert_allclose(normal, expected, atol=1e-12)
    np.testing.assert_allclose(state.rotation_matrix[0][:, 2], expected, atol=1e-12)
    assert (system["Kalliope"].density / system["Linus"].density).to_value("") == pytest.approx(1.0, rel=1e-12)
    # Kepler's third law for a circle of two points gives 7.36e18 kg (Ferrais et al. 2022: 7.7 +- 0.4).
    assert system.masses.sum().value == pytest.approx(7.36e18, rel=2e-3)
    # The mean radius is that of a body of 154 km (published: 150 +- 5).
    assert 2 * np.cbrt(np.prod(AXES)) == pytest.approx(154.1, abs=0.1)


def test_the_data_are_the_published_magnitudes():
    light = Light()
    data = light.data()
    assert len(data) == 1829
    assert [int(np.sum(light.table["night"] == k)) for k in (1, 2, 3, 4)] == [522, 398, 500, 409]
    assert (data.times[0] - EPOCH).to_value("day") == pytest.approx(2459546.69210264 - 2459547.7, abs=1e-8)
    # The Sun is 2.65 au away: half its angular diameter at 1 au is 959.6 arc seconds.
    distance = np.linalg.norm(light.geometry.to_sun(data.times[0]).to_value("au"))
    assert np.degrees(light.sun_radius) * 3600 == pytest.approx(959.6 / distance, rel=1e-3)


@pytest.mark.filterwarnings("ignore:the fit was stopped")
def test_a_draft_finds_linus_and_its_events(tmp_path):
    path = report.write(tmp_path, draft=True, progress=False)
    numbers = json.loads((tmp_path / "numbers.json").read_text())
    fits = numbers["fits"]
    # Each further part of the model takes most of what the one before left.
    chi2 = [fits[name]["chi2"] for name in study.OTHER]
    assert chi2[0] > 10 * chi2[1] > 30 * chi2[3]
    fit = fits["a series and events, in exact gravity"]
    assert 2 * fit["values"]["radius"] == pytest.approx(28.0, abs=4.0)
    assert list(fit["values"])[5:9] == [f"zero point of {k}" for k in (1, 2, 3, 4)]
    events = numbers["events"]["rows"]
    assert len(events) >= 2
    assert {row[1] for row in events} == {"Kalliope", "Linus"}
    assert all(row[3].startswith("2021-11-") for row in events)
    for name in ("curves", "losses"):
        assert (tmp_path / f"{name}.png").stat().st_size > 2e4
    text = path.read_text()
    assert "| figure | C20 of Kalliope" in text
    assert "another program" not in text
    from astropy.table import QTable

    assert QTable.read(tmp_path / "events.ecsv")["begin"].scale == "utc"
