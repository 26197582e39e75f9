"""Gravity at the times of a run."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import InvalidInput
from ..model.gravity import Gravity, gravity_at, points_in
from .record import Record

__all__ = ["gravity"]


def gravity(run: Record, time: Any, points: Any, body: int | str | None = None) -> Gravity:
    """Return the gravity of the bodies at points of the inertial frame and times of the run; see
    :meth:`System.gravity`.

    Parameters
    ----------
    time : float, Quantity or array_like, (...)
        Times of samples, or any times within a run with ``dense=True``. The shapes of times and points are broadcast:
        times (K,) and points (K, 3) are a track, times (K, 1) and points (P, 3) are all points at all times.
    points : array_like or Quantity, (..., 3)
    body : int or str, optional

    Returns
    -------
    Gravity

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> run = system.integrate(state, 10.0, output=5.0, dense=True)
    >>> run.gravity([[1.0], [2.5]], [[0.0, 0.0, 5.0], [0.0, 3.0, 5.0], [0.0, 0.0, 9.0]]).potential.shape
    (2, 3)
    """
    context = run.context
    times, array = context.units.strip(time, "time", "time"), points_in(points, context.units)
    try:
        shape = np.broadcast_shapes(times.shape, array.shape[:-1])
    except ValueError as error:
        shapes = f"times of shape {times.shape} and points of shape {array.shape}"
        raise InvalidInput(f"{shapes} do not go together; expected shapes that numpy broadcasts") from error
    distinct, index = np.unique(times, return_inverse=True)
    states = run.states(distinct)
    poses, index = (states["position"], states["attitude"]), np.broadcast_to(index.reshape(times.shape), shape)
    only = None if body is None else context.index(body)
    return gravity_at(context.attraction, *poses, np.broadcast_to(array, (*shape, 3)), context.units, only, index)
