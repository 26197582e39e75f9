"""The reference has every public name, once."""

import importlib
import inspect
import pkgutil
import runpy
from collections import Counter
from pathlib import Path

import fullbody

NAMES = runpy.run_path(str(Path(__file__).parents[3] / "docs" / "names.py"))
#: Packages whose public names are those of ``fullbody`` or are documented where they are used.
ELSEWHERE = {"base", "commands", "files", "model", "motion", "orbit", "peers", "record", "setups"}


def listed():
    """The objects, parents and attributes that the pages of the reference list."""
    groups = [group for page in NAMES["subjects"]() for group in NAMES["all_groups"](page)]
    for group in groups:
        for name in group.names:
            yield *NAMES["resolved"](group.module, name), name.rpartition(".")[2]


def test_every_public_name_is_in_the_reference():
    documented = [thing for thing, _, _ in listed()]
    packages = {module.name for module in pkgutil.iter_modules(fullbody.__path__) if module.ispkg}
    assert packages > ELSEWHERE
    modules = [importlib.import_module(f"fullbody.{name}") for name in packages - ELSEWHERE]
    for module in (fullbody, fullbody.errors, *modules):
        for name in module.__all__:
            thing = getattr(module, name)
            if not inspect.ismodule(thing) and name != "__version__":
                assert any(thing is other for other in documented), f"the reference lacks {module.__name__}.{name}"


def test_no_name_is_documented_twice():
    counts = Counter((id(parent), name) for _, parent, name in listed())
    assert {name for (_, name), count in counts.items() if count > 1} == set()
