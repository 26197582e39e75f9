"""Without an optional package, functions that need it name what to install before any work is done."""

import re
import subprocess
import sys
import tomllib
from itertools import chain
from pathlib import Path

import fullbody
import nbclient
import nbformat

ROOT = Path(__file__).parents[3]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]

#: Each case is told in a process of its own, a copy of one that has imported nothing but numpy.
SETUP = """
import os, sys
import numpy
os.dup2(1, 2)
for missing, calls in {cases!r}:
    if child := os.fork():
        os.waitpid(child, 0)
        continue
    sys.modules[missing] = None
    import fullbody
    from fullbody import observables
    from fullbody.base import version
    from fullbody.commands.cli import main
    version.PUBLISHED = {published}
    system, state = fullbody.systems.case1()
    run = system.integrate(state, 300.0, output=1.0)
    print("case")
    for call in calls:
        try:
            exec(call)
            if "main(" not in call:
                print("done")
        except ImportError as error:
            print(error)
    os._exit(0)
"""
INWARD = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
TOML = "[system]\nG = 1.0\n[[body]]\nradius = 1.0\nmass = 1.0\n[run]\nuntil = 1.0\n"


def messages(cases, folder, published=True):
    """What is printed without a package, a line a call, for each case; commands print errors themselves."""
    code = SETUP.format(cases=cases, published=published)
    command = [sys.executable, "-u", "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=folder)
    lines = [part.splitlines() for part in done.stdout.split("case\n")[1:]]
    assert [len(lines) for lines in lines] == [len(calls) for _, calls in cases], done.stdout
    return lines


NAMES = ("orbit", "elements", "spins", "angles", "libration", "energy", "scene")
SWEEP = "fullbody.sweep(lambda x: 1 / 0, {{'x': [1]}}, 1.0, measure=print, {})"
PICTURES = ["plot()", *(f"plot.{name}()" for name in NAMES)]


#: Calls that need a package, by this package and by the extra that has it.
CASES = {
    "matplotlib": {
        "plot": [
            *(f"run.{call}" for call in (*PICTURES, "animate('a.gif')")),
            *("main(['kw4'])", "main(['run', 'a.toml', '--page', 'a.png'])"),
        ]
    },
    "scipy": {
        "plot": ["run.plot.scene(0.3)", "run.animate('a.gif')", "run.view()"],
        "analysis": [
            *("observables.mutual_period(run)", "observables.orbit_precession(run)"),
            *(
                "fullbody.systems.didymos(gravity='multipole:4')",
                "fullbody.systems.fg3_1996(primary_ratios=(1.1, 1.0))",
            ),
        ],
        "fit": ["fullbody.fit(print, {'x': 1.0}, [])"],
    },
    "xarray": {"data": ["run.to_xarray()", "run.save('a.nc')", "main(['kw4'])", SWEEP.format("")]},
    "h5netcdf": {"data": ["run.save('a.nc')", "main(['run', 'a.toml'])", SWEEP.format("store='a.nc', key='a'")]},
    "h5py": {"data": ["run.save('a.nc')", "fullbody.load('a.toml')", "main(['run', 'a.toml'])"]},
    "emcee": {"fit": ["from fullbody.fitting.uncertainty import sample; sample(None, rng=0)"]},
    "cloudpickle": {"data": [SWEEP.format("executor=type('Pool', (), {'submit': print})()")]},
    "pandas": {"data": ["run.to_pandas()"]},
    "spiceypy": {"spice": ["run.to_spk('a.bsp', {}, 1)", "run.to_ck('a.bc', {})"]},
    "astropy": {
        "units": [
            "fullbody.systems.kw4(units=True)",
            "fullbody.System(system.bodies, G=1.0, epoch='2000-01-01 TDB').epoch",
            "system.integrate(state, '1 day')",
            "fullbody.Sphere('1 km')",
            "fullbody.frames.rotation('ecliptic', 'galactic')",
            "fullbody.frames.rotate([1, 2, 3], 'ecliptic', 'galactic')",
            "fullbody.frames.rotate_pole(1, 0.5, 'ecliptic', 'galactic')",
            "fullbody.frames.rotate_state(state, 'ecliptic', 'galactic')",
            "fullbody.KeplerElements(1, 0, 0, 0, 0, 0, frame='ecliptic').to_frame(target='galactic')",
        ]
    },
    "networkx": {"shapes": ["fullbody.Polyhedron.load('a.tab', heal=True)"]},
}


def test_what_is_missing_is_named_with_its_extra(tmp_path):
    (tmp_path / "a.toml").write_text(TOML)
    (tmp_path / "a.tab").write_text(INWARD)
    expected = [[extra for extra, calls in case.items() for _ in calls] for case in CASES.values()]
    printed = messages([(missing, [*chain(*case.values())]) for missing, case in CASES.items()], tmp_path)
    for missing, extras, lines in zip(CASES, expected, printed, strict=True):
        for extra, text in zip(extras, lines, strict=True):
            assert f"the package {missing}" in text
            assert f"pip install 'fullbody[{extra}]'" in text
    assert {path.name for path in tmp_path.iterdir()} == {"a.toml", "a.tab"}


def test_before_the_package_is_published_the_missing_packages_are_named(tmp_path):
    ((text,),) = messages([("matplotlib", ["run.plot()"])], tmp_path, published=False)
    assert text == "a picture needs the package matplotlib: pip install matplotlib"


def test_rebound_is_in_no_extra_and_the_continuous_solution_needs_no_scipy(tmp_path):
    dense = "run = system.integrate(state, 9.0, output=3.0, dense=True); run.plot.scene(7.7); run.view()"
    (text,), drawn = messages([("rebound", ["fullbody.to_rebound(system, state)"]), ("scipy", [dense])], tmp_path)
    assert text == "a simulation of rebound needs the package rebound: pip install rebound"
    assert drawn == ["done"]


def test_the_error_of_a_missing_package_has_one_traceback(tmp_path):
    code = "import sys; sys.modules['astropy'] = None; import fullbody; fullbody.Sphere('1 km')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert done.stderr.count("Traceback") == 1
    assert done.stderr.splitlines()[-1].endswith("text with a unit needs the package astropy: pip install astropy")


def test_all_has_every_extra_for_users():
    (requirement,) = EXTRAS["all"]
    assert {*requirement.removeprefix("fullbody[").rstrip("]").split(",")} == {*EXTRAS} - {"all", "test", "docs", "dev"}
    assert any(needed.startswith("ipywidgets") for needed in EXTRAS["notebook"])


def test_the_page_of_the_installation_names_the_extras():
    installing = (ROOT / "docs" / "install.md").read_text().partition("\n## ")[0]
    lines = dict(re.findall(r"^\| `(\w+)` \| ([\w, ]+) \| ", installing, re.M))
    expected = {
        name: ", ".join(re.split(r"\W", package)[0] for package in packages)
        for name, packages in EXTRAS.items()
        if name not in ("all", "test", "docs", "dev")
    }
    assert lines == expected


def test_the_readmes_snippets_run_with_what_they_say(tmp_path):
    snippets = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    bare = ("astropy", "xarray", "h5netcdf", "h5py", "pandas", "matplotlib", "scipy", "jinja2", "ipywidgets")
    for snippet, missing in zip(snippets, (bare, bare[5:]), strict=True):
        code = f"import sys\nsys.modules.update(dict.fromkeys({missing!r}))\n{snippet}"
        subprocess.run([sys.executable, "-W", "error", "-c", code], check=True, cwd=tmp_path, capture_output=True)
    assert len(fullbody.load(tmp_path / "run.nc")) == 721


def test_a_progress_bar_in_jupyter_warns_of_nothing():
    source = "import fullbody; run = fullbody.Simulation(*fullbody.systems.case1()).integrate(10.0, progress=True)"
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(source)])
    nbclient.NotebookClient(notebook, kernel_name="python3", timeout=120).execute()
    outputs = notebook.cells[0].outputs
    assert outputs
    assert "arning" not in "".join(output.get("text", "") for output in outputs)
