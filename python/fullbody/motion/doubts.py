"""Starts that can be integrated, but are probably a mistake."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import tables

if TYPE_CHECKING:
    from .. import _core
    from ..model.system import BaseSystem

__all__ = ["of_start"]

#: Speeds of escape. A flyby of asteroids is faster still; a day taken for an hour makes 24 of them.
_FAST = 10.0
#: Distances to the nearest body. From there on coordinates round at more than the default tolerances.
_FAR = 1e3


def of_start(system: BaseSystem, start: _core.State, tolerance: float | None) -> Iterator[str]:
    """Warnings about a start.

    Parameters
    ----------
    tolerance
        The sum of the integrator's, relative to the distance of the nearest body; ``None`` for fixed steps.
    """
    if len(system) > 1:
        masses = system._masses
        # The run itself refuses what is too large.
        with np.errstate(all="ignore"):
            position = start.position
            apart = np.sqrt(((position[:, None] - position) ** 2).sum(axis=2))
            np.fill_diagonal(apart, np.inf)
            yield from _unbound(system, start, masses, apart)
            yield from _far(system, position, masses, apart, tolerance)
    for force, described in zip(system.forces, system._core.forces, strict=True):
        yield from force._doubts(described, system.names, start, system._units)


def _unbound(system: BaseSystem, start: _core.State, masses: Any, apart: Any) -> Iterator[str]:
    """Whether a body is so much faster than the others' speed of escape that their attraction can hardly be meant to
    hold it.
    """
    velocity = start.velocity
    # Of the others, by rows.
    rest = np.where(apart < np.inf, masses, 0.0)
    sums = rest.sum(axis=1)
    speed = np.sqrt(((velocity - rest @ velocity / sums[:, None]) ** 2).sum(axis=1))
    escape = np.sqrt(2.0 * system._G * (masses + sums) * (rest / apart).sum(axis=1) / sums)
    # Without attraction there is nothing to be bound by.
    times = np.where(escape > 0.0, speed / escape, 0.0)
    body = int(np.argmax(times))
    if not _FAST < times[body] < np.inf:
        return
    fast, held = (tables.number(system._units.attach(value[body], "velocity"), 4) for value in (speed, escape))
    who = f"{' and '.join(system.names)} start" if len(system) == 2 else f"{system.names[body]} starts"
    whom = "each other" if len(system) == 2 else "the barycentre of the others"
    yield (
        f"{who} at {fast} relative to {whom}, {times[body]:.3g} times the speed of escape there, "
        f"{held}; expected at most {_FAST:g} times, unless a fast flyby is meant: check the units of the velocities, "
        "of the masses and of G"
    )


def _far(system: BaseSystem, position: Any, masses: Any, apart: Any, tolerance: float | None) -> Iterator[str]:
    """Whether the barycentre, which the integrators count positions from, is far from bodies near each other."""
    nearest = apart.min(axis=1)
    from_barycentre = np.sqrt(((position - masses @ position / masses.sum()) ** 2).sum(axis=1))
    body = int(np.argmax(from_barycentre / nearest))
    rounding = np.spacing(from_barycentre[body]) / nearest[body]
    enough = 10.0 ** np.ceil(np.log10(rounding))
    if from_barycentre[body] < _FAR * nearest[body] or (tolerance is not None and tolerance >= enough):
        return
    distances = apart[body]
    neighbour = np.argmin(distances)
    # The body that draws the barycentre there.
    far = (distances >= _FAR / 2 * nearest[body]) & (distances < np.inf)
    heavy = np.argmax(np.where(far, masses, 0.0))

    def length(value: float, digits: int = 4) -> str:
        return tables.number(system._units.attach(np.float64(value), "length"), digits)

    pair = " and ".join(system.names[place] for place in sorted((body, int(neighbour))))
    if tolerance is None:
        follows = "Every step loses that much"
    else:
        follows = (
            "A step cannot be more exact than that: with smaller tolerances steps grow ever shorter, and the run may "
            "never end"
        )
    who = system.names[heavy]
    instead = f"{who} as a fullbody.forces.ThirdBody on a prescribed path, which costs no digits"
    remedy = instead if tolerance is None else f"{instead}, or rtol and atol of {enough:g} or more"
    yield (
        f"{who} is {length(distances[heavy])} from {pair}, which are {length(nearest[body])} "
        "apart, and so heavy that the barycentre, which positions are counted from, is far from these two: their "
        f"coordinates round at {length(np.spacing(from_barycentre[body]), 2)}, {rounding:.2g} of their distance. "
        f"{follows}; expected bodies within {_FAR:g} such distances, or {remedy}"
    )
