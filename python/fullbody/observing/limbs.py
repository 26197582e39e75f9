"""Limbs of bodies: whether a ray passes through a body, and how far it passes from its edge.

A ray is given in the body's frame by a point ``w`` (..., 3) on it, from the body's centre, and its direction ``u``.
Each limb has a measure that is negative where the ray passes through the body and zero where it touches it. For an
ellipsoid with the semi-axes A, with p = A^-1 w and q = A^-1 u, it is abs(p x q)^2 / abs(q)^2 - 1, a quadratic function
of the place of the ray. For a polyhedron it is the distance from the outline. Both take complex numbers, so that a step
along the imaginary axis gives their derivatives.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base.units import need
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .silhouettes import across

#: The number of products of rays and edges that are computed at a time.
_BLOCK = 2_000_000
#: The iterations in which an extremum of a measure between three times is narrowed down.
_EXTREMA = 60
#: The smallest relative width of the bracket of a root that scipy accepts.
_RELATIVE = 4.0 * float(np.finfo(float).eps)

#: The places of the next component of a vector, and of the one before, in cyclic order.
_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])

#: The number of points of the outline of an ellipsoid.
_RIM = 361

Span = tuple[float, float]


class Limb(Protocol):
    """The limb of a part of a body."""

    #: An upper bound of the distance of the part's points from the body's centre.
    reach: float

    def measure(self, w: Any, u: Any) -> Any:
        """Return the measure (M,) of rays: negative where they pass through the part."""

    def extent(self, normals: Any) -> Any:
        """Return how far (M,) the part reaches along unit vectors (M, 3) in the body's frame."""

    def rim(self, u: Floats) -> Floats:
        """Return points (R, 3) on the outline along a direction (3,), with rows of NaN between separate lines."""

    def length(self, measure: Any) -> Any:
        """Return about how far rays with a measure pass outside the limb, as a length."""

    def crossings(self, w: Floats, u: Floats, way: Floats) -> Floats:
        """Return the shares, from 0 to 1, of a displacement ``way`` (3,) of one ray at which it may cross the limb."""


class EllipsoidLimb:
    """The limb of an ellipsoid with semi-axes (3,), whose centre and rotation (3, 3) are given in the body's frame."""

    def __init__(self, semi_axes: Any, position: Floats, rotation: Floats) -> None:
        self.semi_axes, self._position, self._rotation = np.asarray(semi_axes), position, rotation
        self.reach = float(np.linalg.norm(position) + self.semi_axes.real.max())

    def measure(self, w: Any, u: Any) -> Any:
        """Return the square of the scaled distance of the rays from the centre minus one."""
        p = (w - self._position) @ self._rotation / self.semi_axes
        q = u @ self._rotation / self.semi_axes
        product = cross(p, q)
        return np.sum(product * product, axis=-1) / np.sum(q * q, axis=-1) - 1.0

    def extent(self, normals: Any) -> Any:
        """Return how far (M,) the ellipsoid reaches along unit vectors (M, 3) in the body's frame."""
        return normals @ self._position + np.linalg.norm(normals @ self._rotation * self.semi_axes, axis=-1)

    def rim(self, u: Floats) -> Floats:
        """Return points (R, 3) on the outline along a direction (3,): s = A^-1 x is a circle across A^-1 u."""
        first, second = (axis[0] for axis in across((u @ self._rotation / self.semi_axes)[None]))
        angles = np.linspace(0.0, 2.0 * np.pi, _RIM)
        circle = np.outer(np.cos(angles), first) + np.outer(np.sin(angles), second / np.linalg.norm(second))
        return self._position + circle * self.semi_axes @ self._rotation.T

    def length(self, measure: Any) -> Any:
        """Return the distance from the limb of a sphere of the same volume."""
        return (np.sqrt(measure + 1.0) - 1.0) * np.cbrt(self.semi_axes.real.prod())

    def crossings(self, w: Floats, u: Floats, way: Floats) -> Floats:
        """Return nothing, since the measure is smooth and its extrema show all crossings."""
        return np.zeros(0)


class MeshLimb:
    """The limb of a polyhedron with vertices (V, 3) and faces (F, 3), in the body's frame.

    The outline consists of the edges between a face that is turned to the ray's source and one that is turned away.
    They wind about a point as often as faces that are turned to it cover it.
    """

    def __init__(self, vertices: Floats, faces: npt.NDArray[np.int64]) -> None:
        self._vertices = vertices
        self.reach = float(np.linalg.norm(vertices, axis=1).max())
        corners = vertices[faces]
        self._normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
        owners = np.repeat(np.arange(len(faces)), 3)
        order = np.lexsort(np.sort(sides, axis=1).T)
        first, second = order[0::2], order[1::2]
        self._edges = sides[first]
        self._sides = np.stack([owners[first], owners[second]], axis=1)

    def measure(self, w: Any, u: Any) -> Any:
        """Return the distance of the rays from the outline, negative inside it."""
        w, u = np.broadcast_arrays(w, u)
        flat_w, flat_u = w.reshape(-1, 3), u.reshape(-1, 3)
        size = max(1, _BLOCK // len(self._edges))
        parts = [self._block(flat_w[k : k + size], flat_u[k : k + size]) for k in range(0, len(flat_w), size)]
        return np.concatenate(parts).reshape(w.shape[:-1]) if parts else np.zeros(w.shape[:-1])

    def _block(self, w: Any, u: Any) -> Any:
        """Return the distances (M,): the edges and the sign are chosen by the real parts."""
        axes = across(u)
        ends = np.stack([(self._vertices @ axis.T).T - np.sum(w * axis, -1)[:, None] for axis in axes], axis=-1)
        start, stop = ends[:, self._edges[:, 0]], ends[:, self._edges[:, 1]]
        turned = (u.real @ self._normals.T > 0.0)[:, self._sides]
        on_limb = turned[..., 0] != turned[..., 1]
        way = stop - start
        length = np.sum(way * way, axis=-1)
        share = -np.sum(start * way, axis=-1).real / np.where(length.real > 0.0, length.real, 1.0)
        share = np.clip(share, 0.0, 1.0)
        near = start + share[..., None] * way
        square = np.where(on_limb, np.sum(near * near, axis=-1).real, np.inf)
        nearest = np.argmin(square, axis=1)
        rows = np.arange(len(w))
        below = start[..., 1].real <= 0.0, stop[..., 1].real <= 0.0
        area = start[..., 0] * stop[..., 1] - start[..., 1] * stop[..., 0]
        crosses = on_limb & (below[0] != below[1]) & ((area.real > 0.0) == below[0])
        # An edge runs about the face that has it in this order; the other face has it reversed.
        sign = np.where(below[0], 1, -1) * np.where(turned[..., 0], 1, -1)
        inside = np.sum(np.where(crosses, sign, 0), axis=1) != 0
        distance = self._distance(start[rows, nearest], way[rows, nearest], share[rows, nearest], near[rows, nearest])
        return np.where(inside, -distance, distance)

    @staticmethod
    def _distance(start: Any, way: Any, share: Floats, near: Any) -> Any:
        """Return the distances (M,) of the origin from edges, or from their ends, without roots of zero."""
        normal = np.stack([-way[:, 1], way[:, 0]], axis=-1) / np.sqrt(np.sum(way * way, axis=-1))[:, None]
        along = np.sum(start * normal, axis=-1)
        along = np.where(along.real < 0.0, -along, along)
        square = np.sum(near * near, axis=-1)
        at_end = ((share == 0.0) | (share == 1.0)) & (square.real > 0.0)
        return np.where(at_end, np.sqrt(np.where(at_end, square, 1.0)), along)

    def extent(self, normals: Any) -> Any:
        """Return how far (M,) the vertices reach along unit vectors (M, 3) in the body's frame."""
        return (normals @ self._vertices.T).max(axis=-1)

    def rim(self, u: Floats) -> Floats:
        """Return the ends of the edges of the outline along a direction (3,), with a row of NaN after each edge."""
        turned = (self._normals @ u > 0.0)[self._sides]
        ends = self._vertices[self._edges[turned[:, 0] != turned[:, 1]]]
        return np.concatenate([ends, np.full((len(ends), 1, 3), np.nan)], axis=1).reshape(-1, 3)

    def length(self, measure: Any) -> Any:
        """Return the measure, which is a distance."""
        return measure

    def crossings(self, w: Floats, u: Floats, way: Floats) -> Floats:
        """Return the shares of a displacement of one ray at which it crosses edges of the outline."""
        axes = across(u[None])
        place, move = (np.array([vector @ axis[0] for axis in axes]) for vector in (w, way))
        turned = (self._normals @ u > 0.0)[self._sides]
        edges = self._edges[turned[:, 0] != turned[:, 1]]
        start, stop = (np.stack([self._vertices[edges[:, k]] @ axis[0] for axis in axes], -1) - place for k in (0, 1))
        along = stop - start
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1.0 / (move[0] * along[:, 1] - move[1] * along[:, 0])
            share = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) * inverse
            on_edge = (start[:, 0] * move[1] - start[:, 1] * move[0]) * inverse
            hit = (share >= 0.0) & (share <= 1.0) & (on_edge >= 0.0) & (on_edge <= 1.0)
        return np.sort(share[hit])


def cross(a: Any, b: Any) -> Any:
    """Return the cross products (..., 3) of vectors, which numpy's function takes longer for."""
    return a[..., _NEXT] * b[..., _LAST] - a[..., _LAST] * b[..., _NEXT]


def limbs_of(system: SystemLike, body: int, semi_axes: Any = None) -> list[Limb]:
    """Return the limbs of the parts of a body that hide a star: none for a point, and none for voids.

    Parameters
    ----------
    system : System
    body : int
        The index of the body.
    semi_axes : array_like, (3,), optional
        Other semi-axes, which may be complex, for a body that is an ellipsoid.
    """
    limbs: list[Limb] = []
    for shape, mass, position, rotation in system.context.bodies[body].parts:
        if shape is None or mass <= 0.0:
            continue
        place, turn = np.array(position), np.array(rotation)
        if isinstance(shape, _core.Polyhedron):
            limbs.append(MeshLimb(shape.vertices @ turn.T + place, shape.faces))
        elif isinstance(shape, _core.StokesCoefficients):
            raise InvalidInput(
                f"{system.context.names[body]} is given by Stokes coefficients, which have no surface; expected a body "
                "with a surface, or a point, which hides nothing"
            )
        else:
            limbs.append(EllipsoidLimb(shape if semi_axes is None else semi_axes, place, turn))
    return limbs


def spans_below_zero(measure: Callable[[Floats], Floats], nodes: Floats) -> list[Span]:
    """Return the spans of time in which a measure is negative, to the last digits.

    Extrema between the nodes (T,) are searched, so that a graze is found. A span that is cut by an end of the nodes
    ends there.
    """
    with need("observing", "a search for chords"):
        from scipy.optimize import brentq

    values = measure(nodes)
    times, found = [nodes], [values]
    middle = values[1:-1]
    sign = np.where(middle > 0.0, 1.0, -1.0)
    # A least value above zero may dip below it, and a greatest below zero may rise above it.
    is_extremum = (sign * middle <= sign * values[:-2]) & (sign * middle <= sign * values[2:])
    for k in np.flatnonzero(is_extremum) + 1:
        if (values[k - 1 : k + 2] > 0.0).all() or (values[k - 1 : k + 2] < 0.0).all():
            time, value = _extremum(measure, nodes[k - 1 : k + 2], values[k - 1 : k + 2])
            times.append(np.array([time]))
            found.append(np.array([value]))
    all_times, all_values = np.concatenate(times), np.concatenate(found)
    order = np.argsort(all_times, kind="stable")
    all_times, all_values = all_times[order], all_values[order]
    below = all_values < 0.0
    edges = [float(all_times[0])] if below[0] else []
    for k in np.flatnonzero(below[1:] != below[:-1]):
        a, b = float(all_times[k]), float(all_times[k + 1])
        edges.append(brentq(lambda t: float(measure(np.array([t]))[0]), a, b, xtol=1e-300, rtol=_RELATIVE))
    if below[-1]:
        edges.append(float(all_times[-1]))
    return [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if a < b]


def _extremum(measure: Callable[[Floats], Floats], times: Floats, values: Floats) -> tuple[float, float]:
    """Return the time and value of the extremum within three times, towards zero; it ends where the sign changes."""
    sign = 1.0 if values[1] > 0.0 else -1.0
    a, b = float(times[0]), float(times[2])
    best, least = float(times[1]), float(values[1])
    for _ in range(_EXTREMA):
        trial = np.linspace(a, b, 9)[1:-1]
        found = measure(trial)
        k = int(np.argmin(sign * found))
        step = (b - a) / 8.0
        if sign * found[k] < sign * least:
            best, least = float(trial[k]), float(found[k])
        if sign * least <= 0.0 or step <= 4.0 * np.spacing(abs(best)):
            break
        a, b = max(a, best - step), min(b, best + step)
    return best, least


def dense_nodes(limb: Limb, nodes: Floats, w: Floats, u: Floats) -> Floats:
    """Return times (T,) that show all spans in which a ray, at w (N, 3) along u (N, 3) at the nodes, is inside a limb.

    Between two crossings of the outline there is a time at which the ray is inside, or outside.
    """
    between = []
    for k in range(len(nodes) - 1):
        shares = np.concatenate([[0.0], limb.crossings(w[k], u[k], w[k + 1] - w[k]), [1.0]])
        between.append(nodes[k] + (nodes[k + 1] - nodes[k]) * 0.5 * (shares[1:] + shares[:-1]))
    return np.unique(np.concatenate([nodes, *between]))


def union(spans: Sequence[Span]) -> list[Span]:
    """Return spans of time without overlaps, in order."""
    joined: list[Span] = []
    for a, b in sorted(spans):
        if joined and a <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(b, joined[-1][1]))
        else:
            joined.append((a, b))
    return joined
