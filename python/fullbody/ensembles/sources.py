"""Descriptions of options and functions as texts, by which a store distinguishes sweeps."""

from __future__ import annotations

import ast
import dataclasses
import functools
import importlib
import inspect
import re
import sys
import textwrap
import types
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..base.units import is_quantity


def described(things: Mapping[str, Any]) -> dict[str, str]:
    """Return the texts of values by their names, and the sources of the user's functions that these name."""
    texts = {name: _text(thing) for name, thing in things.items()}
    visited: set[int] = set()
    for name, thing in things.items():
        for part in _parts(thing):
            _add(name, _definition(part), texts, visited)
    return texts


def _text(value: Any) -> str:
    """Return a text of a value that is the same in every process, without the content of functions."""
    if is_quantity(value):
        return f"{_text(value.value)} {value.unit}"
    if isinstance(value, np.ndarray | np.generic):
        return repr(value.tolist())
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_text, value))}]"
    if isinstance(value, set | frozenset):
        # The order of a set is another one in each process.
        return f"{{{', '.join(sorted(map(_text, value)))}}}"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_text(name)}: {_text(part)}' for name, part in value.items())}}}"
    if isinstance(value, functools.partial):
        named = [f"{name}={_text(part)}" for name, part in value.keywords.items()]
        return f"partial({', '.join([_text(value.func), *map(_text, value.args), *named])})"
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        named = [f"{part.name}={_text(getattr(value, part.name))}" for part in dataclasses.fields(value)]
        return f"{type(value).__name__}({', '.join(named)})"
    if isinstance(value, types.FunctionType | types.MethodType | type):
        return value.__qualname__ if _is_users(value.__module__) else f"{value.__module__}.{value.__qualname__}"
    # An object without a repr of its own is shown with its address, which is another one in each process.
    return re.sub(r" at 0x[0-9a-fA-F]+", "", repr(value))


def _parts(value: Any) -> Iterator[Any]:
    """Yield a value and the values that it is composed of."""
    yield value
    inner: list[Any] = []
    if isinstance(value, functools.partial):
        inner = [value.func, *value.args, *value.keywords.values()]
    elif isinstance(value, list | tuple | set | frozenset):
        inner = list(value)
    elif isinstance(value, Mapping):
        inner = list(value.values())
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        inner = [getattr(value, part.name) for part in dataclasses.fields(value)]
    for part in inner:
        yield from _parts(part)


def _definition(thing: Any) -> Any:
    """Return the function or class that determines the behaviour of an object."""
    while isinstance(thing, functools.partial):
        thing = thing.func
    thing = inspect.unwrap(thing) if callable(thing) else thing
    if isinstance(thing, types.MethodType):
        thing = thing.__self__
    return thing if isinstance(thing, types.FunctionType | type) else type(thing)


def _add(name: str, thing: Any, texts: dict[str, str], visited: set[int]) -> None:
    """Add the source of a function or class of the user, and of those that it names."""
    if id(thing) in visited or not _is_users(thing.__module__):
        return
    visited.add(id(thing))
    try:
        source = _source(thing)
    except (OSError, TypeError):
        # A function that was compiled or made by exec has no source.
        return
    scope = dict(vars(sys.modules.get(thing.__module__, types)) if isinstance(thing, type) else thing.__globals__)
    if isinstance(thing, types.FunctionType):
        for variable, cell in zip(thing.__code__.co_freevars, thing.__closure__ or (), strict=True):
            with suppress(ValueError):  # The variable has no value yet.
                scope[variable] = value = cell.cell_contents
                if isinstance(value, str | int | float | np.ndarray | np.generic) or is_quantity(value):
                    source += f"\n{variable} = {_text(value)}"
    texts[name] = f"{texts[name]}\n{source}" if name in texts else source
    words = sorted(set(re.findall(r"\w+", source)))
    modules = [scope[word] for word in words if isinstance(scope.get(word), types.ModuleType)]
    for module in re.findall(r"^\s+(?:from|import) +([\w.]+)", source, re.MULTILINE):
        with suppress(ImportError):
            modules.append(importlib.import_module(module, scope.get("__package__")))
    for module in modules:
        if _is_users(module.__name__):
            scope |= {word: getattr(module, word) for word in words if hasattr(module, word)}
    for word in words:
        _add(f"source of {word}", _definition(scope.get(word)), texts, visited)


def _source(thing: Any) -> str:
    source = textwrap.dedent(inspect.getsource(thing))
    # A lambda in a call over several lines is no statement; its lines are taken as they are.
    with suppress(SyntaxError):
        tree = ast.parse(source)
        lambdas = [node for node in ast.walk(tree) if isinstance(node, ast.Lambda)]
        return "\n".join(map(ast.unparse, lambdas if thing.__name__ == "<lambda>" else [tree]))
    return source


def _is_users(module: str | None) -> bool:
    """Return whether a module, given by name, belongs neither to Python nor to an installed package."""
    if module is None:  # The thing was made by exec.
        return True
    top = module.partition(".")[0]
    if top == __name__.partition(".")[0] or top in sys.stdlib_module_names:
        return False
    file = getattr(sys.modules.get(module), "__file__", None)
    return file is None or not {"site-packages", "dist-packages"} & set(Path(file).parts)
