"""Pictures of radar echoes: Doppler spectra and delay-Doppler images."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.figures import full_option_names, grid, legend, line, single, unit_of
from ..base.units import as_quantity, is_quantity, without_unit
from ..observing.radar_echoes import delay_doppler as image_of
from ..observing.radar_echoes import radar_spectrum as spectrum_of
from ..record.record import Record
from ..typing import Floats
from ._style import RunPlots, colour_bar, label, label_of, unit

if TYPE_CHECKING:
    from ..observing.vectors import Vectors

#: The options of echoes; further arguments are those of matplotlib.
_OF_ECHOES = ("law", "mutual", "transmitter", "exposure", "frequency_response", "delay_response")


def radar_spectrum(
    plots: RunPlots,
    time: Any,
    geometry: Vectors,
    frequencies: Any,
    ax: Any = None,
    *,
    transmit_frequency: Any,
    bodies: bool = False,
    **kwargs: Any,
) -> Any:
    """Draw the Doppler spectrum of a radar echo as steps, with the cross section in each bin.

    Parameters
    ----------
    time : astropy Time, float or Quantity
        The time when the echo arrives.
    geometry, frequencies, transmit_frequency
        Arguments of :func:`fullbody.observing.radar_spectrum`.
    ax : matplotlib Axes, optional
    bodies : bool
        Whether the echo of each body is drawn, too.
    **kwargs
        ``law``, ``mutual``, ``transmitter``, ``exposure`` and ``frequency_response`` are passed to
        :func:`fullbody.observing.radar_spectrum`; others to ``Axes.stairs``.
    """
    run, options = plots.run, {name: kwargs.pop(name) for name in _OF_ECHOES if name in kwargs}
    options |= {"transmit_frequency": transmit_frequency, "per_body": True}
    echo = spectrum_of(run, _moment(time), geometry, frequencies, **options)
    power = without_unit(echo.power)[0]
    edges, text = _axis(run, frequencies, echo.frequencies, "Doppler frequency", "rate")
    ax, kwargs = single(ax, (6.4, 3.4)), full_option_names(kwargs, "patches.StepPatch")
    curves = [("all bodies", power.sum(axis=0), {"color": "k", "linewidth": 1.2, **kwargs})]
    if bodies:
        curves += [(label_of(run, k), power[k], line(k, dict(kwargs))) for k in range(len(power))]
    for name, values, style in curves:
        ax.stairs(values, edges, **({"label": name} if bodies else {}) | style)
    ax.set(xlabel=text, ylabel=label(run, "cross section", "area"), xlim=(edges[0], edges[-1]))
    ax.set_ylim(bottom=0.0)
    grid(ax)
    legend(ax)
    return ax


def delay_doppler(
    plots: RunPlots,
    time: Any,
    geometry: Vectors,
    delays: Any,
    frequencies: Any,
    ax: Any = None,
    *,
    transmit_frequency: Any,
    **kwargs: Any,
) -> Any:
    """Draw a delay-Doppler image of all bodies: delay increases downwards, frequency to the right.

    The brightness is the square root of the cross section, which shows faint parts.

    Parameters
    ----------
    time : astropy Time, float or Quantity
        The time when the echo arrives.
    geometry, delays, frequencies, transmit_frequency
        Arguments of :func:`fullbody.observing.delay_doppler`.
    ax : matplotlib Axes, optional
    **kwargs
        ``law``, ``mutual``, ``transmitter``, ``exposure``, ``frequency_response`` and ``delay_response`` are passed to
        :func:`fullbody.observing.delay_doppler`; others to ``Axes.pcolormesh``.
    """
    run, options = plots.run, {name: kwargs.pop(name) for name in _OF_ECHOES if name in kwargs}
    options["transmit_frequency"] = transmit_frequency
    echo = image_of(run, _moment(time), geometry, delays, frequencies, **options)
    power = without_unit(echo.power)[0]
    x, x_label = _axis(run, frequencies, echo.frequencies, "Doppler frequency", "rate")
    y, y_label = _axis(run, delays, echo.delays, "delay", "time")
    ax = single(ax, (5.6, 4.2))
    artist = ax.pcolormesh(x, y, np.sqrt(power), **{"cmap": "gray", "vmin": 0.0, **kwargs})
    ax.set(xlabel=x_label, ylabel=y_label, xlim=(x[0], x[-1]), ylim=(y[-1], y[0]))
    colour_bar(ax, artist, "root of the cross section", unit(run, "length") or "system units")
    return ax


def _moment(time: Any) -> Any:
    """Return one time as an array of one time."""
    return time.reshape(1) if hasattr(time, "reshape") else as_quantity([time], "time", "time")


def _axis(run: Record, argument: Any, edges: Any, text: str, dimension: str) -> tuple[Floats, str]:
    """Return the edges of bins in the unit of the argument that gave them, and the label of their axis."""
    argument = as_quantity(argument, text, dimension)
    if is_quantity(argument):
        return np.asarray(argument.value), f"{text} [{unit_of(argument)}]"
    return without_unit(edges), label(run, text, dimension)
