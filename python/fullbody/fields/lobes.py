"""Roche lobes: the largest closed surfaces of one Jacobi constant about the bodies of a pair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import place
from ..base.kinds import whole
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..model.polyhedron import Polyhedron
from ..typing import Array, Floats, Scalar
from .equilibria import inner_point
from .frame import Frame

#: The number of steps in which a ray searches for the surface, and of halvings of the last one.
_STEPS, _HALVINGS = 200, 50


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class RocheLobe(ArrayFields):
    """The Roche lobe of a body: it holds matter at rest in the rotating frame inside this surface.

    Attributes
    ----------
    name : str
        Name of the body.
    jacobi : float or Quantity
        Jacobi's constant on the surface: that of the equilibrium point between the bodies.
    points : ndarray or Quantity, (rows + 1, 2 rows + 1, 3)
        Points of the surface in the rotating frame: rows from the end at that equilibrium point to the opposite one,
        columns about the axis, with the last equal to the first.
    volume : float or Quantity
        Volume of the mesh through the points, which is smaller than the lobe by about 3.7 parts in ``rows**2``.
    radius : float or Quantity
        Radius of the sphere with that volume.
    """

    name: str
    jacobi: Scalar
    points: Array
    volume: Scalar
    radius: Scalar


def roche_lobe(pair: Any, body: int | str, *, rows: int = 90) -> RocheLobe:
    """Return the surface of a body's Roche lobe, which has the Jacobi constant of the point between the bodies.

    Parameters
    ----------
    body : int or str
        The body's index in the system, or its name.
    rows : int
        Number of rows of the mesh from end to end.

    Returns
    -------
    RocheLobe
    """
    frame, rows, index = pair.frame, whole(rows, "rows", 4), place(body, pair.frame.context.names, "body")
    inner = inner_point(frame)
    if inner is None:
        raise InvalidInput(
            f"there is no equilibrium point between {' and '.join(frame.context.names)}: they have no lobes"
        )
    units = frame.context.units
    centre, tip = frame.centres[index], units.strip(inner.position, "length", "position") - frame.centres[index]
    level = units.number(inner.jacobi, "potential", "jacobi")
    along = tip / np.linalg.norm(tip)
    across = np.array([-along[1], along[0], 0.0])
    polar, angle = np.meshgrid(np.pi * np.arange(1, rows) / rows, np.pi * np.arange(2 * rows) / rows, indexing="ij")
    ring = np.sin(polar)[..., None]
    rays = np.cos(polar)[..., None] * along + ring * (
        np.cos(angle)[..., None] * across + np.sin(angle)[..., None] * np.cross(along, across)
    )
    ends = np.stack([along, -along])
    reach = float(np.linalg.norm(tip))
    distance = _crossings(frame, centre, np.concatenate([ends, rays.reshape(-1, 3)]), level, reach)
    # The surface ends at the point in a cone, where a ray finds no crossing.
    distance[0] = reach
    flat = centre + distance[:, None] * np.concatenate([ends, rays.reshape(-1, 3)])
    middle = flat[2:].reshape(rows - 1, 2 * rows, 3)
    points = np.concatenate(
        [np.broadcast_to(flat[0], (1, 2 * rows, 3)), middle, np.broadcast_to(flat[1], (1, 2 * rows, 3))]
    )
    volume = Polyhedron(flat, _faces(rows)).volume
    return RocheLobe(
        frame.context.names[index],
        inner.jacobi,
        units.attach(np.concatenate([points, points[:, :1]], axis=1), "length"),
        units.attach(volume, "volume"),
        units.attach((volume * 3.0 / (4.0 * np.pi)) ** (1.0 / 3.0), "length"),
    )


def _crossings(frame: Frame, centre: Floats, rays: Floats, level: float, reach: float) -> Floats:
    """Return the distance on each ray where Jacobi's constant first falls below the level, or else the reach."""
    low, high = np.zeros(len(rays)), np.full(len(rays), reach)
    going = np.arange(len(rays))
    for distance in reach * np.linspace(0.0, 1.0, _STEPS + 1)[1:]:
        below = frame.jacobi(centre + distance * rays[going]) < level
        high[going[below]] = distance
        going = going[~below]
        low[going] = distance
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        below = frame.jacobi(centre + middle[:, None] * rays) < level
        low, high = np.where(below, low, middle), np.where(below, middle, high)
    return high


def _faces(rows: int) -> npt.NDArray[np.int64]:
    """Return triangles between two ends, the first vertices, and rings of points between them."""
    count = 2 * rows
    here = np.arange(count)
    after = (here + 1) % count
    rings = 2 + count * np.arange(rows - 1)[:, None]
    first = np.stack([np.zeros_like(here), rings[0] + here, rings[0] + after], axis=1)
    last = np.stack([np.ones_like(here), rings[-1] + after, rings[-1] + here], axis=1)
    a, b, c, d = rings[:-1] + here, rings[:-1] + after, rings[1:] + here, rings[1:] + after
    between = [np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, c, b), (b, c, d))]
    return np.concatenate([first, *between, last])
