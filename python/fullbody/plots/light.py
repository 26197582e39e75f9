"""The light curve of a run, with its mutual events, and views of the bodies above it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import figures
from ..base.figures import full_option_names, legend, line, single
from ..observing.light_curve import light_curve as magnitudes
from ..observing.mutual import mutual_events
from ..observing.times import in_system
from ..record.record import Record
from ..typing import Floats
from ._style import RunPlots, dress, label, label_of

if TYPE_CHECKING:
    from ..observing.vectors import Vectors

#: The arguments of a light curve; all others are those of a line.
_OF_LIGHT = ("law", "albedo", "mutual", "sun_radius", "reduced")
#: Colours of bars by the kind of event.
_BARS = {"occultation": "#56b4e9", "eclipse": "#e69f00"}
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
    **kwargs: Any,
) -> Any:
    """Draw magnitudes, which decrease upwards, with mutual events marked as bars.

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
    **kwargs
        ``law``, ``albedo``, ``mutual``, ``sun_radius`` and ``reduced`` are passed to
        :func:`fullbody.observing.light_curve`; others to ``Axes.plot``.
    """
    run, options = plots.run, {name: kwargs.pop(name) for name in _OF_LIGHT if name in kwargs}
    moments = np.atleast_1d(in_system(times, run.system, "times"))
    each = magnitudes(run, times, geometry, per_body=True, **options)
    with np.errstate(divide="ignore"):
        total = -2.5 * np.log10(np.sum(10.0 ** (-0.4 * each), axis=1))
    order = np.argsort(moments)
    curves = [("all bodies", total[order])]
    if bodies:
        curves += [(label_of(run, body), each[order, body]) for body in range(len(run.context))]
    kwargs, size = full_option_names(kwargs), (7.0, 1.6 + 1.8 * len(curves))
    flat, result = figures.panels(ax, (len(curves),), size) if bodies else ([single(ax, size)], None)
    for axis, (name, values) in zip(flat, curves, strict=True):
        axis.plot(*_broken(moments[order], values), **line(0, {"color": "k", "linewidth": 1.0, **kwargs}))
        if not axis.yaxis_inverted():
            axis.invert_yaxis()
        if events and run.dense is not None:
            _mark(axis, run, geometry, moments)
        dress(axis, f"magnitude of {name}" if bodies else "magnitude")
    flat[-1].set_xlabel(label(run, "time", "time"))
    legend(flat[0])
    return result if bodies else flat[0]


def _broken(moments: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Return a curve with breaks at gaps in time, and where a body is hidden and has no magnitude."""
    apart = np.diff(moments)
    gaps = np.flatnonzero(apart > _GAP * np.median(apart)) + 1 if len(apart) else np.array([], dtype=int)
    shown = np.where(np.isfinite(values), values, np.nan)
    return np.insert(moments, gaps, np.nan), np.insert(shown, gaps, np.nan)


def _mark(ax: Any, run: Record, geometry: Vectors, moments: Floats) -> None:
    """Draw bars from the beginning to the end of each mutual event, darker in totality."""
    first, last = moments.min(), moments.max()
    named: set[str] = set()

    def within(time: Any, otherwise: float) -> float:
        return otherwise if time is None else float(np.clip(getattr(time, "value", time), first, last))

    for event in mutual_events(run, geometry):
        begin, end = within(event.begin, first), within(event.end, last)
        if begin < end:
            name = {} if event.kind in named else {"label": event.kind}
            named.add(event.kind)
            ax.axvspan(begin, end, alpha=0.22, color=_BARS[event.kind], linewidth=0.0, **name)
        if event.total_begin is not None:
            total = within(event.total_begin, first), within(event.total_end, last)
            ax.axvspan(*total, alpha=0.25, color=_BARS[event.kind], linewidth=0.0)
