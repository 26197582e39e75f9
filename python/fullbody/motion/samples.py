"""Runs made of the samples of others: of two that leave one start in both directions, and at chosen times."""

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
    parts = ((earlier._record[name][::-1], later._record[name]) for name in later._record)
    run = copy.copy(later)
    run._record = {name: np.concatenate(part) for name, part in zip(later._record, parts, strict=True)}
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
