"""Acceleration, geopotential and slope on the surface of a body, for a particle at rest on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base.kinds import whole
from ..base.units import Units
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..model.gravity import gravity_at
from ..model.interactions import interactions
from ..model.state import State, strip
from ..record.record import Record
from ..typing import Array, Floats


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SurfaceField(ArrayFields):
    """Fields on a body's surface, at S points with a cell each.

    Attributes
    ----------
    name : str
        Name of the body.
    point, normal : ndarray or Quantity, (S, 3)
        Points of the surface and outward unit normals there, in the body frame.
    area : ndarray or Quantity, (S,)
        Areas of the cells.
    cells : ndarray or Quantity, (S, 4, 3)
        Corners of the cells in the body frame; a triangle has its last corner twice.
    longitude, latitude : ndarray or Quantity, (S,)
        Directions of the points from the centre of mass, radians, in the body frame.
    geopotential : ndarray or Quantity, (S,)
        Geopotential of a particle of unit mass at rest in the body's frame.
    acceleration : ndarray or Quantity, (S, 3)
        Initial acceleration of a particle released there, relative to the surface, in the body frame.
    slope : ndarray or Quantity, (S,)
        Angle between the outward normal and the upward vertical, which is opposite to the acceleration.
    """

    name: str
    point: Array
    normal: Floats
    area: Array
    cells: Array
    longitude: Array
    latitude: Array
    geopotential: Array
    acceleration: Array
    slope: Array

    @property
    def surface_acceleration(self) -> Array:
        """Magnitudes (S,) of the acceleration."""
        return np.sqrt((self.acceleration**2).sum(axis=-1))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SurfaceRange(ArrayFields):
    """Smallest and largest slope and acceleration at each of S points of a body's surface along a run.

    Attributes
    ----------
    name, point, normal, area, cells, longitude, latitude
        Geometry of the surface, as in a :class:`SurfaceField`.
    least_slope, greatest_slope : ndarray or Quantity, (S,)
    least_surface_acceleration, greatest_surface_acceleration : ndarray or Quantity, (S,)
    """

    name: str
    point: Array
    normal: Floats
    area: Array
    cells: Array
    longitude: Array
    latitude: Array
    least_slope: Array
    greatest_slope: Array
    least_surface_acceleration: Array
    greatest_surface_acceleration: Array


def surface_along(run: Record, body: int | str = 0, *, rows: int = 36) -> SurfaceRange:
    """Compute the smallest and the largest slope and acceleration at each point of a body's surface along a run.

    They change if a body librates, rolls or comes nearer to the other one; the largest slope decides whether loose
    matter stays in place.

    Parameters
    ----------
    run : Run
        The run whose samples are examined; some thirty samples in each libration or revolution give extremes to a few
        parts in a thousand of their change.
    body : int or str
        The body's index in the system, or its name.
    rows : int
        Number of rows of cells, as for :func:`surface`.

    Returns
    -------
    SurfaceRange

    Raises
    ------
    InvalidInput
        For a run without samples, and for the reasons given at :func:`surface`.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state.rotated("Beta", [0, 0, 1], 0.2), 17.0, output=1.0)
    >>> found = fullbody.fields.surface_along(run, "Beta", rows=12)
    >>> bool((found.greatest_slope > found.least_slope).all())
    True
    """
    if not isinstance(run, Record) or not len(run):
        raise InvalidInput(f"run is {run!r}; expected a fullbody.Run with samples")
    first = surface(run.system, run[0], body, rows=rows)
    low: Any = [first.slope, first.surface_acceleration]
    high: Any = list(low)
    for k in range(1, len(run)):
        field = surface(run.system, run[k], body, rows=rows)
        for index, surface_samples in enumerate((field.slope, field.surface_acceleration)):
            low[index], high[index] = np.minimum(low[index], surface_samples), np.maximum(high[index], surface_samples)
    points = {name: getattr(first, name) for name in SurfaceRange.__slots__[:7]}
    return SurfaceRange(
        **points,
        least_slope=low[0],
        greatest_slope=high[0],
        least_surface_acceleration=low[1],
        greatest_surface_acceleration=high[1],
    )


def surface(system: SystemLike, state: State, body: int | str = 0, *, rows: int = 36) -> SurfaceField:
    """Compute geopotential, acceleration and slope on a body's surface, with its rotation and the tide of the other
    bodies.

    With r from the body's centre of mass, omega its spin, Phi the potential and g the field of all bodies, Phi_o the
    potential of the other bodies, and a_c the acceleration of the centre, in the body frame,

    ``a = g - a_c - omega x (omega x r) - omega' x r`` and ``V = -(Phi - Phi_o(0)) + a_c.r - |omega x r|^2 / 2``.

    The mutual forces and torques give a_c and omega'. External forces are left out. V has no term for omega', which has
    no potential.

    Parameters
    ----------
    system : System
    state : State
    body : int or str
        The body's index in the system, or its name.
    rows : int
        Number of rows of cells from pole to pole of an ellipsoid. For a polyhedron its faces are used, for a composite
        the surfaces of its parts outside of each other.

    Returns
    -------
    SurfaceField

    Raises
    ------
    InvalidInput
        For a body without a surface, which is a point mass.

    Notes
    -----
    Geopotential and slope are those of Scheeres (2012), "Orbital Motion in Strongly Perturbed Environments", with the
    tide.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> field = fullbody.fields.surface(system, state, "Beta", rows=18)
    >>> field.slope.shape, bool(field.slope.max() < 0.5)
    ((648,), True)
    """
    index, units = system.context.index(body, "body"), system.context.units
    count = whole(rows, "rows", 2)
    core, this_body = strip(state, system.context), system.context.bodies[index]
    surface_samples = samples(this_body, count)
    if not len(surface_samples.points):
        raise InvalidInput(f"{system.context.names[index]} has no surface; expected a body other than a point mass")
    r, rotation, spin = surface_samples.points, core.rotation_matrix[index], core.spin[index]
    here, pose = core.position[index], (core.position[None], core.attitude[None])
    all_bodies = gravity_at(system.context.attraction, *pose, here + r @ rotation.T, Units())
    others_at_centre = [
        gravity_at(system.context.attraction, *pose, here, Units(), k) for k in range(len(system.context)) if k != index
    ]
    others = sum(float(other.potential) for other in others_at_centre)
    loads = interactions(system, state)
    force, torque = (units.strip(v, d, d)[index] for v, d in ((loads.force, "force"), (loads.torque, "torque")))
    centre = rotation.T @ force / this_body.mass
    rotation_velocity = np.cross(spin, r)
    spin_up = (torque - np.cross(spin, this_body.inertia * spin)) / this_body.inertia
    acceleration = all_bodies.field @ rotation - centre - np.cross(spin, rotation_velocity) - np.cross(spin_up, r)
    geopotential = others - all_bodies.potential + r @ centre - 0.5 * (rotation_velocity**2).sum(axis=1)
    across = np.linalg.norm(np.cross(acceleration, surface_samples.normals), axis=1)
    diagonals = (
        surface_samples.cells[:, 2] - surface_samples.cells[:, 0],
        surface_samples.cells[:, 3] - surface_samples.cells[:, 1],
    )
    return SurfaceField(
        name=system.context.names[index],
        point=units.attach(r, "length"),
        normal=surface_samples.normals,
        area=units.attach(0.5 * np.linalg.norm(np.cross(*diagonals), axis=1), "area"),
        cells=units.attach(surface_samples.cells, "length"),
        longitude=units.attach(np.arctan2(r[:, 1], r[:, 0]), "angle"),
        latitude=units.attach(np.arctan2(r[:, 2], np.hypot(r[:, 0], r[:, 1])), "angle"),
        geopotential=units.attach(geopotential, "potential"),
        acceleration=units.attach(acceleration, "acceleration"),
        slope=units.attach(np.arctan2(across, -(acceleration * surface_samples.normals).sum(axis=1)), "angle"),
    )


@dataclass(frozen=True, slots=True)
class Samples:
    """Sample points (S, 3), unit normals (S, 3) and the corners of cells (S, 4, 3), in the body frame."""

    points: Floats
    normals: Floats
    cells: Floats

    def chosen(self, which: npt.NDArray[np.bool_]) -> Samples:
        """Return the samples that a mask selects."""
        return Samples(self.points[which], self.normals[which], self.cells[which])


def samples(body: _core.Body, rows: int) -> Samples:
    """Sample points on the surface of a body: one per cell of each part with positive mass.

    Points inside another part are left out, and a point mass has none. An ellipsoid has ``rows`` rows of cells from
    pole to pole, and points on the surface itself. A polyhedron has its faces and their centres. The corners of a
    triangle contain the last one twice.
    """
    matter = [part for part in body.parts if part[0] is not None and part[1] > 0.0]
    if any(isinstance(shape, _core.StokesCoefficients) for shape, *_ in matter):
        raise InvalidInput("the body is given by its Stokes coefficients; expected one with a surface")
    found = [_of_part(*part, rows) for part in matter]
    if len(matter) > 1:
        found = [
            one.chosen(~np.any([_within(other, one.points) for other in matter if other is not part], axis=0))
            for one, part in zip(found, matter, strict=True)
        ]
    empty = (np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4, 3)))
    names = ("points", "normals", "cells")
    all_of = ([none, *(getattr(one, name) for one in found)] for none, name in zip(empty, names, strict=True))
    return Samples(*map(np.concatenate, all_of))


def _of_part(shape: Any, mass: float, position: Any, rotation: Any, rows: int) -> Samples:
    turn = np.array(rotation)
    if isinstance(shape, _core.Polyhedron):
        cells = shape.vertices[shape.faces]
        normals = np.cross(cells[:, 1] - cells[:, 0], cells[:, 2] - cells[:, 0])
        points, cells = cells.mean(axis=1), cells[:, [0, 1, 2, 2]]
    else:
        axes = np.array(shape)
        ends = _ball(np.arange(rows + 1), np.arange(2 * rows + 1), rows)
        corners = np.stack([ends[:-1, :-1], ends[1:, :-1], ends[1:, 1:], ends[:-1, 1:]], axis=2)
        middle = _ball(np.arange(rows) + 0.5, np.arange(2 * rows) + 0.5, rows).reshape(-1, 3)
        points, cells, normals = axes * middle, axes * corners.reshape(-1, 4, 3), middle / axes
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return Samples(points @ turn.T + position, normals @ turn.T, cells @ turn.T + position)


def _ball(row: Any, column: Any, rows: int) -> Floats:
    """Return unit vectors of a grid, with rows from the pole on and columns in longitude."""
    polar, longitude = np.meshgrid(np.pi * row / rows, np.pi * column / rows - np.pi, indexing="ij")
    ring = np.sin(polar)
    return np.stack([ring * np.cos(longitude), ring * np.sin(longitude), np.cos(polar)], axis=-1)


def _within(part: Any, points: Floats) -> npt.NDArray[np.bool_]:
    """Return whether each point lies inside a part, where the divergence of its gravity is not zero."""
    shape, mass, position, rotation = part
    alone = _core.Attraction([_core.Body("part", shape, mass)], 1.0, "auto")
    local = np.ascontiguousarray((points - position) @ np.array(rotation))
    centre, unturned = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
    gradient = np.empty((len(local), 3, 3))
    alone.gravity(centre, unturned, None, local, [len(local)], None, [gradient])
    volume = shape.volume if isinstance(shape, _core.Polyhedron) else 4.0 / 3.0 * np.pi * np.prod(shape)
    return np.trace(gradient, axis1=1, axis2=2) < -2.0 * np.pi * mass / volume
