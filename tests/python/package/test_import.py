"""``import fullbody`` is fast: libraries for units, files, pictures and progress come only when they are used."""

import json
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import fullbody
import pytest

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
