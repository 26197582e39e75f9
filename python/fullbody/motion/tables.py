"""Tables that show a system: its constant and settings, its bodies, its forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..base.tables import Table, head, number
from ..model.bodies import Body
from ..model.composite import Composite
from ..model.context import Context
from ..model.force import Force
from ..model.polyhedron import Polyhedron
from ..model.stokes import StokesCoefficients


def system_tables(
    context: Context, bodies: Sequence[Body], forces: Sequence[Force], options: dict[str, Any]
) -> tuple[Table, ...]:
    """Return tables of the constant, the method and the settings, the bodies and the forces of a system."""
    rows: list[Sequence[str]] = [("units", ", ".join(context.units.names) if context.units.names else "none")]
    rows.append(("G", number(context.units.attach(context.G, "G"), 12)))
    rows += [
        (name.replace("_", " "), f"{value}")
        for name, value in options.items()
        if value not in (None, "auto") and not (name == "attitude_chart" and value == "quaternion")
    ]
    return (Table("System", (), rows), _table_of_bodies(context, bodies), *_tables_of_forces(context, forces))


def _table_of_bodies(context: Context, bodies: Sequence[Body]) -> Table:
    """Return a table of the bodies of a system, one per row, in its units."""
    units = context.units
    length, mass = (units.unit(d) if units.defined else "" for d in ("length", "mass"))
    header = ("body", "shape", head("semi-axes", length), head("mass", mass))
    rows: list[Sequence[str]] = []
    for name, body, described in zip(context.names, bodies, context.core.bodies, strict=True):
        shape, mass = body.shape, described.get("mass")
        if isinstance(shape, Composite):
            size, mass = f"{len(shape.parts)} parts", sum(part["mass"] for part in described["parts"])
        elif isinstance(shape, Polyhedron):
            size = f"{len(shape.faces)} faces"
        elif isinstance(shape, StokesCoefficients):
            size = f"degree {shape.degree}"
        else:
            axes = (described["semi_axes"] or ())[: len(shape.__slots__)]
            size = ", ".join(f"{value:.8g}" for value in axes)
        rows.append((name, type(shape).__name__, size or "-", f"{mass:.8g}"))
    return Table("Bodies", header, rows)


def _tables_of_forces(context: Context, forces: Sequence[Force]) -> tuple[Table, ...]:
    """Return a table of the external forces, one per row, if there are any."""
    both = zip(forces, context.core.forces, strict=True)
    rows: list[Sequence[str]] = [
        (force.name, type(force).__name__, force._summary(described, context.units)) for force, described in both
    ]
    return (Table("Forces", ("force", "kind", "what"), rows),) if rows else ()
