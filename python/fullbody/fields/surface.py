"""What a particle at rest on a body's surface feels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..base.arguments import integer, named_options
from ..base.units import Units
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..model.gravity import gravity_at
from ..model.state import State
from ..model.system import BaseSystem
from ..typing import Array
from .samples import samples

__all__ = ["SurfaceField", "surface"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SurfaceField(ArrayFields):
    """Fields on a body's surface, at S points with a cell each.

    Attributes
    ----------
    name : str
        Of the body.
    point, normal : ndarray or Quantity, (S, 3)
        Points of the surface and its outward unit normals, body frame.
    area : ndarray or Quantity, (S,)
        Of the cells.
    cells : ndarray or Quantity, (S, 4, 3)
        Corners of the cells, body frame; a triangle has its last one twice.
    longitude, latitude : ndarray or Quantity, (S,)
        Of the points' directions from the centre of mass, radians, body frame.
    geopotential : ndarray or Quantity, (S,)
        Of a particle of unit mass at rest in the body's frame.
    acceleration : ndarray or Quantity, (S, 3)
        Of a particle that is let go there, relative to the surface; body frame.
    slope : ndarray or Quantity, (S,)
        Angle between the outward normal and the upward vertical, which is against the acceleration.
    """

    name: str
    point: Array
    normal: npt.NDArray[np.float64]
    area: Array
    cells: Array
    longitude: Array
    latitude: Array
    geopotential: Array
    acceleration: Array
    slope: Array

    @property
    def surface_acceleration(self) -> Array:
        """The size of the acceleration (S,)."""
        size: Array = np.sqrt((self.acceleration**2).sum(axis=-1))
        return size


@named_options
def surface(system: BaseSystem, state: State, body: int | str = 0, *, rows: int = 36) -> SurfaceField:
    """Geopotential, acceleration and slope on a body's surface, with its rotation and the tide of the other bodies.

    With r from the body's centre of mass, omega its spin, Phi the potential and g the field of all bodies, Phi_o that
    of the others, and a_c the acceleration of the centre, in the body frame,

    ``a = g - a_c - omega x (omega x r) - omega' x r`` and ``V = -(Phi - Phi_o(0)) + a_c.r - |omega x r|^2 / 2``.

    a_c and omega' come from the mutual forces and torques. Forces from outside are left out. V has no part for omega',
    which has no potential.

    Parameters
    ----------
    system : System
    state : State
    body : int or str
        Its place or name.
    rows : int
        Rows of cells from pole to pole of an ellipsoid. A polyhedron has its faces, a composite the surfaces of its
        parts outside of each other.

    Returns
    -------
    SurfaceField

    Raises
    ------
    InvalidInput
        For a body without a surface: a point mass.

    Notes
    -----
    The geopotential and slope of Scheeres (2012), "Orbital Motion in Strongly Perturbed Environments", with the tide.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> field = fullbody.fields.surface(system, state, "Beta", rows=18)
    >>> field.slope.shape, bool(field.slope.max() < 0.5)
    ((648,), True)
    """
    place, units = system._place(body, "body"), system._units
    count = integer(rows)
    if count is None or count < 2:
        raise InvalidInput(f"rows is {rows!r}; expected a whole number, 2 or more")
    core, own = system._strip(state), system._core_bodies()[place]
    found = samples(own, count)
    if not len(found.points):
        raise InvalidInput(f"{system.names[place]} has no surface; expected a body that is no point mass")
    r, turn, spin = found.points, core.rotation_matrix[place], core.spin[place]
    here, pose = core.position[place], (core.position[None], core.attitude[None])
    all_bodies = gravity_at(system._attracting, *pose, here + r @ turn.T, Units())
    rest = [gravity_at(system._attracting, *pose, here, Units(), k) for k in range(len(system)) if k != place]
    others = sum(float(other.potential) for other in rest)
    loads = system.interactions(state)
    force, torque = (units.strip(v, d, d)[place] for v, d in ((loads.force, "force"), (loads.torque, "torque")))
    centre = turn.T @ force / own.mass
    turning = np.cross(spin, r)
    spin_up = (torque - np.cross(spin, own.inertia * spin)) / own.inertia
    acceleration = all_bodies.field @ turn - centre - np.cross(spin, turning) - np.cross(spin_up, r)
    geopotential = others - all_bodies.potential + r @ centre - 0.5 * (turning**2).sum(axis=1)
    across = np.linalg.norm(np.cross(acceleration, found.normals), axis=1)
    diagonals = found.cells[:, 2] - found.cells[:, 0], found.cells[:, 3] - found.cells[:, 1]
    return SurfaceField(
        name=system.names[place],
        point=units.attach(r, "length"),
        normal=found.normals,
        area=units.attach(0.5 * np.linalg.norm(np.cross(*diagonals), axis=1), "area"),
        cells=units.attach(found.cells, "length"),
        longitude=units.attach(np.arctan2(r[:, 1], r[:, 0]), "angle"),
        latitude=units.attach(np.arctan2(r[:, 2], np.hypot(r[:, 0], r[:, 1])), "angle"),
        geopotential=units.attach(geopotential, "potential"),
        acceleration=units.attach(acceleration, "acceleration"),
        slope=units.attach(np.arctan2(across, -(acceleration * found.normals).sum(axis=1)), "angle"),
    )
