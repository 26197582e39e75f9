"""Short tables of what an object holds, as HTML for Jupyter and as text for the command line."""

from __future__ import annotations

import contextlib
import html
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidInput
from .values import same

if TYPE_CHECKING:
    from ..model.bodies import Body
    from ..model.interactions import Energy, Interactions
    from ..model.state import State
    from ..model.system import BaseSystem
    from ..orbit.elements import KeplerElements
    from ..record.base import BaseRun
    from ..setups.component import Component

__all__ = [
    "Table",
    "of_bodies",
    "of_body",
    "of_component",
    "of_elements",
    "of_energy",
    "of_interactions",
    "of_run",
    "of_state",
    "of_system",
    "to_html",
    "to_text",
]


#: What ended a run before its time.
_STOPPED = {"event": "by the last event", "interrupted": "by an interrupt", "unfinished": "by an error"}


@dataclass(slots=True)
class Table:
    """A caption, a header (may be empty) and rows of text."""

    caption: str
    header: Sequence[str] = ()
    rows: list[Sequence[str]] = field(default_factory=list)


def to_html(*tables: Table) -> str:
    """HTML of tables, with every text escaped."""

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


def to_text(*tables: Table) -> str:
    """Aligned text of tables."""
    lines: list[str] = []
    for table in tables:
        rows = [table.header, *table.rows] if table.header else table.rows
        widths = [max(len(cells[k]) for cells in rows) for k in range(len(rows[0]))] if rows else []
        lines += ["", table.caption] if lines else [table.caption]
        lines += [
            "  " + "  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True)).rstrip()
            for cells in rows
        ]
    return "\n".join(lines)


def number(value: Any, digits: int = 8) -> str:
    """A number with its unit, if it has one."""
    if value is None:
        return "-"
    if hasattr(value, "unit"):
        return f"{float(value.value):.{digits}g} {value.unit}".rstrip()
    return f"{float(value):.{digits}g}"


def vector(value: Any, digits: int = 6) -> str:
    """Components in brackets."""
    # Zero is added since it turns -0 into 0.
    return "(" + ", ".join(f"{float(component) + 0.0:.{digits}g}" for component in np.asarray(value)) + ")"


def _head(name: str, unit: object) -> str:
    return f"{name} [{unit}]" if unit else name


def of_body(body: Body) -> Table:
    """Shape, size, mass and density of one body."""
    rows: list[Sequence[str]] = [("shape", type(body.shape).__name__)]
    if body.shape.semi_axes is not None:
        rows.append(("semi-axes", ", ".join(number(axis) for axis in body.shape.semi_axes)))
    # Where only some of a body's numbers have units, what follows from them is known to its system alone.
    for name in ("mass", "density"):
        with contextlib.suppress(InvalidInput):
            rows += [(name, number(value))] if (value := getattr(body, name)) is not None else []
    return Table(f"Body {body.name}" if body.name is not None else "Body", (), rows)


def of_component(component: Component) -> Table:
    """What is given of one body of a pair, and not what it is without that."""
    rows: list[Sequence[str]] = []
    for part in fields(component):
        value = getattr(component, part.name)
        if part.name != "name" and not same(value, part.default):
            shown = [number(x) for x in value] if np.ndim(value) or isinstance(value, tuple) else [number(value)]
            rows.append((part.name.replace("_", " "), ", ".join(shown)))
    return Table("Component" if component.name is None else f"Component {component.name}", (), rows)


def of_energy(energy: Energy) -> Table:
    """The parts of an energy."""
    names = ("translational", "rotational", "potential", "total")
    return Table("Energy", (), [(name, number(getattr(energy, name))) for name in names])


def of_interactions(found: Interactions) -> Table:
    """Force and torque, a body a row, by its place."""
    columns = [np.asarray(getattr(value, "value", value)) for value in (found.force, found.torque)]
    units = [getattr(value, "unit", "") for value in (found.force, found.torque)]
    header = ("body", _head("force", units[0]), _head("torque, body frame", units[1]))
    rows = [(str(k), *(vector(column[k]) for column in columns)) for k in range(len(columns[0]))]
    return Table(f"Interactions, potential energy {number(found.potential_energy)}", header, list(rows))


def of_bodies(system: BaseSystem) -> Table:
    """The bodies of a system, one a row, in its units."""
    units = system._units
    length, mass = (units.unit(d) if units.known else "" for d in ("length", "mass"))
    header = ("body", "shape", _head("semi-axes", length), _head("mass", mass))
    rows: list[Sequence[str]] = []
    for name, described in zip(system.names, system._describe()["bodies"], strict=True):
        size = ", ".join(f"{value:.8g}" for value in described["size"].values())
        rows.append((name, described["shape"], size or "-", f"{described['mass']:.8g}"))
    return Table("Bodies", header, rows)


def of_system(system: BaseSystem) -> Table:
    """Constant, method and settings of a system."""
    rows: list[Sequence[str]] = [("units", ", ".join(system.units) if system.units else "none")]
    rows.append(("G", number(system.G, 12)))
    rows += [
        (name.replace("_", " "), f"{value}")
        for name, value in system.options.items()
        if value not in (None, "auto") and not (name == "attitude_chart" and value == "quaternion")
    ]
    return Table("System", (), rows)


def of_state(state: State, bodies: Sequence[str] | None = None) -> Table:
    """Position, velocity, attitude and spin, a body a row, by its name or else its place."""
    names = ("position", "velocity", "attitude", "spin")
    columns = [np.asarray(getattr(getattr(state, name), "value", getattr(state, name))) for name in names]
    header = ["body", *(_head(name, getattr(getattr(state, name), "unit", "")) for name in names)]
    bodies = [str(k) for k in range(len(state))] if bodies is None else bodies
    rows = [(body, *(vector(column[k]) for column in columns)) for k, body in enumerate(bodies)]
    return Table(f"State at time {number(state.time)}", header, list(rows))


def of_elements(elements: KeplerElements) -> Table:
    """Elements: a value, or where there are many the first, last, least and greatest; angles in degrees."""
    rows: list[Sequence[str]] = []
    many = 0
    for name in ("a", "e", "i", "Omega", "omega", "M"):
        value = getattr(elements, name)
        unit = str(getattr(value, "unit", ""))
        if name not in "ae":
            value = np.rad2deg(value.to_value("rad") if unit else value)
            unit = "deg"
        flat = np.ravel(np.asarray(getattr(value, "value", value), dtype=float))
        shown = [flat[0]] if flat.size == 1 else [flat[0], flat[-1], flat.min(), flat.max()] if flat.size else []
        many = max(many, flat.size)
        rows.append((_head(name, unit), *(f"{x:.8g}" for x in shown)))
    rows = [(*row, *[row[1]] * 3) if many > 1 and len(row) == 2 else row for row in rows]
    header = ("", "first", "last", "least", "greatest") if many > 1 else ()
    return Table(f"Kepler elements, {many} orbits" if many > 1 else "Kepler elements", header, rows)


def of_run(run: BaseRun) -> Table:
    """Span, counts, events and conservation of a run."""
    s, integrator = run.statistics, run.integrator
    rows: list[Sequence[str]] = [("samples", str(len(run)))]
    if len(run):
        rows.append(("time", f"{number(run.time[0])} to {number(run.time[-1])}"))
    start = run.start
    if start is not None and not (len(run) and start.time == run.time[0]):
        rows.append(("start", number(start.time)))
    rows += [
        ("integrator", repr(integrator)),
        ("steps", f"{s.steps}, {s.rejected} rejected, {s.evaluations} evaluations"),
    ]
    kinds = Counter(type(happened.event).__name__ for happened in run.events)
    if kinds:
        rows.append(("events", ", ".join(f"{count} {kind}" for kind, count in kinds.items())))
    if run.stop_reason in _STOPPED:
        rows.append(("stopped", _STOPPED[run.stop_reason]))
    drifts = {
        "energy_drift": "drift of the energy{}, relative to the total",
        "energy_drift_orbital": "drift of the energy{}, relative to the orbit's",
        "angular_momentum_drift": "drift of the angular momentum{}, relative",
    }
    since = "" if start else " since the first sample"
    # Where there is something to be relative to.
    rows += [
        (name.format(since), f"{np.abs(run._drift(of)).max():.2e}")
        for of, name in drifts.items()
        if run._relative_to(of)
    ]
    return Table("Run", (), rows)
