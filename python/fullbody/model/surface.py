"""The surfaces of bodies as numbers, and deformations: displacements of surfaces with a parameter."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

import fullbody._core as _core

from ..typing import Floats


class Surface(NamedTuple):
    """The surface of a polyhedron, or of a :class:`fullbody.ConvexShape`, in numbers of a system's units.

    It has the ``vertices`` (V, 3) of a polyhedron in the body frame and the same ones in the ``working`` frame, or the
    ``areas`` (F,) of the facets of a convex shape. The difference of two surfaces is a displacement, which has the same
    form.
    """

    vertices: Floats
    working: Floats
    areas: Floats

    def flat(self) -> Floats:
        """Return all numbers as one array."""
        return np.concatenate([np.ravel(part) for part in self])

    def unflattened(self, numbers: Floats) -> Surface:
        """Return a surface of the same form with these numbers."""
        ends = np.cumsum([part.size for part in self])[:-1]
        parts = zip(np.split(numbers, ends), self, strict=True)
        return Surface(*(part.reshape(like.shape) for part, like in parts))


#: The displacements of bodies, by their indices, per unit of a parameter.
Deformation = Mapping[int, Surface]


def surface_of(body: _core.Body) -> Surface | None:
    """Return the surface of a body that is one polyhedron or known by its facets; ``None`` for other bodies."""
    none = np.empty((0, 3))
    if (areas := body.areas) is not None:
        return Surface(none, none, areas)
    if body.input_parts or not isinstance(shape := body.parts[0][0], _core.Polyhedron):
        return None
    return Surface(shape.vertices, shape.input_vertices, np.empty(0))


def size_of(bodies: tuple[_core.Body, ...], deformation: Deformation) -> float:
    """Return a change of a parameter that moves surfaces by about the size of the bodies."""
    sizes = []
    for index, displacement in deformation.items():
        surface = surface_of(bodies[index])
        assert surface is not None
        largest = [float(np.abs(part.flat()).max(initial=0.0)) for part in (surface, displacement)]
        sizes.append(largest[0] / largest[1] if largest[1] else 1.0)
    return min(sizes, default=1.0)
