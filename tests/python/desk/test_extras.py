"""Without an optional package whatever needs it says which extra to install, before any work is done."""

import subprocess
import sys

import pytest

SETUP = """
import sys
sys.modules[{missing!r}] = None
import fullbody
from fullbody import observables
from fullbody.cli import main
system, state = fullbody.systems.case1()
run = system.integrate(state, 300.0, output=1.0)
for call in {calls!r}:
    try:
        exec(call)
        print("done")
    except ImportError as error:
        print(error)
"""
TOML = "[system]\nG = 1.0\n[[body]]\nradius = 1.0\nmass = 1.0\n[run]\nuntil = 1.0\n"


def said(missing, calls, folder):
    """What a fresh interpreter without a package prints, a line a call."""
    code = SETUP.format(missing=missing, calls=calls)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=folder)
    # A command prints to standard error and gives its code.
    lines = [line for line in (done.stdout + done.stderr).splitlines() if line != "done" or "main(" not in str(calls)]
    assert len(lines) == len(calls)
    return lines


PICTURES = ["plot()", *(f"plot.{name}()" for name in ("orbit", "elements", "spins", "angles", "energy", "scene"))]


@pytest.mark.parametrize(
    ("missing", "calls", "extra"),
    [
        ("matplotlib", [f"run.{call}" for call in (*PICTURES, "animate('a.gif')")], "plot"),
        ("matplotlib", ["main(['kw4'])", "main(['run', 'a.toml', '--page', 'a.png'])"], "plot"),
        ("scipy", ["run.plot.scene(0.3)", "run.animate('a.gif')", "run.view()"], "plot"),
        ("scipy", ["observables.mutual_period(run)", "observables.orbit_precession(run)"], "analysis"),
        ("xarray", ["run.to_xarray()", "run.save('a.nc')", "main(['kw4'])"], "data"),
        ("h5netcdf", ["run.save('a.nc')", "main(['run', 'a.toml'])"], "data"),
        ("h5py", ["run.save('a.nc')", "fullbody.load('a.nc')", "main(['run', 'a.toml'])"], "data"),
        ("pandas", ["run.to_pandas()"], "data"),
        ("jinja2", ["main(['reproduce'])"], "report"),
        (
            "astropy",
            ["fullbody.systems.kw4(units=True)", "fullbody.System(system.bodies, G=1.0, epoch='2000-01-01 TDB').epoch"],
            "units",
        ),
    ],
)
def test_what_is_missing_is_named_with_its_extra(missing, calls, extra, tmp_path):
    (tmp_path / "a.toml").write_text(TOML)
    for text in said(missing, calls, tmp_path):
        assert f"the package {missing}" in text
        assert f"pip install 'fullbody[{extra}]'" in text
    assert [path.name for path in tmp_path.iterdir()] == ["a.toml"]


def test_the_continuous_solution_needs_no_scipy(tmp_path):
    call = "run = system.integrate(state, 9.0, output=3.0, dense=True); run.plot.scene(7.7); run.view()"
    assert said("scipy", [call], tmp_path) == ["done"]
