"""Positions and attitudes of a run at any time in it, for pictures, and whether these show the true motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base import rotations
from ..base.units import need
from ..errors import InvalidInput, caution
from ..particles.rules import FATES
from ..record.record import Record
from ..typing import Floats
from ._style import near_and_far

if TYPE_CHECKING:
    from ..particles.flight import Flight

#: The number of points below which the corners of a path would be visible.
_SMOOTH = 1000
#: The largest number of times for each sample of a flight.
_PARTS = 12
#: The fraction of a revolution between points of a curve of an angle, and the largest number of points.
_TURN_FRACTION, _MAX_POINTS = 1.0 / 48.0, 400_000
#: The largest difference in radians of a rotation between samples from that of the mean spin, and the largest angle of
#: the rotation, with which attitudes are interpolated by the spins.
_AGREED, _FOLLOWED = 0.5, 2.8


def time_in_run(run: Record, time: Any) -> float:
    """Return a time of the run in the system's units; the run's end for ``None``."""
    samples = run.arrays["time"]
    if time is None:
        return float(samples[-1])
    number = run.context.units.number(time, "time", "time")
    span = (samples.min(), samples.max(), *(() if run.dense is None else run.dense.core.range))
    if not min(span) <= number <= max(span):
        raise InvalidInput(f"time is {time}; expected one within the run, from {min(span):.8g} to {max(span):.8g}")
    return number


def dense_times(run: Record, end: float, count: int = _SMOOTH) -> Floats:
    """Return the samples' times up to ``end`` and ``end`` itself; if they are few, ``count`` times in all."""
    samples = run.arrays["time"]
    passed = samples <= end if samples[-1] >= samples[0] else samples >= end
    stops = np.append(samples[passed], [end] if end not in samples else [])
    parts = max(1, (count - 1) // max(1, len(stops) - 1))
    positions = np.linspace(0, len(stops) - 1, (len(stops) - 1) * parts + 1)
    return np.asarray(np.interp(positions, np.arange(len(stops)), stops))


def poses(run: Record, times: Floats) -> tuple[Floats, Floats]:
    """Return centres (T, N, 3) from the barycentre and attitudes (T, N, 4) at times (T,) within the run.

    They are taken from the continuous solution if the run has one (``dense=True``). Otherwise centres between samples
    are cubics that fit positions and velocities, and attitudes follow rotation vectors that fit attitudes and spins, or
    the shorter turn where a spin is for more than half a turn between samples.
    """
    record = run.arrays
    if run.dense is not None and run.dense.covers(times).all():
        states = run.dense.core.states(times)
        return _from_barycentre(run, states["position"]), np.asarray(states["attitude"])
    samples, order = np.unique(record["time"], return_index=True)
    index = np.minimum(np.searchsorted(samples, times), len(samples) - 1)
    centres, attitude = _from_barycentre(run, record["position"][order]), record["attitude"][order]
    if np.array_equal(samples[index], times):
        return centres[index], attitude[index]
    with need("plot", "a picture between two samples"):
        curve = _interpolated(samples, centres, _from_barycentre(run, record["velocity"][order]), times)
    return curve, _rotated_between(samples, attitude, record["spin"][order], times)


class Trails(NamedTuple):
    """Particles of a flight at times (T,) within a run, for pictures.

    Positions (P, T, 3) are from the barycentre, and NaN if a particle is gone; ``landed`` (P,) has the times at which
    particles came to lie on a body, NaN for others; ``parts`` is the number of times for each sample of the flight.
    """

    time: Floats
    position: Floats
    landed: Floats
    parts: int


def trails(run: Record, flight: Flight, particles: int, most_points: int) -> Trails:
    """Return the particles of a flight at its samples within a run, and, unless these are many, at times between them.

    If there are many particles and samples, an even selection is taken, with at most ``particles`` particles and
    ``most_points`` positions in all. Positions between samples lie on cubics that fit positions and velocities, except
    where a particle lands.
    """
    if flight.context.describe() != run.context.describe():
        raise InvalidInput("flight is one among other bodies than the run's; expected one of the same system")
    samples, span = flight.arrays["time"], (run.arrays["time"].min(), run.arrays["time"].max())
    inside = np.flatnonzero((samples >= span[0]) & (samples <= span[1]))
    if len(inside) < 2:
        raise InvalidInput(f"flight has {len(inside)} samples within the run; expected two or more, such as output=0.1")
    chosen = np.unique(np.linspace(0, len(flight) - 1, min(len(flight), particles)).astype(int))
    room = max(2, most_points // len(chosen))
    moments = np.unique(np.linspace(0, len(inside) - 1, room).astype(int))
    stops = samples[inside][moments]
    parts = int(np.clip((room - 1) // (len(stops) - 1), 1, _PARTS)) if len(moments) == len(inside) else 1
    times = np.interp(np.arange(parts * (len(stops) - 1) + 1) / parts, np.arange(len(stops)), stops)
    x, v = (np.array(flight.arrays[name][inside[moments]][:, chosen]) for name in ("position", "velocity"))
    has_landed = np.isin(flight.arrays["fate"][chosen], [FATES.index("impact"), FATES.index("rest")])
    landed = np.where(has_landed, flight.arrays["fate_time"][chosen], np.nan)
    x -= _barycentre(run, stops)[:, None]
    v -= _barycentre(run, stops, "velocity")[:, None]
    # The velocity jumps when a particle lands, so that a straight line is taken there.
    earlier, later = np.minimum(stops[1:], stops[:-1]), np.maximum(stops[1:], stops[:-1])
    linear = (earlier <= landed[:, None]) & (landed[:, None] <= later)
    order = slice(None, None, -1 if stops[-1] < stops[0] else 1)
    paths = _interpolated(stops[order], x[order], v[order], times[order], linear[:, order].T)
    return Trails(times, np.ascontiguousarray(np.moveaxis(paths, 0, 1)[:, order]), landed, parts)


def _interpolated(samples: Floats, centres: Floats, velocities: Floats, times: Floats, linear: Any = False) -> Floats:
    """Interpolate by cubics, or by lines where samples are half a turn apart or more, or as marked (K - 1, N)."""
    from scipy.interpolate import CubicHermiteSpline, interp1d

    chord = np.linalg.norm(np.diff(centres, axis=0), axis=2)
    speed = np.linalg.norm(velocities, axis=2)
    arc = 0.5 * (speed[1:] + speed[:-1]) * np.diff(samples)[:, None]
    interval = np.clip(np.searchsorted(samples, times, side="right") - 1, 0, len(samples) - 2)
    curved = ((arc <= 0.5 * np.pi * chord) & ~np.asarray(linear))[interval][..., None]
    line = np.asarray(interp1d(samples, centres, axis=0)(times))
    # Removed particles have NaN positions, which scipy's cubic does not accept.
    gone = ~(np.isfinite(centres) & np.isfinite(velocities))
    cubic = CubicHermiteSpline(samples, np.where(gone, 0.0, centres), np.where(gone, 0.0, velocities))(times)
    return np.where(curved, cubic, line)


def _rotated_between(samples: Floats, attitude: Floats, spin: Floats, times: Floats) -> Floats:
    """Interpolate attitudes (K, N, 4) by rotation vectors from each sample that are cubics in time.

    The rate of a rotation vector v is w + v x w / 2 + c v x (v x w), with the spin w in the body frame.
    """
    step = np.diff(samples)[:, None, None]
    vector = rotations.between(attitude[:-1], attitude[1:])
    begin, end = spin[:-1] * step, spin[1:] * step
    angle = np.linalg.norm(vector, axis=2, keepdims=True)
    half = np.maximum(0.5 * angle, 1e-4)
    product = np.cross(vector, end)
    c = (1.0 - half / np.tan(half)) / (2.0 * half) ** 2
    rate = end + 0.5 * product + c * np.cross(vector, product)
    # Without this, a body that makes most of a turn between samples would oscillate.
    followed = (np.linalg.norm(0.5 * (begin + rate) - vector, axis=2, keepdims=True) < _AGREED) & (angle < _FOLLOWED)
    begin, rate = np.where(followed, begin, vector), np.where(followed, rate, vector)
    interval = np.clip(np.searchsorted(samples, times, side="right") - 1, 0, len(samples) - 2)
    t = ((times - samples[interval]) / np.diff(samples)[interval])[:, None, None]
    begin, rate, vector = begin[interval], rate[interval], vector[interval]
    rotation = t * begin + t**2 * (3.0 * vector - 2.0 * begin - rate) + t**3 * (begin + rate - 2.0 * vector)
    return np.asarray(rotations.products(attitude[interval], rotations.of_vectors(rotation)))


def _from_barycentre(run: Record, vectors: Floats) -> Floats:
    """Subtract from positions or velocities (T, N, 3) those of the barycentre of the bodies that fit in one picture."""
    return np.asarray(vectors - _mean(run, vectors)[:, None])


def _mean(run: Record, vectors: Floats) -> Floats:
    """Return the mean position or velocity (T, 3) of that barycentre."""
    weights = np.zeros(len(run.context))
    near = near_and_far(run)[0]
    weights[near] = run.context.masses[near]
    return np.asarray(np.einsum("n,tnx->tx", weights / weights.sum(), vectors))


def _barycentre(run: Record, times: Floats, quantity: str = "position") -> Floats:
    """Return positions or velocities (T, 3) of that barycentre at any times, by interpolation."""
    if run.dense is not None and run.dense.covers(times).all():
        return _mean(run, run.dense.core.states(times)[quantity])
    samples, order = np.unique(run.arrays["time"], return_index=True)
    means = _mean(run, run.arrays[quantity][order])
    return np.stack([np.interp(times, samples, means[:, c]) for c in range(3)], axis=1)


def dense_attitudes(run: Record) -> tuple[Floats, Floats]:
    """Return times (T,) and attitudes (T, N, 4) for curves of angles, dense enough to resolve every turn of a body.

    Points at nearly equal phases of each turn would look like slow curves. The samples are returned if they are dense
    enough, or more than half a turn apart, which causes a warning.
    """
    samples = run.arrays["time"]
    warn_if_aliased(run, samples, "samples")
    revolutions = _revolutions(run, samples, samples)
    largest = revolutions.max(initial=0.0)
    if largest <= _TURN_FRACTION or (run.dense is None and largest > 0.5):
        return samples, np.asarray(run.arrays["attitude"])
    count = 1 + (len(samples) - 1) * int(np.ceil(largest / _TURN_FRACTION))
    times = dense_times(run, float(samples[-1]), min(_MAX_POINTS, count))
    return times, poses(run, times)[1]


def relative_path(run: Record, body: int, about: int) -> tuple[Floats, bool]:
    """Return positions (T, 3) of a body relative to another, and whether a line shows its path.

    They are dense enough for a smooth line. Without a continuous solution, the samples are returned if a body goes more
    than half way round the other between two of them, as they do not tell its path.
    """
    r, v = (run.arrays[name][:, body] - run.arrays[name][:, about] for name in ("position", "velocity"))
    areas, squares = np.linalg.norm(np.cross(r, v), axis=1), np.maximum(np.sum(r * r, axis=1), np.finfo(float).tiny)
    rate = np.minimum((areas / squares)[1:], (areas / squares)[:-1])
    revolutions = float((rate * np.abs(np.diff(run.arrays["time"]))).max(initial=0.0)) / (2.0 * np.pi)
    if run.dense is None and revolutions > 0.5:
        return r, False
    count = 1 + (len(r) - 1) * int(np.ceil(revolutions / _TURN_FRACTION))
    centres = poses(run, dense_times(run, float(run.arrays["time"][-1]), min(_MAX_POINTS, max(_SMOOTH, count))))[0]
    return centres[:, body] - centres[:, about], True


def _revolutions(run: Record, times: Floats, samples: Floats) -> Floats:
    """Return the revolutions (N, T - 1) of each body between times that increase or decrease."""
    order = np.unique(samples, return_index=True)[1]
    rate = np.linalg.norm(run.arrays["spin"][order], axis=2)
    fastest = [np.interp(times[:-1], samples[order], rate[:, body]) for body in range(len(run.context))]
    return np.asarray(np.array(fastest) * np.abs(np.diff(times)) / (2.0 * np.pi))


def warn_if_aliased(run: Record, times: Floats, kind: str = "pictures") -> None:
    """Warn if a body makes more than half a turn between two pictures, or between samples without a dense solution."""
    samples = run.arrays["time"]
    advice = {"pictures": "show more of them, or a shorter time"} if kind == "pictures" else {}
    if run.dense is None:
        advice["samples"] = "record more of them (output=), or with dense=True"
    # If two samples coincide, either of them is suitable.
    order = np.unique(samples, return_index=True)[1]
    for kind, moments in (("pictures", np.sort(times)), ("samples", samples[order])):
        if kind not in advice or len(moments) < 2:
            continue
        revolutions = _revolutions(run, moments, samples).max(axis=1)
        body = int(np.argmax(revolutions))
        if revolutions[body] > 0.5:
            caution(
                f"{run.context.names[body]} makes up to {revolutions[body]:.2g} turns between two {kind} and will seem "
                f"to rotate otherwise; {advice[kind]}",
                UserWarning,
            )
            return
