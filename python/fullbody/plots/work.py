"""The work of external forces against time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidInput
from ._style import RunPlots, escaped, grid, label, legend, line, matplotlib, single, time_label, times, wishes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: The ratio of the largest to the smallest work above which a linear axis would show the smallest as zero.
_APART = 30.0
_NAME = 24


def work(plots: RunPlots, ax: Any = None, **kwargs: Any) -> Axes:
    """Draw the energy that each external force has added since the start of the run.

    Parameters
    ----------
    ax : matplotlib Axes, optional
    **kwargs
        Passed to ``Axes.plot``.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    InvalidInput
        For a run without external forces.

    Notes
    -----
    If the largest work exceeds the smallest more than thirty times, the axis is linear up to the largest work of
    the smallest force and logarithmic beyond.
    """
    run = plots.sampled()
    forces = list(run.context.forces)
    if not forces:
        raise InvalidInput("the run has no external forces; expected a system with some to draw their work")
    ax, kwargs = single(ax, (7.0, 3.2)), wishes(kwargs)
    done = run.arrays["work"]
    sizes = np.abs(done).max(axis=0)
    for index, force in enumerate(forces):
        name = force if len(force) <= _NAME else f"{force[: _NAME - 1]}…"
        name = escaped(name) if sizes[index] > 0.0 else f"{escaped(name)}: none"
        ax.plot(times(run), done[:, index], **line(index, {"label": name, **kwargs}))
    sizes = sizes[sizes > 0.0]
    if len(sizes) and sizes.max() > _APART * sizes.min():
        # The axis is linear over all of the smallest force's work, then logarithmic.
        threshold = 10.0 ** np.ceil(np.log10(sizes.min()))
        ax.set_yscale("symlog", linthresh=threshold, linscale=1.5)
        ticker = matplotlib("ticker")
        locator = ticker.SymmetricalLogLocator(base=10.0, linthresh=threshold)
        # The number of ticks is small enough for a page of plots too.
        locator.set_params(numticks=5)
        ax.yaxis.set_major_locator(locator)
    ax.set_ylabel(label(run, "work", "energy"))
    grid(ax)
    legend(ax)
    time_label(ax, run)
    return ax
