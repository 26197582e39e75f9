"""The tables ``[[body]]`` and ``[binary]`` of a ``system.toml``: shapes, masses, and the arguments of a binary."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.arguments import name_of
from ..base.kinds import Number
from ..model.bodies import Body
from ..model.composite import Composite, Part
from ..model.polyhedron import Polyhedron
from ..model.shapes import Ellipsoid, PointMass, Solid, Sphere
from ..model.stokes import StokesCoefficients
from ..orbit.elements import KeplerElements
from .component import KINDS, Component
from .masses import KINDS as OF_BINARIES
from .toml_state import ANGLES, attitude, flag
from .toml_table import TomlTable

SHAPES = ("semi_axes", "radius", "point", "polyhedron", "stokes", "diameters", "diameter")
#: The keys of the figure beside a diameter: a/b and b/c, or the two ratios of the longest axis, or J2.
FIGURES = ("axis_ratios", "a/b", "a/c", "J2")
MASSES = {"mass": KINDS["mass"], "density": KINDS["density"], "GM": Number("mu")}
_SOLID = (*SHAPES, *FIGURES, *MASSES)
#: The keys of a part, of a body that is placed by itself, and of a body of a binary.
_PART = (*_SOLID, "position", *ANGLES)
_BODY = ("name", "part", *_PART, "velocity", "orbit", "spin", "rotation_period", "synchronous")
_ROTATION = {key: KINDS[key] for key in ("rotation_period", "rotation_angle", "tilt")}
_COMPONENT = ("name", "part", *_SOLID, *_ROTATION, "pole", "synchronous")
#: The arguments of :func:`fullbody.binary` that are neither numbers nor the pole.
_CHOICES = ("equal_density", "elements", "synchronous", "at_rest")


def body(table: TomlTable, G: float) -> Body:
    """Make a body of its table; a ``GM`` is divided by G."""
    table.only(*_BODY)
    shape, masses, name = _solid(table, G), _masses(table, G), _name(table)
    with table.naming("part" if "part" in table else next(iter(masses), "")):
        return Body(shape, name=name, **masses)


def pair(table: TomlTable, rows: list[TomlTable], G: float) -> dict[str, Any]:
    """Return the arguments of :func:`fullbody.binary` from its table, which may have other angles, and of the two
    bodies.
    """
    table.only(*OF_BINARIES, *_CHOICES, "pole", "inclination", "ascending_node", "mean_longitude")
    if len(rows) != 2:
        raise table.fault("", f"has {len(rows)} bodies; expected two")
    arguments: dict[str, Any] = {key: table.take(key, "a choice") for key in _CHOICES if key in table}
    arguments |= table.numbers(OF_BINARIES)
    if table.only_key("pole", "inclination") == "pole":
        arguments["pole"] = tuple(table.vector("pole", "angle", 2))
    if "inclination" in table or "ascending_node" in table:
        node, inclination = table.number("ascending_node", "angle"), table.number("inclination", "angle")
        arguments["pole"] = (node - np.pi / 2, np.pi / 2 - inclination)
    if table.only_key("mean_anomaly", "mean_longitude") == "mean_longitude":
        passed = table.number("ascending_node", "angle") + arguments.get("argument_of_periapsis", 0.0)
        arguments["mean_anomaly"] = table.number("mean_longitude", "angle") - passed
    primary, secondary = (_component(row, G) for row in rows)
    if "synchronous" in rows[1]:
        raise rows[1].fault("synchronous", f"is given for the second body; expected it in [{table.location}]")
    if flag(rows[0], "synchronous"):
        names = ("eccentricity", "argument_of_periapsis", "mean_anomaly")
        e, periapsis, anomaly = (arguments.get(name, 0.0) for name in names)
        (x, y, _), _ = KeplerElements(1.0, e, 0.0, 0.0, periapsis, anomaly).to_cartesian(1.0)
        primary |= {"rotation_period": table.number("period", "time"), "rotation_angle": float(np.arctan2(y, x))}
    with rows[0].naming(""):
        arguments["primary"] = Component(**primary)
    with rows[1].naming(""):
        arguments["secondary"] = Component(**secondary)
    return arguments


def _component(table: TomlTable, G: float) -> dict[str, Any]:
    """Return the arguments of a component."""
    table.only(*_COMPONENT)
    shape = _solid(table, G)
    arguments: dict[str, Any] = {"name": _name(table), **_masses(table, G)}
    match shape:
        case Ellipsoid() | Sphere():
            arguments["semi_axes"] = shape.semi_axes
        case Composite() | Polyhedron() | StokesCoefficients():
            arguments["composite"] = shape
        case _:
            arguments["composite"] = Composite([Part(shape, mass=1.0)])
    arguments |= table.numbers(_ROTATION)
    if "pole" in table:
        arguments["pole"] = tuple(table.vector("pole", "angle", 2))
    return arguments


def _name(table: TomlTable) -> str | None:
    """Return the name of a body, or ``None`` if it has none."""
    with table.naming("name"):
        return name_of(table.text("name") if "name" in table else None)


def _masses(table: TomlTable, G: float) -> dict[str, float]:
    """Return the mass and the density as far as the table has them; the body refuses both."""
    arguments = table.numbers(MASSES)
    if "GM" in arguments:
        arguments["mass"] = arguments.pop("GM") / G
    return arguments


def _solid(table: TomlTable, G: float) -> Solid | Composite:
    """Make the shape of a body, with parts or without."""
    if "part" not in table:
        return _shape(table)
    for key in _SOLID:
        if key in table:
            raise table.fault(key, "is given beside [[body.part]]; expected it in the parts")
    parts = []
    for row in table.tables("part"):
        row.only(*_PART)
        shape = _shape(row)
        position = row.vector("position", "length", 3) if "position" in row else None
        with row.naming(""):
            parts.append(Part(shape, position=position, attitude=attitude(row), **_masses(row, G)))
    with table.naming("part"):
        return Composite(parts)


def _shape(table: TomlTable) -> Solid:
    key = table.only_key(*SHAPES)
    if key is None:
        raise table.fault("", f"has none of {', '.join(SHAPES)}; expected one of them")
    if key != "diameter":
        for figure in FIGURES:
            if figure in table:
                raise table.fault(figure, f"is given beside {key}; expected it beside a diameter")
    if key == "polyhedron":
        return _polyhedron(table)
    if key == "stokes":
        return _stokes(table)
    with table.naming(key):
        match key:
            case "semi_axes":
                return Ellipsoid(*map(float, table.vector(key, "length", 3)))
            case "diameters":
                return Ellipsoid(*(float(diameter) / 2 for diameter in table.vector(key, "length", 3)))
            case "radius":
                return Sphere(table.number(key, "length"))
            case "point":
                if table.content[key] is not True:
                    raise table.fault(key, f"is {table.content[key]!r}; expected true")
                return PointMass()
    with table.naming(""):
        diameter, ratios = table.number("diameter", "length"), _axis_ratios(table)
        return Component(diameter=diameter, axis_ratios=ratios, name=_name(table)).shape  # type: ignore[return-value]


def _axis_ratios(table: TomlTable) -> tuple[float, float]:
    """Return the axis ratios a/b and b/c: as they stand, from a/b and a/c, or of a spheroid with a J2."""
    match table.only_key("axis_ratios", "a/c", "J2") or table.only_key("axis_ratios", "a/b", "J2"):
        case "J2":
            return (1.0, _spheroid(table.number("J2", "number")))
        case "axis_ratios":
            first, second = table.vector("axis_ratios", "number", 2)
            return (float(first), float(second))
    first = table.number("a/b", "number") if "a/b" in table else 1.0
    return (first, table.number("a/c", "number") / first if "a/c" in table else 1.0)


def _spheroid(j2: float) -> float:
    """Return the axis ratio a/c of a homogeneous spheroid of this J2, which refers to the radius R of its volume.

    J2 R^2 = (a^2 - c^2)/5 and a^2 c = R^3, so that x = c/R is the positive root of x^3 + 5 J2 x = 1. The others have
    negative real parts.
    """
    return float(np.roots([1.0, 0.0, 5 * j2, -1.0]).real.max() ** -1.5)


def _polyhedron(table: TomlTable) -> Polyhedron:
    """Make a polyhedron, in the system's units, from a file beside this one or from the table itself."""
    if isinstance(table.content["polyhedron"], str):
        with table.naming("polyhedron"):
            return Polyhedron.load(table.path.parent / table.text("polyhedron"))
    mesh = table.table("polyhedron").only("vertices", "faces")
    faces = mesh.take("faces", "lists of three whole numbers")
    mesh.take("vertices", "lists of three numbers")
    with mesh.naming(""):
        return Polyhedron(np.array(mesh.array("vertices", "length")), faces)


def _stokes(table: TomlTable) -> StokesCoefficients:
    """Make a shape from Stokes coefficients, in the system's units, of a file beside this one or of the table."""
    lengths = dict.fromkeys(("reference_radius", "radius"), Number("length"))
    coefficients = table.table("stokes").only("file", "C", "S", *lengths, "inertia", "normalization")
    arguments: dict[str, Any] = coefficients.numbers(lengths)
    arguments["inertia"] = coefficients.number("inertia", "area")
    if "normalization" in coefficients:
        arguments["normalization"] = coefficients.text("normalization")
    with coefficients.naming(""):
        if coefficients.only_key("file", "C") == "file":
            return StokesCoefficients.read(table.path.parent / coefficients.text("file"), **arguments)
        C = coefficients.content["C"]
        return StokesCoefficients(C, coefficients.content.get("S", np.zeros_like(C)), **arguments)
