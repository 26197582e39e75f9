"""The drifts of energy and angular momentum."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._style import check_samples, grid, legend, line, single, time_label, times, wishes

if TYPE_CHECKING:
    from ..record.base import BaseRun

#: Half the spacing of doubles at 1: no smaller relative change exists.
_FLOOR = 0.5 * float(np.finfo(np.float64).eps)


def energy(run: BaseRun, ax: Any, **kwargs: Any) -> Any:
    """See :meth:`fullbody.plots.Plots.energy`."""
    check_samples(run)
    ax, kwargs = single(ax, (7.0, 3.2)), wishes(kwargs)
    time = times(run)
    drifts = {
        "energy_drift": "energy / total",
        "energy_drift_orbital": "energy / orbital",
        "angular_momentum_drift": "angular momentum",
    }
    for place, (of, name) in enumerate(drifts.items()):
        # A drift that is relative to zero is left out: a body alone has no orbit, and one at rest no angular momentum.
        if not run._relative_to(of):
            continue
        drift = run._drift(of)
        # A logarithm has no zero: the line goes on from the sample before to the one after.
        shown = drift != 0.0
        name = name if shown.any() else f"{name}: no change"
        ax.plot(time[shown], np.abs(drift[shown]), **line(place, {"label": name, **kwargs}))
    ax.set_yscale("log")
    largest = ax.dataLim.y1 if np.isfinite(ax.dataLim.y1) else 0.0
    ax.set_ylim(_FLOOR / 2, 10.0 * max(largest, _FLOOR))
    # A run from a file of version 0.1.0 does not tell its start.
    ax.set_ylabel("|relative drift|" if run.start else "|relative drift|\nsince the first sample")
    grid(ax)
    legend(ax)
    time_label(ax, run)
    return ax
