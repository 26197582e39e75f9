"""``import fullbody`` is fast: libraries for units, files, pictures and progress come only when they are used."""

import json
import re
import runpy
import subprocess
import sys
import tomllib
from importlib.metadata import EntryPoint, version
from pathlib import Path

import fullbody
import pytest
from fullbody.commands import cli
from packaging.version import Version

ROOT = Path(__file__).parents[3]

HEAVY = ("astropy", "xarray", "pandas", "h5netcdf", "matplotlib", "scipy", "tqdm", "PIL", "rebound")


def python(code):
    code = f"import json, sys\n{code}"
    return json.loads(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)


def test_heavy_libraries_are_not_imported_by_what_does_without():
    """The submodules that the reference documents, and what the commands use, come when they are asked for."""
    pages = (ROOT / "docs" / "reference").glob("*.md")
    documented = {name for page in pages for name in re.findall(r"auto\w+:: (fullbody\.\w+)$", page.read_text(), re.M)}
    assert {"fullbody.plots", "fullbody.view"} <= documented
    code = f"""
import numpy
before = set(sys.modules)
import fullbody
little = len(set(sys.modules) - before)
lazy = [name for name in ("plots", "view") if "fullbody." + name in sys.modules]
system, state = fullbody.systems.case1()
system.integrate(state, 1.0).elements()._repr_html_()
names = [fullbody.plots.__name__, fullbody.view.__name__]
loaded = sorted({{name.split('.')[0] for name in sys.modules}})
missing = [name for name in {sorted(documented)} if not hasattr(fullbody, name.removeprefix("fullbody."))]
print(json.dumps([little, lazy, names, loaded, missing]))
"""
    little, lazy, names, loaded, missing = python(code)
    # How long it takes is in benches/.
    assert little < 160
    assert lazy == missing == []
    assert names == ["fullbody.plots", "fullbody.view"]
    assert set(loaded).isdisjoint(HEAVY)


def test_version_is_the_packages():
    assert fullbody.__version__ == version("fullbody")
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        fullbody.nonsense  # noqa: B018


def locked(folder):
    """The version of this package in a lock file of Cargo."""
    packages = tomllib.loads((ROOT / folder / "Cargo.lock").read_text())["package"]
    return next(package["version"] for package in packages if package["name"] == "fullbody")


def test_the_version_is_the_same_everywhere():
    versions_by_file = {
        "the package": version("fullbody"),
        "Cargo.lock": locked("."),
        "fuzz/Cargo.lock": locked("fuzz"),
    }
    for file, pattern in runpy.run_path(str(ROOT / "packaging" / "release.py"))["STATED"].items():
        versions_by_file[file] = re.search(pattern, (ROOT / file).read_text(), re.MULTILINE)[1]
    # Cargo writes 0.3.0-dev for Python's 0.3.0.dev0.
    versions = {name: Version(text) for name, text in versions_by_file.items()}
    assert len(set(versions.values())) == 1, versions_by_file
    # A release is the newest entry of the changelog; while the next one is made, its changes stand under Unreleased.
    newest = re.search(r"^## \[(\S+)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)[1]
    this = versions["the package"]
    assert newest == "Unreleased" if this.is_devrelease else Version(newest) == this


def test_the_command_that_is_installed_exists():
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
    assert list(scripts) == ["fullbody"]
    assert EntryPoint("fullbody", scripts["fullbody"], "console_scripts").load() is cli.main
