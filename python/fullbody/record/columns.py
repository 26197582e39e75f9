"""Arrays of a record as its attributes, with units."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput
from ..typing import Array

__all__ = ["Attribute", "Column", "Numbers", "array"]

_T = TypeVar("_T")
#: What a run keeps for some option, by the name of the array.
_OPTIONS = {
    "transition": "derivatives; integrate with derivatives=True",
    "chaos": "indicators of chaos; integrate with chaos=True",
}


def array(record: Any, name: str, part: int | None = None) -> npt.NDArray[np.float64]:
    """Return an array of a record or a column of it, or raise an error that says with which option a run keeps it."""
    if name in _OPTIONS and name not in record.arrays:
        raise InvalidInput(f"this run keeps no {_OPTIONS[name]}")
    values: npt.NDArray[np.float64] = record.arrays[name]
    return values if part is None else values[:, part]


class Attribute(property, Generic[_T]):
    """A property of a record that is computed by a function."""

    def __init__(self, function: Callable[[Any], _T], text: str | None = None) -> None:
        super().__init__(function)
        # Python 3.11 would show the text of the class.
        self.__doc__ = text or function.__doc__

    if TYPE_CHECKING:

        def __get__(self, record: Any, kind: type | None = None, /) -> _T: ...  # type: ignore[override]


class Numbers(Attribute[npt.NDArray[np.float64]]):
    """A property of a record: pure numbers, an array of the record or a column of it.

    Parameters
    ----------
    text : str
        The documentation.
    name : str
        The array.
    part : int, optional
        The column.
    """

    def __init__(self, text: str, name: str, part: int | None = None) -> None:
        super().__init__(lambda record: array(record, name, part), text)


class Column(Attribute[Array]):
    """A property of a record: an array of the record or a column of it, with the unit of a dimension.

    Parameters
    ----------
    text : str
        The documentation.
    name : str
        The array.
    dimension : str
        The dimension, as in :mod:`fullbody.base.units`.
    part : int, optional
        The column.
    """

    def __init__(self, text: str, name: str, dimension: str, part: int | None = None) -> None:
        super().__init__(lambda record: record.context.units.attach(array(record, name, part), dimension), text)
