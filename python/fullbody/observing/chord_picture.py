"""The picture of chords in the plane of the sky, with the outlines of bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.figures import LINES, grid, legend, single, unit_of
from ..record.record import Record
from .predicted_chords import PredictedChords


def draw_chords(data: PredictedChords, run: Record, ax: Any, kwargs: dict[str, Any]) -> Any:
    """Draw chords and outlines; see :meth:`fullbody.observing.StellarOccultation.plot`."""
    ax = single(ax, (5.5, 5.0))
    sky, sigma = data.sky(run), data.errors_in(run.system)
    seen = data.sign != 0.0
    style = {"color": "0.3", "linewidth": 1.0} | kwargs
    for station in np.unique(data.station[seen]):
        rows = np.flatnonzero(seen & (data.station == station))
        ends = sky.points[rows]
        ax.plot(*ends.T, marker="o" if len(rows) == 1 else "", markersize=2.5, **style)
        if len(rows) == 2:
            times = data.times_in(run.system)[rows]
            velocity = (ends[1] - ends[0]) / (times[1] - times[0])
            for end, error in zip(ends, sigma[rows], strict=True):
                ax.plot(
                    *np.transpose([end - error * velocity, end + error * velocity]),
                    color=LINES[4]["color"],
                    linewidth=2.2,
                )
    if not seen.all():
        ax.plot(*sky.points[~seen].T, ".", color="0.6", label="miss")
    for k, (name, lines) in enumerate(sky.outlines.items()):
        for line in lines:
            ax.plot(*line.T, color=LINES[k % 3]["color"], linewidth=1.4, label=name if line is lines[0] else None)
    unit = unit_of(run.context.units.attach(1.0, "length"))
    ax.set_xlabel(f"east [{unit}]")
    ax.set_ylabel(f"north [{unit}]")
    ax.set_aspect("equal")
    if not ax.xaxis_inverted():
        ax.invert_xaxis()
    grid(ax)
    legend(ax, markerscale=1.0)
    return ax
