"""Parts of all pictures: matplotlib itself, axes, and line styles that are distinct in grey print."""

from __future__ import annotations

import re
from importlib import import_module
from typing import Any

import numpy as np

from ..errors import InvalidInput
from .units import need

#: Okabe and Ito's colours in an order of clearly different lightness, each with its own dashes.
LINES: tuple[dict[str, Any], ...] = (
    {"color": "#0072B2", "linestyle": "-"},
    {"color": "#E69F00", "linestyle": (0, (5, 1.5))},
    {"color": "#000000", "linestyle": (0, (1, 1.2))},
    {"color": "#009E73", "linestyle": (0, (5, 1.5, 1, 1.5))},
    {"color": "#D55E00", "linestyle": (0, (8, 2))},
    {"color": "#56B4E9", "linestyle": (0, (3, 1.5, 1, 1.5, 1, 1.5))},
)
#: The mean width in points of a character of a small text.
_CHARACTER = 4.4
#: The name in a legend of the band from the smallest to the largest value of a fast oscillation.
RANGE = "range"


def matplotlib(module: str = "pyplot") -> Any:
    """Import a module of matplotlib, or raise an error that says how to install it."""
    with need("plot", "a picture"):
        return import_module(f"matplotlib.{module}")


def line(index: int, kwargs: dict[str, Any]) -> dict[str, Any]:
    """Return the style of the index-th line, overridden by the caller's options."""
    return {"linewidth": 1.2, **LINES[index % len(LINES)], **kwargs}


def full_option_names(kwargs: dict[str, Any], artist: str = "lines.Line2D") -> dict[str, Any]:
    """Return the caller's options under their long names, since matplotlib accepts no option under two names."""
    module, _, kind = artist.rpartition(".")
    return matplotlib("cbook").normalize_kwargs(kwargs, getattr(matplotlib(module), kind))


def grid(ax: Any) -> None:
    """Draw faint grid lines behind the data."""
    ax.grid(True, color="0.9", linewidth=0.6)
    ax.set_axisbelow(True)


def legend(ax: Any, **kwargs: Any) -> None:
    """Draw a legend above the axes, where it covers no data, in as many columns as there is room for beside the title.

    Its lines are long enough to recognise dashes.
    """
    entries = kwargs.pop("handles", None) or ax.get_legend_handles_labels()[0]
    # Matplotlib warns of an empty legend.
    if not entries:
        return
    entries = sorted(entries, key=lambda entry: entry.get_label() == RANGE)
    names = [entry.get_label() for entry in entries]
    room = width(ax) - _CHARACTER * 1.2 * _length(ax.get_title(loc="left"))
    column = 30.0 + _CHARACTER * max(map(_length, names))
    style = {
        "loc": "lower right",
        "bbox_to_anchor": (1.0, 1.0),
        "ncols": min(len(names), max(1, int(room / column))),
        "frameon": False,
        "fontsize": "small",
    }
    spaces = {"handlelength": 2.2, "handletextpad": 0.5, "columnspacing": 0.8, "borderaxespad": 0.1}
    ax.legend(handles=entries, **{**style, **spaces, "markerscale": 3.0, **kwargs})


def width(ax: Any) -> float:
    """Return the width of axes in points."""
    return float(ax.get_window_extent().width * 72.0 / ax.figure.dpi)


def _length(text: str) -> int:
    """Return the number of characters that are shown of a text with formulas."""
    return len(re.sub(r"\\[a-z]+", "x", text).replace("$", "").replace("_", ""))


def panels(axes: Any, shape: tuple[int, ...], size: tuple[float, float]) -> tuple[Any, Any]:
    """Return the caller's axes as a flat array, or new ones, and the object that the plot returns."""
    if axes is None:
        rows, columns = shape if len(shape) == 2 else (shape[0], 1)
        options = {"figsize": size, "sharex": True, "squeeze": False, "layout": "constrained"}
        grid_of_axes = matplotlib().subplots(rows, columns, **options)[1]
        return list(grid_of_axes.flat), grid_of_axes.reshape(shape)
    flat = [check_axes(ax, "one of axes") for ax in np.asarray(axes, dtype=object).flat]
    if len(flat) != int(np.prod(shape)):
        raise InvalidInput(f"axes has {len(flat)} axes; expected {int(np.prod(shape))}")
    return flat, axes


def single(ax: Any, size: tuple[float, float], **projection: Any) -> Any:
    """Return the caller's axes, or new ones."""
    if ax is not None:
        return check_axes(ax, "ax")
    return matplotlib().figure(figsize=size, layout="constrained").add_subplot(**projection)


def unit_of(value: Any) -> str:
    """Return the unit of a Quantity for a label; for plain numbers, a text that they are in the system's units."""
    return str(value.unit.to_string("unicode")) if hasattr(value, "unit") else "system units"


def check_axes(ax: Any, what: str, projection: str = "") -> Any:
    """Raise an error for an object that is not matplotlib axes, or axes in 3D for a plot in 2D or vice versa."""
    if not isinstance(ax, matplotlib("axes").Axes) or (ax.name == "3d") != (projection == "3d"):
        kind = "matplotlib axes in 3D (projection='3d')" if projection else "matplotlib axes in 2D"
        raise InvalidInput(f"{what} is {ax!r}; expected {kind}")
    return ax
