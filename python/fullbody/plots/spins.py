"""Angular velocities against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.kinds import choice
from ..record.record import Record
from ._style import (
    called,
    check_samples,
    chosen,
    grid,
    label,
    legend,
    line,
    matrices,
    panels,
    steady,
    time_label,
    times,
    wishes,
)


def spins(run: Record, axes: Any, *, bodies: Sequence[int] | None = None, frame: str, **kwargs: Any) -> Any:
    """Draw angular velocities; see :meth:`fullbody.plots.Plots.spins`."""
    choice(frame, "frame", ("body", "inertial"))
    check_samples(run)
    places, kwargs = chosen(run, bodies), wishes(kwargs)
    flat, result = panels(axes, (len(places),), (7.0, 0.4 + 2.2 * len(places)))
    time = times(run)
    for body, ax in zip(places, flat, strict=True):
        spin = run.arrays["spin"][:, body]
        if frame == "inertial":
            spin = np.einsum("kij,kj->ki", matrices(run, body), spin)
        for component, letter in enumerate("xyz"):
            ax.plot(time, spin[:, component], **line(component, {"label": rf"$\omega_{letter}$", **kwargs}))
        ax.set_ylabel(label(run, "spin", "spin"))
        ax.set_title(f"{called(run, body)}, {frame} frame", fontsize="medium", loc="left")
        ax.ticklabel_format(axis="y", useOffset=False)
        steady(ax)
        grid(ax)
        legend(ax)
    time_label(flat[-1], run)
    return result
