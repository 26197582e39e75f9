"""Shared parts of the figures."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from fullbody.base.figures import LINES, matplotlib

__all__ = ["SHAPES", "floor", "largest", "new_figure", "positive", "power", "windows"]

_Array = npt.NDArray[np.float64]

#: The lines of the two shapes of 1999 KW4, blue and red, solid and dotted as in the paper.
SHAPES: dict[str, dict[str, Any]] = {
    "ellipsoid": {**LINES[0], "label": "ellipsoids"},
    "spheroid": {**LINES[4], "linestyle": (0, (1, 1.2)), "label": "spheroids"},
}


def new_figure(rows: int, columns: int, size: tuple[float, float], **options: Any) -> tuple[Any, Any]:
    """Return a figure that is not shown in a window, and its axes (rows, columns)."""
    figure = matplotlib("figure").Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def positive(x: _Array, values: _Array) -> tuple[_Array, _Array]:
    """Return the points with positive values, which a logarithmic axis can show."""
    return x[values > 0], values[values > 0]


def power(values: Any) -> int:
    """Return the power of ten of the largest absolute value, for the label of an axis of small numbers."""
    largest_value = float(np.abs(values).max())
    return int(np.floor(np.log10(largest_value))) if largest_value > 0 else 0


def windows(x: _Array, values: _Array, width: float) -> tuple[_Array, _Array, _Array]:
    """Return the middles of windows of a width, and the smallest and the largest value in each window."""
    starts = np.unique(np.searchsorted(x, np.arange(x[0], x[-1], width)))
    ends = np.append(starts[1:], len(x)) - 1
    middle = 0.5 * (x[starts] + x[ends])
    return middle, np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)


def largest(x: _Array, values: _Array, width: float) -> tuple[_Array, _Array]:
    """Return the middles of windows of a width, and the largest absolute value in each where it is not zero."""
    middle, _, high = windows(x, np.abs(values), width)
    return positive(middle, high)


def floor(ax: Any, energy: float) -> None:
    """End an axis of relative errors of an energy at the spacing of doubles, below which the only value is zero."""
    spacing = float(np.spacing(abs(energy)) / abs(energy))
    ax.set_yscale("log")
    highest = max(float(ax.dataLim.y1), spacing)
    ax.axhspan(spacing / 1e3, spacing, color="0.93", linewidth=0, zorder=0)
    options = {"xycoords": ax.get_yaxis_transform(), "fontsize": "small", "color": "0.3", "va": "center"}
    ax.annotate("below the spacing of double-precision numbers: only 0", (0.01, spacing / 2.2), **options)
    ax.set_ylim(spacing / 4, 4 * highest)
    ax.yaxis.set_minor_formatter(matplotlib("ticker").NullFormatter())
