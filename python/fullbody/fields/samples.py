"""Sample points on a body's surface, each with its normal and its cell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..errors import InvalidInput

_Numbers = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SurfaceSamples:
    """Sample points (S, 3), unit normals (S, 3) and the corners of cells (S, 4, 3), in the body frame."""

    points: _Numbers
    normals: _Numbers
    cells: _Numbers

    def chosen(self, which: npt.NDArray[np.bool_]) -> SurfaceSamples:
        """Return the samples that a mask selects."""
        return SurfaceSamples(self.points[which], self.normals[which], self.cells[which])


def samples(body: _core.Body, rows: int) -> SurfaceSamples:
    """Sample points on the surface of a body: one per cell of each part with positive mass.

    Points inside another part are left out, and a point mass has none. An ellipsoid has ``rows`` rows of cells from
    pole to pole, and points on the surface itself. A polyhedron has its faces and their centres. The corners of a
    triangle contain the last one twice.
    """
    matter = [part for part in body.parts if part[0] is not None and part[1] > 0.0]
    if any(isinstance(shape, _core.StokesCoefficients) for shape, *_ in matter):
        raise InvalidInput("the body is given by its Stokes coefficients; expected one with a surface")
    samples_of_parts = [_of_part(*part, rows) for part in matter]
    if len(matter) > 1:
        samples_of_parts = [
            result.chosen(~np.any([_within(other, result.points) for other in matter if other is not part], axis=0))
            for result, part in zip(samples_of_parts, matter, strict=True)
        ]
    empty = (np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4, 3)))
    names = ("points", "normals", "cells")
    all_of = (
        [none, *(getattr(result, name) for result in samples_of_parts)] for none, name in zip(empty, names, strict=True)
    )
    return SurfaceSamples(*map(np.concatenate, all_of))


def _of_part(shape: Any, mass: float, position: Any, rotation: Any, rows: int) -> SurfaceSamples:
    rotation_matrix = np.array(rotation)
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
    return SurfaceSamples(
        points @ rotation_matrix.T + position, normals @ rotation_matrix.T, cells @ rotation_matrix.T + position
    )


def _ball(row: Any, column: Any, rows: int) -> _Numbers:
    """Return unit vectors of a grid, with rows from the pole on and columns in longitude."""
    polar, longitude = np.meshgrid(np.pi * row / rows, np.pi * column / rows - np.pi, indexing="ij")
    ring = np.sin(polar)
    return np.stack([ring * np.cos(longitude), ring * np.sin(longitude), np.cos(polar)], axis=-1)


def _within(part: Any, points: _Numbers) -> npt.NDArray[np.bool_]:
    """Return whether each point lies inside a part, where the divergence of its gravity is not zero."""
    shape, mass, position, rotation = part
    alone = _core.Attraction([_core.Body("part", shape, mass)], 1.0, "auto")
    local = np.ascontiguousarray((points - position) @ np.array(rotation))
    centre, unturned = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
    gradient = np.empty((len(local), 3, 3))
    alone.gravity(centre, unturned, None, local, [len(local)], None, [gradient])
    volume = shape.volume if isinstance(shape, _core.Polyhedron) else 4.0 / 3.0 * np.pi * np.prod(shape)
    return np.trace(gradient, axis1=1, axis2=2) < -2.0 * np.pi * mass / volume
