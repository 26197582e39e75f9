"""Each room uses only those above it, and no files use each other: imports at the top, in functions and for types."""

import ast
from graphlib import TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "python" / "fullbody"
#: In the direction in which data flows; the extension module lies above all of them.
ROOMS = "errors base model frames orbit events record files observables plots view motion peers setups systems commands"


def module(path):
    """The dotted name of a file within the package."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {module(path): path for path in PACKAGE.rglob("*.py")}


def used(path):
    """Modules of the package that a file names in any import."""
    folder = path.relative_to(PACKAGE).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = [*folder[: len(folder) - node.level + 1], *(node.module or "").split(".")]
            for alias in node.names:
                name = ".".join(part for part in (*base, alias.name) if part)
                if not name.startswith("_core"):
                    yield name if name in FILES else name.rpartition(".")[0]


def test_python_rooms_use_only_those_above_them():
    order = [*ROOMS.split(), "", "__main__"]
    for name, path in FILES.items():
        for other in used(path):
            rooms = [order.index(file.partition(".")[0]) for file in (other, name)]
            assert rooms == sorted(rooms), f"{name} uses {other}"


def test_no_python_files_use_each_other():
    graph = {name: set(used(path)) for name, path in FILES.items()}
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(FILES)
