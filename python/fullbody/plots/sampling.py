"""Which samples a moving picture shows, and whether they lie close enough together to show the true motion."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from ..run import Run

__all__ = ["evenly", "warn_if_aliased"]


def evenly(run: Run, count: int) -> npt.NDArray[np.int64]:
    """Places of at most ``count`` samples, as even in time as the run's samples allow."""
    time = run._record["time"]
    wanted = np.linspace(time[0], time[-1], count)
    order = np.argsort(time)
    right = np.clip(np.searchsorted(time[order], wanted), 1, max(1, len(time) - 1))
    left = right - 1
    right = np.minimum(right, len(time) - 1)
    closer = np.abs(time[order][left] - wanted) <= np.abs(time[order][right] - wanted)
    places = np.unique(order[np.where(closer, left, right)])
    return places if time[-1] >= time[0] else np.sort(places)


def warn_if_aliased(run: Run, places: npt.NDArray[np.int64]) -> None:
    """Warn where a body turns by more than half a turn between two pictures: it would seem to turn otherwise."""
    time = run._record["time"][places]
    if len(time) < 2:
        return
    rate = np.linalg.norm(run._record["spin"][places], axis=2)
    turns = (rate[:-1] * np.abs(np.diff(time))[:, None]).max(axis=0) / (2.0 * np.pi)
    body = int(np.argmax(turns))
    if turns[body] > 0.5:
        warnings.warn(
            f"{run.system.names[body]} makes up to {turns[body]:.2g} turns between two pictures and will seem to turn "
            "otherwise; record more samples (output=) over a shorter time, or show more of them",
            stacklevel=4,
        )
