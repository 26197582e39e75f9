"""The tables ``[[forces]]`` of a ``system.toml``, and the state that its ``[[body]]`` describe: orbits, rotations."""

from __future__ import annotations

from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base import rotations
from ..base.kinds import Kind, Number, direction, kinds_of
from ..forces import BinaryYarkovsky, Byorp, Force, ThirdBody, Tide, Yorp
from ..forces.radiation import torque_dimension
from ..frames import attitude as attitude_of_pole
from ..frames import rotate_pole
from ..model.state import State, from_numbers
from ..motion.system import System
from ..orbit.elements import DIMENSIONS, KeplerElements
from ..typing import Floats
from .toml_table import TomlTable

#: The elements of an orbit, also by other words for angles, with their dimensions.
ELEMENTS = DIMENSIONS | dict.fromkeys(("f", "l", "pomega", "theta"), "angle")
#: The keys of an attitude.
ANGLES = ("attitude", "angles", "pole", "pole_frame", "rotation_angle")
_KINDS: dict[str, type[Force]] = {kind.__name__: kind for kind in (ThirdBody, Tide, Yorp, Byorp, BinaryYarkovsky)}


def elements(table: TomlTable) -> KeplerElements[Any]:
    """Make the orbit of a table, in its units."""
    names = [name for name in ELEMENTS if name in table or name in ("a", "e", "i", "Omega")]
    numbers = {name: table.number(name, ELEMENTS[name]) for name in names}
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


@dataclass(frozen=True, slots=True)
class _Orbit:
    """A body's orbit: indices of the bodies about whose barycentre it goes, elements, mu, position and velocity."""

    about: list[int]
    shape: KeplerElements
    mu: float
    position: Floats
    velocity: Floats


def state_of(run: TomlTable, system: System, rows: list[TomlTable]) -> State:
    """Make the state of the tables of the bodies; ``run`` holds the time and the choice of the origin."""
    masses = system.context.masses
    names = list(system.names)
    orbits = [_orbit(row, names, masses, system.context.G, k) for k, row in enumerate(rows)]
    position, velocity, spins = np.zeros((3, len(rows), 3))
    attitudes = np.zeros((len(rows), 4))
    for k in _order(rows, orbits):
        if (orbit := orbits[k]) is None:
            if k > 0 and "position" not in rows[k]:
                raise rows[k].fault("", "has no position and no orbit; expected one of them")
            for key, values, dimension in (("position", position, "length"), ("velocity", velocity, "velocity")):
                values[k] = rows[k].vector(key, dimension, 3) if key in rows[k] else 0.0
        else:
            shares = masses[orbit.about] / masses[orbit.about].sum()
            position[k] = shares @ position[orbit.about] + orbit.position
            velocity[k] = shares @ velocity[orbit.about] + orbit.velocity
        attitudes[k], spins[k] = _rotation(rows[k], orbit, system.context.frame)
    if run.choice("origin", ("given", "barycentre")) == "barycentre":
        shares = masses / masses.sum()
        position, velocity = position - shares @ position, velocity - shares @ velocity
    start = run.number("start", "time") if "start" in run else 0.0
    with run.naming("start"):
        return from_numbers(system.context, position, velocity, attitudes, spins, start)


def _order(rows: list[TomlTable], orbits: list[_Orbit | None]) -> list[int]:
    """Return the indices of the bodies so that each comes after those about which it orbits."""
    try:
        return list(
            TopologicalSorter({k: orbit.about if orbit else () for k, orbit in enumerate(orbits)}).static_order()
        )
    except CycleError as error:
        raise rows[min(error.args[1])].table("orbit").fault("about", "is a body that orbits about this one") from error


def _orbit(table: TomlTable, names: list[str], masses: Floats, G: float, k: int) -> _Orbit | None:
    """Return the orbit of a body, or ``None`` if its table has none."""
    if "orbit" not in table:
        return None
    if keys := [key for key in ("position", "velocity") if key in table]:
        raise table.fault("", f"has {' and '.join([*keys, 'orbit'])}; expected an orbit, or position and velocity")
    orbit = table.table("orbit").only("about", *ELEMENTS)
    named = orbit.take("about", "the name of a body, or a list of names")
    about = named if isinstance(named, list) else [named]
    if not about or any(names.count(name) != 1 or names.index(name) == k for name in about):
        possible = ", ".join(name for j, name in enumerate(names) if j != k)
        raise orbit.fault("about", f"is {named!r}; expected the name of another body, or a list of names: {possible}")
    indices = [names.index(name) for name in about]
    shape = elements(orbit)
    with orbit.naming(""):
        mu = G * float(masses[[*indices, k]].sum())
        return _Orbit(indices, shape, mu, *shape.to_cartesian(mu))


def _rotation(table: TomlTable, orbit: _Orbit | None, frame: str | None) -> tuple[Floats, Floats]:
    """Return the attitude and the spin of a body.

    With ``pole = "orbit"`` the z-axis is the orbit's pole and the x-axis its node. A synchronous body also points its
    x-axis at what it orbits about, and rotates once in the orbit's period.
    """
    locked = flag(table, "synchronous")
    if not locked and table.content.get("pole") != "orbit":
        return attitude(table, frame), spin(table)
    if locked and (key := next((key for key in (*ANGLES, "spin", "rotation_period") if key in table), None)):
        raise table.fault(key, "is given for a synchronous body; expected none")
    if orbit is None:
        raise table.fault("", "has no orbit; expected one for a pole of 'orbit' and for a synchronous body")
    plane = rotations.of_plane(float(orbit.shape.Omega), float(orbit.shape.i))
    if not locked:
        return plane, spin(table)
    x, y, _ = -orbit.position @ rotations.matrices(plane)
    rate = 2 * np.pi / orbit.shape.period(orbit.mu)
    return rotations.product(plane, rotations.about_axis(2, float(np.arctan2(y, x)))), np.array([0.0, 0.0, rate])


def attitude(table: TomlTable, frame: str | None = None) -> Floats:
    """Return the attitude of a body in a frame, or of a part, as a quaternion: none by default."""
    for key in ("rotation_angle", "pole_frame"):
        if key in table and "pole" not in table:
            raise table.fault(key, "is given without a pole; expected both")
    match table.only_key("attitude", "angles", "pole"):
        case "attitude":
            value = table.vector("attitude", "number", 4)
            if not value.any():
                raise table.fault("attitude", "is zero; expected a quaternion [w, x, y, z]")
            return value
        case "angles":
            return _core.quaternion_of_tait_bryan(table.vector("angles", "angle", 3).tolist())
        case "pole":
            angle = table.number("rotation_angle", "angle") if "rotation_angle" in table else 0.0
            longitude, latitude = table.vector("pole", "angle", 2)
            if "pole_frame" in table:
                with table.naming("pole_frame"):
                    longitude, latitude = rotate_pole(longitude, latitude, table.text("pole_frame"), frame)
            with table.naming("pole"):
                return attitude_of_pole(longitude, latitude, angle)
    return np.array([1.0, 0.0, 0.0, 0.0])


def flag(table: TomlTable, key: str) -> bool:
    """Return a choice of yes or no; no by default."""
    value = table.content.get(key, False)
    if not isinstance(value, bool):
        raise table.fault(key, f"is {value!r}; expected true or false")
    return value


def spin(table: TomlTable) -> Floats:
    """Return the spin of a body in its own frame: none by default."""
    match table.only_key("spin", "rotation_period"):
        case "spin":
            return table.vector("spin", "spin", 3)
        case "rotation_period":
            period = table.number("rotation_period", "time")
            if period == 0.0:
                raise table.fault("rotation_period", "is 0; expected a time, negative for a retrograde spin")
            return np.array([0.0, 0.0, 2.0 * np.pi / period])
    return np.zeros(3)
