"""Tait-Bryan angles against time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base import rotations
from . import _style
from ._style import ArrayOfAxes, RunPlots
from .sampling import followed

_SYMBOLS = (r"$\phi$", r"$\theta$", r"$\psi$")


def angles(plots: RunPlots, ax: Any = None, *, bodies: Sequence[int | str] | None = None, **kwargs: Any) -> ArrayOfAxes:
    """Draw Tait-Bryan angles against time, in degrees: a row per body, with phi and theta in one panel, psi in
    another.

    Parameters
    ----------
    ax : array of matplotlib Axes, optional
        Axes to draw on, two for each body; ``axes`` is another name of the argument.
    bodies : sequence of int or str, optional
        Indices in the system, or names; by default all bodies.
    **kwargs
        Passed to ``Axes.plot``.

    Returns
    -------
    ndarray of Axes, (number of bodies, 2), or the axes given
    """
    run, ax, kwargs = plots.sampled(), kwargs.pop("axes", ax), _style.wishes(kwargs)
    indices = _style.chosen(run, bodies)
    flat, result = _style.panels(ax, (len(indices), 2), (9.0, 0.4 + 2.2 * len(indices)))
    moments, attitude = followed(run)
    time = _style.times(run, moments)
    for row, body in enumerate(indices):
        values = np.rad2deg(rotations.tait_bryan(attitude[:, body]))
        left, right = flat[2 * row], flat[2 * row + 1]
        for ax, columns in ((left, (0, 1)), (right, (2,))):
            for column in columns:
                _style.draw_angle(
                    ax, time, values[:, column], _style.line(column, {"label": _SYMBOLS[column], **kwargs})
                )
            ax.set_ylabel(", ".join(_SYMBOLS[c] for c in columns) + " [deg]")
            ax.set_title(_style.called(run, body), fontsize="medium", loc="left")
            _style.degrees(ax)
            _style.grid(ax)
            _style.legend(ax)
    for ax in flat[-2:]:
        _style.time_label(ax, run)
    return result
