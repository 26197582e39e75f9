"""A run at any time in it, for pictures: where the bodies are and how they are turned."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.units import need, scalar
from ..errors import InvalidInput
from ._style import Array, split_far

if TYPE_CHECKING:
    from ..particles.flight import Flight
    from ..record.base import BaseRun

__all__ = ["at", "moment", "track", "trails"]

#: A path of fewer points shows its corners.
_SMOOTH = 1000


def moment(run: BaseRun, time: Any) -> float:
    """A time of the run in the system's units; its end for ``None``."""
    known = run._record["time"]
    if time is None:
        return float(known[-1])
    wanted = scalar(run.system._units.strip(time, "time", "time"), "time")
    span = (known.min(), known.max(), *(() if run.dense is None else run.dense._core.range))
    if not min(span) <= wanted <= max(span):
        raise InvalidInput(f"time is {time}; expected one within the run, from {min(span):.8g} to {max(span):.8g}")
    return wanted


def track(run: BaseRun, end: float, count: int = _SMOOTH) -> Array:
    """Times of the samples up to ``end`` and of it; where they are few, others between them, ``count`` in all."""
    known = run._record["time"]
    passed = known <= end if known[-1] >= known[0] else known >= end
    stops = np.append(known[passed], [end] if end not in known else [])
    parts = max(1, (count - 1) // max(1, len(stops) - 1))
    places = np.linspace(0, len(stops) - 1, (len(stops) - 1) * parts + 1)
    return np.asarray(np.interp(places, np.arange(len(stops)), stops))


def at(run: BaseRun, times: Array) -> tuple[Array, Array]:
    """Centres (T, N, 3) from the barycentre and attitudes (T, N, 4) at times (T,) within the run.

    From the continuous solution where the run keeps one (``dense=True``); otherwise from the samples and, between them,
    centres by cubics that fit positions and velocities, attitudes by the shorter turn.
    """
    record = run._record
    if run.dense is not None and _inside(times, run.dense._core.range):
        states = run.dense._core.states(times)
        return _from_barycentre(run, states["position"]), np.asarray(states["attitude"])
    known, order = np.unique(record["time"], return_index=True)
    place = np.minimum(np.searchsorted(known, times), len(known) - 1)
    centres, attitude = _from_barycentre(run, record["position"][order]), record["attitude"][order]
    if np.array_equal(known[place], times):
        return centres[place], attitude[place]
    with need("plot", "a picture between two samples"):
        from scipy.spatial.transform import Rotation, Slerp

    turned = np.empty((len(times), len(run.system), 4))
    for body in range(len(run.system)):
        turns = Rotation.from_quat(attitude[:, body], scalar_first=True)
        turned[:, body] = Slerp(known, turns)(times).as_quat(scalar_first=True)
    return _curve(known, centres, _from_barycentre(run, record["velocity"][order]), times), turned


def trails(run: BaseRun, flight: Flight, particles: int, places: int) -> tuple[Array, Array]:
    """Times (T,) of a flight's samples within a run and places (P, T, 3) of its particles from the barycentre.

    Of many particles and samples some are taken, evenly: at most so many particles, and places in all.
    """
    if flight.system != run.system:
        raise InvalidInput("flight is one among other bodies than the run's; expected one of the same system")
    known, span = flight._record["time"], (run._record["time"].min(), run._record["time"].max())
    inside = np.flatnonzero((known >= span[0]) & (known <= span[1]))
    if len(inside) < 2:
        raise InvalidInput(f"flight has {len(inside)} samples within the run; expected two or more, such as output=0.1")
    taken = np.unique(np.linspace(0, len(flight) - 1, min(len(flight), particles)).astype(int))
    moments = np.unique(np.linspace(0, len(inside) - 1, max(2, places // len(taken))).astype(int))
    times = known[inside][moments]
    samples = flight._record["samples"][taken][:, inside[moments], :3]
    return times, samples - _barycentre(run, times)


def _curve(known: Array, centres: Array, velocities: Array, times: Array) -> Array:
    """Cubics; straight lines where samples are more than half a turn apart, which a cubic would miss by far."""
    from scipy.interpolate import CubicHermiteSpline, interp1d

    chord = np.linalg.norm(np.diff(centres, axis=0), axis=2)
    speed = np.linalg.norm(velocities, axis=2)
    arc = 0.5 * (speed[1:] + speed[:-1]) * np.diff(known)[:, None]
    interval = np.clip(np.searchsorted(known, times, side="right") - 1, 0, len(known) - 2)
    bent = (arc <= 0.5 * np.pi * chord)[interval][..., None]
    straight = interp1d(known, centres, axis=0)(times)
    return np.asarray(np.where(bent, CubicHermiteSpline(known, centres, velocities)(times), straight))


def _from_barycentre(run: BaseRun, vectors: Array) -> Array:
    """Positions or velocities (T, N, 3) less those of the barycentre of the bodies that fit in one picture."""
    return np.asarray(vectors - _mean(run, vectors)[:, None])


def _mean(run: BaseRun, vectors: Array) -> Array:
    """Positions or velocities (T, 3) of that barycentre."""
    weights = np.zeros(len(run.system))
    near = split_far(run)[0]
    weights[near] = run.system._masses[near]
    return np.asarray(np.einsum("n,tnx->tx", weights / weights.sum(), vectors))


def _barycentre(run: BaseRun, times: Array) -> Array:
    """Places (T, 3) of that barycentre, which moves uniformly but for weak forces from outside."""
    if run.dense is not None and _inside(times, run.dense._core.range):
        return _mean(run, run.dense._core.states(times)["position"])
    known, order = np.unique(run._record["time"], return_index=True)
    means = _mean(run, run._record["position"][order])
    return np.stack([np.interp(times, known, means[:, c]) for c in range(3)], axis=1)


def _inside(times: Array, span: tuple[float, float]) -> bool:
    return bool(np.all((times >= min(span)) & (times <= max(span))))
