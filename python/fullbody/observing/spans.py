"""Spans of time in which a function of time is negative."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..base.units import need
from ..typing import Floats

#: The number of times in a search for an extremum between nodes, and the largest number of searches.
_TRIALS, _SEARCHES = 9, 60
#: The smallest relative width of the bracket of a root that scipy accepts.
_RELATIVE = 4.0 * float(np.finfo(float).eps)

Span = tuple[float, float]


def spans_below_zero(measure: Callable[[Floats], Floats], nodes: Floats) -> list[Span]:
    """Return the spans of time in which a measure is negative, to the last digits.

    Extrema between the nodes (T,) are searched, so that a graze is found. Spans end at the first and the last node.
    """
    with need("observing", "a search for chords"):
        from scipy.optimize import brentq

    values = measure(nodes)
    times, measures = [nodes], [values]
    middle = values[1:-1]
    sign = np.where(middle > 0.0, 1.0, -1.0)
    # A least value above zero may dip below it, and a greatest below zero may rise above it.
    is_extremum = (sign * middle <= sign * values[:-2]) & (sign * middle <= sign * values[2:])
    for k in np.flatnonzero(is_extremum) + 1:
        if (values[k - 1 : k + 2] > 0.0).all() or (values[k - 1 : k + 2] < 0.0).all():
            side = sign[k - 1]

            def towards_zero(moments: Floats, side: float = side) -> Floats:
                return side * measure(moments)

            time, value = minimum(towards_zero, nodes[k - 1], nodes[k + 1], _TRIALS, _SEARCHES, stop=0.0)
            times.append(np.array([time]))
            measures.append(np.array([side * value]))
    all_times, all_values = np.concatenate(times), np.concatenate(measures)
    order = np.argsort(all_times, kind="stable")
    all_times, below = all_times[order], all_values[order] < 0.0
    edges = [float(all_times[0])] if below[0] else []
    for k in np.flatnonzero(below[1:] != below[:-1]):
        a, b = float(all_times[k]), float(all_times[k + 1])
        edges.append(brentq(lambda t: float(measure(np.array([t]))[0]), a, b, xtol=1e-300, rtol=_RELATIVE))
    if below[-1]:
        edges.append(float(all_times[-1]))
    return [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if a < b]


def minimum(
    function: Callable[[Floats], Floats], first: float, last: float, trials: int, searches: int, stop: float = -np.inf
) -> tuple[float, float]:
    """Return the time between two at which a function of times is least, and the function there.

    Each search takes a number of ``trials`` and narrows the time down to the two intervals about the least of them. The
    last one has a value that is not above ``stop``, or intervals of a few units in the last place.
    """
    for _ in range(searches):
        times = np.linspace(first, last, trials)
        values = function(times)
        k = int(np.argmin(values))
        first, last = times[max(k - 1, 0)], times[min(k + 1, trials - 1)]
        if values[k] <= stop or last - first <= 8.0 * np.spacing(abs(times[k])):
            break
    return float(times[k]), float(values[k])


def union(spans: Sequence[Span]) -> list[Span]:
    """Return spans of time without overlaps, in order."""
    joined: list[Span] = []
    for a, b in sorted(spans):
        if joined and a <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(b, joined[-1][1]))
        else:
            joined.append((a, b))
    return joined
