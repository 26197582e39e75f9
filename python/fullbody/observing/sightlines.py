"""Lines of sight from stations to a star, past the bodies of a run as the stations see them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.units import UNITLESS
from ..errors import InvalidInput
from ..record.record import Record
from ..typing import Floats
from .contacts import into_body
from .spans import Span, union
from .star import Star
from .states import refuse_near
from .stations import Stations
from .vectors import Vectors, local_geometry

#: The number of samples of a speed, and the factor by which it may be higher between them.
_SAMPLES, _FASTER = 512, 1.5
#: The share of a radius that the line of sight may move at least in a step of the search for it.
_SHARE = 0.25
#: The number of iterations of the light time, each of which gains the digits of c over the bodies' speed.
_ITERATIONS = 4


class Sight(NamedTuple):
    """M lines of sight past a body, in the system's units and axes.

    Attributes
    ----------
    w : ndarray, (M, 3)
        The position of the ray from the centre of the body, across the direction to the star.
    u : ndarray, (M, 3)
        Unit vectors to the star.
    attitude : ndarray, (M, 4)
        The attitude of the body when the light passes it.
    is_ahead : ndarray of bool, (M,)
        Whether the body is on the star's side of the station.
    """

    w: Floats
    u: Floats
    attitude: Floats
    is_ahead: Any

    def in_body(self) -> tuple[Floats, Floats]:
        """Return the places and the directions of the rays in the body's frame."""
        return into_body(self.attitude, self.w), into_body(self.attitude, self.u)


class SightLines:
    """Lines of sight past the bodies of a run with its continuous solution.

    Parameters
    ----------
    run : Run
        A run with ``dense=True``.
    geometry : Geometry
    star : Star
    stations : Stations or None
        The stations; ``None`` for the observer of the geometry alone.
    """

    def __init__(self, run: Record, geometry: Vectors, star: Star, stations: Stations | None) -> None:
        self.run, self.system, self.star, self.stations = run, run.system, star, stations
        self.solution = run.continuous().core
        self.local, self.delayed = local_geometry(geometry, run.system), geometry.light_time
        self._weights = run.context.masses / run.context.masses.sum()

    def span(self, ends: Any) -> tuple[float, float]:
        """Return the first and the last time at the observer: those given, or all that run and geometry cover.

        The latter is a little shorter, so that all stations see the bodies within the run.
        """
        low, high = sorted(self.solution.range)
        begin, end = self.local.ends()
        first, last = max(begin, float(self.local.arrival(low))), min(end, float(self.local.arrival(high)))
        attach = self.system.context.units.attach
        if not first < last:
            raise InvalidInput(
                f"the run, from {attach(low, 'time')} to {attach(high, 'time')}, and the geometry, from "
                f"{attach(begin, 'time')} to {attach(end, 'time')} at the observer, have no time in common"
            )
        if ends is None:
            return first, last
        start, stop = ends
        if not start < stop:
            raise InvalidInput(
                f"span is {attach(start, 'time')} to {attach(stop, 'time')}; expected the first time first"
            )
        if start < first or stop > last:
            raise InvalidInput(
                f"span is {attach(start, 'time')} to {attach(stop, 'time')}, and the run and the geometry cover the "
                f"times from {attach(first, 'time')} to {attach(last, 'time')} at the observer; expected one within"
            )
        return start, stop

    def refuse_inside(self, times: Floats) -> None:
        """Raise an error for an observer within the system, and for a star on the observer's side of it."""
        observer, u = self.local.observer(times), self.star.directions(self.system, times)
        states = self.states(times)
        centre = states["position"] - self._barycentre(states)[:, None]
        refuse_near(self.system, self.local, "observer", observer, centre, states["attitude"], times, 1.0, 1.0)
        if self.local.distant:
            raise InvalidInput(
                "the geometry has directions without a unit of length; expected vectors to the observer in the unit of "
                "length of the system, or Quantities"
            )
        if (np.sum(observer * u, axis=-1) >= 0.0).all():
            raise InvalidInput(
                "star is on the observer's side of the system at all times, with no body between them; expected the "
                "direction from the observer to the star, past the system"
            )

    def states(self, times: Floats) -> dict[str, Floats]:
        """Return the states at which light leaves the barycentre that arrives at the observer at times (M,)."""
        low, high = sorted(self.solution.range)
        return self.solution.states(np.clip(self.local.emission(times), low, high))

    def _barycentre(self, states: dict[str, Floats]) -> Floats:
        return np.einsum("n,tnx->tx", self._weights, states["position"])

    def at(self, body: int, times: Floats, stations: Any = None) -> Sight:
        """Return the lines of sight past a body at times (M,), from stations with indices (M,) or from the observer."""
        u = self.star.directions(self.system, times)
        observer = self.local.observer(times)
        if stations is not None:
            assert self.stations is not None
            offset = self.stations.at(self.system, stations, times)
            if self.stations.on_earth:
                offset = self.stations.retarded(self.system, times, offset, self.local.observer_velocity(times), u)
            observer = observer + offset
        low, high = sorted(self.solution.range)
        emitted = times - np.linalg.norm(observer, axis=-1) / self.local.light_speed
        for k in range(_ITERATIONS):
            states = self.solution.states(np.ascontiguousarray(np.clip(emitted, low, high)))
            way = observer - states["position"][:, body] + self._barycentre(states)
            if k == _ITERATIONS - 1 or np.isinf(self.local.light_speed):
                break
            emitted = times - np.linalg.norm(way, axis=-1) / self.local.light_speed
        depth = np.sum(way * u, axis=-1)
        return Sight(way - depth[:, None] * u, u, states["attitude"][:, body], depth < 0.0)

    def meetings(self, body: int, span: Span, radius: float) -> list[Span]:
        """Return spans that contain all times at which the observer's line of sight is within a radius of a body."""
        first, last = span
        times = np.linspace(first, last, _SAMPLES)
        step = min(1e-3 * (last - first), 0.5 * (times[1] - times[0]))
        earlier, later = np.clip(times - step, first, last), np.clip(times + step, first, last)
        moved = np.linalg.norm(self.at(body, later).w - self.at(body, earlier).w, axis=1)
        if (speed := float(_FASTER * (moved / (later - earlier)).max())) == 0.0:
            return [span]
        spans: list[Span] = []
        time = first
        while time < last:
            gap = float(self.distances(body, np.array([time]))[0]) - radius
            # An observer who looks away from the body may turn towards it within a share of the span.
            gap = speed * (last - first) / _SAMPLES if np.isinf(gap) else gap
            step = max(gap, _SHARE * radius) / speed
            if gap <= _SHARE * radius:
                spans.append((max(first, time - step), min(last, time + step)))
            time += step
        return union(spans)

    def distances(self, body: int, times: Floats, stations: Any = None) -> Floats:
        """Return the distances (M,) of the lines of sight from a body's centre; infinite if the body is behind."""
        sight = self.at(body, times, stations)
        return np.where(sight.is_ahead, np.linalg.norm(sight.w, axis=-1), np.inf)


def span_of(span: Any, system: Any, clock: Any) -> tuple[float, float] | None:
    """Return a span of two times, which may be dates, on the clock of a system."""
    if span is None:
        return None
    times = np.ravel(clock(span, system, "span"))
    if times.shape != (2,):
        raise InvalidInput(f"span is {span!r}; expected the first and the last time")
    first, last = UNITLESS.numbers(times, "number", "span")
    return float(first), float(last)
