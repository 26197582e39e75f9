"""Gravity at the times of a run."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput
from ..model.gravity import Gravity, gravity_at, points_in

if TYPE_CHECKING:
    from ..motion.run import Run

__all__ = ["gravity"]


def gravity(run: Run, time: Any, points: Any, body: int | str | None) -> Gravity:
    """Compute gravity at points and times; see :meth:`fullbody.Run.gravity`."""
    units = run.system._units
    times, array = units.strip(time, "time", "time"), points_in(points, units)
    try:
        shape = np.broadcast_shapes(times.shape, array.shape[:-1])
    except ValueError as error:
        shapes = f"times of shape {times.shape} and points of shape {array.shape}"
        raise InvalidInput(f"{shapes} do not go together; expected shapes that numpy broadcasts") from error
    asked, states = np.unique(times, return_inverse=True)
    place = None if body is None else run.system._place(body, "body")
    of = np.broadcast_to(states.reshape(times.shape), shape)
    poses = _poses(run, asked)
    return gravity_at(run.system._attracting, *poses, np.broadcast_to(array, (*shape, 3)), units, place, of)


def _poses(run: Run, times: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return positions (K, N, 3) and attitudes (K, N, 4) at times (K,), as plain numbers."""
    units = run.system._units
    if run.dense is not None:
        found = run.dense(units.attach(times, "time"))
        return units.strip(found.position, "length", "position"), found.attitude
    own = run._record["time"]
    order = np.argsort(own, kind="stable")
    places = np.searchsorted(own[order], times).clip(max=len(own) - 1)
    missing = np.flatnonzero(own[order][places] != times) if len(own) else np.arange(len(times))
    if missing.size:
        raise InvalidInput(
            f"time is {units.attach(times[missing[0]], 'time')}, of no sample; expected times of samples, or a run "
            "with dense=True"
        )
    places = order[places]
    return run._record["position"][places], run._record["attitude"][places]
