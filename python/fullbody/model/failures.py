"""Errors of the core, completed by distances with units and by the exceptions of Python functions."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

import fullbody._core as _core

from ..errors import BodiesOverlap, ForceFailed, FullbodyError, Interrupted
from .context import Context


def explained(
    error: BaseException, context: Context, state: _core.State | None = None, when: str = ""
) -> BaseException:
    """Return an error about an overlap with distance or time, one about a force with its cause, others unchanged."""
    if isinstance(error, BodiesOverlap):
        return _overlap(error, context, state, when)
    return _caused(error, context) if isinstance(error, ForceFailed) else error


@contextmanager
def explaining(context: Context, state: _core.State | None = None, when: str = "") -> Iterator[None]:
    """Context manager that raises the core's errors explained."""
    try:
        yield
    except (BodiesOverlap, ForceFailed) as error:
        better = explained(error, context, state, when)
        raise better from better.__cause__


def _overlap(error: BodiesOverlap, context: Context, state: _core.State | None, when: str) -> BodiesOverlap:
    if state is not None:
        first, second = (state.position[context.names.index(name)] for name in error.bodies)
        distance = context.units.text(float(np.linalg.norm(second - first)), "length")
        text = f"overlap{when}, their centres {distance} apart; expected interiors apart"
    else:
        text = f"overlap at time {context.units.text(error.time, 'time', 12)}; expected interiors apart"
        text += " (events.Contact, terminal, ends a run at the contact)"
    return BodiesOverlap(f"{' and '.join(error.bodies)} {text}", error.bodies, error.time)


def _caused(error: ForceFailed, context: Context) -> BaseException:
    """Return the error with the exception of the force's function as its cause, or that exception if it is an exit."""
    call = context.calls.get(error.force)
    if call is None:
        return error
    raised = call.raised(error.answer)
    if raised is None:
        raised = KeyboardInterrupt() if call.is_lost(error.answer) else error
    if isinstance(raised, KeyboardInterrupt):
        return Interrupted(f"interrupted in force {error.force} at time {error.time}")
    if raised is error or not isinstance(raised, Exception):
        return raised
    what = f"{raised}" if isinstance(raised, FullbodyError) else f"{type(raised).__name__}: {raised}"
    caused = ForceFailed(f"force {error.force} at time {error.time}: {what}", error.force, error.time)
    caused.__cause__ = raised
    return caused
