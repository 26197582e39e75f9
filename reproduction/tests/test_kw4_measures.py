"""Measures of the year of 1999 KW4 against closed forms, and its table beside the paper."""

import json

import fullbody
import numpy as np
import pytest

from reproduction.ho2021 import kw4, kw4_year, paper


def test_slow_maxima_of_a_rippled_cosine():
    hours = np.arange(0.0, 9000.0, 0.2)
    values = np.cos(2 * np.pi * (hours - 300.0) / 4000.0) + 0.01 * np.cos(2 * np.pi * hours / 8.7)
    assert kw4.slow_maxima(hours, values) == pytest.approx([300.0, 4300.0, 8300.0], abs=5.0)
    assert kw4.between_maxima(hours, values) == pytest.approx(4000.0, abs=5.0)
    assert np.isnan(kw4.between_maxima(hours[:1000], values[:1000]))


def test_inclination_to_the_first_plane_of_a_point_orbit_is_zero():
    system, state = fullbody.systems.kw4_ho2021(gravity="point")
    run = system.integrate(state, 100.0, output=1.0)
    assert kw4.inclination_to_first(run).max() < 1e-9


def test_momentum_of_samples_is_that_of_the_states():
    system, state = fullbody.systems.kw4_ho2021(units=True)
    run = system.integrate(state, 100.0, output=10.0)
    expected = [system.angular_momentum(at).value for at in run]
    assert kw4.momentum_of_samples(run) == pytest.approx(np.array(expected), rel=1e-13)
    assert run.angular_momentum.value == pytest.approx(np.array(expected), rel=1e-13)


def test_the_docstring_of_the_system_quotes_the_paper():
    text = fullbody.systems.kw4_ho2021.__doc__
    for shape in paper.YEAR.values():
        assert f"{shape.period:.4f}" in text
        assert f"{shape.inclination_period:.0f}" in text
    for value in (*paper.SPIN["z"], -paper.SPIN["x"][0], paper.SPIN["y"][1]):
        assert f"{value:.2f}" in text


def test_a_short_year_has_numbers_of_valid_json(tmp_path, capsys):
    assert kw4_year.main(["--out", str(tmp_path), "--gravity", "focal", "--until", "12.5 day"]) == 0
    read = json.loads((tmp_path / "numbers.json").read_text(), parse_constant=lambda name: pytest.fail(name))
    assert read["spheroid"]["focal"]["inclination_period"] is None
    printed = capsys.readouterr().out
    assert "nan" not in printed
    assert "300 hours; the paper's numbers are of 8766 hours" in printed
    assert kw4_year.main(["--out", str(tmp_path), "--until", "-3"]) == 1
    assert capsys.readouterr().err == "reproduction: --until is -3; expected hours above zero\n"
