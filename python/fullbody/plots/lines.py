"""A quantity against time: a line, the envelope of an oscillation too fast for a line, or an angle."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.figures import RANGE, matplotlib, width
from ..typing import Floats

#: An oscillation that is narrower than this, in points of the page, is drawn as an envelope, and a turn as its
#: departure from a uniform one.
_NARROW = 4.0
#: The number of oscillations over which an envelope is taken.
_OSCILLATIONS = 4
#: The width of an envelope, relative to the range of the curve, from which on it is seen.
_VISIBLE = 0.02
#: The range of values, relative to their size, that is taken for the rounding of a constant.
_ROUNDING = 1e-8
#: The number of points of an envelope for each such interval.
_POINTS = 8
#: A change between samples, in degrees, that is a jump: a full turn, or the half turn of phi and psi at theta = 90.
_JUMP = 170.0
#: The largest part of a turn, in degrees, by which an angle may change between samples and still be followed.
_FOLLOWED = 120.0
#: Spacings of the ticks of angles, in degrees: parts of a turn, and whole turns for hyperbolic anomalies.
_STEPS = (15.0, 30.0, 45.0, 90.0, 180.0, *(360.0 * m * 10.0**k for k in range(12) for m in (1, 2, 3, 5)))


def draw(ax: Any, time: Floats, values: Floats, style: dict[str, Any], scale: float = 0.0) -> Any:
    """Draw a quantity (K,) against time as a line, or as an envelope if it oscillates too fast to be seen as one.

    An envelope is a band from the smallest to the largest value, and a line through the mean, of the samples within a
    few oscillations. The legend names the band once. Oscillations that are small beside the whole range of the values,
    or beside ``scale``, are drawn as a line all the same.
    """
    size = _interval(ax, values)
    # The rounding of a constant is no oscillation.
    if size and np.ptp(values) > _ROUNDING * np.abs(values).max():
        from scipy.ndimage import maximum_filter1d, minimum_filter1d

        index = np.unique(np.append(np.arange(0, len(values), max(1, size // _POINTS)), len(values) - 1))
        low, high = (extreme(values, size, mode="nearest")[index] for extreme in (minimum_filter1d, maximum_filter1d))
        mean = _mean(_mean(values, size), size)
        # A slow change of the mean is no oscillation.
        oscillation = high - low - size * np.abs(np.gradient(mean))[index]
        if np.median(oscillation) > _VISIBLE * max(np.ptp(values), scale):
            line = ax.plot(time[index], mean[index], **style)[0]
            named = RANGE in ax.get_legend_handles_labels()[1]
            band = {"color": line.get_color(), "alpha": 0.3, "linewidth": 0.0, "zorder": line.get_zorder() - 0.5}
            ax.fill_between(time[index], low, high, label=None if named else RANGE, **band)
            return line
    return ax.plot(time, values, **style)[0]


def _interval(ax: Any, values: Floats) -> int:
    """Return the number of samples over which an envelope is taken, or zero for a quantity that a line shows."""
    slopes = np.sign(np.diff(values))
    slopes = slopes[slopes != 0.0]
    oscillations = np.count_nonzero(slopes[1:] != slopes[:-1]) / 2.0
    if oscillations <= width(ax) / _NARROW:
        return 0
    return int(max(_OSCILLATIONS * len(values) / oscillations, len(values) / width(ax)))


def _mean(values: Floats, size: int) -> Floats:
    """Return the means of the values (K,) within ``size`` samples about each, of fewer at the ends."""
    centre = values.mean()
    sums = np.concatenate([[0.0], np.cumsum(values - centre)])
    index = np.arange(len(values))
    begin, end = np.maximum(index - size // 2, 0), np.minimum(index + size // 2 + 1, len(values))
    return np.asarray(centre + (sums[end] - sums[begin]) / (end - begin))


def draw_angle(ax: Any, time: Floats, degrees: Floats, style: dict[str, Any], name: str, unit: str) -> str:
    """Draw an angle (K,) in degrees, without strokes across jumps of a full turn.

    An angle that stays within half a turn is drawn without jumps, also outside 0 to 360 degrees. One that turns too
    often for the width of the axes is drawn as its departure from the uniform turn between its first and its last
    sample, whose rate nu the legend gives in degrees by the unit of the time axis. If its samples are too far apart for
    that, they are drawn as dots. The name for the vertical axis is returned, which tells whether the angle or its
    departure is drawn.
    """
    jumps = np.flatnonzero(np.abs(np.diff(degrees)) > _JUMP) + 1
    # An angle of several turns, such as a hyperbola's anomaly, has no jumps.
    jumps = jumps[:0] if np.ptp(degrees) > 360.0 else jumps
    unwrapped = np.unwrap(degrees, period=360.0)
    followed = np.median(np.abs(np.diff(unwrapped))) <= _FOLLOWED if len(unwrapped) > 1 else False
    if len(jumps) and followed and np.ptp(unwrapped) < 180.0:
        draw(ax, time, unwrapped, style)
        return name
    if len(jumps) <= width(ax) / (2.0 * _NARROW):
        if len(jumps):
            ax.plot(np.insert(time, jumps, np.nan), np.insert(degrees, jumps, np.nan), **style)
        else:
            draw(ax, time, degrees, style)
        return name
    rate = (unwrapped[-1] - unwrapped[0]) / (time[-1] - time[0])
    departure = unwrapped - unwrapped[0] - rate * (time - time[0])
    if not followed or np.ptp(departure) > 360.0:
        dots = {"marker": ".", "markersize": 2.5, "markeredgewidth": 0.0}
        ax.plot(time, degrees, **{**dots, **style, "linestyle": "none"})
        return name
    number = f"{rate:.4g}".replace("-", "\N{MINUS SIGN}")
    rate_text = rf"$\nu$ = {number}°" + (f"/{unit}" if unit else "")
    name_of_line = f"{style['label']}, " if "label" in style else ""
    draw(ax, time, departure, {**style, "label": name_of_line + rate_text})
    return rf"{name} $-\,\nu t$"


def degrees(ax: Any) -> None:
    """Set ticks of a y-axis of angles: parts of a turn, tens of degrees or whole turns."""
    ticker = matplotlib("ticker")

    class Locator(ticker.MaxNLocator):  # type: ignore[misc, name-defined]
        def tick_values(self, low: float, high: float) -> Any:
            for step in _STEPS:
                if 2.5 * step < high - low <= 5.0 * step:
                    return step * np.arange(np.floor(low / step), np.ceil(high / step) + 1)
            return super().tick_values(low, high)

    ax.yaxis.set_major_locator(Locator(5, steps=[1, 2, 2.5, 5, 10]))


def steady(ax: Any, scale: float = 0.0) -> None:
    """Show curves as constant that stay within 1e-8 of their size, or of ``scale`` if that is larger."""
    low, high = ax.dataLim.intervaly
    size = max(abs(low), abs(high), scale)
    # Curves of zeros get limits from matplotlib.
    if size > 0.0 and high - low < 1e-8 * size:
        margin = 0.02 * size if size > scale else 20.0 * size
        # Curves drawn later may still change the limits.
        ax.set_ylim(low - margin, high + margin, auto=True)
