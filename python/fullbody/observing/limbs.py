"""Limbs of bodies: whether a ray passes through a body, how far it passes from its edge, and where its outline is.

A ray is given in the body's frame by a point ``w`` (..., 3) on it, from the body's centre, and its unit direction
``u``. Each limb has a measure that is negative where the ray passes through the body and zero where it touches it. For
an ellipsoid with the semi-axes A, with p = A^-1 w and q = A^-1 u, it is abs(p x q)^2 / abs(q)^2 - 1, a quadratic
function of w. For a polyhedron it is the distance from the outline, which the core computes with its derivatives. Both
take complex numbers, so that a step along the imaginary axis gives their derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

import fullbody._core as _core

from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .states import cross

#: The number of points of the outline of an ellipsoid, of normals among which that at the nearest point of an ellipse
#: is sought, and of steps of Newton's method from there.
_POINTS, _NORMALS, _STEPS = 361, 64, 12


class LimbPoints(NamedTuple):
    """Points of a limb: distances (n,) of rays, zero where a ray misses it; positions and outward normals (n, 3)."""

    distances: Floats
    points: Floats
    normals: Floats


class Limb:
    """The limb of a part of a body, whose centre (3,) and rotation matrix (3, 3) are given in the body's frame.

    The ``radius`` is an upper bound of the distance of the part's points from the body's centre.
    """

    def __init__(self, position: Floats, rotation: Floats, radius: float) -> None:
        self.position, self.rotation, self.radius = position, rotation, radius

    def measure(self, w: Any, u: Any) -> Any:
        """Return the measure (...) of rays: negative where they pass through the part."""
        raise NotImplementedError

    def distance(self, w: Any, u: Any) -> Any:
        """Return the distances (...) of rays from the outline along its normal, negative inside it."""
        return self.measure(w, u)

    def length(self, measure: Any) -> Any:
        """Return about how far rays with a measure pass outside the limb, as a length."""
        return measure

    def depth(self, w: Floats, u: Floats) -> Floats:
        """Return numbers (...) that are negative where the part is ahead of the point on its ray."""
        return np.asarray(np.sum((w - self.position) * u, axis=-1))

    def extent(self, normals: Any) -> Any:
        """Return how far (M,) the part reaches along unit vectors (M, 3)."""
        raise NotImplementedError

    def outline(self, u: Floats) -> Floats:
        """Return points (R, 3) on the outline along a direction (3,), with rows of NaN between separate lines."""
        raise NotImplementedError

    def outermost(self, u: Floats, axes: Floats, rays: Floats) -> LimbPoints:
        """Return the outermost points on rays from the body's centre across a direction (3,).

        The rays (n, 2) are unit vectors along the ``axes`` (2, 3), which are perpendicular to the direction.
        """
        raise NotImplementedError

    def crossings(self, w: Floats, u: Floats, displacements: Floats) -> tuple[Any, Floats]:
        """Return where ``displacements`` (M, 3) of rays may cross the limb: indices of rays, and shares of them.

        The shares are between 0 and 1, in their order for each ray. There are none for a smooth measure, whose extrema
        show all crossings.
        """
        return np.zeros(0, dtype=np.int64), np.zeros(0)


class EllipsoidLimb(Limb):
    """The limb of an ellipsoid with semi-axes (3,)."""

    def __init__(self, semi_axes: Any, position: Floats, rotation: Floats) -> None:
        self.semi_axes = np.asarray(semi_axes)
        super().__init__(position, rotation, float(np.linalg.norm(position) + self.semi_axes.real.max()))

    def _scaled(self, w: Any, u: Any) -> tuple[Any, Any]:
        """Return points and directions of rays in the unit sphere of the ellipsoid."""
        return (w - self.position) @ self.rotation / self.semi_axes, u @ self.rotation / self.semi_axes

    def measure(self, w: Any, u: Any) -> Any:
        """Return the square of the scaled distance of the rays from the centre minus one."""
        p, q = self._scaled(w, u)
        product = cross(p, q)
        return np.sum(product * product, axis=-1) / np.sum(q * q, axis=-1) - 1.0

    def distance(self, w: Any, u: Any) -> Any:
        """Return the distances (...) of rays from the ellipse that is the outline."""
        axes = np.stack(axes_across(u), axis=-2)
        columns = axes @ (self.rotation * self.semi_axes)
        ellipse = columns @ np.swapaxes(columns, -1, -2)
        point = (axes @ (w - self.position)[..., None])[..., 0]
        normal = _normals_at_nearest(ellipse.real, point.real)
        # The distance is the largest height above a tangent, so that a change of the normal has no effect.
        return np.sum(normal * point, axis=-1) - np.sqrt(np.einsum("...i,...ij,...j->...", normal, ellipse, normal))

    def depth(self, w: Floats, u: Floats) -> Floats:
        """Return the scaled positions along the rays of the points from the middle of the chords."""
        return np.asarray(np.sum(np.multiply(*self._scaled(w, u)), axis=-1))

    def extent(self, normals: Any) -> Any:
        """Return how far (M,) the ellipsoid reaches along unit vectors (M, 3)."""
        return normals @ self.position + np.linalg.norm(normals @ self.rotation * self.semi_axes, axis=-1)

    def outline(self, u: Floats) -> Floats:
        """Return points (R, 3) on the outline along a direction (3,): s = A^-1 x is a circle across A^-1 u."""
        first, second = (axis[0] for axis in axes_across((u @ self.rotation / self.semi_axes)[None]))
        angles = np.linspace(0.0, 2.0 * np.pi, _POINTS)
        circle = np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second / np.linalg.norm(second))
        return self.position + circle * self.semi_axes @ self.rotation.T

    def outermost(self, u: Floats, axes: Floats, rays: Floats) -> LimbPoints:
        """Return the points of the ellipse that is the outline; the tangent plane at x has the normal Q^-1 x."""
        columns = self.rotation * self.semi_axes
        matrix = columns @ columns.T
        inverse = np.linalg.inv(axes @ matrix @ axes.T)
        middle = axes @ self.position
        square = np.einsum("nx,xy,ny->n", rays, inverse, rays)
        half = rays @ inverse @ middle
        discriminant = half**2 - square * (middle @ inverse @ middle - 1.0)
        distances = np.where(discriminant > 0.0, half + np.sqrt(np.maximum(discriminant, 0.0)), 0.0) / square
        normals = (distances[:, None] * rays - middle) @ inverse @ axes
        tangent = normals @ matrix
        size = np.sqrt(np.maximum(np.einsum("nx,nx->n", normals, tangent), np.finfo(float).tiny))
        return LimbPoints(distances, self.position + tangent / size[:, None], normals)

    def length(self, measure: Any) -> Any:
        """Return the distance from the limb of a sphere of the same volume."""
        return (np.sqrt(measure + 1.0) - 1.0) * np.cbrt(self.semi_axes.real.prod())


class MeshLimb(Limb):
    """The limb of a polyhedron of the core.

    The outline consists of the edges between a face that is turned to the ray's source and one that is turned away.
    Its winding number about a point is the number of faces turned to the source that cover it.
    """

    def __init__(self, polyhedron: _core.Polyhedron, position: Floats, rotation: Floats) -> None:
        self.polyhedron, self._core = polyhedron, _core.Limb(polyhedron)
        self.vertices = position + polyhedron.vertices @ rotation.T
        super().__init__(position, rotation, float(np.linalg.norm(self.vertices, axis=1).max()))

    def measure(self, w: Any, u: Any) -> Any:
        """Return the distance of the rays from the outline, negative inside it."""
        w, u = np.broadcast_arrays((w - self.position) @ self.rotation, u @ self.rotation)
        rows = (np.ascontiguousarray(vectors.real).reshape(-1, 3) for vectors in (w, u))
        distance, by_w, by_u = self._core.distances(*rows)
        distance = distance.reshape(w.shape[:-1])
        if not (np.iscomplexobj(w) or np.iscomplexobj(u)):
            return distance
        changes = (np.sum(by.reshape(v.shape) * v.imag, axis=-1) for by, v in ((by_w, w), (by_u, u)))
        return distance + 1j * sum(changes)

    def extent(self, normals: Any) -> Any:
        """Return how far (M,) the vertices reach along unit vectors (M, 3)."""
        return (normals @ self.vertices.T).max(axis=-1)

    def _edges(self, u: Floats) -> Floats:
        """Return the ends (E, 2, 3) of the edges of the outline along a direction (3,)."""
        return self.position + self._core.edges(u @ self.rotation) @ self.rotation.T

    def outline(self, u: Floats) -> Floats:
        """Return the ends of the edges of the outline along a direction (3,), with a row of NaN after each edge."""
        edges = self._edges(u)
        return np.concatenate([edges, np.full((len(edges), 1, 3), np.nan)], axis=1).reshape(-1, 3)

    def outermost(self, u: Floats, axes: Floats, rays: Floats) -> LimbPoints:
        """Return the points at which rays t d meet edges p + s (q - p), where d x (p + s (q - p)) = 0."""
        edges = self._edges(u)
        p, q = np.moveaxis(edges @ axes.T, 1, 0)
        side = q - p
        slope, offset = (rays[:, [0]] * v[:, 1] - rays[:, [1]] * v[:, 0] for v in (side, p))
        share = np.divide(-offset, slope, out=np.full_like(slope, -1.0), where=slope != 0.0)
        distances = rays @ p.T + share * (rays @ side.T)
        distances = np.where((share >= 0.0) & (share <= 1.0), distances, 0.0)
        rows, edge = np.arange(len(rays)), np.argmax(distances, axis=1)
        sides = edges[edge, 1] - edges[edge, 0]
        points = edges[edge, 0] + share[rows, edge, None] * sides
        return LimbPoints(np.maximum(distances[rows, edge], 0.0), points, np.cross(sides, u))

    def crossings(self, w: Floats, u: Floats, displacements: Floats) -> tuple[Any, Floats]:
        """Return the indices of rays, and the shares of their displacements, at which they cross the outline."""
        rotated = (vectors @ self.rotation for vectors in (w - self.position, u, displacements))
        return self._core.crossings(*map(np.ascontiguousarray, rotated))


def limbs_of(system: SystemLike, body: int, semi_axes: Any = None) -> list[Limb]:
    """Return the limbs of the parts of a body with surfaces: none for a point, and none for voids.

    A body that is an ellipsoid may have other ``semi_axes`` (3,), which may be complex.
    """
    limbs: list[Limb] = []
    for shape, mass, position, rotation in system.context.bodies[body].parts:
        pose = np.array(position), np.array(rotation)
        if isinstance(shape, _core.StokesCoefficients):
            raise InvalidInput(
                f"{system.context.names[body]} is given by Stokes coefficients, which have no surface; expected a body "
                "with a surface, or a point, which hides nothing"
            )
        if shape is None or mass <= 0.0:
            continue
        if isinstance(shape, _core.Polyhedron):
            limbs.append(MeshLimb(shape, *pose))
        else:
            limbs.append(EllipsoidLimb(shape if semi_axes is None else semi_axes, *pose))
    return limbs


class PosedLimbs(NamedTuple):
    """The limbs of a body in its pose: a centre (3,) and the rotation matrix (3, 3) from its frame."""

    limbs: Sequence[Limb]
    centre: Floats
    matrix: Floats

    def outermost(self, sight: Floats, axes: Floats, rays: Floats) -> LimbPoints:
        """Return the outermost points on rays from the centre across a line of sight, the unit vector ``sight`` (3,).

        The rays (n, 2) are unit vectors along the ``axes`` (2, 3), which are perpendicular to the line of sight.
        """
        result = LimbPoints(np.zeros(len(rays)), np.zeros((len(rays), 3)), np.zeros((len(rays), 3)))
        for limb in self.limbs:
            part = limb.outermost(sight @ self.matrix, axes @ self.matrix, rays)
            farther = part.distances > result.distances
            for values, others in zip(result, part, strict=True):
                values[farther] = others[farther]
        return LimbPoints(result.distances, self.centre + result.points @ self.matrix.T, result.normals @ self.matrix.T)

    def hides(self, points: Floats, directions: Floats) -> Any:
        """Return whether the body hides each of the points (n, 3) along unit vectors (n, 3)."""
        w, u = (points - self.centre) @ self.matrix, directions @ self.matrix
        hidden = np.zeros(len(points), dtype=bool)
        for limb in self.limbs:
            hidden |= (limb.depth(w, u) < 0.0) & (limb.measure(w, u) < 0.0)
        return hidden


def dense_nodes(limb: Limb, nodes: Floats, w: Floats, u: Floats) -> Floats:
    """Return times (T,) that show all spans in which a ray, at w (N, 3) along u (N, 3) at the nodes, is inside a limb.

    Between two crossings of the outline there is a time at which the ray is inside, or outside.
    """
    index, shares = limb.crossings(w[:-1], u[:-1], w[1:] - w[:-1])
    count = np.arange(float(len(nodes)))
    breaks = np.sort(np.concatenate([count, index + shares]))
    return np.unique(np.concatenate([nodes, np.interp(0.5 * (breaks[1:] + breaks[:-1]), count, nodes)]))


def axes_across(directions: Any) -> tuple[Any, Any]:
    """Return two unit vectors (..., 3) across directions (..., 3), right-handed with them; they may be complex."""
    least = np.eye(3)[np.argmin(np.abs(directions.real), axis=-1)]
    first = np.cross(directions, least)
    first = first / np.sqrt(np.sum(first * first, axis=-1))[..., None]
    return first, np.cross(directions, first)


def _normals_at_nearest(ellipse: Floats, point: Floats) -> Floats:
    """Return the unit normals (..., 2) of ellipses x^T A^-1 x = 1 at the points that are nearest to others (..., 2)."""

    def terms(angle: Any, matrix: Any, x: Any) -> tuple[Any, Any, Any]:
        """Return the height above the tangent at a normal's angle, and its first and second derivatives."""
        n = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        t = np.stack([-n[..., 1], n[..., 0]], axis=-1)
        square, product = (np.einsum("...i,...ij,...j->...", v, matrix, n) for v in (n, t))
        size = np.sqrt(square)
        slope = product / size
        curvature = (np.einsum("...i,...ij,...j->...", t, matrix, t) - slope**2) / size
        height = np.sum(x * n, axis=-1)
        return height - size, np.sum(x * t, axis=-1) - slope, size - height - curvature

    angles = 2.0 * np.pi * np.arange(_NORMALS) / _NORMALS
    angle = angles[np.argmax(terms(angles, ellipse[..., None, :, :], point[..., None, :])[0], axis=-1)]
    for _ in range(_STEPS):
        _, first, second = terms(angle, ellipse, point)
        # Where the height is not concave there is no maximum for Newton's method, and the best of the grid stays.
        step = np.divide(first, second, out=np.zeros_like(first), where=second < 0.0)
        angle = angle - np.clip(step, -0.1, 0.1)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
