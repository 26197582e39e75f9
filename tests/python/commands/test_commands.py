"""The commands of the command line."""

import csv
import inspect
import io
import json
import re
import shlex
import subprocess
import sys

import fullbody
import numpy as np
import pytest
from fullbody.commands.cli import build_parser, main
from PIL import Image
from support import forbid
from support.toml_texts import KW4, PAIR


@pytest.fixture
def description(tmp_path):
    path = tmp_path / "kw4.toml"
    path.write_text(KW4.replace('"1 day"', '"6 hour"'))
    return path


def test_run_writes_the_run(description, capsys):
    assert main(["run", str(description)]) == 0
    run = fullbody.load(description.with_suffix(".nc"))
    assert run == fullbody.read_toml(description).run()
    out, err = capsys.readouterr()
    assert "samples" in out
    assert "written to" in out
    assert err == ""


def test_run_takes_another_file_another_end_and_a_page(description, tmp_path, capsys):
    out, page = tmp_path / "other.nc", tmp_path / "page.png"
    command = ["run", str(description), "-o", str(out), "--until", "90 min", "--page", str(page), "--quiet"]
    assert main(command) == 0
    assert np.array_equal(fullbody.load(out).time.value, [0.0, 0.5, 1.0, 1.5])
    assert not description.with_suffix(".nc").exists()
    with Image.open(page) as image:
        assert image.format == "PNG"
        assert image.width > 800
    assert capsys.readouterr() == ("", "")


def test_errors_are_one_line_and_an_exit_code(description, tmp_path, capsys):
    description.write_text(KW4.replace("mass = 0.135e12", "mass = 0"))
    assert main(["run", str(description)]) == 1
    err = capsys.readouterr().err
    assert err.startswith(f"fullbody: {description}: body[1].mass: ")
    assert err.count("\n") == 1
    assert main(["run", str(tmp_path / "nothing.toml")]) == 1
    assert "nothing.toml" in capsys.readouterr().err
    description.write_text(KW4)
    for text, unit in (("soon", ""), ("1_0", ", whose unit '_0' is not known")):
        assert main(["run", str(description), "--until", text]) == 1
        expected = f"--until is {text!r}{unit}; expected numbers, or text with a unit, such as '2.5 h'"
        assert expected in capsys.readouterr().err
    assert main(["run", str(description), "-o", str(tmp_path / "nowhere" / "a.nc")]) == 1
    assert "no folder" in capsys.readouterr().err
    # Before the work, not after it.
    for option, name, message in (
        ("-o", "a.xls", "one of .nc, .nc4, .npz, .csv"),
        ("--page", "a.txt", "one of .png, .pdf, .svg"),
    ):
        assert main(["run", str(description), option, str(tmp_path / name)]) == 1
        assert f"expected a name that ends in {message}" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["kw4.toml"]


def test_a_run_that_a_collision_cuts_short_is_kept(tmp_path, capsys):
    path = tmp_path / "fall.toml"
    path.write_text(PAIR.replace("velocity = [0, 0.6, 0]", "").replace("until = 2.0", "until = 100.0\noutput = 0.5"))
    assert main(["run", str(path)]) == 1
    err = capsys.readouterr().err
    assert "stopped early" in err
    partial = fullbody.load(tmp_path / "fall.partial.nc")
    assert 2 <= len(partial) < 20
    assert not (tmp_path / "fall.nc").exists()


def test_info_of_a_description_and_of_a_run(description, capsys):
    main(["run", str(description), "--quiet"])
    assert main(["info", str(description), str(description.with_suffix(".nc"))]) == 0
    out = capsys.readouterr().out
    description_part, run_part = out.split(str(description.with_suffix(".nc")) + "\nRun")
    assert "Alpha  Ellipsoid  0.766, 0.7475, 0.6735  2.353e+12" in description_part
    assert "until       6 h" in description_part
    assert "samples" in run_part
    assert "0 h to 6 h" in run_part
    assert "gravity            surface" in run_part
    for part, index in ((description_part, 0), (run_part, -1)):
        beta = fullbody.load(description.with_suffix(".nc")).position[index, 1].value
        row = next(line for line in part.split("State at time")[1].splitlines() if line.startswith("  Beta"))
        assert ", ".join(f"{x:.6g}" for x in beta) in row
    a = fullbody.load(description.with_suffix(".nc")).elements().a.value
    assert f"{a.max():.8g}" in run_part


def test_info_shows_the_others_beside_a_bad_file(description, tmp_path, capsys):
    main(["run", str(description), "--quiet"])
    good, bad = description.with_suffix(".nc"), tmp_path / "bad.nc"
    bad.write_text("not NetCDF")
    missing = tmp_path / "missing.toml"
    assert main(["info", str(good), str(bad), str(missing), str(description)]) == 1
    out, err = capsys.readouterr()
    first, second = out.split(f"\n\n{description}\n")
    assert first.startswith(f"{good}\nRun")
    assert "until       6 h" in second
    assert [path in line for path, line in zip((str(bad), str(missing)), err.splitlines(), strict=True)] == [True] * 2
    assert str(bad) not in out


def test_a_path_that_cannot_be_written_is_refused_before_the_run(description, tmp_path, capsys, monkeypatch):
    def work(*_, **__):
        raise AssertionError("ran")

    monkeypatch.setattr(fullbody.System, "integrate", work)
    out = tmp_path / "out.nc"
    out.mkdir()
    assert main(["run", str(description), "-o", str(out)]) == 1
    assert capsys.readouterr().err == f"fullbody: [Errno 21] Is a directory: '{out}'\n"
    out.rmdir()
    forbid(monkeypatch)
    for option, path in (("-o", out), ("--page", tmp_path / "page.png")):
        assert main(["run", str(description), option, str(path)]) == 1
        assert str(tmp_path) in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == [description.name]


def test_the_module_is_a_command():
    done = subprocess.run([sys.executable, "-m", "fullbody", "--help"], capture_output=True, text=True, check=True)
    assert "run" in done.stdout
    assert "info" in done.stdout
    wrong = subprocess.run([sys.executable, "-m", "fullbody", "walk"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2
    assert "invalid choice" in wrong.stderr


def test_kw4_prints_and_writes_both_shapes(tmp_path, capsys):
    assert main(["kw4", "--out", str(tmp_path), "--gravity", "focal", "--until", "210"]) == 0
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
    pages = [f"page_{shape}.{kind}" for shape in read for kind in ("pdf", "png")]
    assert sorted(path.name for path in tmp_path.glob("page_*")) == pages


def test_quiet_commands_print_nothing(tmp_path, capsys):
    assert main(["kw4", "--out", str(tmp_path), "--gravity", "focal", "--until", "8.5 day", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    assert 203.0 < fullbody.load(tmp_path / "kw4_spheroid_focal.nc").time[-1].value <= 204.0


@pytest.mark.parametrize("until", ["-3", "0", "nan", "inf"])
def test_years_are_given_in_hours(until, tmp_path, capsys):
    assert main(["kw4", "--out", str(tmp_path / "kw4"), "--until", until, "--quiet"]) == 1
    assert f"--until is {until}; expected hours above zero" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_info_describes_maps_and_flights(tmp_path, capsys):
    system, state = fullbody.systems.kw4()
    particles = fullbody.Particles([[4.0, 0.0, 0.0]], [[0.0, 0.0, 0.7]])
    system.fly(state, particles, 10.0, output=5.0).save(tmp_path / "flight.nc")

    def setup(angle):
        if angle > 0.15:
            raise ValueError("too far")
        return system, state.rotated("Beta", [0, 0, 1], angle)

    options = {"measure": lambda run: {"place": run.position[-1]}, "store": tmp_path / "map.nc", "key": "places"}
    fullbody.sweep(setup, {"angle": [0.0, 0.1, 0.2]}, 1.0, **options)
    system.integrate(state, 1.0).save(tmp_path / "run.nc")
    assert main(["info", *(str(tmp_path / f"{name}.nc") for name in ("flight", "map", "run"))]) == 0
    flight, output, run = capsys.readouterr().out.split(f"{tmp_path}/")[1:]
    for text in ("particles +1", "flying +1"):
        assert re.search(text, flight)
    for text in ("angle +3 values", "place +angle, place_0, place_1", "ValueError +1", "none +2"):
        assert re.search(text, output)
    assert "Integrator" in run or "steps" in run


def test_info_names_a_file_that_is_no_run(tmp_path, capsys):
    for content, message in ((b"not NetCDF", "is not a readable run of fullbody"), (bytes(800), "map.nc")):
        (tmp_path / "map.nc").write_bytes(content)
        assert main(["info", str(tmp_path / "map.nc")]) == 1
        assert message in capsys.readouterr().err


def test_a_description_is_read_from_standard_input(tmp_path, monkeypatch, capsys):
    text = KW4.replace('"1 day"', '"6 hour"')
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    assert main(["run", "-", "-o", str(tmp_path / "a.npz"), "--quiet"]) == 0
    (tmp_path / "b.toml").write_text(text)
    assert fullbody.load(tmp_path / "a.npz") == fullbody.read_toml(tmp_path / "b.toml").run()
    assert main(["run", "-"]) == 1
    assert capsys.readouterr().err == (
        "fullbody: -o is not given; expected a file to write for a description from standard input\n"
    )
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"[system")))
    assert main(["run", "-", "-o", str(tmp_path / "a.npz")]) == 1
    assert capsys.readouterr().err.startswith("fullbody: standard input: not valid TOML")


def test_a_table_of_a_run_has_columns_with_units_in_the_order_of_a_state(description, tmp_path):
    # Names of bodies in the order of the system, which is not that of the alphabet.
    description.write_text(description.read_text().replace('"Alpha"', '"Primary"'))
    assert main(["run", str(description), "-o", str(tmp_path / "a.csv"), "--quiet"]) == 0
    main(["run", str(description), "--quiet"])
    run = fullbody.load(description.with_suffix(".nc"))
    with (tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["time [h]"]) for row in rows] == run.time.value.tolist()
    assert [float(row["position Beta x [km]"]) for row in rows] == run.position[:, 1, 0].value.tolist()
    assert [float(row["attitude Primary w"]) for row in rows] == run.attitude[:, 0, 0].tolist()
    assert list(rows[0])[:8] == [
        "time [h]",
        *(f"position {n} {x} [km]" for n in ("Primary", "Beta") for x in "xyz"),
        "velocity Primary x [km / h]",
    ]
    quantities = dict.fromkeys(column.split()[0] for column in rows[0])
    assert list(quantities) == ["time", "position", "velocity", "attitude", "spin", "energy", "angular_momentum"]


def accepted(parser, arguments):
    try:
        return parser.parse_args(arguments)
    except SystemExit:
        return None


def test_pictures_of_a_recorded_run(description, tmp_path, capsys):
    main(["run", str(description), "--quiet"])
    saved = description.with_suffix(".nc")
    commands = (
        (["plot", str(saved)], "kw4.png", b"\x89PNG"),
        (["plot", str(saved), "--kind", "orbit", "-o", str(tmp_path / "orbit.pdf")], "orbit.pdf", b"%PDF"),
        (["plot", str(saved), "--kind", "elements", "-o", str(tmp_path / "e.svg")], "e.svg", b"<?xml"),
        (["view", str(saved)], "kw4.html", b"<!"),
        (["animate", str(saved), "--seconds", "1", "--fps", "8"], "kw4.gif", b"GIF8"),
    )
    for command, name, begin in commands:
        assert main(command) == 0
        assert capsys.readouterr().out == f"written to {tmp_path / name}\n"
        assert (tmp_path / name).read_bytes().startswith(begin)
    # Plots that need a geometry are not offered.
    parser = build_parser()
    kinds = {name for name in vars(fullbody.plots.Plots) if not name.startswith("_")}
    offered = {name for name in kinds if accepted(parser, ["plot", "run.nc", "--kind", name])}
    assert kinds - offered == {"delay_doppler", "light_curve", "radar_spectrum", "sky"}
    run = fullbody.load(saved)
    assert all("geometry" in inspect.signature(getattr(run.plot, name)).parameters for name in kinds - offered)
    assert main(["plot", str(saved), "-o", str(tmp_path / "a.gif")]) == 1
    assert "one of .png, .pdf, .svg" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["didymos", "kw4_ho2021", "sn263_2001", "case1"])
def test_the_description_of_a_ready_made_system_runs(name, tmp_path, capsys):
    assert main(["init", name]) == 0
    path = tmp_path / "a.toml"
    path.write_text(capsys.readouterr().out)
    assert path.read_text().startswith("# ")
    assert main(["run", str(path), "--until", "2", "--quiet"]) == 0
    run = fullbody.load(tmp_path / "a.nc")
    assert run.system.context.names == getattr(fullbody.systems, name)()[0].context.names


def test_ready_made_systems_are_listed(capsys):
    assert main(["init"]) == 0
    assert "didymos_after_dart" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["init", "didimos"])


def test_info_as_json(description, tmp_path, capsys):
    main(["run", str(description), "--quiet"])
    assert main(["info", "--json", str(description), str(description.with_suffix(".nc")), str(tmp_path / "no.nc")]) == 1
    out, err = capsys.readouterr()
    assert "no.nc" in err
    toml, run = json.loads(out).values()
    assert toml["Run"]["until"] == "6 h"
    (elements,) = (run[caption] for caption in run if caption.startswith("Kepler elements of Beta about Alpha, "))
    a = fullbody.load(description.with_suffix(".nc")).elements().a.value
    assert float(elements[0]["greatest"]) == pytest.approx(a.max(), rel=1e-7)


def test_a_closed_pipe_ends_quietly():
    code = "import sys; from fullbody.commands.cli import main; sys.exit(main(['init', 'didymos']))"
    command = f"{sys.executable} -c {shlex.quote(code)} | true; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=True)
    assert done.stderr == ""
    assert int(done.stdout) in (0, 141)


def test_completions_know_the_commands(capsys):
    assert main(["completion", "bash"]) == 0
    script = capsys.readouterr().out
    for word in ("animate", "--until", "didymos"):
        assert word in script
