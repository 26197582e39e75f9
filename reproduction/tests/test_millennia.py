"""Ten thousand years of 1999 KW4: a resumed run has the same bits."""

import json

import fullbody
import pytest

from reproduction.ho2021.millennia import main

#: A step of 0.73 hours and parts of 0.1 years.
OPTIONS = ["--step", "0.73", "--part", "0.1"]


def millennia(folder, years, *more):
    return main(["--out", str(folder), "--years", str(years), *OPTIONS, *more])


def test_a_resumed_run_has_the_same_bits(tmp_path, capsys):
    unbroken, broken = tmp_path / "unbroken", tmp_path / "broken"
    assert millennia(unbroken, 0.3) == 0
    printed = capsys.readouterr().out
    assert millennia(broken, 0.1) == 0
    # As if the process was killed after it had written the samples of the second part, but not yet the simulation.
    (broken / "part-0001.nc").write_bytes((broken / "part-0000.nc").read_bytes())
    assert millennia(broken, 0.3) == 0
    assert (broken / "simulation.sim").read_bytes() == (unbroken / "simulation.sim").read_bytes()
    parts = sorted(path.name for path in unbroken.glob("part-*.nc"))
    assert len(parts) == 3
    runs = [[fullbody.load(folder / name) for name in parts] for folder in (unbroken, broken)]
    assert runs[0] == runs[1]
    # A part ends at the end of a step.
    steps = sum(run.statistics.steps for run in runs[0])
    assert runs[0][-1].time[-1] == pytest.approx(0.73 * steps, rel=1e-14)
    numbers = json.loads((broken / "numbers.json").read_text())
    assert 0 < float(numbers["largest energy error, relative to the orbit's energy"]) < 1e-9
    assert numbers["eccentricity"] in printed


def test_a_run_has_the_given_length_and_continues_in_parts_of_another_length(tmp_path):
    assert millennia(tmp_path, 0.2, "--part", "100") == 0
    assert float(json.loads((tmp_path / "numbers.json").read_text())["years"]) == pytest.approx(0.2, rel=1e-3)
    assert millennia(tmp_path, 0.7, "--part", "0.3") == 0
    times = [fullbody.load(path).time for path in sorted(tmp_path.glob("part-*.nc"))]
    # Samples are at the ends of steps, at equal spacings across the parts.
    steps = [round(time / 0.73) for part in times for time in part]
    assert steps == list(range(0, steps[-1] + 1, steps[1]))
    # A Julian year has 8,766 hours.
    assert steps[-1] * 0.73 / 8766.0 == pytest.approx(0.7, rel=1e-3)


def test_a_run_of_other_settings_in_the_folder_is_refused(tmp_path, capsys):
    assert millennia(tmp_path, 0.1) == 0
    for more in (["--shape", "ellipsoid"], ["--step", "0.5"]):
        assert millennia(tmp_path, 0.3, *more) == 1
        assert "expected" in capsys.readouterr().err


def test_a_negative_number_of_years_is_refused(tmp_path, capsys):
    assert millennia(tmp_path, -1.0) == 1
    assert "--years" in capsys.readouterr().err
