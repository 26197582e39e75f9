"""Acceleration, geopotential and slope on the surface of a body, for a particle at rest on it."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..base.kinds import whole_number
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
class _Surface(ArrayFields):
    """The geometry of a surface, as :class:`SurfaceField` describes it."""

    name: str
    point: Array
    normal: Floats
    area: Array
    cells: Array
    longitude: Array
    latitude: Array


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SurfaceField(_Surface):
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

    geopotential: Array
    acceleration: Array
    slope: Array

    @property
    def surface_acceleration(self) -> Array:
        """Magnitudes (S,) of the acceleration."""
        return np.sqrt((self.acceleration**2).sum(axis=-1))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class SurfaceRange(_Surface):
    """Smallest and largest slope and acceleration at each of S points of a body's surface along a run.

    Attributes
    ----------
    name, point, normal, area, cells, longitude, latitude
        Geometry of the surface, as in a :class:`SurfaceField`.
    least_slope, greatest_slope : ndarray or Quantity, (S,)
    least_surface_acceleration, greatest_surface_acceleration : ndarray or Quantity, (S,)
    """

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
    body, rows
        As for :func:`surface`.

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
    extremes: dict[str, Any] = {}
    for k in range(len(run)):
        field = surface(run.system, run[k], body, rows=rows)
        for quantity in ("slope", "surface_acceleration"):
            value = getattr(field, quantity)
            for name, extreme in ((f"least_{quantity}", np.minimum), (f"greatest_{quantity}", np.maximum)):
                extremes[name] = extreme(extremes.get(name, value), value)
    return SurfaceRange(**{part.name: getattr(field, part.name) for part in fields(_Surface)}, **extremes)


def surface(system: SystemLike, state: State, body: int | str = 0, *, rows: int = 36) -> SurfaceField:
    """Compute geopotential, acceleration and slope on a body's surface, with its rotation and the others' tide.

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
        The body's index in the system, or its name; not a point mass, which has no surface.
    rows : int
        Number of rows of cells from pole to pole of an ellipsoid. For a polyhedron its faces are used, for a composite
        the surfaces of its parts outside of each other.

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
    context, count = system.context, whole_number(rows, "rows", 2)
    index, attach = context.index(body, "body"), context.units.attach
    core, core_body = strip(state, context), context.bodies[index]
    r, normals, cells = samples(core_body, count)
    if not len(r):
        raise InvalidInput(f"{context.names[index]} has no surface; expected a body other than a point mass")
    rotation, spin = core.rotation_matrix[index], core.spin[index]
    centre, poses = core.position[index], (core.position[None], core.attitude[None])
    all_bodies = gravity_at(context.attraction, *poses, centre + r @ rotation.T, Units())
    others = [k for k in range(len(context)) if k != index]
    other_potential = sum(float(gravity_at(context.attraction, *poses, centre, Units(), k).potential) for k in others)
    loads = interactions(system, state)
    force, torque = (context.units.strip(getattr(loads, name), name, name)[index] for name in ("force", "torque"))
    centre_acceleration = rotation.T @ force / core_body.mass
    rotation_velocity = np.cross(spin, r)
    spin_rate = (torque - np.cross(spin, core_body.inertia * spin)) / core_body.inertia
    acceleration = all_bodies.field @ rotation - centre_acceleration
    acceleration -= np.cross(spin, rotation_velocity) + np.cross(spin_rate, r)
    geopotential = other_potential - all_bodies.potential + r @ centre_acceleration
    geopotential -= 0.5 * (rotation_velocity**2).sum(axis=1)
    tangential = np.linalg.norm(np.cross(acceleration, normals), axis=1)
    diagonals = (cells[:, 2] - cells[:, 0], cells[:, 3] - cells[:, 1])
    return SurfaceField(
        name=context.names[index],
        point=attach(r, "length"),
        normal=normals,
        area=attach(0.5 * np.linalg.norm(np.cross(*diagonals), axis=1), "area"),
        cells=attach(cells, "length"),
        longitude=attach(np.arctan2(r[:, 1], r[:, 0]), "angle"),
        latitude=attach(np.arctan2(r[:, 2], np.hypot(r[:, 0], r[:, 1])), "angle"),
        geopotential=attach(geopotential, "potential"),
        acceleration=attach(acceleration, "acceleration"),
        slope=attach(np.arctan2(tangential, -(acceleration * normals).sum(axis=1)), "angle"),
    )


class Samples(NamedTuple):
    """Sample points (S, 3), unit normals (S, 3) and the corners of cells (S, 4, 3), in the body frame."""

    points: Floats
    normals: Floats
    cells: Floats


def samples(body: _core.Body, rows: int) -> Samples:
    """Sample points on the surface of a body: one per cell of each part with positive mass.

    Points inside another part are left out, and a point mass has none. An ellipsoid has ``rows`` rows of cells from
    pole to pole, and points on the surface itself. A polyhedron has its faces and their centres. The corners of a
    triangle contain the last one twice.
    """
    matter = [part for part in body.parts if part[0] is not None and part[1] > 0.0]
    if any(isinstance(shape, _core.StokesCoefficients) for shape, *_ in matter):
        raise InvalidInput("the body is given by its Stokes coefficients; expected one with a surface")
    parts = [Samples(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4, 3)))]
    for part in matter:
        sampled = _of_part(*part, rows)
        if len(matter) > 1:
            outside = ~np.any([_is_inside(other, sampled.points) for other in matter if other is not part], axis=0)
            sampled = Samples(*(values[outside] for values in sampled))
        parts.append(sampled)
    return Samples(*map(np.concatenate, zip(*parts, strict=True)))


def _of_part(shape: Any, mass: float, position: Any, rotation: Any, rows: int) -> Samples:
    matrix = np.array(rotation)
    if isinstance(shape, _core.Polyhedron):
        cells = shape.vertices[shape.faces]
        normals = np.cross(cells[:, 1] - cells[:, 0], cells[:, 2] - cells[:, 0])
        points, cells = cells.mean(axis=1), cells[:, [0, 1, 2, 2]]
    else:
        axes = np.array(shape)
        grid = _directions(np.arange(rows + 1), np.arange(2 * rows + 1), rows)
        corners = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2)
        centres = _directions(np.arange(rows) + 0.5, np.arange(2 * rows) + 0.5, rows).reshape(-1, 3)
        points, cells, normals = axes * centres, axes * corners.reshape(-1, 4, 3), centres / axes
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    return Samples(points @ matrix.T + position, normals @ matrix.T, cells @ matrix.T + position)


def _directions(row: Any, column: Any, rows: int) -> Floats:
    """Return unit vectors of a grid, with rows from the pole on and columns in longitude."""
    polar, longitude = np.meshgrid(np.pi * row / rows, np.pi * column / rows - np.pi, indexing="ij")
    ring = np.sin(polar)
    return np.stack([ring * np.cos(longitude), ring * np.sin(longitude), np.cos(polar)], axis=-1)


def _is_inside(part: Any, points: Floats) -> npt.NDArray[np.bool_]:
    """Return whether each point lies inside a part, where the divergence of its gravity is not zero."""
    shape, mass, position, rotation = part
    alone = _core.Attraction([_core.Body("part", shape, mass)], 1.0, "auto")
    local = np.ascontiguousarray((points - position) @ np.array(rotation))
    position, attitude = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
    gradient = np.empty((len(local), 3, 3))
    alone.gravity(position, attitude, None, local, [len(local)], None, [gradient])
    volume = shape.volume if isinstance(shape, _core.Polyhedron) else 4.0 / 3.0 * np.pi * np.prod(shape)
    return np.trace(gradient, axis1=1, axis2=2) < -2.0 * np.pi * mass / volume
