"""The state that the tables ``[[body]]`` of a ``system.toml`` describe: positions, orbits, attitudes and spins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..base import rotations
from ..model.state import State, from_numbers
from ..motion.system import System
from ..orbit.elements import KeplerElements
from .toml_attitudes import ANGLES, attitude, flag, spin
from .toml_forces import ELEMENTS, elements
from .toml_table import TomlTable

__all__ = ["state_of"]

_Array = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Orbit:
    """A body's orbit: indices of the bodies about whose barycentre it goes, elements, mu, position and velocity."""

    about: list[int]
    shape: KeplerElements
    mu: float
    position: _Array
    velocity: _Array


def state_of(run: TomlTable, system: System, rows: list[TomlTable]) -> State:
    """Make the state of the tables of the bodies; ``run`` holds the time and the choice of the origin."""
    masses = system.context.masses
    names = list(system.names)
    orbits = [_orbit(row, names, masses, system.context.G, k) for k, row in enumerate(rows)]
    position, velocity, spins = np.zeros((3, len(rows), 3))
    attitudes = np.zeros((len(rows), 4))
    for k in _order(rows, orbits, names):
        if (orbit := orbits[k]) is None:
            position[k], velocity[k] = _pose(rows[k], k)
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


def _order(rows: list[TomlTable], orbits: list[_Orbit | None], names: list[str]) -> list[int]:
    """Return the indices of the bodies so that each comes after those about which it orbits."""
    order: list[int] = []
    while len(order) < len(rows):
        ready = [
            k for k, orbit in enumerate(orbits) if k not in order and (orbit is None or set(orbit.about) <= set(order))
        ]
        if not ready:
            first = next(k for k in range(len(rows)) if k not in order)
            raise rows[first].table("orbit").fault("about", "is a body that orbits about this one")
        order += ready
    return order


def _orbit(table: TomlTable, names: list[str], masses: _Array, G: float, k: int) -> _Orbit | None:
    """Return the orbit of a body, or ``None`` if its table has none."""
    if "orbit" not in table:
        return None
    others = [key for key in ("position", "velocity") if key in table]
    if others:
        keys = " and ".join([*others, "orbit"])
        raise table.fault("", f"has {keys}; expected an orbit, or position and velocity")
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


def _pose(table: TomlTable, k: int) -> tuple[_Array, _Array]:
    """Return the position and the velocity of a body without an orbit."""
    if k > 0 and "position" not in table:
        raise table.fault("", "has no position and no orbit; expected one of them")
    position = table.vector("position", "length", 3) if "position" in table else np.zeros(3)
    return position, table.vector("velocity", "velocity", 3) if "velocity" in table else np.zeros(3)


def _rotation(table: TomlTable, orbit: _Orbit | None, frame: str | None) -> tuple[_Array, _Array]:
    """Return the attitude and the spin of a body.

    With ``pole = "orbit"`` the z-axis is the orbit's pole and the x-axis its node. A synchronous body also points its
    x-axis at what it orbits about, and turns once in the orbit's period.
    """
    locked = flag(table, "synchronous")
    if not locked and table.content.get("pole") != "orbit":
        return attitude(table, frame), spin(table)
    if locked and (key := next((key for key in (*ANGLES, "spin", "rotation_period") if key in table), None)):
        raise table.fault(key, "is given for a synchronous body; expected none")
    if orbit is None:
        raise table.fault("", "has no orbit; expected one for a pole of 'orbit' and for a synchronous body")
    plane = rotations.product(
        rotations.about_axis(2, float(orbit.shape.Omega)), rotations.about_axis(0, float(orbit.shape.i))
    )
    if not locked:
        return plane, spin(table)
    x, y, _ = -orbit.position @ rotations.matrices(plane)
    rate = 2 * np.pi / orbit.shape.period(orbit.mu)
    return rotations.product(plane, rotations.about_axis(2, float(np.arctan2(y, x)))), np.array([0.0, 0.0, rate])
