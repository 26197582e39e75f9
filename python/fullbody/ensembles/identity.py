"""Whether two things compute the same: a digest of functions with all that they use, and of values."""

from __future__ import annotations

import copyreg
import dis
import functools
import hashlib
import importlib
import sys
import sysconfig
import types
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..base.units import is_quantity
from ..errors import InvalidInput

__all__ = ["digest", "parts"]

#: Entries of a class that say where it stands, not what it does.
_BOOKKEEPING = {
    *("__dict__", "__weakref__", "__doc__", "__module__", "__qualname__", "__firstlineno__", "__static_attributes__"),
    *("_abc_impl", "__annotations__", "__annotate__", "__annotate_func__", "__annotations_cache__"),
}
_WRAPPERS = (staticmethod, classmethod, types.MethodType)


def digest(thing: Any) -> str:
    """A text that is the same for things that compute the same, in every process of one version of Python.

    Functions count by their instructions, constants, defaults, and what they use from around them: values, and
    functions, classes and modules of the user's, each in the same way. What belongs to Python or to an installed
    package counts by its name. Other objects count by what they pickle.

    Raises
    ------
    InvalidInput
        For what cannot be told from another, such as an open file.
    """
    return _Digest().of(thing)


def parts(function: Any) -> dict[str, str]:
    """The digests of a function and of each thing that it uses, by a name for people."""
    if not isinstance(function, types.FunctionType) or not _is_users(function):
        return {"": digest(function)}
    found = {"": digest((_code(function), function.__defaults__, function.__kwdefaults__))}
    return found | {name: digest(value) for name, value in _used(function)}


class _Digest:
    """The digest of one thing."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        #: What was met before, by its place: things may hold each other. It is kept, lest another takes its id.
        self._met: dict[int, tuple[int, Any]] = {}

    def of(self, thing: Any) -> str:
        self._feed(thing)
        return self._hash.hexdigest()

    def _say(self, *words: object) -> None:
        for word in words:
            data = word if isinstance(word, bytes) else str(word).encode("utf-8", "surrogatepass")
            self._hash.update(len(data).to_bytes(8, "little"))
            self._hash.update(data)

    def _feed(self, thing: Any) -> None:
        match thing:
            case None | bool() | int() | float() | complex() | str() | bytes() | types.EllipsisType() if (
                type(thing).__module__ == "builtins"
            ):
                self._say(type(thing).__name__, thing if isinstance(thing, str | bytes) else repr(thing))
            case np.ndarray() | np.generic() if not is_quantity(thing) and thing.dtype.kind != "O":
                array = np.asarray(thing)
                self._say("array", array.dtype.str, array.shape, np.ascontiguousarray(array).tobytes())
            case tuple():
                self._say("tuple", type(thing).__qualname__, len(thing))
                for part in thing:
                    self._feed(part)
            case frozenset() | set():
                self._say("set", *sorted(digest(part) for part in thing))
            case types.CodeType():
                self._code(thing)
            case _:
                place = self._met.get(id(thing))
                if place is not None:
                    self._say("met", place[0])
                else:
                    self._met[id(thing)] = (len(self._met), thing)
                    self._object(thing)

    def _object(self, thing: Any) -> None:
        inner = getattr(thing, "py_func", None) or getattr(thing, "__wrapped__", None)
        if is_quantity(thing):
            self._say("quantity", thing.unit)
            self._feed(np.asarray(thing.value))
        elif thing is getattr(np.random.random, "__self__", None):
            # Numpy's global random numbers, which distributions of scipy hold, begin anew in each process.
            self._say("global random numbers")
        elif isinstance(thing, list):
            self._say("list", len(thing))
            for part in thing:
                self._feed(part)
        elif isinstance(thing, Mapping):
            self._say("mapping", len(thing))
            for key, value in thing.items():
                self._feed(key)
                self._feed(value)
        elif isinstance(thing, functools.partial):
            self._say("partial")
            self._feed((thing.func, thing.args, thing.keywords))
        elif isinstance(thing, _WRAPPERS):
            self._say(type(thing).__name__)
            self._feed(thing.__func__)
            self._feed(getattr(thing, "__self__", None))
        elif isinstance(thing, types.ModuleType):
            self._say("module", thing.__name__)
        elif isinstance(thing, type | types.FunctionType) and not _is_users(thing):
            self._say("named", thing.__module__, thing.__qualname__)
        elif isinstance(thing, types.FunctionType):
            self._say("function")
            self._feed((_code(thing), thing.__defaults__, thing.__kwdefaults__))
            for name, value in _used(thing):
                self._say(name)
                self._feed(value)
        elif isinstance(thing, type):
            self._class(thing)
        elif isinstance(thing, property):
            self._say("property")
            self._feed((thing.fget, thing.fset, thing.fdel))
        elif isinstance(thing, functools.cached_property):
            self._say("cached property")
            self._feed(thing.func)
        elif callable(thing) and inner is not None:
            # Compiled or cached; what it does is what the function does.
            self._say("wrapped", type(thing).__qualname__)
            self._feed(inner)
        else:
            self._pickled(thing)

    def _class(self, thing: type) -> None:
        self._say("class", thing.__qualname__)
        self._feed(thing.__bases__)
        for name, value in vars(thing).items():
            plain = isinstance(value, types.MemberDescriptorType | types.GetSetDescriptorType)
            if name not in _BOOKKEEPING and not plain:
                self._say(name)
                self._feed(value)

    def _pickled(self, thing: Any) -> None:
        reduce = copyreg.dispatch_table.get(type(thing))
        try:
            reduced = thing.__reduce_ex__(4) if reduce is None else reduce(thing)
        except Exception as error:
            raise InvalidInput(
                f"{thing!r} cannot be told from another of the type {type(thing).__qualname__}, so that a change would "
                "not be noticed; expected set-ups and measures that use none, or no store"
            ) from error
        self._say("object")
        if isinstance(reduced, str):
            self._say(type(thing).__module__, type(thing).__qualname__, reduced)
            return
        self._feed(tuple(part if part is None or k < 3 else list(part) for k, part in enumerate(reduced[:5])))

    def _code(self, code: types.CodeType) -> None:
        self._say("code", code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
        self._say(code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
        self._say(code.co_exceptiontable)
        self._feed(code.co_consts)


def _code(function: types.FunctionType) -> types.CodeType:
    """The code of a function, without its docstring."""
    code = function.__code__
    documented = function.__doc__ is not None and code.co_consts[:1] == (function.__doc__,)
    return code.replace(co_consts=(None, *code.co_consts[1:])) if documented else code


def _is_users(thing: Any) -> bool:
    """Whether a function, class or module is neither Python's nor an installed package's."""
    name = thing.__name__ if isinstance(thing, types.ModuleType) else getattr(thing, "__module__", None)
    if name is None or name == "__main__":
        return True
    if name.partition(".")[0] == __name__.partition(".")[0]:
        return False
    file = getattr(sys.modules.get(name), "__file__", None)
    if file is None:
        # Built in, or made by a program while it runs.
        return name not in sys.builtin_module_names and name not in sys.stdlib_module_names
    folders = [sysconfig.get_path(kind) for kind in ("purelib", "platlib")]
    installed = any(file.startswith(folder) for folder in folders) or "site-packages" in file or "dist-packages" in file
    return not installed and name.partition(".")[0] not in sys.stdlib_module_names


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """A code and those within it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def _used(function: types.FunctionType) -> Iterator[tuple[str, Any]]:
    """What a function uses from around it, by name."""
    cells = function.__closure__ or ()
    for name, cell in zip(function.__code__.co_freevars, cells, strict=True):
        try:
            yield name, cell.cell_contents
        except ValueError:
            # Not yet given a value, as in a function that is not made to the end.
            yield name, None
    names, attributes, imported = set(), set(), set()
    for code in _codes(function.__code__):
        for step in dis.get_instructions(code):
            if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
                names.add(str(step.argval))
            elif step.opname in ("LOAD_ATTR", "LOAD_METHOD", "IMPORT_FROM"):
                attributes.add(str(step.argval))
            elif step.opname == "IMPORT_NAME":
                imported.add(str(step.argval))
    around = function.__globals__
    found = {name: around[name] for name in names if name in around}
    for name in imported:
        try:
            found.setdefault(name, importlib.import_module(name))
        except (ImportError, TypeError, ValueError):
            # The function itself will say so, where it ever comes there.
            continue
    for name in sorted(found):
        yield name, found[name]
        if isinstance(found[name], types.ModuleType):
            yield from _attributes(name, found[name], attributes, set())


def _attributes(
    path: str, module: types.ModuleType, attributes: set[str], seen: set[types.ModuleType]
) -> Iterator[tuple[str, Any]]:
    """What of a user's module has one of these names."""
    if module in seen or not _is_users(module):
        return
    seen.add(module)
    for name in sorted(attributes & vars(module).keys()):
        value = vars(module)[name]
        yield f"{path}.{name}", value
        if isinstance(value, types.ModuleType):
            yield from _attributes(f"{path}.{name}", value, attributes, seen)
