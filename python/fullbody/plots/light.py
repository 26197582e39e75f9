"""The light curve of a run, with its mutual events, and views of the bodies above it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import figures
from ..base.figures import full_option_names, legend, line, single
from ..base.kinds import whole_number
from ..observing.light_curve import light_curve as magnitudes
from ..observing.mutual import mutual_events
from ..observing.times import to_system_times
from ..record.record import Record
from ..typing import Floats
from ._style import RunPlots, label, label_of, rounded
from .telescope import SkyFrames

if TYPE_CHECKING:
    from ..observing.vectors import Vectors

#: The arguments of a light curve; all others are those of a line.
_OF_LIGHT = ("law", "albedo", "mutual", "sun_radius", "reduced")
#: Colours of bars by the kind of event.
_EVENT_COLOURS = {"occultation": "#56b4e9", "eclipse": "#e69f00"}
#: A line is broken where the interval between points is this multiple of the median one.
_GAP = 8.0


def light_curve(
    plots: RunPlots,
    times: Any,
    geometry: Vectors,
    ax: Any = None,
    *,
    bodies: bool = False,
    events: bool = True,
    views: Any = 0,
    **kwargs: Any,
) -> Any:
    """Draw magnitudes, which decrease upwards, with mutual events marked as bars, and the bodies in the sky above them.

    Parameters
    ----------
    times : astropy Time, or array_like or Quantity, (K,)
        Times at which the light arrives.
    geometry : fullbody.observing.Geometry
    ax : matplotlib Axes, or array of them, optional
        With ``bodies`` one for all bodies together, and one for each body.
    bodies : bool
        Whether the magnitude of each body is drawn too, each in a panel of its own.
    events : bool
        Whether mutual events are marked.
    views : int, or astropy Time, array_like or Quantity, (V,)
        The number of pictures of the bodies in the sky above the curve, at equal steps of time, or their times; see
        :meth:`fullbody.plots.Plots.sky`.
    **kwargs
        ``law``, ``albedo``, ``mutual``, ``sun_radius`` and ``reduced`` are passed to
        :func:`fullbody.observing.light_curve`; others to ``Axes.plot``.
    """
    run, options = plots.run, {name: kwargs.pop(name) for name in _OF_LIGHT if name in kwargs}
    moments = np.atleast_1d(to_system_times(times, run.system, "times"))
    per_body = magnitudes(run, times, geometry, per_body=True, **options)
    with np.errstate(divide="ignore"):
        total = -2.5 * np.log10(np.sum(10.0 ** (-0.4 * per_body), axis=1))
    order = np.argsort(moments)
    curves = [("all bodies", total[order])]
    if bodies:
        curves += [(label_of(run, body), per_body[order, body]) for body in range(len(run.context))]
    view_times = _times_of_views(views, run, moments)
    kwargs, size = full_option_names(kwargs), (7.0, 1.6 + 1.8 * len(curves) + (1.4 if len(view_times) else 0.0))
    flat, result = figures.panels(ax, (len(curves),), size) if bodies else ([single(ax, size)], None)
    for axis, (name, values) in zip(flat, curves, strict=True):
        axis.plot(*_with_gaps(moments[order], values), **line(0, {"color": "k", "linewidth": 1.0, **kwargs}))
        if not axis.yaxis_inverted():
            axis.invert_yaxis()
        if events and run.dense is not None:
            _mark_events(axis, run, geometry, moments)
        axis.set_ylabel("magnitude")
        figures.grid(axis)
        if bodies:
            axis.set_title(name, fontsize="medium", loc="left", y=1.0)
    flat[-1].set_xlabel(label(run, "time", "time"))
    legend(flat[0])
    if len(view_times):
        _draw_views(flat[0], run, view_times, geometry)
    return result if bodies else flat[0]


def _with_gaps(moments: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return a curve with breaks at gaps in time, and where a body is hidden and has no magnitude."""
    steps = np.diff(moments)
    gaps = np.flatnonzero(steps > _GAP * np.median(steps)) + 1 if len(steps) else np.array([], dtype=int)
    finite = np.where(np.isfinite(values), values, np.nan)
    return np.insert(moments, gaps, np.nan), np.insert(finite, gaps, np.nan)


def _times_of_views(views: Any, run: Record, moments: Floats) -> Floats:
    """Return the times of the pictures above a light curve."""
    if np.ndim(views) == 0 and not hasattr(views, "unit"):
        count = whole_number(views, "views", 0)
        return moments.min() + (np.arange(count) + 0.5) / max(1, count) * np.ptp(moments)
    return np.sort(np.atleast_1d(to_system_times(views, run.system, "views")))


def _draw_views(ax: Any, run: Record, times: Floats, geometry: Vectors) -> None:
    """Draw the bodies in the sky above axes, all to one scale, and mark their times in these."""
    frames, count = SkyFrames(run, times, geometry), len(times)
    box = ax.get_window_extent()
    # A row of squares above the legend.
    bottom, side = 1.0 + 20.0 * ax.figure.dpi / 72.0 / box.height, 0.94 / count
    for k, time in enumerate(times):
        view = ax.inset_axes([(k + 0.03) / count, bottom, side, min(side * box.width / box.height, 0.8)])
        frames.prepare(view)
        # One scale and one compass do for all.
        for artist in (*view.texts, *view.lines) if k else ():
            artist.remove()
        frames.draw(view, k, False, {})
        view.set(xticks=[], yticks=[], xlabel="", ylabel="")
        view.set_title(rounded(time), fontsize="small", pad=2.0)
        ax.axvline(time, color="0.5", linewidth=0.8, linestyle=":")


def _mark_events(ax: Any, run: Record, geometry: Vectors, moments: Floats) -> None:
    """Draw bars from the beginning to the end of each mutual event, darker in totality."""
    first, last = moments.min(), moments.max()
    labelled: set[str] = set()

    def clipped(time: Any, default: float) -> float:
        return default if time is None else float(np.clip(getattr(time, "value", time), first, last))

    for event in mutual_events(run, geometry):
        begin, end = clipped(event.begin, first), clipped(event.end, last)
        style = {"color": _EVENT_COLOURS[event.kind], "linewidth": 0.0}
        if begin < end:
            label = None if event.kind in labelled else event.kind
            labelled.add(event.kind)
            ax.axvspan(begin, end, alpha=0.22, label=label, **style)
        if event.total_begin is not None:
            ax.axvspan(clipped(event.total_begin, first), clipped(event.total_end, last), alpha=0.25, **style)
