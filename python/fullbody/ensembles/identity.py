"""The identity of functions and values: a digest that is equal only where two things compute the same."""

from __future__ import annotations

import copyreg
import functools
import hashlib
import importlib.util
import io
import pickle
import sys
import sysconfig
import types
import warnings
from collections.abc import Iterator
from modulefinder import ModuleFinder
from typing import Any

import numpy as np

from ..base.units import is_quantity, need
from ..errors import FullbodyError, InvalidInput

__all__ = ["digest", "parts"]

#: Entries of a class or a module that tell where it was defined but do not affect what it computes.
_BOOKKEEPING = {
    *("__dict__", "__weakref__", "__doc__", "__module__", "__qualname__", "__firstlineno__", "__static_attributes__"),
    *("_abc_impl", "__annotations__", "__annotate__", "__annotate_func__", "__annotations_cache__"),
    *("__builtins__", "__cached__", "__file__", "__loader__", "__name__", "__package__", "__path__", "__spec__"),
    "__warningregistry__",
}
#: Names with which a function looks up other names at run time; such a function is refused, as its use is unknown.
_BY_TEXT = {"eval", "exec", "globals", "__import__", "import_module"}
#: Types of values that are written out as they are.
_ATOMS = (type(None), bool, int, float, complex, str, bytes, type(...), type(NotImplemented))


class _Unreadable(FullbodyError):
    """An object whose identity cannot be computed."""


def digest(thing: Any) -> str:
    """Compute a text that is equal for two things only where they compute the same, in any process.

    A function is identified by its instructions, constants, defaults and attributes, and by what it uses from its
    surroundings: values, and the functions, classes and modules of the user, each in the same way. A module of the user
    is identified by all that it contains. Objects that Python or an installed package defines are identified by their
    name and the package's version. Any other object is identified by the content of its pickle.

    Raises
    ------
    InvalidInput
        For an object whose value cannot be read, such as an open file.
    """
    try:
        return _Digest().of(thing)
    except (_Unreadable, RecursionError) as error:
        raise InvalidInput(
            f"{error}, so that a store would not notice a change of it; expected setups and measures that use none, "
            "or key=, a text of your own that stands for them and that you change whenever they change"
        ) from error


def parts(function: Any) -> dict[str, str]:
    """Compute the digests of a function and of each object that it uses, by readable names."""
    if not isinstance(function, types.FunctionType) or _has_name(function):
        return {"": digest(function)}
    found = {"": digest(_own(function))}
    return found | {name: digest(value) for name, value in _used(function)}


class _Digest:
    """The computation of the digest of one object."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()
        #: The objects already visited, with their indices, by their ids. Keeping an object alive keeps its id unique.
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
        kind = type(thing)
        if kind in _ATOMS:
            self._say(kind.__name__, thing if kind in (str, bytes) else repr(thing))
        elif kind is tuple:
            self._say("tuple", len(thing))
            for part in thing:
                self._feed(part)
        elif kind in (set, frozenset):
            self._say(kind.__name__, *sorted(_Digest().of(part) for part in thing))
        elif kind is types.CodeType:
            self._code(thing)
        elif (kind is np.ndarray or isinstance(thing, np.generic)) and not thing.dtype.hasobject:
            self._say("array", kind.__name__, np.lib.format.dtype_to_descr(thing.dtype), thing.shape, thing.flags.fnc)
            self._say(np.ascontiguousarray(thing).tobytes())
        elif id(thing) in self._met:
            self._say("met", self._met[id(thing)][0])
        else:
            self._met[id(thing)] = (len(self._met), thing)
            self._object(thing, kind)

    def _object(self, thing: Any, kind: type) -> None:
        if kind is list:
            self._say("list", len(thing))
            for part in thing:
                self._feed(part)
        elif kind in (dict, types.MappingProxyType):
            self._say(kind.__name__, len(thing))
            for key, value in thing.items():
                self._feed(key)
                self._feed(value)
        elif thing is getattr(np.random.random, "__self__", None):
            # Numpy's global random generator, which distributions of scipy hold, is reseeded in each process.
            self._say("global random numbers")
        elif is_quantity(thing) and kind.__module__.startswith("astropy."):
            # The pickled form of a unit includes a cache of earlier conversions.
            self._say("quantity", kind.__qualname__, *_unit(thing.unit))
            self._feed((np.asarray(thing.value), {k: v for k, v in vars(thing).items() if k not in ("_unit", "info")}))
        elif kind is types.ModuleType:
            self._module(thing)
        elif isinstance(thing, type | types.FunctionType) and _has_name(thing):
            self._say("named", thing.__module__, thing.__qualname__, _version(thing.__module__))
        elif kind is types.FunctionType:
            self._say("function")
            self._feed(_own(thing))
            for name, value in _used(thing):
                self._say(name)
                self._feed(value)
        elif isinstance(thing, type):
            self._say("class", thing.__qualname__)
            self._feed((type(thing), thing.__bases__))
            self._entries(thing)
        elif kind in (staticmethod, classmethod, types.MethodType):
            self._say(kind.__name__)
            self._feed((thing.__func__, getattr(thing, "__self__", None)))
        elif kind is property:
            self._say("property")
            self._feed((thing.fget, thing.fset, thing.fdel))
        elif kind is functools.cached_property:
            self._say("cached property")
            self._feed(thing.func)
        elif kind is types.CellType:
            self._say("cell")
            self._feed(_content(thing))
        elif kind is functools._lru_cache_wrapper:
            # A cache returns what its function returns; the attributes of the wrapper hold the function.
            self._say("cached", _version(kind.__module__))
            self._feed(vars(thing))
        elif kind.__module__.startswith("numba.") and callable(getattr(thing, "__wrapped__", thing)):
            self._say("compiled", kind.__qualname__, _version("numba"), getattr(thing, "_sig", ""))
            options = getattr(thing, "targetoptions", None), getattr(thing, "locals", None)
            self._feed((getattr(thing, "py_func", None) or getattr(thing, "__wrapped__", None), options))
        else:
            self._pickled(thing, kind)

    def _module(self, module: types.ModuleType) -> None:
        """Add a module of the user with all its content, or only the name of another module."""
        self._say("module", module.__name__, "" if _is_users(module.__name__) else _version(module.__name__))
        if _is_users(module.__name__):
            self._entries(module)

    def _entries(self, thing: type | types.ModuleType) -> None:
        for name, value in vars(thing).items():
            plain = isinstance(value, types.MemberDescriptorType | types.GetSetDescriptorType)
            if name not in _BOOKKEEPING and not plain:
                self._say(name)
                self._feed(value)

    def _pickled(self, thing: Any, kind: type) -> None:
        """Add an object by its content according to Python's pickling protocol."""
        reduce = copyreg.dispatch_table.get(kind)
        try:
            # Pickle looks for a name in all imported modules, some of which issue warnings when an attribute is read.
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                reduced = thing.__reduce_ex__(4) if reduce is None else reduce(thing)
                if isinstance(reduced, str):
                    # Pickling checks that the name leads to this very object.
                    reduced = pickle.dumps(thing)
        except Exception as error:
            raise _Unreadable(
                f"{thing!r} is of the type {kind.__qualname__}, whose value cannot be seen ({error})"
            ) from error
        self._say("object")
        if isinstance(reduced, bytes):
            self._say(reduced)
        else:
            self._feed(tuple(part if part is None or k < 3 else list(part) for k, part in enumerate(reduced)))

    def _code(self, code: types.CodeType) -> None:
        self._say("code", code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
        self._say(code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
        self._say(code.co_exceptiontable)
        self._feed(code.co_consts)


def _own(function: types.FunctionType) -> Any:
    """Return what a function contains itself: its code without the docstring, its defaults and attributes."""
    code = function.__code__
    if function.__doc__ is not None and code.co_consts[:1] == (function.__doc__,):
        code = code.replace(co_consts=(None, *code.co_consts[1:]))
    return code, function.__defaults__, function.__kwdefaults__, vars(function)


def _unit(unit: Any) -> tuple[str, ...]:
    """Return the name of a unit and the units it is composed of."""
    base = unit.decompose() if hasattr(unit, "decompose") else unit
    return str(unit), repr(getattr(base, "scale", "")), str(base)


def _version(module: str) -> str:
    """Return the version of the package that a module belongs to, if the package has one."""
    return str(getattr(sys.modules.get(module.partition(".")[0]), "__version__", ""))


def _has_name(thing: Any) -> bool:
    """Return whether a function or class is what a module of Python or an installed package has under its name."""
    module = getattr(thing, "__module__", None)
    if not isinstance(module, str) or _is_users(module):
        return False
    found: Any = sys.modules.get(module)
    for name in thing.__qualname__.split("."):
        found = getattr(found, name, None)
    return found is thing


def _is_users(module: str) -> bool:
    """Return whether a module, given by name, belongs neither to Python nor to an installed package."""
    top = module.partition(".")[0]
    if top == __name__.partition(".")[0] or top in sys.builtin_module_names or top in sys.stdlib_module_names:
        return False
    file = getattr(sys.modules.get(module), "__file__", None)
    if top == "__main__" or file is None:
        # A program may create modules while it runs.
        return True
    folders = [sysconfig.get_path(kind) for kind in ("purelib", "platlib")]
    return not (
        any(file.startswith(folder) for folder in folders) or "site-packages" in file or "dist-packages" in file
    )


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """Yield a code object and those nested in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def _content(cell: types.CellType) -> Any:
    """Return the value of a variable of an enclosing function, or ``None`` if it has no value yet."""
    try:
        return cell.cell_contents
    except ValueError:
        return None


def _used(function: types.FunctionType) -> Iterator[tuple[str, Any]]:
    """Yield what a function uses from its surroundings, by name."""
    names = {name for code in _codes(function.__code__) for name in code.co_names}
    unseen = sorted((names & _BY_TEXT) - function.__globals__.keys())
    if unseen:
        raise _Unreadable(f"the function {function.__qualname__} uses {unseen[0]}, by which it may use anything")
    found = dict(zip(function.__code__.co_freevars, map(_content, function.__closure__ or ()), strict=True))
    found |= _globals(function)
    for name, module in _imported(function):
        found.setdefault(name, module)
    yield from sorted(found.items())


def _globals(function: types.FunctionType) -> dict[str, Any]:
    """Return the global variables that a function and those nested in it use."""
    with need("data", "a store of a sweep"):
        import cloudpickle
    # Functions with this module's name are those that cloudpickle sends with all that they use.
    copy = types.FunctionType(function.__code__, function.__globals__, closure=function.__closure__)
    copy.__module__ = "__main__"
    _, _, (_, kept), *_ = cloudpickle.Pickler(io.BytesIO()).reducer_override(copy)
    found: dict[str, Any] = kept["__globals__"]
    return found


def _imported(function: types.FunctionType) -> Iterator[tuple[str, types.ModuleType]]:
    """Yield the modules that a function imports when it is called."""
    package = function.__globals__.get("__package__") or ""
    for code in _codes(function.__code__):
        for kind, found in ModuleFinder().scan_opcodes(code):
            if kind not in ("absolute_import", "relative_import"):
                continue
            level, items, name = found if kind == "relative_import" else (0, *found)
            for full in (name, *(f"{name}.{item}" for item in items or ())):
                try:
                    full = importlib.util.resolve_name("." * level + full, package)
                    yield full, importlib.import_module(full)
                except (ImportError, ValueError):
                    # An item need not be a module; if the module is missing, the function itself will raise the error.
                    continue
