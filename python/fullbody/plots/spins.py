"""Angular velocities against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.kinds import choice
from . import _style
from ._style import ArrayOfAxes, RunPlots


def spins(
    plots: RunPlots, ax: Any = None, *, bodies: Sequence[int | str] | None = None, frame: str = "body", **kwargs: Any
) -> ArrayOfAxes:
    """Draw angular velocities against time, one panel per body.

    Parameters
    ----------
    ax : array of matplotlib Axes, optional
        Axes to draw on, one for each body; ``axes`` is another name of the argument.
    bodies : sequence of int or str, optional
        Indices in the system, or names; by default all bodies.
    frame : {"body", "inertial"}
        The frame of the components.
    **kwargs
        Passed to ``Axes.plot``.

    Returns
    -------
    ndarray of Axes, (number of bodies,), or the axes given
    """
    choice(frame, "frame", ("body", "inertial"))
    run, ax, kwargs = plots.sampled(), kwargs.pop("axes", ax), _style.wishes(kwargs)
    indices = _style.chosen(run, bodies)
    flat, result = _style.panels(ax, (len(indices),), (7.0, 0.4 + 2.2 * len(indices)))
    time = _style.times(run)
    for body, ax in zip(indices, flat, strict=True):
        spin = run.arrays["spin"][:, body]
        if frame == "inertial":
            spin = np.einsum("kij,kj->ki", _style.matrices(run, body), spin)
        for component, letter in enumerate("xyz"):
            ax.plot(time, spin[:, component], **_style.line(component, {"label": rf"$\omega_{letter}$", **kwargs}))
        ax.set_ylabel(_style.label(run, "spin", "spin"))
        ax.set_title(f"{_style.called(run, body)}, {frame} frame", fontsize="medium", loc="left")
        ax.ticklabel_format(axis="y", useOffset=False)
        _style.steady(ax)
        _style.grid(ax)
        _style.legend(ax)
    _style.time_label(flat[-1], run)
    return result
