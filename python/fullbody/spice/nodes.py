"""Conversion of a run to the nodes of Hermite interpolation of kernels, and the interpolation error."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..base import rotations
from ..errors import InvalidInput, PrecisionWarning, caution
from ..record.record import Record
from ..typing import Floats
from .conventions import Conventions

#: A function from samples of a run to values (K, N, C) in SPICE's units and their rates per second.
Curve = Callable[[dict[str, Floats]], tuple[Floats, Floats]]

#: The number of nodes that a polynomial fits with value and rate: its degree is 11, which all versions of readers take.
_WINDOW = 6
#: The number of times that the nodes may be doubled, from two steps of the run per node.
_DOUBLINGS = 8
_CHUNK = 4096


class Nodes(NamedTuple):
    """Nodes: times in seconds past J2000 (K,), values and rates (K, N, C), and the polynomials' degree."""

    et: Floats
    values: Floats
    rates: Floats
    degree: int


def centres(conventions: Conventions, masses: Floats) -> Curve:
    """Return the function to positions in km from the barycentre, in the axes of J2000."""
    weights = masses / masses.sum()

    def about(vectors: Floats) -> Floats:
        relative = vectors - np.einsum("n,knc->kc", weights, vectors)[:, None]
        return np.asarray(relative @ conventions.axes.T * conventions.km)

    return lambda samples: (about(samples["position"]), about(samples["velocity"]) / conventions.second)


def attitudes(conventions: Conventions) -> Curve:
    """Return the function to quaternions from the axes of J2000 to those of the bodies, without jumps of the sign."""
    axes = rotations.quaternion(conventions.axes)

    def curve(samples: dict[str, Floats]) -> tuple[Floats, Floats]:
        q = rotations.products(axes, samples["attitude"])
        return rotations.inverse(q), rotations.inverse(rotations.rates(q, samples["spin"] / conventions.second))

    return curve


def nodes(
    run: Record, conventions: Conventions, curve: Curve, tolerance: float, error_text: Callable[[float], str]
) -> Nodes:
    """Choose nodes so close that the interpolation is within the tolerance of the continuous solution, or warn.

    For a run without a continuous solution the nodes are the samples, and the error is that at every second sample.
    """
    if run.dense is None:
        et, values, rates = _of_samples(run, conventions, curve)
        result = Nodes(et, values, rates, _degree(len(et)))
        # Samples beyond the last node are left out.
        odd = len(et) - 1 + len(et) % 2
        error = _error(et[:odd], values[:odd], rates[:odd])
        reason = (
            "the run has no continuous solution, and every second of its samples follows from the others only to "
            f"within {error_text(error)}; integrate with dense=True, or with output= at a shorter spacing"
        )
    else:
        low, high = sorted(run.dense.core.range)
        first, last = conventions.et(low), conventions.et(high)
        # Seconds past J2000 are rounded, so the nodes are kept within the run.
        while conventions.time(first) < low:
            first = np.nextafter(first, np.inf)
        while conventions.time(last) > high:
            last = np.nextafter(last, -np.inf)
        if not first < last:
            raise InvalidInput(f"the run covers {last - first:.1g} s; a kernel needs a stretch of time")
        intervals = max(_WINDOW, run.statistics.steps // 2)
        for _ in range(_DOUBLINGS):
            et = np.linspace(first, last, 2 * intervals + 1)
            times = conventions.time(et)
            values, rates = curve(run.dense.core.states(times))
            error = _error(et, values, rates)
            # The remaining error is the rounding of the times.
            floor = 2.0 * np.spacing(np.abs(times).max()) * conventions.second * np.abs(rates).max()
            tolerance = max(tolerance, floor)
            # The error may be larger elsewhere between the nodes.
            if error <= max(0.1 * tolerance, floor):
                break
            intervals *= 2
        result = Nodes(et[::2].copy(), values[::2], rates[::2], _degree(intervals + 1))
        reason = f"the kernel is off by {error_text(error)} between its nodes; the run's solution is too rough for less"
    if error > tolerance:
        caution(reason, PrecisionWarning)
    return result


def _degree(count: int) -> int:
    return 2 * min(_WINDOW, count // 2 * 2) - 1


def _of_samples(run: Record, conventions: Conventions, curve: Curve) -> tuple[Floats, Floats, Floats]:
    """Return times, values and rates of the samples, forward in time."""
    record = run.arrays
    order = slice(None, None, -1 if len(run) > 1 and record["time"][-1] < record["time"][0] else 1)
    samples = {name: record[name][order] for name in ("time", "position", "velocity", "attitude", "spin")}
    et = conventions.et(samples["time"])
    if len(et) < 3 or np.diff(et).min() <= 0.0:
        raise InvalidInput(
            f"the run has {len(et)} samples; a kernel needs three or more, at least 2e-7 s apart, or dense=True"
        )
    values, rates = curve(samples)
    # Seconds past J2000 are rounded to 1e-7 s, in which a fast spin turns by more than the tolerance.
    late = ((et - conventions.epoch) - samples["time"] * conventions.second)[:, None, None]
    return et, values + rates * late, rates + np.gradient(rates, et, axis=0) * late


def _error(et: Floats, values: Floats, rates: Floats) -> float:
    """Return the largest distance of every second value from the interpolation between the others."""
    distance = 0.0
    for start in range(1, len(et), 2 * _CHUNK):
        odd = slice(start, start + 2 * _CHUNK, 2)
        off = _hermite(et[::2], values[::2], rates[::2], et[odd]) - values[odd]
        distance = max(distance, float(np.linalg.norm(off, axis=-1).max()))
    return distance


def _hermite(et: Floats, values: Floats, rates: Floats, at: Floats) -> Any:
    """Evaluate at given times the polynomials through the nodes about each time, which are chosen as by SPICE."""
    window = (_degree(len(et)) + 1) // 2 or 1
    first = np.clip(np.searchsorted(et, at) - window // 2, 0, len(et) - window)
    use = first[:, None] + np.arange(window)
    x = at[:, None] - et[use]
    between = et[use][:, :, None] - et[use][:, None, :] + np.eye(window)
    ratio = x[:, None, :] / between
    slope = (1.0 / between).sum(axis=2) - 1.0
    ratio[:, np.arange(window), np.arange(window)] = 1.0
    square = ratio.prod(axis=2) ** 2
    parts = ((1.0 - 2.0 * x * slope) * square, values[use]), (x * square, rates[use])
    return sum(np.einsum("mw,mwnc->mnc", *part) for part in parts)
