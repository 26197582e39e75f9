"""The description of a system by its core and its notes, from which files and changed parameters rebuild it."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar, cast

from ..base.arguments import normal_form, refuse_unknown
from ..base.units import Units
from ..errors import InvalidInput
from .bodies import Body
from .context import SystemLike
from .force import Force, rebuilt
from .freeform import ConvexShape, with_areas
from .polyhedron import Polyhedron
from .surface import Deformation, surface_of

_System = TypeVar("_System", bound=SystemLike)
#: The names of the notes that a description keeps of a system, its bodies and its forces.
_NOTES = ("units", "epoch", "frame", "bodies", "forces")
_NOTED = {"bodies": ("named", "shape", "parts", "series"), "forces": ("date",)}


def notes_of(
    units: Units, epoch: str | None, frame: str | None, bodies: Iterable[Body], forces: Iterable[Force]
) -> dict[str, Any]:
    """Return the data of a system that the core's description does not contain."""
    noted = ([item._notes() for item in ones] for ones in (bodies, forces))
    return dict(zip(_NOTES, (units.names, epoch, frame, *noted), strict=True))


def functions(system: SystemLike) -> dict[str, Force]:
    """Return the forces of a system that files cannot keep, by name."""
    return {force.name: force for force in system.forces if force.name in system.context.calls}


def arguments(described: Mapping[str, Any], forces_by_name: Mapping[str, Force] | None = None) -> dict[str, Any]:
    """Return the arguments of a system from its description, which may have no notes, and functions by name."""
    notes = described.get("notes", {})
    refuse_unknown(notes, _NOTES, "the notes of a system")
    bodies, forces = (_noted(described[name], notes, name) for name in ("bodies", "forces"))
    units = notes.get("units")
    system_units, replacements = Units(None if units is None else tuple(units)), forces_by_name or {}
    return {
        "bodies": [Body._rebuild(body, note) for body, note in bodies],
        "G": described["G"],
        "units": system_units.names,
        "epoch": notes.get("epoch"),
        "frame": notes.get("frame"),
        "forces": [replacements.get(force["name"]) or rebuilt(force | note, system_units) for force, note in forces],
        **described["settings"],
    }


def changed(system: _System, parameter: str, by: float) -> _System:
    """Return the system with one of its :attr:`~fullbody.System.parameters` changed by a number in the system's units.

    Raises
    ------
    InvalidInput
        For a name that is not among the parameters, and for a change that leaves no valid system.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> float(system.changed("mass of Beta", 1e9)["Beta"].mass)
    136000000000.0
    """
    context, parameter = system.context, normal_form(parameter)
    if parameter in context.deformations:
        return _deformed(system, context.deformations[parameter], by)
    bodies, forces, G, _ = context.core.changed(parameter, by)
    described = context.describe() | {"bodies": bodies, "forces": forces, "G": G}
    notes = [dict(note) for note in described["notes"]["bodies"]]
    for body, note in zip(context.names, notes, strict=True):
        if parameter.startswith("semi-axis") and parameter.endswith(f" of {body}"):
            # A sphere with one changed semi-axis is an ellipsoid.
            note.pop("shape", None)
    described["notes"]["bodies"] = notes
    return cast(Any, type(system))(**arguments(described, functions(system)))


def with_deformations(system: _System, deformations: Mapping[str, Deformation]) -> _System:
    """Return the system with named deformations, which :func:`changed` then takes as parameters."""
    other = copy.copy(system)
    cast(Any, other).context = replace(system.context, deformations=deformations)
    return other


def _deformed(system: _System, deformation: Deformation, by: float) -> _System:
    """Return the system whose surfaces have moved along a deformation; the masses and the body frames stay."""
    units = system.context.units
    for index, displacement in deformation.items():
        shape, surface = system.bodies[index].shape, surface_of(system.context.bodies[index])
        assert surface is not None
        if isinstance(shape, ConvexShape):
            changed: Any = with_areas(shape, units.attach(surface.areas + by * displacement.areas, "area"))
        else:
            changed = Polyhedron(units.attach(surface.vertices + by * displacement.vertices, "length"), shape.faces)
        mass = units.attach(system.context.masses[index], "mass")
        system = cast(Any, system).with_body(index, changed, mass=mass)
    return system


def _noted(parts: list[Any], notes: dict[str, Any], what: str) -> list[tuple[Any, dict[str, Any]]]:
    """Return each part of a description with its notes, which may be missing."""
    noted = notes.get(what, [{}] * len(parts))
    if len(noted) != len(parts):
        raise InvalidInput(f"the notes have {len(noted)} {what}; expected {len(parts)}, as the description has")
    for note in noted:
        refuse_unknown(note, _NOTED[what], f"the notes of {what}")
    return list(zip(parts, noted, strict=True))
