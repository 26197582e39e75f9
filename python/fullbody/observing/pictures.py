"""Pictures of data with the predictions of a run: values over time with their residuals, and chords in the sky."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..base.figures import LINES, grid, legend, line, matplotlib, panels, single, unit_of
from ..base.foreign import are_dates
from ..typing import Floats


def draw(
    across: tuple[Any, str],
    parts: Mapping[str, tuple[Any, Any, Any]],
    axes: Any,
    kwargs: dict[str, Any],
) -> Any:
    """Draw data with their errors over predictions, and below them the residuals, and return the axes (2, C).

    The horizontal axis has the numbers or dates (K,) of ``across``, and its label. The ``parts`` are predictions,
    residuals and standard errors (K,) by the names of the C numbers of a row; ``kwargs`` go to ``Axes.errorbar``.
    """
    flat, result = panels(axes, (2, len(parts)), (0.6 + 4.6 * len(parts), 4.8))
    x_values, label = across
    for k, (name, (predicted, residual, sigma)) in enumerate(parts.items()):
        above, below = flat[k], flat[len(parts) + k]
        unit = f" [{unit_of(residual)}]" if hasattr(residual, "unit") else ""
        model, difference, errors = (
            np.asarray(getattr(values, "value", values)) for values in (predicted, residual, sigma)
        )
        style = {"linestyle": "", "marker": ".", "markersize": 4.0, "color": "k", "elinewidth": 0.7, **kwargs}
        above.plot(
            x_values, model, **line(0, {"marker": "_", "linestyle": "", "markersize": 7.0, "label": "predicted"})
        )
        above.errorbar(x_values, model + difference, errors, **{"label": "observed", **style})
        below.axhline(0.0, **line(0, {}))
        below.errorbar(x_values, difference, errors, **style)
        above.set_ylabel(f"{name}{unit}")
        below.set_ylabel(f"observed \N{MINUS SIGN} predicted{unit}")
        below.set_xlabel(label)
        for ax in (above, below):
            grid(ax)
            if name == "magnitude" and not ax.yaxis_inverted():
                ax.invert_yaxis()
        if np.asarray(x_values).dtype == object:
            locator = matplotlib("dates").AutoDateLocator(maxticks=6)
            below.xaxis.set_major_locator(locator)
            below.xaxis.set_major_formatter(matplotlib("dates").ConciseDateFormatter(locator))
    legend(flat[0], markerscale=1.0)
    return result


def time_axis(times: Any) -> tuple[Any, str]:
    """Return times in the form that an axis takes, and its label."""
    if are_dates(times):
        return np.asarray(times.utc.to_datetime()), "date, UTC"
    return np.asarray(getattr(times, "value", times)), f"time since the epoch [{unit_of(times)}]"


class ChordPicture(NamedTuple):
    """Chords in the plane of the sky that moves with the barycentre: lengths to the east and to the north."""

    #: The ends (2, 2) of each chord, or (1, 2) if one of them was timed.
    chords: list[Floats]
    #: The ends (2, 2) of the bars of standard errors along the chords.
    errors: list[Floats]
    #: The lines of sight (M, 2) of misses in the middle of their intervals.
    misses: Floats
    #: Lines (R, 2) of the outline of each body, which has NaN between separate lines.
    outlines: dict[str, list[Floats]]


def draw_chords(picture: ChordPicture, unit: str, ax: Any, kwargs: dict[str, Any]) -> Any:
    """Draw chords and outlines; see :meth:`fullbody.observing.StellarOccultation.plot`."""
    ax = single(ax, (5.5, 5.0))
    style = {"color": "0.3", "linewidth": 1.0} | kwargs
    for chord in picture.chords:
        ax.plot(*chord.T, marker="o" if len(chord) == 1 else "", markersize=2.5, **style)
    for bar in picture.errors:
        ax.plot(*bar.T, color=LINES[4]["color"], linewidth=2.2)
    if len(picture.misses):
        ax.plot(*picture.misses.T, ".", color="0.6", label="miss")
    for k, (name, lines) in enumerate(picture.outlines.items()):
        for outline in lines:
            ax.plot(*outline.T, color=LINES[k % 3]["color"], linewidth=1.4, label=name if outline is lines[0] else None)
    ax.set_xlabel(f"east [{unit}]")
    ax.set_ylabel(f"north [{unit}]")
    ax.set_aspect("equal")
    if not ax.xaxis_inverted():
        ax.invert_xaxis()
    grid(ax)
    legend(ax, markerscale=1.0)
    return ax
