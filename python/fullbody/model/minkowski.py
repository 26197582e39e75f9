"""Minkowski's problem: find the convex polytope from the normals and areas of its facets.

With the heights h_i of the facets' planes above the origin, the areas A_i(h) have the derivatives l_ij / sin t_ij with
respect to the heights of adjacent facets j, where l_ij is the length of the common edge and t_ij the angle between the
normals, and minus the sum of l_ij cot t_ij with respect to their own. Newton's steps are damped so that no facet
vanishes and the residual falls (Kitagawa, Merigot & Thibert 2019, J. Eur. Math. Soc. 21, 2603), from the polytope
around the unit sphere.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..base.units import need
from ..errors import InvalidInput, NotConverged
from ..typing import Floats

#: The largest difference of the areas at the solution, relative to the largest, and the largest number of steps.
_CLOSE, _STEPS = 1e-10, 200
#: The distance of vertices, relative to the size, below which they are one.
_SAME = 1e-9


class _Polytope(NamedTuple):
    """A polytope with the origin inside: its vertices (S, 3), the three facets (S, 3) at each, areas (F,) and edges.

    An edge has the two facets ``left`` and ``right`` (E,), the ``length`` (E,) and the angle between the normals.
    """

    vertices: Floats
    facets: npt.NDArray[np.int64]
    areas: Floats
    left: npt.NDArray[np.int64]
    right: npt.NDArray[np.int64]
    length: Floats
    angle: Floats


def polytope(normals: Floats, areas: Floats) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Return vertices (V, 3) and triangles (T, 3) of the polytope with these normals (F, 3) and areas (F,)."""
    with need("analysis", "Minkowski's problem"):
        from scipy.sparse import bmat, csc_matrix
        from scipy.sparse.linalg import spsolve

    target = closed_areas(normals, areas)
    surface = target.sum()
    target = target / surface
    heights = np.ones(len(normals))
    current = _intersection(normals, heights)
    # Areas and heights have the unit in which the surface is one.
    heights = heights / np.sqrt(current.areas.sum())
    current = _intersection(normals, heights)
    least = 0.5 * min(float(current.areas.min()), float(target.min()))
    for _ in range(_STEPS):
        residual = target - current.areas
        if np.abs(residual).max() <= _CLOSE * target.max():
            vertices, triangles = _triangles(normals, current)
            return vertices * np.sqrt(surface), triangles
        size = len(normals)
        sine, cosine = np.sin(current.angle), np.cos(current.angle)
        across, along = current.length / sine, -current.length * cosine / sine
        rows = np.concatenate([current.left, current.right, current.left, current.right])
        columns = np.concatenate([current.right, current.left, current.left, current.right])
        jacobian = csc_matrix((np.concatenate([across, across, along, along]), (rows, columns)), shape=(size, size))
        # A shift of the polytope changes no area; the origin stays where the weighted heights of a shift vanish.
        border = csc_matrix(normals * target[:, None])
        full = csc_matrix(bmat([[jacobian, border], [border.T, None]]))
        step = spsolve(full, np.concatenate([residual, np.zeros(3)]))[:size]
        damping, norm = 1.0, np.linalg.norm(residual)
        while damping > 1e-8:
            moved = heights + damping * step
            if moved.min() > 0.0:
                trial = _intersection(normals, moved)
                if trial.areas.min() >= least and np.linalg.norm(target - trial.areas) <= (1.0 - 0.5 * damping) * norm:
                    break
            damping *= 0.5
        else:
            break
        heights, current = _centred(normals, moved, trial)
    error = np.abs(target - current.areas).max() / target.max()
    expected = "expected areas of a rounder shape"
    raise NotConverged(f"Minkowski's problem: the areas of facets differ by {error:.3g} of the largest; {expected}")


def closed_areas(normals: Floats, areas: Floats) -> Floats:
    """Return areas (F,) whose facets close, at the least sum of squared changes over the areas."""
    missing = -(areas @ normals)
    multiplier = np.linalg.solve((normals * areas[:, None]).T @ normals, missing)
    factors = 1.0 + normals @ multiplier
    if factors.min() <= 0.0:
        size = np.linalg.norm(missing) / areas.sum()
        expected = "expected facets that are nearly closed"
        raise InvalidInput(f"areas of the facets times normals have a sum of {size:.3g} of the surface; {expected}")
    return np.asarray(areas * factors)


def _intersection(normals: Floats, heights: Floats) -> _Polytope:
    """Return the polytope of points x with n_i.x <= h_i, whose dual is the convex hull of the points n_i / h_i."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(normals / heights[:, None])
    facets = hull.simplices.astype(np.int64)
    vertices = np.linalg.solve(normals[facets], heights[facets][..., None])[..., 0]
    rows = np.arange(len(facets))
    left, right, length = [], [], []
    for k in range(3):
        other = hull.neighbors[:, k]
        once = rows < other
        left.append(facets[once, (k + 1) % 3])
        right.append(facets[once, (k + 2) % 3])
        length.append(np.linalg.norm(vertices[once] - vertices[other[once]], axis=1))
    i, j, edge = np.concatenate(left), np.concatenate(right), np.concatenate(length)
    across = np.linalg.norm(np.cross(normals[i], normals[j]), axis=1)
    angle = np.arctan2(across, np.sum(normals[i] * normals[j], axis=1))
    sine, cosine = np.sin(angle), np.cos(angle)
    areas: Floats = np.zeros(len(normals))
    areas += np.bincount(i, 0.5 * edge * (heights[j] - heights[i] * cosine) / sine, len(normals))
    areas += np.bincount(j, 0.5 * edge * (heights[i] - heights[j] * cosine) / sine, len(normals))
    return _Polytope(vertices, facets, areas, i, j, edge, angle)


def _centred(normals: Floats, heights: Floats, current: _Polytope) -> tuple[Floats, _Polytope]:
    """Return the polytope moved so that the mean of its vertices is the origin."""
    middle = current.vertices.mean(axis=0)
    return heights - normals @ middle, _Polytope(current.vertices - middle, *current[1:])


def _triangles(normals: Floats, current: _Polytope) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Return the vertices of a polytope, and its facets divided into triangles."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    # A vertex at which more than three facets meet occurs several times.
    count, size = len(current.vertices), np.abs(current.vertices).max()
    pairs = KDTree(current.vertices).query_pairs(_SAME * size, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), tuple(pairs.T)), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    _, first = np.unique(label, return_index=True)
    vertices = current.vertices[first]
    corners = np.unique(np.stack([current.facets.ravel(), np.repeat(label, 3)], axis=1), axis=0)
    # The corners of a facet are taken counterclockwise as seen from outside.
    facet, vertex = corners.T
    counts = np.bincount(facet, minlength=len(normals))
    sums = np.stack([np.bincount(facet, vertices[vertex, k], len(normals)) for k in range(3)], axis=1)
    middle = sums / np.maximum(counts, 1)[:, None]
    along = np.eye(3)[np.abs(normals).argmin(axis=1)]
    across = np.cross(normals, along)
    from_middle = vertices[vertex] - middle[facet]
    up = np.cross(normals, across)
    angle = np.arctan2(np.sum(from_middle * up[facet], axis=1), np.sum(from_middle * across[facet], axis=1))
    facet, vertex = corners[np.lexsort((angle, facet))].T
    starts = np.cumsum(counts) - counts
    inner = np.arange(len(facet)) - starts[facet]
    fan = np.flatnonzero((inner >= 1) & (inner <= counts[facet] - 2))
    return vertices, np.stack([vertex[starts[facet[fan]]], vertex[fan], vertex[fan + 1]], axis=1)
