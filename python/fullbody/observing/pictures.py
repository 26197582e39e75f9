"""Pictures of data with the predictions of a run and the residuals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..base.figures import grid, legend, line, matplotlib, panels, unit_of
from ..base.foreign import are_dates


def draw(
    across: tuple[Any, str],
    parts: Mapping[str, tuple[Any, Any, Any]],
    axes: Any,
    kwargs: dict[str, Any],
) -> Any:
    """Draw data with their errors over predictions, and below them the residuals.

    Parameters
    ----------
    across : (ndarray, (K,), str)
        The numbers or dates along the horizontal axis, and its label.
    parts : mapping of str to three ndarrays or Quantities, (K,)
        For each number of a row its name with predictions, residuals and standard errors.
    axes : array of matplotlib Axes, or None
        Two rows with a column for each number.
    kwargs : dict
        Options for ``Axes.errorbar``.

    Returns
    -------
    ndarray of Axes, (2, C)
    """
    flat, result = panels(axes, (2, len(parts)), (0.6 + 4.6 * len(parts), 4.8))
    places, label = across
    for k, (name, (predicted, residual, sigma)) in enumerate(parts.items()):
        above, below = flat[k], flat[len(parts) + k]
        unit = f" [{unit_of(residual)}]" if hasattr(residual, "unit") else ""
        model, left, errors = (np.asarray(getattr(values, "value", values)) for values in (predicted, residual, sigma))
        style = {"linestyle": "", "marker": ".", "markersize": 4.0, "color": "k", "elinewidth": 0.7, **kwargs}
        above.plot(places, model, **line(0, {"marker": "_", "linestyle": "", "markersize": 7.0, "label": "predicted"}))
        above.errorbar(places, model + left, errors, **{"label": "observed", **style})
        below.axhline(0.0, **line(0, {}))
        below.errorbar(places, left, errors, **style)
        above.set_ylabel(f"{name}{unit}")
        below.set_ylabel(f"observed \N{MINUS SIGN} predicted{unit}")
        below.set_xlabel(label)
        for ax in (above, below):
            grid(ax)
            if name == "magnitude" and not ax.yaxis_inverted():
                ax.invert_yaxis()
        if np.asarray(places).dtype == object:
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


def draw_spectra(
    edges: Any, parts: Sequence[tuple[Any, Any, Any]], titles: Sequence[str], axes: Any, kwargs: dict[str, Any]
) -> Any:
    """Draw radar spectra over their predictions, one column for each, and below them the residuals.

    Parameters
    ----------
    edges : ndarray or Quantity, (F,)
        The edges of the bins of frequency.
    parts : sequence of three ndarrays or Quantities, (F - 1,)
        For each spectrum the prediction, the residuals and the standard errors.
    titles : sequence of str
    axes : array of matplotlib Axes, or None
    kwargs : dict
        Options for ``Axes.errorbar``.

    Returns
    -------
    ndarray of Axes, (2, K)
    """
    flat, result = panels(axes, (2, len(parts)), (0.6 + 3.4 * len(parts), 4.8))
    plain = np.asarray(getattr(edges, "value", edges))
    middles = 0.5 * (plain[1:] + plain[:-1])
    for k, (three, title) in enumerate(zip(parts, titles, strict=True)):
        unit = f" [{unit_of(three[0])}]" if hasattr(three[0], "unit") else ""
        model, left, errors = (np.asarray(getattr(values, "value", values)) for values in three)
        style = {"linestyle": "", "marker": ".", "markersize": 3.0, "color": "k", "elinewidth": 0.6, **kwargs}
        above, below = flat[k], flat[len(parts) + k]
        above.errorbar(middles, model + left, errors, **{"label": "observed", **style})
        above.stairs(model, plain, baseline=None, color=line(0, {})["color"], label="predicted", zorder=3.0)
        below.axhline(0.0, **line(0, {}))
        below.errorbar(middles, left, errors, **style)
        above.set_title(title, fontsize="small")
        below.set_xlabel(f"frequency [{unit_of(edges)}]")
        if k == 0:
            above.set_ylabel(f"power{unit}")
            below.set_ylabel(f"observed \N{MINUS SIGN} predicted{unit}")
        grid(above)
        grid(below)
    flat[0].legend(frameon=False, fontsize="small")
    return result


def draw_images(edges: tuple[Any, Any], parts: Sequence[tuple[Any, Any, Any]], titles: Sequence[str], axes: Any) -> Any:
    """Draw delay-Doppler images: in each column the observed one, the prediction, and the residuals over their errors.

    Parameters
    ----------
    edges : two ndarrays or Quantities, (D,) and (F,)
        The edges of the bins of delay and of frequency.
    parts : sequence of three ndarrays or Quantities, (D - 1, F - 1)
        For each image the prediction, the residuals and the standard errors.
    titles : sequence of str
    axes : array of matplotlib Axes, or None

    Returns
    -------
    ndarray of Axes, (3, K)
    """
    flat, result = panels(axes, (3, len(parts)), (0.8 + 3.0 * len(parts), 7.4))
    delays, frequencies = (np.asarray(getattr(one, "value", one)) for one in edges)
    for k, (three, title) in enumerate(zip(parts, titles, strict=True)):
        model, left, errors = (np.asarray(getattr(values, "value", values)) for values in three)
        high = float(np.max(model, initial=0.0)) or 1.0
        shown = (
            (model + left, "observed", {"cmap": "gray", "vmin": 0.0, "vmax": high}),
            (model, "predicted", {"cmap": "gray", "vmin": 0.0, "vmax": high}),
            (left / errors, "residual / error", {"cmap": "RdBu", "vmin": -4.0, "vmax": 4.0}),
        )
        for row, (image, name, style) in enumerate(shown):
            ax = flat[row * len(parts) + k]
            ax.pcolormesh(frequencies, delays, image, **style)
            # The surface nearest to the antenna is at the top.
            ax.set_ylim(delays[-1], delays[0])
            ax.set_title(f"{title}: {name}" if row == 0 else name, fontsize="small")
            if k == 0:
                ax.set_ylabel(f"delay [{unit_of(edges[0])}]")
        flat[2 * len(parts) + k].set_xlabel(f"frequency [{unit_of(edges[1])}]")
    return result
