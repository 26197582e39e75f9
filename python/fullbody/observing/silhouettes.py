"""Silhouettes of bodies as seen along a direction, and the rays that bodies hide."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import _core
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats


@dataclass(frozen=True, slots=True)
class Solid:
    """A part of a body in its pose: an ellipsoid, or a polyhedron with its corners.

    Attributes
    ----------
    centre : ndarray, (3,)
    columns : ndarray, (3, 3)
        The semi-axes of an ellipsoid as vectors; for a polyhedron those of a sphere around it.
    corners : ndarray or None, (V, 3)
        The corners of a polyhedron.
    faces : ndarray or None, (F, 3)
        The indices of the corners of its faces.
    """

    centre: Floats
    columns: Floats
    corners: Any = None
    faces: Any = None


@dataclass(frozen=True, slots=True)
class LimbPoints:
    """Points of a limb: positions (n, 3), outward normals across the line of sight (n, 3), and whether there is one."""

    points: Floats
    normals: Floats
    exists: Any


def solids(system: SystemLike, body: int, centre: Floats, matrix: Floats) -> list[Solid]:
    """Return the parts of a body with surfaces, at centres (..., 3) and rotation matrices (..., 3, 3), without voids.

    The poses may be complex. A point has no parts, and Stokes coefficients raise an error.
    """
    found = []
    for shape, mass, position, rotation in system.context.bodies[body].parts:
        if isinstance(shape, _core.StokesCoefficients):
            name = system.context.names[body]
            raise InvalidInput(
                f"{name} has Stokes coefficients, which give no surface; expected a shape with an outline"
            )
        if shape is None or mass <= 0.0:
            continue
        place, own = centre + matrix @ np.array(position), matrix @ np.array(rotation)
        if isinstance(shape, _core.Polyhedron):
            corners = place[..., None, :] + shape.vertices @ np.swapaxes(own, -1, -2)
            found.append(Solid(place, own * shape.circumradius, corners, shape.faces))
        else:
            found.append(Solid(place, own * np.array(shape)))
    return found


def limb(parts: list[Solid], centre: Floats, sight: Floats, axes: Floats, directions: Floats) -> LimbPoints:
    """Return the outermost points of a body's limb on rays from its centre across the line of sight.

    Parameters
    ----------
    parts : list of Solid
    centre : ndarray, (3,)
    sight : ndarray, (3,)
        The unit vector to the observer.
    axes : ndarray, (2, 3)
        Unit vectors across the line of sight.
    directions : ndarray, (n, 2)
        Unit vectors of the rays along these.
    """
    count = len(directions)
    best, points, normals = np.zeros(count), np.tile(centre, (count, 1)), np.zeros((count, 3))
    for part in parts:
        reach, where, outward = (_round_limb if part.corners is None else _edged_limb)(
            part, centre, sight, axes, directions
        )
        outermost = reach > best
        best = np.where(outermost, reach, best)
        points[outermost], normals[outermost] = where[outermost], outward[outermost]
    return LimbPoints(points, normals, best > 0.0)


def _round_limb(
    part: Solid, centre: Floats, sight: Floats, axes: Floats, directions: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return distances (n,) from the centre to the outline of an ellipsoid along rays, with points and normals."""
    matrix = part.columns @ part.columns.T
    inverse = np.linalg.inv(axes @ matrix @ axes.T)
    middle = axes @ (part.centre - centre)
    square = np.einsum("nx,xy,ny->n", directions, inverse, directions)
    half = directions @ inverse @ middle
    discriminant = half**2 - square * (middle @ inverse @ middle - 1.0)
    reach = np.where(discriminant > 0.0, half + np.sqrt(np.maximum(discriminant, 0.0)), 0.0) / square
    normals = (reach[:, None] * directions - middle) @ inverse @ axes
    # The tangent plane at a point x has the normal Q^-1 x.
    tangent = normals @ matrix
    size = np.sqrt(np.maximum(np.einsum("nx,nx->n", normals, tangent), np.finfo(float).tiny))
    return reach, part.centre + tangent / size[:, None], normals


def silhouette_edges(corners: Floats, faces: Any, sight: Floats) -> Any:
    """Return the indices (E, 2) of the ends of edges between faces toward the observer and faces turned away.

    They run counterclockwise about the faces that are turned to the observer.
    """
    a, b, c = (corners[faces[:, k]] for k in range(3))
    seen = np.cross(b - a, c - a) @ sight > 0.0
    sides = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    mine = np.tile(seen, 3)
    count = len(corners)
    keys, back = sides[:, 0] * count + sides[:, 1], sides[:, 1] * count + sides[:, 0]
    order = np.argsort(keys)
    neighbour = mine[order][np.searchsorted(keys, back, sorter=order)]
    return sides[mine & ~neighbour]


def _edged_limb(
    part: Solid, centre: Floats, sight: Floats, axes: Floats, directions: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return distances (n,) from the centre to the outline of a polyhedron along rays, with points and normals."""
    ends = part.corners[silhouette_edges(part.corners, part.faces, sight)]
    p, q = ((ends[:, k] - centre) @ axes.T for k in (0, 1))
    along = q - p
    # A ray t d meets an edge p + s (q - p) where d x (p + s (q - p)) = 0.
    across = directions[:, [0]] * along[:, 1] - directions[:, [1]] * along[:, 0]
    offset = directions[:, [0]] * p[:, 1] - directions[:, [1]] * p[:, 0]
    share = np.divide(-offset, across, out=np.full_like(across, -1.0), where=across != 0.0)
    reach = directions @ p.T + share * (directions @ along.T)
    reach = np.where((share >= 0.0) & (share <= 1.0), reach, 0.0)
    edge = np.argmax(reach, axis=1)
    rows = np.arange(len(directions))
    points = ends[edge, 0] + share[rows, edge, None] * (ends[edge, 1] - ends[edge, 0])
    sides = np.cross(ends[:, 1] - ends[:, 0], sight)
    return np.maximum(reach[rows, edge], 0.0), points, sides[edge]


def hides(parts: list[Solid], centre: Floats, points: Floats, directions: Floats) -> Any:
    """Return whether a body with these parts hides each of the points (n, 3) along unit vectors (n, 3).

    A polyhedron hides the points that are behind its centre and within its silhouette, where that is met once on
    each ray from its centre.
    """
    hidden = np.zeros(len(points), dtype=bool)
    for part in parts:
        if part.corners is None:
            inverse = np.linalg.inv(part.columns)
            x, d = (points - part.centre) @ inverse.T, directions @ inverse.T
            along, outside = np.sum(x * d, axis=1), np.sum(x * x, axis=1) - 1.0
            hidden |= (along < 0.0) & (along**2 > np.sum(d * d, axis=1) * outside)
            continue
        # The silhouette along the mean direction serves for all points, whose directions hardly differ.
        sight = directions.mean(axis=0)
        sight /= np.linalg.norm(sight)
        axes = np.concatenate(across(sight[None]))
        from_centre = points - part.centre
        behind = from_centre @ sight < 0.0
        flat = from_centre @ axes.T
        size = np.linalg.norm(flat, axis=1)
        rays = flat / np.where(size > 0.0, size, 1.0)[:, None]
        reach = _edged_limb(part, part.centre, sight, axes, np.where(size[:, None] > 0.0, rays, [1.0, 0.0]))[0]
        hidden |= behind & (size < reach)
    return hidden


def across(directions: Any) -> tuple[Any, Any]:
    """Return two unit vectors (M, 3) across directions (M, 3), right-handed with them; they may be complex."""
    fixed = np.eye(3)[np.argmin(np.abs(directions.real), axis=-1)]
    first = np.cross(directions, fixed)
    first = first / np.sqrt(np.sum(first * first, axis=-1))[:, None]
    return first, np.cross(directions, first)
