"""``fullbody kw4``: its numbers and its files."""

import json

import fullbody
import pytest
from fullbody.commands.cli import main


def test_kw4_prints_and_writes_both_shapes(tmp_path, capsys):
    assert main(["kw4", "--out", str(tmp_path), "--gravity", "focal", "--until", "210", "--quiet"]) == 0
    read = json.loads((tmp_path / "numbers.json").read_text(), parse_constant=lambda name: pytest.fail(name))
    assert {shape: list(methods) for shape, methods in read.items()} == {"ellipsoid": ["focal"], "spheroid": ["focal"]}
    # Beta's spin about z in the first 200 h, 1e-5 rad/s, by two independent programs.
    ellipsoid = read["ellipsoid"]["focal"]
    assert [round(value, 2) for value in ellipsoid["spin_z"]] == [9.05, 10.69]
    printed = capsys.readouterr().out
    assert "1999 KW4, spheroids, 210 hours" in printed
    assert f"{ellipsoid['a_mean']:.6g}" in printed
    for shape in read:
        saved = fullbody.load(tmp_path / f"kw4_{shape}_focal.nc")
        assert 205.0 < saved.time[-1].value <= 210.0
        assert ellipsoid["a_min"] < saved.elements().a.value.min() or shape == "spheroid"
    assert sorted(path.name for path in tmp_path.glob("page_*")) == [
        f"page_{shape}.{kind}" for shape in read for kind in ("pdf", "png")
    ]


@pytest.mark.parametrize("until", ["-3", "0", "nan", "inf"])
def test_years_are_given_in_hours(until, tmp_path, capsys):
    assert main(["kw4", "--out", str(tmp_path / "kw4"), "--until", until, "--quiet"]) == 1
    assert f"--until is {until}; expected hours above zero" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
