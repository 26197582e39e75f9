"""The drifts of energy and angular momentum."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..record import conserved
from ._style import RunPlots, grid, legend, line, single, time_label, times, wishes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Half the spacing of doubles at 1, the smallest relative change that exists.
_FLOOR = 0.5 * float(np.finfo(np.float64).eps)


def energy(plots: RunPlots, ax: Any = None, **kwargs: Any) -> Axes:
    """Draw the drift of the energy, relative to the total and to the orbit's energy, and of the angular momentum.

    Parameters
    ----------
    ax : matplotlib Axes, optional
    **kwargs
        Passed to ``Axes.plot``.

    Returns
    -------
    matplotlib Axes

    Notes
    -----
    The axis is logarithmic; samples with a drift of exactly zero are left out. The orbit's energy is potential +
    translational.
    """
    run = plots.sampled()
    ax, kwargs = single(ax, (7.0, 3.2)), wishes(kwargs)
    time = times(run)
    drifts = {
        "energy_drift": "energy / total",
        "energy_drift_orbital": "energy / orbital",
        "angular_momentum_drift": "angular momentum",
    }
    for index, (of, name) in enumerate(drifts.items()):
        # A drift relative to zero is left out: a single body has no orbital energy, one at rest no angular momentum.
        if not conserved.size(of, run.invariants):
            continue
        drift = getattr(run, of)
        # Zero has no logarithm: the line continues from the sample before to the one after.
        shown = drift != 0.0
        name = name if shown.any() else f"{name}: no change"
        ax.plot(time[shown], np.abs(drift[shown]), **line(index, {"label": name, **kwargs}))
    ax.set_yscale("log")
    largest = ax.dataLim.y1 if np.isfinite(ax.dataLim.y1) else 0.0
    ax.set_ylim(_FLOOR / 2, 10.0 * max(largest, _FLOOR))
    ax.set_ylabel("|relative drift|")
    grid(ax)
    legend(ax)
    time_label(ax, run)
    return ax
