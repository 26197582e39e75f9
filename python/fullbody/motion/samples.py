"""Runs made of the samples of other runs: of two runs from one start in both directions, and at chosen times."""

from __future__ import annotations

import copy
from dataclasses import astuple

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput
from ..record.statistics import Statistics
from .run import Run

__all__ = ["chosen", "joined"]


def joined(later: Run, earlier: Run) -> Run:
    """Return the run with the samples of a run forward and of one backward from the same start, in the order of time.

    It has the statistics of both, no events and no continuous solution.
    """
    # A run without samples keeps no derivatives.
    run = copy.copy(later if len(later) else earlier)
    run._record = {
        name: np.concatenate([values[::-1], later._record.get(name, values[:0])])
        for name, values in earlier._record.items()
    }
    counts = (astuple(one.statistics) for one in (later, earlier))
    run.statistics = Statistics(*(sum(both) for both in zip(*counts, strict=True)))
    run.events, run.dense, run._drifts = [], None, {}
    run._protect()
    return run


def chosen(run: Run, times: npt.NDArray[np.float64]) -> Run:
    """Return the run with those of its samples that have these times (K,), in numbers of the system's units."""
    place = np.searchsorted(run._record["time"], times)
    if not np.array_equal(run._record["time"][np.minimum(place, len(run) - 1)] if len(run) else times[:0], times):
        raise InvalidInput("a time is not among those of the samples; expected times of samples")
    found = copy.copy(run)
    found._record = {name: np.ascontiguousarray(values[place]) for name, values in run._record.items()}
    found._drifts = {}
    found._protect()
    return found
