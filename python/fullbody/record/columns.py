"""Arrays of a record as its attributes, with units."""

from __future__ import annotations

from typing import Any

from ..base.attributes import Attribute, WithUnit
from ..errors import InvalidInput
from ..typing import Array, Floats

#: What a run keeps for some option, by the name of the array.
_OPTIONS = {
    "transition": "derivatives; integrate with derivatives=True",
    "chaos": "indicators of chaos; integrate with chaos=True",
}


def array(record: Any, name: str, part: int | None = None) -> Floats:
    """Return an array of a record or a column of it, or raise an error that says with which option a run keeps it."""
    if name in _OPTIONS and name not in record.arrays:
        raise InvalidInput(f"this run keeps no {_OPTIONS[name]}")
    values: Floats = record.arrays[name]
    return values if part is None else values[:, part]


class Numbers(Attribute[Floats]):
    """A property of a record: pure numbers, an array of the record or one of its columns, the ``part``."""

    def __init__(self, text: str, name: str, part: int | None = None) -> None:
        super().__init__(lambda record: array(record, name, part), text)


class Column(WithUnit[Array]):
    """A property of a record: an array of the record, or one of its columns, with the unit of a dimension."""

    def __init__(self, text: str, name: str, dimension: str, part: int | None = None) -> None:
        super().__init__(text, lambda record: array(record, name, part), dimension)
