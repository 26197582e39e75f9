"""Overlaps as the user is told of them: where the bodies are, and when, with units."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from ..base import tables
from ..errors import BodiesOverlap

if TYPE_CHECKING:
    from .. import _core
    from ..motion.system import System

__all__ = ["explained", "explaining"]


def explained(error: BodiesOverlap, system: System, start: _core.State | None, when: str = "") -> BodiesOverlap:
    """The error with the distance of the centres in a state, or without one with the time in a run."""
    units = system._units
    if start is not None:
        first, second = (start.position[system.names.index(name)] for name in error.bodies)
        apart = tables.number(units.attach(np.float64(np.linalg.norm(second - first)), "length"))
        text = f"overlap{when}, their centres {apart} apart; expected interiors apart"
    else:
        time = tables.number(units.attach(np.float64(error.time), "time"), 12)
        text = f"overlap at time {time}; expected interiors apart (events.Contact, terminal, ends a run at the contact)"
    return BodiesOverlap(f"{' and '.join(error.bodies)} {text}", error.bodies, error.time)


@contextmanager
def explaining(system: System, state: Callable[[], _core.State], when: str = "") -> Iterator[None]:
    """A context for what is asked of one state."""
    try:
        yield
    except BodiesOverlap as error:
        raise explained(error, system, state(), when) from None
