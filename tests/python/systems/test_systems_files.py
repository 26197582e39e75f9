"""The files of the ready-made systems: what functions, documentation and starts follow from them."""

import doctest
import inspect
import pickle
import subprocess
import sys
import tomllib
from pathlib import Path

import fullbody
import numpy as np
import pytest
from fullbody import systems
from fullbody.setups.elements import start_with_period
from fullbody.systems import _files
from support import DATA
from support.ready_systems import PUBLISHED, TABULATED

pytestmark = pytest.mark.usefixtures("memoised_searches")


def test_completion_offers_what_is_documented():
    functions = set(systems.__all__) - {"Published", "Value", "published"}
    assert functions == {*TABULATED, "kw4_ho2021", "case1", "case2"}
    for name in functions:
        assert callable(getattr(systems, name))
        assert f":func:`{name}`" in systems.__doc__
    for name, doi in [("kw4", "10.1126/science.1133622"), ("kw4", "10.1016/j.icarus.2007.11.007")]:
        assert doi in getattr(systems, name).__doc__


#: Numbers as they are printed in the sources.
PRINTED = tomllib.loads((DATA / "printed_numbers.toml").read_text())


@pytest.mark.parametrize("name", PRINTED)
def test_numbers_of_systems_are_as_published(name):
    facts = systems.published(name)
    assert {what: str(facts.values[what]) for what in PRINTED[name]} == PRINTED[name]


def test_the_search_for_a_mean_period_is_made_once(monkeypatch):
    from fullbody.setups import elements as module

    searches = []
    search = module.start_with_period
    monkeypatch.setattr(module, "start_with_period", lambda *arguments: searches.append(1) or search(*arguments))
    first, again = (fullbody.systems.didymos_after_dart(tilt=0.0123) for _ in range(2))
    assert first == again
    # The masses of the orbit before the impact need none.
    assert len(searches) == 1
    assert fullbody.systems.didymos_after_dart(tilt=0.0124) != first
    assert len(searches) == 2


def test_systems_need_no_scipy_for_their_starts():
    # Where a search for the mean period would need it, the file has what the search found.
    code = (
        "import sys; sys.modules.update(scipy=None, astropy=None); import fullbody\n"
        f"for name in {[name for name in PUBLISHED if name not in ('haumea', 'lempo', 'sn263_2001')]}:\n"
        "    getattr(fullbody.systems, name)()"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        *(("kw4", {"shape": "ellipsoid"}), ("kw4", {"shape": "radar"}), ("didymos", {"model": "daly2023"})),
        *(("didymos_after_dart", {"model": model}) for model in ("daly2023", "naidu2024")),
        *((name, {}) for name in ("antiope", "didymos", "didymos_after_dart", "dinkinesh", "dp107_2000")),
        *((name, {}) for name in ("kalliope_linus", "vh_1991", "patroclus_menoetius")),
    ],
)
def test_starts_of_the_files_are_those_of_the_search(name, options, monkeypatch):
    _, stored = getattr(systems, name)(**options)
    result = []

    def search(system, period, start, locked):
        result.append(start_with_period(system, period, start, locked))
        return result[0]

    monkeypatch.setattr("fullbody.setups.elements.start_with_period", search)
    contents = _files.contents(name)
    variants = contents.get("variants", {})
    content = _files.changed(contents, options.get(variants.get("option"), variants.get("default")), {})
    content["binary"].pop("start_period")
    monkeypatch.setattr("fullbody.systems._files.changed", lambda *_: content)
    _, searched = getattr(systems, name)(**options)
    assert len(result) == 1
    for part in ("position", "velocity", "spin"):
        expected = getattr(searched, part)
        np.testing.assert_allclose(getattr(stored, part), expected, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("name", [*TABULATED, "kw4_ho2021", "case1", "case2"])
def test_examples_of_the_documentation_run(name):
    parser, runner = doctest.DocTestParser(), doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    example = parser.get_doctest(getattr(systems, name).__doc__, {}, name, None, 0)
    assert example.examples
    runner.run(example)
    assert runner.summarize(verbose=False).failed == 0


def test_functions_follow_from_the_files():
    assert " ".join(inspect.signature(systems.didymos_after_dart).parameters) == "model tilt frame sun units options"
    assert inspect.signature(systems.case2).parameters["theta_0"].default == np.pi / 32
    assert pickle.loads(pickle.dumps(systems.didymos)) is systems.didymos
    assert systems.didymos.__name__ == "didymos"
    assert set(_files.names()) == set(systems.__all__) - {"Published", "Value", "published"}
    with pytest.raises(AttributeError, match="no attribute 'vulcan'"):
        _ = systems.vulcan


@pytest.mark.parametrize("name", _files.names())
def test_files_are_read_as_those_of_users_are(name, tmp_path):
    path = tmp_path / "mine.toml"
    content = _files.contents(name)
    path.write_text((Path(systems.__file__).parent / f"{name}.toml").read_text())
    mine = fullbody.read_toml(path)
    frame = {"frame": content["system"]["frame"]} if "frame" in content["system"] else {}
    units = {"units": True} if "units" in content["system"] else {}
    system, state = getattr(systems, name)(**frame, **units)
    assert mine.system.names == system.names
    for part in ("position", "velocity", "spin"):
        ours, expected = (np.asarray(getattr(item, part)) for item in (mine.state, state))
        np.testing.assert_allclose(ours, expected, atol=1e-11 * np.abs(expected).max())
    np.testing.assert_allclose(mine.system.masses, system.masses, rtol=1e-12)
