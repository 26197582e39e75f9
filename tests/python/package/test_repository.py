"""Files beside the package agree with it: the address of the source, versions, licences, and names in benchmarks."""

import ast
import importlib
import re
import runpy
import shutil
import subprocess
import tomllib
from importlib.metadata import EntryPoint, version
from pathlib import Path

import pytest
from fullbody.commands import cli
from packaging.version import Version

ROOT = Path(__file__).parents[3]
SCRIPT = runpy.run_path(str(ROOT / "packaging" / "address.py"))
ADDRESS = "https://example.org/fullbody"


def texts(folder):
    return {name: (folder / name).read_text() for name in SCRIPT["PLACES"]}


def test_the_address_is_written_everywhere_and_removed_again(tmp_path):
    for name in SCRIPT["PLACES"]:
        shutil.copy(ROOT / name, tmp_path / name)
    original, project = texts(tmp_path), tmp_path / "pyproject.toml"
    empty = 'address = ""'
    assert empty in original["pyproject.toml"]
    project.write_text(original["pyproject.toml"].replace(empty, f'address = "{ADDRESS}"'))
    SCRIPT["main"](tmp_path)
    SCRIPT["main"](tmp_path)
    filled = texts(tmp_path)
    assert [text.count(ADDRESS) for text in filled.values()] == [1, 1, 2]
    assert tomllib.loads(filled["pyproject.toml"])["project"]["urls"] == {"Source": ADDRESS}
    assert f'\nrepository-code: "{ADDRESS}"\n' in filled["CITATION.cff"]
    project.write_text(filled["pyproject.toml"].replace(f'address = "{ADDRESS}"', empty))
    SCRIPT["main"](tmp_path)
    assert texts(tmp_path) == original


def test_the_files_show_the_address_of_the_variable(tmp_path):
    for name in SCRIPT["PLACES"]:
        shutil.copy(ROOT / name, tmp_path / name)
    SCRIPT["main"](tmp_path)
    assert texts(tmp_path) == texts(ROOT)


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


@pytest.mark.skipif(shutil.which("cargo") is None, reason="cargo is not installed")
def test_each_crate_of_the_extension_is_listed_with_its_version():
    command = "cargo tree --locked --offline --package fullbody-python --edges normal --prefix none --format {p}"
    tree = subprocess.run(command.split(), cwd=ROOT, capture_output=True, text=True, check=True).stdout
    linked = {tuple(line.split()[:2]) for line in tree.splitlines()}
    text = (ROOT / "packaging" / "THIRD_PARTY_LICENCES.yml").read_text()
    listed = re.findall(r"^- package_name: (\S+)\n  package_version: '?([^\s']+)", text, re.MULTILINE)
    workspace = {crate for crate in linked if crate[0] in ("fullbody", "fullbody-python")}
    assert len(workspace) == 2
    missing = linked - workspace - {(name, f"v{version}") for name, version in listed}
    assert not missing, f"run `make licences`: {sorted(missing)} are not in THIRD_PARTY_LICENCES.yml"


@pytest.mark.parametrize("path", sorted((ROOT / "benches").glob("*.py")), ids=lambda path: path.stem)
def test_the_names_of_the_package_in_a_benchmark_exist(path):
    names = {"fullbody": importlib.import_module("fullbody")}
    tree = ast.parse(path.read_text())
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "fullbody":
            module = importlib.import_module(node.module)
            for alias in node.names:
                if not hasattr(module, alias.name):
                    importlib.import_module(f"{node.module}.{alias.name}")
                names[alias.asname or alias.name] = getattr(module, alias.name)
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            owner = names.get(node.value.id)
            # Attributes of classes and instances may come to be at run time; those of modules are fixed.
            assert not hasattr(owner, "__path__") or hasattr(owner, node.attr), f"{node.value.id}.{node.attr}"
