"""Each module or subpackage uses only those above it, and no two files use each other.

Imports at the top of a file, in functions and for type hints count.
"""

import ast
import functools
import re
from graphlib import TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).parents[3] / "python" / "fullbody"
#: Subpackages in the direction in which data flow; the extension module lies above all of them.
SUBPACKAGES = (
    "typing errors base model frames orbit forces events record fields files spice observables observing particles"
    " plots view motion peers setups ensembles analysis fitting loading systems commands"
)


def module(path):
    """The dotted name of a file within the package."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


FILES = {module(path): path for path in PACKAGE.rglob("*.py")}


@functools.cache
def nodes_of(path):
    return list(ast.walk(ast.parse(path.read_text())))


def used(path):
    """Modules of the package that a file names in any import."""
    folder = path.relative_to(PACKAGE).parts[:-1]
    for node in (node for node in nodes_of(path) if isinstance(node, ast.ImportFrom) and node.level):
        base = [*folder[: len(folder) - node.level + 1], *(node.module or "").split(".")]
        for alias in node.names:
            name = ".".join(part for part in (*base, alias.name) if part)
            file = name if name in FILES else name.rpartition(".")[0]
            if not name.startswith("_core"):
                yield file


def test_python_subpackages_use_only_those_above_them():
    order = [*SUBPACKAGES.split(), "", "__main__"]
    for name, path in FILES.items():
        for other in used(path):
            ranks = [order.index(file.partition(".")[0]) for file in (other, name)]
            assert ranks == sorted(ranks), f"{name} uses {other}"


def test_no_python_files_use_each_other():
    graph = {name: set(used(path)) for name, path in FILES.items()}
    assert len(tuple(TopologicalSorter(graph).static_order())) == len(FILES)


#: Private attributes that the package reads from the public classes of bodies, components, shapes, forces, events,
#: integrators and laws.
INWARD = {"_condition", "_core", "_describe", "_event_spec", "_input_warnings", "_layer", "_minimised", "_notes"}
INWARD |= {"_numbers", "_phase", "_radius", "_rebuild", "_summary", "_tolerance", "_unitless", "_with"}
#: Names of Python's own modules.
INWARD |= {"_getframe", "_Pointer", "_replace"}


def test_private_attributes_are_those_of_the_same_file():
    for name, path in FILES.items():
        nodes = nodes_of(path)
        definitions = {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)}
        definitions |= {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
        definitions |= {
            node.attr for node in nodes if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
        }
        read = (node for node in nodes if isinstance(node, ast.Attribute) and re.match("_[^_]", node.attr))
        for node in read:
            within = node.attr in definitions | INWARD or ast.unparse(node.value) in ("self", "cls", "super()")
            assert within, f"{name} reads {ast.unparse(node)}, which another file keeps to itself"


SRC = Path(__file__).parents[3] / "src"
USE = r"(pub(?:\(\w+\))? )?\buse ([^;]+);"


def leaves(tree):
    """The paths of a use declaration: a::{b, c::{d, e}} has a::b, a::c::d and a::c::e."""
    while group := re.search(r"([\w:]*)\{([^{}]*)\}", tree):
        parts = [group[1] + part.strip() for part in group[2].split(",") if part.strip()]
        tree = tree.replace(group[0], ", ".join(parts))
    return [path.split(" as ")[0].strip() for path in tree.split(",")]


@functools.cache
def rust_imports():
    """The files whose names each file of src uses, by module path; re-exports are resolved."""
    text = {
        path.relative_to(SRC).with_suffix("").parts: re.sub(r"//.*", "", path.read_text()) for path in SRC.rglob("*.rs")
    }
    text = {name[:-1] if name[-1] in ("mod", "lib") else name: source for name, source in text.items()}

    def resolve(module, path):
        first, *remainder = path.split("::")
        start = {"crate": (), "self": module, "super": module[:-1]}.get(first)
        if start is None:
            return (*module, first, *remainder) if (*module, first) in text else None
        while remainder and remainder[0] == "super":
            start, remainder = start[:-1], remainder[1:]
        return (*start, *remainder)

    facade = {
        (*module, path[-1]): path
        for module, source in text.items()
        for public, tree in re.findall(USE, source)
        for path in (resolve(module, leaf) for leaf in leaves(tree))
        if public and path
    }
    imports = {}
    for module, source in text.items():
        body = re.sub(USE, "", source)
        paths = re.findall(r"\b(?:crate|super|self)(?:::\w+)+", body)
        # A module's facade imports what it uses itself.
        for public, tree in re.findall(USE, source):
            paths += [leaf for leaf in leaves(tree) if not public or re.search(rf"\b{leaf.split('::')[-1]}\b", body)]
        imports[module] = set()
        for target in filter(None, (resolve(module, path) for path in paths)):
            while target in facade:
                target = facade[target]
            while target not in text:
                target = target[:-1]
            imports[module] |= {target} - {module}
    return imports


def test_rust_modules_use_only_those_above_them():
    imports = rust_imports()
    assert ("mutual", "pair") in imports["mutual", "choice"]
    modules = re.findall(r"^(?:pub )?mod (\w+);", (SRC / "lib.rs").read_text(), re.MULTILINE)
    for module, targets in imports.items():
        up = [target for target in targets if target and modules.index(target[0]) > modules.index(module[0])]
        assert not up, f"{'::'.join(module)} uses {up}, which src/lib.rs lists below it"


def test_no_rust_files_use_each_other():
    # A circle is an error that names its files.
    TopologicalSorter(rust_imports()).prepare()


def test_each_subpackage_has_a_folder_of_tests():
    subpackages = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    folders = {path.parent.name for path in Path(__file__).parents[1].glob("*/test_*.py")}
    assert folders == subpackages | {"package"}


def test_files_that_the_documentation_names_exist():
    root = SRC.parent
    pages = [*root.glob("*.md"), *root.glob("docs/**/*.md"), *root.glob("fuzz/*.md")]
    named = re.compile(r"\b(?:src|python|reproduction|tests|benches|docs|fuzz)/[\w/.-]+\.(?:rs|py|md)\b")
    missing = {(page.name, name) for page in pages for name in named.findall(page.read_text())}
    # NAME stands for what a reader of a recipe adds.
    missing = {(page, name) for page, name in missing if "NAME" not in name and not (root / name).exists()}
    assert not missing, missing
