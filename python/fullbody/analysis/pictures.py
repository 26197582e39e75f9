"""Plots of modes, branches and sections."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from ..base.figures import LINES, full_option_names, grid, legend, line, matplotlib, panels, single, unit_of
from ..base.kinds import choice
from ..base.tables import number
from ..base.units import without_unit
from ..model.state import State
from ..plots._style import escaped, in_si

_QUANTITIES = ("separation", "angular_momentum", "rate", "energy")
#: Components of a mode below this would look like zero and are not drawn.
_VISIBLE = 0.02


def branch(
    branch: Any,
    ax: Any = None,
    *,
    x: Literal["separation", "angular_momentum", "rate", "energy"] = "separation",
    y: Literal["separation", "angular_momentum", "rate", "energy", "frequency"] = "angular_momentum",
    **kwargs: Any,
) -> Any:
    """Draw one quantity against another, with stable parts as full lines and the folds marked.

    Parameters
    ----------
    ax : matplotlib axes, optional
        Those to draw on, which are returned.
    x, y : str
        Names of attributes; ``y="frequency"`` draws all modes.
    **kwargs
        Passed to ``Axes.plot``.
    """
    choice(x, "x", _QUANTITIES)
    choice(y, "y", (*_QUANTITIES, "frequency"))
    kwargs = full_option_names(kwargs)
    ax = single(ax, (6.0, 4.0))
    x_values, y_values = (without_unit(in_si(getattr(branch, name))) for name in (x, y))
    columns = y_values.reshape(len(branch), -1)
    kinds = np.where(branch.energetically_stable, 0, np.where(branch.linearly_stable, 1, 2))
    names = ("minimum of energy", "linearly stable", "unstable")
    labelled = set()
    # Each piece of one kind of stability extends to the first point of the next, so that the curve has no gaps.
    begin = 0
    for end in [*np.flatnonzero(np.diff(kinds)) + 1, len(kinds)]:
        kind = int(kinds[begin])
        for column in columns.T:
            style = {**LINES[kind], "linewidth": 1.4, **kwargs}
            label = None if kind in labelled else names[kind]
            ax.plot(x_values[begin : end + 1], column[begin : end + 1], **{"label": label, **style})
            labelled.add(kind)
        begin = end
    for fold in branch.folds if y != "frequency" else ():
        point = [without_unit(in_si(getattr(fold.equilibrium, name))) for name in (x, y)]
        ax.plot(*point, "o", color="0.2", markersize=5.0, fillstyle="none", label=f"fold in {_phrase(fold.quantity)}")
    for set_label, name in ((ax.set_xlabel, x), (ax.set_ylabel, y)):
        set_label(f"{_phrase(name)} [{unit_of(in_si(getattr(branch, name)))}]")
    if x == "separation" and branch.end == "contact":
        ax.axvline(x_values[-1], color="0.6", linewidth=0.8, linestyle=":")
        ax.annotate(
            "contact", (x_values[-1], 0.5), xycoords=("data", "axes fraction"), rotation=90, va="center", ha="right",
            fontsize="small", color="0.4", xytext=(-2, 0), textcoords="offset points",
        )  # fmt: skip
    grid(ax)
    legend(ax, markerscale=1.0)
    return ax


def _phrase(name: str) -> str:
    return name.replace("_", " ")


def modes(modes: Any, axes: Any = None) -> npt.NDArray[np.object_]:
    """Draw in one panel for each mode how far the separation and the bodies oscillate; return the panels' axes.

    The largest component of a mode is 1: an angle in radians, or the change of the distance relative to it.
    """
    count = len(modes)
    flat, panel_axes = panels(axes, (count,), (7.0, 1.1 * count + 0.6))
    rotations = [f"{escaped(name)} about {axis}" for name in modes.system.names for axis in "xyz"]
    labels = ["relative distance", "longitude", "latitude", *rotations]
    phase = np.linspace(0.0, 2.0, 201)
    shapes = np.concatenate([modes.position, modes.rotation.reshape(count, 6)], axis=1)
    styles = {k: line(k % 3, {"color": ("#000000", "#0072B2", "#D55E00")[k // 3]}) for k in range(9)}
    for mode, (ax, shape) in enumerate(zip(flat, shapes, strict=True)):
        frequency = float(without_unit(modes.frequency)[mode])
        periods = phase if frequency > 0.0 else np.zeros_like(phase)
        for k, part in enumerate(shape):
            if abs(part) > _VISIBLE:
                ax.plot(phase, np.real(part * np.exp(2j * np.pi * periods)), label=labels[k], **styles[k])
        if frequency > 0.0:
            title = f"period {number(modes.period[mode], 4)}"
        else:
            title = f"no oscillation, grows at {number(modes.growth[mode], 4)}"
        plane = "in" if modes.in_plane[mode] else "out of"
        ax.set_title(f"{title}, {plane} the plane", fontsize="small", loc="left")
        ax.set(ylim=(-1.15, 1.15), ylabel="amplitude")
        grid(ax)
        style = {"fontsize": "small", "handlelength": 1.8, "labelspacing": 0.1, "borderaxespad": 0.2}
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, **style)
    flat[-1].set_xlabel("periods of the mode")
    return np.asarray(panel_axes, dtype=object)


def section(section: Any, x: Callable[[State], Any], y: Callable[[State], Any], ax: Any = None, **kwargs: Any) -> Any:
    """Draw two coordinates of all crossings against each other, with a colour for each start, which a bar explains.

    Parameters
    ----------
    x, y : callable
        Functions that take a State and return a number or Quantity.
    ax : matplotlib axes, optional
        Those to draw on, which are returned.
    **kwargs
        Passed to ``Axes.plot``.
    """
    kwargs, columns = full_option_names(kwargs), (section.values(x), section.values(y))
    ax = single(ax, (6.0, 4.5))
    count = len(section)
    colours = matplotlib("colors").ListedColormap(matplotlib().get_cmap("viridis")(np.linspace(0.0, 0.9, count)))
    for k, (x_values, y_values) in enumerate(zip(*columns, strict=True)):
        style = {"linestyle": "none", "marker": ".", "markersize": 4.0, "markeredgewidth": 0.0, "color": colours(k)}
        ax.plot(without_unit(x_values), without_unit(y_values), **{**style, **kwargs})
    for set_label, coordinate, values in zip((ax.set_xlabel, ax.set_ylabel), (x, y), columns, strict=True):
        set_label(_title(coordinate, values))
    if count > 1 and "color" not in kwargs:
        norm = matplotlib("colors").BoundaryNorm(np.arange(count + 1) - 0.5, count)
        ticks = matplotlib("ticker").MaxNLocator(8, integer=True)
        colour_map = matplotlib("cm").ScalarMappable(norm, colours)
        ax.figure.colorbar(colour_map, ax=ax, label="index of the start", ticks=ticks)
    grid(ax)
    return ax


def _title(coordinate: Callable[[State], Any], values: Any) -> str:
    """Return the label of an axis: the name of the function unless it has none, and the unit of its values."""
    name = getattr(coordinate, "__name__", "<lambda>")
    unit = next((f"[{unit_of(part)}]" for part in values if hasattr(part, "unit")), "")
    return f"{'' if name == '<lambda>' else _phrase(name)} {unit}".strip()
