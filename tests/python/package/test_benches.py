"""Every benchmark can be imported, so that it does not use a name that the package has no more."""

import ast
import importlib
from pathlib import Path

import pytest

BENCHES = sorted((Path(__file__).parents[3] / "benches").glob("*.py"))


@pytest.mark.parametrize("path", BENCHES, ids=lambda path: path.stem)
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
