"""Attributes of classes: properties that a function computes, and methods that are imported at their first use."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Generic, TypeVar

_T = TypeVar("_T")


class Attribute(property, Generic[_T]):
    """A property, with its text, that a function computes, or an attribute by its name such as ``"frame.rate"``."""

    def __init__(self, source: str | Callable[[Any], _T], text: str | None = None) -> None:
        super().__init__(attrgetter(source) if isinstance(source, str) else source)
        # Python 3.11 would show the text of the class.
        self.__doc__ = text or source.__doc__

    if TYPE_CHECKING:

        def __get__(self, owner: Any, kind: type | None = None, /) -> _T: ...  # type: ignore[override]


class WithUnit(Attribute[_T]):
    """A property of an object with a system: numbers in the system's units, with the unit of a dimension."""

    def __init__(self, text: str, numbers: str | Callable[[Any], Any], dimension: str) -> None:
        get = attrgetter(numbers) if isinstance(numbers, str) else numbers
        super().__init__(lambda owner: owner.system.context.units.attach(get(owner), dimension), text)


class Deferred:
    """A function of another module of the package as a method, which replaces this descriptor at its first use."""

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name = module, name

    def __set_name__(self, owner: type, attribute: str) -> None:
        self._owner, self._attribute = owner, attribute

    def __get__(self, instance: object, kind: type) -> Any:
        function = getattr(import_module(self._module, __name__.partition(".")[0]), self._name)
        setattr(self._owner, self._attribute, function)
        return getattr(kind if instance is None else instance, self._attribute)
