"""Lines of sight from stations to a star, past the bodies of a run as the stations see them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.units import UNITLESS
from ..errors import InvalidInput
from ..record.record import Record
from ..typing import Floats
from .spans import Span, union
from .star import Star
from .states import into_body, refuse_near
from .stations import Stations
from .times import to_system_times
from .vectors import Vectors, local_geometry

#: The number of samples of a speed, and the factor by which it may be higher between them.
_SAMPLES, _FASTER = 512, 1.5
#: The share of a radius that the line of sight may move at least in a step of the search for it.
_SHARE = 0.25
#: The number of iterations of the light time, each of which gains the digits of c over the bodies' speed.
_ITERATIONS = 4


class Sight(NamedTuple):
    """M lines of sight past a body, in the system's units and axes."""

    #: The position (M, 3) of the ray from the centre of the body, perpendicular to the direction to the star.
    w: Floats
    #: Unit vectors (M, 3) to the star.
    u: Floats
    #: The attitude (M, 4) of the body when the light passes it.
    attitude: Floats
    #: Whether the body is on the star's side of the station, (M,).
    is_ahead: Any

    def in_body(self) -> tuple[Floats, Floats]:
        """Return the points and the directions of the rays in the body's frame."""
        return into_body(self.attitude, self.w), into_body(self.attitude, self.u)


class SightLines:
    """Lines of sight past the bodies of a run with its continuous solution.

    They begin at stations, or without these at the observer of the geometry.
    """

    def __init__(self, run: Record, geometry: Vectors, star: Star, stations: Stations | None) -> None:
        self.system, self._star, self._stations = run.system, star, stations
        self._solution = run.continuous().core
        self.local, self.delayed = local_geometry(geometry, run.system), geometry.light_time
        self._weights = run.context.masses / run.context.masses.sum()

    def span(self, ends: Any) -> Span:
        """Return the first and the last time at the observer: those given, or all that run and geometry cover.

        The latter is a little shorter, so that all stations see the bodies within the run. Dates and Quantities are
        converted to numbers on the clock of the system.
        """
        first, last = self.local.common_span(self.system, *sorted(self._solution.range))
        if ends is None:
            return first, last
        times = np.ravel(to_system_times(ends, self.system, "span"))
        if times.shape != (2,):
            raise InvalidInput(f"span is {ends!r}; expected the first and the last time")
        start, stop = UNITLESS.numbers(times, "number", "span").tolist()
        start_text, stop_text, first_text, last_text = (
            str(self.system.context.units.attach(time, "time")) for time in (start, stop, first, last)
        )
        if not start < stop:
            raise InvalidInput(f"span is {start_text} to {stop_text}; expected the first time first")
        if start < first or stop > last:
            raise InvalidInput(
                f"span is {start_text} to {stop_text}, and the run and the geometry cover the times from {first_text} "
                f"to {last_text} at the observer; expected one within"
            )
        return start, stop

    def refuse_inside(self, times: Floats) -> None:
        """Raise an error for an observer within the system, and for a star on the observer's side of it."""
        observer, u = self.local.observer(times), self._star.directions(self.system, times)
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
        return self._states(self.local.emission(times))

    def _states(self, emitted: Floats) -> dict[str, Floats]:
        """Return the states at times (M,), or at the nearest end of the run."""
        return self._solution.states(np.clip(emitted, min(self._solution.range), max(self._solution.range)))

    def _barycentre(self, states: dict[str, Floats]) -> Floats:
        return np.einsum("n,tnx->tx", self._weights, states["position"])

    def past(self, body: int, times: Floats, stations: Any = None) -> Sight:
        """Return the lines of sight past a body at times (M,), from stations with indices (M,) or from the observer."""
        if stations is None:
            observer, u = self.local.observer(times), self._star.directions(self.system, times)
        else:
            assert self._stations is not None
            observer, u = self._stations.positions(self.system, self.local, stations, times)
        emitted = times - np.linalg.norm(observer, axis=-1) / self.local.light_speed
        for _ in range(_ITERATIONS):
            states = self._states(emitted)
            to_observer = observer - states["position"][:, body] + self._barycentre(states)
            emitted = times - np.linalg.norm(to_observer, axis=-1) / self.local.light_speed
        depth = np.sum(to_observer * u, axis=-1)
        return Sight(to_observer - depth[:, None] * u, u, states["attitude"][:, body], depth < 0.0)

    def encounters(self, body: int, span: Span, radius: float) -> list[Span]:
        """Return spans that contain all times at which the observer's line of sight is within a radius of a body."""
        first, last = span
        times = np.linspace(first, last, _SAMPLES)
        step = min(1e-3 * (last - first), 0.5 * (times[1] - times[0]))
        earlier, later = np.clip(times - step, first, last), np.clip(times + step, first, last)
        lengths = np.linalg.norm(self.past(body, later).w - self.past(body, earlier).w, axis=1)
        if (speed := float(_FASTER * (lengths / (later - earlier)).max())) == 0.0:
            return [span]
        spans: list[Span] = []
        time = first
        while time < last:
            gap = float(self.distances(body, np.array([time]))[0]) - radius
            # An observer with the body behind may have it ahead within a share of the span.
            gap = speed * (last - first) / _SAMPLES if np.isinf(gap) else gap
            step = max(gap, _SHARE * radius) / speed
            if gap <= _SHARE * radius:
                spans.append((max(first, time - step), min(last, time + step)))
            time += step
        return union(spans)

    def distances(self, body: int, times: Floats, stations: Any = None) -> Floats:
        """Return the distances (M,) of the lines of sight from a body's centre; infinite if the body is behind."""
        sight = self.past(body, times, stations)
        return np.where(sight.is_ahead, np.linalg.norm(sight.w, axis=-1), np.inf)
