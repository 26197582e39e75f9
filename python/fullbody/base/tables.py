"""Short tables of the contents of objects, as HTML for Jupyter and as text for the command line."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(slots=True)
class Table:
    """A table of text: a caption, a header, which may be empty, and rows."""

    caption: str
    header: Sequence[str] = ()
    rows: list[Sequence[str]] = field(default_factory=list)


def to_html(*tables: Table) -> str:
    """Return tables as HTML, with every text escaped."""

    def row(cells: Sequence[str], tag: str) -> str:
        style = ' style="text-align:left"'
        return "<tr>" + "".join(f"<{tag}{style}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    parts = []
    for table in tables:
        head = f"<thead>{row(table.header, 'th')}</thead>" if table.header else ""
        body = "".join(row(cells, "td") for cells in table.rows)
        caption = f'<caption style="text-align:left;padding-top:.6em"><b>{html.escape(table.caption)}</b></caption>'
        parts.append(f"<table>{caption}{head}<tbody>{body}</tbody></table>")
    return "".join(parts)


def tables_of(*shown: Any) -> list[Table]:
    """Return tables, and those of objects that Jupyter shows as tables."""
    return [table for item in shown for table in ((item,) if isinstance(item, Table) else item._tables())]


def to_text(*shown: Any) -> str:
    """Return tables as aligned text."""
    lines: list[str] = []
    for table in tables_of(*shown):
        rows = [table.header, *table.rows] if table.header else table.rows
        widths = [max(len(cells[k]) for cells in rows) for k in range(len(rows[0]))] if rows else []
        lines += ["", table.caption] if lines else [table.caption]
        lines += [
            "  " + "  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)).rstrip()
            for cells in rows
        ]
    return "\n".join(lines)


class Tabled:
    """Base class of objects that Jupyter shows as tables."""

    __slots__ = ()

    def _tables(self) -> tuple[Table, ...]:
        raise NotImplementedError

    def _repr_html_(self) -> str:
        return to_html(*self._tables())


def number(value: Any, digits: int = 8) -> str:
    """Return a number as text, with its unit if it has one."""
    if value is None:
        return "-"
    if hasattr(value, "unit"):
        return f"{float(value.value):.{digits}g} {value.unit}".rstrip()
    return f"{float(value):.{digits}g}"


def vector(value: Any, digits: int = 6) -> str:
    """Return a vector as text: its components in brackets."""
    # The addition of zero turns -0 into 0.
    return "(" + ", ".join(f"{float(component) + 0.0:.{digits}g}" for component in np.asarray(value)) + ")"


def head(name: str, unit: object) -> str:
    """Return the head of a column: a name, with its unit if it has one."""
    return f"{name} [{unit}]" if unit else name


def facts(owner: Any, *names: str) -> list[Sequence[str]]:
    """Return rows of attributes of an object: their names in words, and their numbers."""
    return [(name.replace("_", " "), number(getattr(owner, name))) for name in names]
