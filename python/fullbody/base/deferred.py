"""Methods whose modules are imported when they are first used, since most sessions need none of them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["Deferred"]


class Deferred:
    """A function of another module as a method, which replaces this descriptor at its first use.

    Parameters
    ----------
    module, name : str
        The module, relative to the package, and the name of the function in it.
    """

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name = module, name

    def __set_name__(self, owner: type, attribute: str) -> None:
        self._owner, self._attribute = owner, attribute

    def __get__(self, instance: object, kind: type) -> Any:
        function = getattr(import_module(self._module, __name__.partition(".")[0]), self._name)
        setattr(self._owner, self._attribute, function)
        return getattr(kind if instance is None else instance, self._attribute)
