"""The address of the source is one variable, and is shown nowhere while it is empty."""

import runpy
import shutil
import tomllib
from pathlib import Path

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
