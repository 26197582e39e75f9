"""``import fullbody`` is fast: libraries for units, files, pictures and progress come only when they are used."""

import json
import subprocess
import sys
from importlib.metadata import version

import fullbody
import pytest

HEAVY = ("astropy", "xarray", "pandas", "h5netcdf", "matplotlib", "scipy", "tqdm", "PIL", "rebound")


def python(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def test_heavy_libraries_are_not_imported():
    code = "import sys, json, fullbody; print(json.dumps(sorted({name.split('.')[0] for name in sys.modules})))"
    loaded = set(python(code))
    assert "numpy" in loaded
    assert loaded.isdisjoint(HEAVY)


def test_a_plain_run_needs_none_of_them():
    code = (
        "import sys, json, fullbody; system, state = fullbody.systems.case1(); "
        "system.integrate(state, 1.0).elements()._repr_html_(); "
        "print(json.dumps(sorted({name.split('.')[0] for name in sys.modules})))"
    )
    assert set(python(code)).isdisjoint(HEAVY)


def test_import_time():
    """Under 0.2 s beyond numpy; the best of five, since other work on the machine only adds to it."""
    code = (
        "import time, json, numpy; start = time.perf_counter(); import fullbody; "
        "print(json.dumps(time.perf_counter() - start))"
    )
    assert min(python(code) for _ in range(5)) < 0.2


def test_version_is_the_packages():
    assert fullbody.__version__ == version("fullbody")
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        fullbody.nonsense  # noqa: B018
