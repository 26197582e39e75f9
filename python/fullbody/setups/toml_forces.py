"""The tables ``[[forces]]`` of a ``system.toml``: the arguments of the classes of :mod:`fullbody.forces`."""

from __future__ import annotations

from typing import Any

from ..base.kinds import Kind, Number, direction, kinds_of
from ..forces import Byorp, Force, ThirdBody, Tide, Yorp
from ..forces.radiation import torque_dimension
from ..orbit.elements import DIMENSIONS, KeplerElements
from .toml_table import TomlTable

#: The elements of an orbit, also by other words for angles, with their dimensions.
ELEMENTS = DIMENSIONS | dict.fromkeys(("f", "l", "pomega", "theta"), "angle")
_KINDS: dict[str, type[Force]] = {kind.__name__: kind for kind in (ThirdBody, Tide, Yorp, Byorp)}


def elements(table: TomlTable) -> KeplerElements[Any]:
    """Make the orbit of a table, in its units."""
    given = [name for name in ELEMENTS if name in table or name in ("a", "e", "i", "Omega")]
    numbers = {name: table.number(name, ELEMENTS[name]) for name in given}
    with table.naming(""):
        return KeplerElements(**numbers)


def force(table: TomlTable) -> Force:
    """Make the force of a table, with numbers in its units."""
    if table.content.get("kind") == "Function":
        raise table.fault("kind", "is 'Function', which no file can hold; give it in Python: system.with_forces([...])")
    table.take("kind", f"one of {', '.join(map(repr, _KINDS))}")
    kind = _KINDS[table.choice("kind", tuple(_KINDS))]
    kinds = kinds_of(kind)
    arguments = {name: _argument(table, name, kinds.get(name)) for name in table.fields_of(kind, "kind")}
    with table.naming(""):
        return kind(**arguments)


def _argument(table: TomlTable, key: str, kind: Kind | None) -> Any:
    if key == "orbit":
        return elements(table.table(key).only(*ELEMENTS))
    if key in ("along", "across"):
        return table.array(key, torque_dimension(table.text("normalization") if "normalization" in table else None))
    if isinstance(kind, Number) or kind is direction:
        return table.array(key, kind.dimension if isinstance(kind, Number) else "number")
    return table.text(key)
