"""Tait-Bryan angles against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import rotations
from ..record.record import Record
from ._style import (
    called,
    check_samples,
    chosen,
    degrees,
    draw_angle,
    grid,
    legend,
    line,
    panels,
    time_label,
    times,
    wishes,
)
from .sampling import followed

_SYMBOLS = (r"$\phi$", r"$\theta$", r"$\psi$")


def angles(run: Record, axes: Any, *, bodies: Sequence[int] | None = None, **kwargs: Any) -> Any:
    """Draw Tait-Bryan angles; see :meth:`fullbody.plots.Plots.angles`."""
    check_samples(run)
    places, kwargs = chosen(run, bodies), wishes(kwargs)
    flat, result = panels(axes, (len(places), 2), (9.0, 0.4 + 2.2 * len(places)))
    moments, attitude = followed(run)
    time = times(run, moments)
    for row, body in enumerate(places):
        values = np.rad2deg(rotations.tait_bryan(attitude[:, body]))
        left, right = flat[2 * row], flat[2 * row + 1]
        for ax, columns in ((left, (0, 1)), (right, (2,))):
            for column in columns:
                draw_angle(ax, time, values[:, column], line(column, {"label": _SYMBOLS[column], **kwargs}))
            ax.set_ylabel(", ".join(_SYMBOLS[c] for c in columns) + " [deg]")
            ax.set_title(called(run, body), fontsize="medium", loc="left")
            degrees(ax)
            grid(ax)
            legend(ax)
    for ax in flat[-2:]:
        time_label(ax, run)
    return result
