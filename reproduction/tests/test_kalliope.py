"""The study of Kalliope and Linus: its model, its data, and a draft of its report."""

import json

import fullbody
import numpy as np
import pytest

from reproduction.kalliope import interior, report, study
from reproduction.kalliope.freeform import FreeForm
from reproduction.kalliope.model import AXES, EPOCH, PERIOD, START, A, Light, setup


def test_the_start_is_the_published_circle_about_the_published_pole():
    system, state = setup(**START)
    separation, velocity = (np.diff(value, axis=0)[0] for value in (state.position, state.velocity))
    separation, velocity = (np.asarray(getattr(value, "value", value)) for value in (separation, velocity))
    assert np.linalg.norm(separation) == pytest.approx(A, rel=1e-12)
    assert np.linalg.norm(velocity) * PERIOD == pytest.approx(2 * np.pi * A, rel=1e-12)
    normal = np.cross(separation, velocity) / np.linalg.norm(np.cross(separation, velocity))
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
    chi2 = [fits[name]["chi2"] for name in study.INDEPENDENT_CHI2]
    assert chi2[0] > 10 * chi2[1] > 30 * chi2[3]
    fit = fits["a series and events, in exact gravity"]
    assert 2 * fit["values"]["radius"] == pytest.approx(28.0, abs=4.0)
    assert list(fit["values"])[5:9] == [f"zero point of {k}" for k in (1, 2, 3, 4)]
    events = numbers["events"]["rows"]
    assert len(events) >= 2
    assert {row[1] for row in events} == {"Kalliope", "Linus"}
    assert all(row[3].startswith("2021-11-") for row in events)
    assert set(numbers["figure"]["values"]) == set(interior.QUANTITIES)
    assert [core["name"] for core in numbers["cores"]] == ["homogeneous", "a sphere of iron in silicates"]
    # A core of the same mass leaves less of it far from the centre.
    assert abs(numbers["cores"][1]["c20"]) < abs(numbers["cores"][0]["c20"])
    for name in ("curves", "losses", "shape_curves", "shape"):
        assert (tmp_path / f"{name}.png").stat().st_size > 2e4
    text = path.read_text()
    assert "| figure | C20, homogeneous" in text
    assert "another program" not in text
    from astropy.table import QTable

    assert QTable.read(tmp_path / "events.ecsv")["begin"].scale == "utc"


def test_a_free_form_near_the_ellipsoid_has_its_state_and_moments():
    form = FreeForm()
    size, coefficients = form.nearest(AXES)
    values = {**START, "period": PERIOD, "size": size, "coefficients": coefficients}
    system, state = form.setup(**values)
    other, start = setup(**START)
    np.testing.assert_allclose(state.position, start.position, rtol=2e-3, atol=0.2)
    np.testing.assert_allclose(state.rotation_matrix, start.rotation_matrix, atol=2e-3)
    # A series of degree 6 has the volume and the moments of an ellipsoid whose axes differ by 1.7 to two per cent.
    ratio = (system["Kalliope"].density / other["Kalliope"].density).to_value("")
    assert ratio == pytest.approx(1.0, abs=0.03)
    np.testing.assert_allclose(*(np.asarray(pair["Kalliope"].inertia) for pair in (system, other)), rtol=0.03)


def test_a_core_of_iron_reduces_the_oblateness_by_its_share():
    # A homogeneous ellipsoid has C20 = (2 c^2 - a^2 - b^2) / 10 R^2, and a sphere in its middle adds none.
    form = FreeForm(2, 5120)
    zero = form.shape(np.log(120.0 / 75.0), np.zeros(2))
    shape = fullbody.Polyhedron(np.asarray(zero.vertices) / 120.0 * np.array(AXES), zero.faces)
    radius = np.cbrt(np.prod(AXES))
    exact = (2 * AXES[2] ** 2 - AXES[0] ** 2 - AXES[1] ** 2) / 10 / radius**2
    body = fullbody.Body(shape, density=1.0)
    assert interior.oblateness(body, radius) == pytest.approx(exact, rel=5e-3)
    mass = 4.3e12 * body.mass
    core = 40.0
    composite = fullbody.Body(interior.cored(shape, mass, core))
    assert float(composite.mass) == pytest.approx(mass, rel=1e-12)
    iron = 7.87e12 * 4 / 3 * np.pi * core**3
    mantle = (mass - iron) / (body.mass - 4 / 3 * np.pi * core**3)
    share = mantle * body.mass / mass
    assert interior.oblateness(composite, radius) == pytest.approx(share * interior.oblateness(body, radius), rel=1e-9)
