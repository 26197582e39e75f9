"""Mutual events: occultations and eclipses of the bodies of a run by each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base.kinds import choice
from ..errors import InvalidInput, interruptible
from ..events import Occultation
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .states import refuse_near
from .vectors import SystemGeometry, Vectors, local_geometry

if TYPE_CHECKING:
    from ..typing import Scalar

__all__ = ["KINDS", "MutualEvent", "mutual_events", "occultation"]

#: Kinds of events, and the sign of the light's way: toward the distant point or from there.
KINDS = {"occultation": 1.0, "eclipse": -1.0}
#: Rows of a table of directions, at least: with fewer the spline of a geometry would be another one.
_ROWS = 64
#: The number of iterations of a light time, each of which gains the digits of c over the bodies' speed.
_ITERATIONS = 4


@dataclass(frozen=True, slots=True)
class MutualEvent:
    """A body that another one hides from the observer, or from the Sun.

    Times are those at which the observer sees it, in the system's clock: numbers, or Quantities since the epoch. The
    outlines of the bodies overlap from ``begin`` to ``end``, as seen from a point (the Sun counts as one); how much of
    the hidden part faces the observer is another question, which a light curve answers.

    Attributes
    ----------
    kind : str
        ``"occultation"`` (by a body between it and the observer) or ``"eclipse"`` (by one between it and the Sun).
    body, by : str
        Names of the hidden body and of the other one.
    begin, end : float, Quantity or None
        ``None`` where the run, or the geometry, begins or ends within the event.
    total_begin, total_end : float, Quantity or None
        First and last time of totality, when the whole outline is hidden; ``None`` if it never is, or where the run
        begins or ends within it.
    """

    kind: str
    body: str
    by: str
    begin: Scalar | None
    end: Scalar | None
    total_begin: Scalar | None = None
    total_end: Scalar | None = None

    @property
    def middle(self) -> Scalar | None:
        """The middle between ``begin`` and ``end``; ``None`` if one of them is ``None``."""
        return None if self.begin is None or self.end is None else 0.5 * (self.begin + self.end)

    @property
    def duration(self) -> Scalar | None:
        """Time from ``begin`` to ``end``; ``None`` where one of them is."""
        return None if self.begin is None or self.end is None else self.end - self.begin


@interruptible("a search for mutual events")
def mutual_events(run: Record, geometry: Vectors) -> list[MutualEvent]:
    """All occultations and eclipses among the bodies of a run, in the order of time.

    Contacts are located on the continuous solution, each to the last digits of its time; between the samples of a step
    extrema are sought, so that events that only graze are found too. Each body is taken at the time when its light left
    it, and seen within its cone from the observer, or from the Sun, at any distance. Shadows take account of the time
    that light takes from body to body.

    Parameters
    ----------
    run : Run
        A run with ``dense=True``.
    geometry : Geometry
        Events are those in the time that both the run and the geometry cover. Without the Sun there are occultations
        alone.

    Returns
    -------
    list of MutualEvent

    Raises
    ------
    InvalidInput
        For a run without its continuous solution, one that the geometry does not cover at any time, and an observer or
        a Sun that is as near to the barycentre as the bodies reach.

    Notes
    -----
    The outline of an ellipsoid is an ellipse; that of a composite is the union of its parts' outlines, but it is only
    within one of them that something counts as totally hidden; that of a polyhedron is the convex hull of its vertices.

    Examples
    --------
    >>> import astropy.units as u, fullbody
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> run = system.integrate(state, "1 day", dense=True)
    >>> view = {"to_observer": [0.1, 0.01, 0.0] * u.au, "to_sun": [0.9, 0.4, 0.0] * u.au}
    >>> events = observing.mutual_events(run, observing.Geometry([-1.0, 2.0] * u.day, **view))
    >>> sorted({(event.kind, event.body) for event in events})[:2]
    [('eclipse', 'Didymos'), ('eclipse', 'Dimorphos')]
    """
    if run.dense is None:
        raise InvalidInput("this run keeps no continuous solution; integrate with dense=True")
    system = run.system
    local = local_geometry(geometry, system)
    start, stop = run.dense.core.range
    first, last = sorted((start, stop))
    begin, end = local.ends()
    span = [max(first, float(local.emission(begin))), min(last, float(local.emission(end)))]
    if not span[0] < span[1]:
        attach = system.context.units.attach
        raise InvalidInput(
            f"the run, from {attach(first, 'time')} to {attach(last, 'time')}, and the geometry, from "
            f"{attach(begin, 'time')} to {attach(end, 'time')} at the observer, have no time in common"
        )
    kinds = [kind for kind in KINDS if kind == "occultation" or geometry.has_sun]
    pairs = [(i, j) for i in range(len(system.context)) for j in range(len(system.context)) if i != j]
    asked = [(kind, i, j, total) for kind in kinds for i, j in pairs for total in (False, True)]
    towards = {}
    weights = system.context.masses / system.context.masses.sum()
    for kind in kinds:
        knots, toward = _table(local, kind, span)
        states = run.dense.core.states(np.clip(np.array(knots), span[0], span[1]))
        centre = states["position"] - np.einsum("n,tnx->tx", weights, states["position"])[:, None]
        what = "observer" if kind == "occultation" else "Sun"
        refuse_near(system, local, what, np.array(toward), centre, states["attitude"], np.array(knots), 1.0, 1.0)
        towards[kind] = _core.Toward(knots, toward, KINDS[kind] / local.light_speed, local.distant, False)
    conditions = [_core.Condition.Occultation(i, j, total, towards[kind]) for kind, i, j, total in asked]
    crossings = run.dense.core.crossings(system.context.core, conditions, span)
    intervals = {key: _intervals(*found, span, start < stop) for key, found in zip(asked, crossings, strict=True)}
    found = []
    for kind, i, j in ((kind, i, j) for kind in kinds for i, j in pairs):
        totals = intervals[kind, i, j, True]
        for interval in intervals[kind, i, j, False]:
            within = [ends for ends in totals if interval[0] <= ends[0] and ends[1] <= interval[1]]
            found.append(([*interval, *((within[0][0], within[-1][1]) if within else (np.nan, np.nan))], kind, i, j))
    found.sort(key=lambda one: one[0][:2])
    times = np.array([one[0] for one in found]).reshape(-1, 4)
    hidden = np.array([i for _, _, i, _ in found], dtype=np.intp)
    eclipsed = np.array([kind == "eclipse" for _, kind, _, _ in found], dtype=bool)
    known = ~(np.isnan(times) | np.isin(times, span))
    which = np.nonzero(known)[0]
    times[known] = _arrivals(run, local, times[known], hidden[which], eclipsed[which])

    def attached(time: float, is_known: bool) -> Any:
        return system.context.units.attach(float(time), "time") if is_known else None

    return [
        MutualEvent(kind, system.context.names[i], system.context.names[j], *map(attached, row, mask))
        for (_, kind, i, j), row, mask in zip(found, times, known, strict=True)
    ]


def _arrivals(
    run: Record, local: SystemGeometry, times: Floats, hidden: npt.NDArray[np.intp], eclipsed: npt.NDArray[np.bool_]
) -> Floats:
    """Return when the observer sees contacts that conditions have at times (T,), with the indices of hidden bodies."""
    found = local.arrival(times)
    if np.isinf(local.light_speed) or not eclipsed.any():
        return found
    assert run.dense is not None
    # Sunlight that passes the barycentre at that time reaches the body earlier or later, and leaves it then.
    passing = left = times[eclipsed]
    sun = local.sun(found[eclipsed])
    weights = run.context.masses / run.context.masses.sum()
    for _ in range(_ITERATIONS):
        position = run.dense.core.states(np.clip(left, min(run.dense.core.range), max(run.dense.core.range)))[
            "position"
        ]
        place = position[np.arange(len(position)), hidden[eclipsed]] - np.einsum("n,tnx->tx", weights, position)
        way = np.linalg.norm(sun - place, axis=1) - np.linalg.norm(sun, axis=1)
        left = passing + way / local.light_speed
    found[eclipsed] = local.arrival(left, place)
    return found


def _intervals(at_start: float, zeros: list[float], span: list[float], forward: bool) -> list[tuple[float, float]]:
    """Return the spans in which a function is negative, from a value before its first zero along the run."""
    below = at_start < 0.0
    if not forward:
        below ^= len(zeros) % 2 == 1
        zeros = zeros[::-1]
    edges = [-np.inf, *zeros] if below else [*zeros]
    edges += [np.inf] if len(edges) % 2 else []
    pairs = zip(edges[::2], edges[1::2], strict=True)
    # Round-off may find a zero twice; nothing lasts no time.
    clipped = ((max(a, span[0]), min(b, span[1])) for a, b in pairs)
    return [(a, b) for a, b in clipped if a < b]


def _table(local: SystemGeometry, kind: str, span: list[float]) -> tuple[list[float], list[list[float]]]:
    """Times of emission in a span and the vectors to the observer, or to the Sun, of the light that leaves then."""
    ends = [float(local.arrival(time)) for time in span]
    rows = local.rows()
    inside = rows[(rows > ends[0]) & (rows < ends[1])]
    # Between the rows of the geometry its own spline is a cubic: a few points on each piece give it back.
    knots = np.unique(np.concatenate([[ends[0]], inside, [ends[1]]]))
    parts = max(3, -(-_ROWS // len(knots)))
    places = np.linspace(0, len(knots) - 1, (len(knots) - 1) * parts + 1)
    arrivals = np.interp(places, np.arange(len(knots)), knots)
    vectors = local.observer(arrivals) if kind == "occultation" else local.sun(arrivals)
    return local.emission(arrivals).tolist(), vectors.tolist()


def occultation(
    system: SystemLike,
    geometry: Vectors,
    body: int | str,
    by: int | str,
    *,
    kind: str = "occultation",
    total: bool = False,
    direction: int = 0,
    terminal: bool = False,
) -> Occultation:
    """An event of :mod:`fullbody.events` for a run to watch for, or to end with: a mutual event in a geometry.

    Parameters
    ----------
    system : System
        The system that gives the event its times, units and axes.
    geometry : Geometry
        The geometry, which has to cover the run.
    body, by : int or str
        The hidden body and the one that hides it, by their indices in the system or their names.
    kind : {"occultation", "eclipse"}
    total : bool
        Whether the whole outline of the body is hidden.
    direction : {-1, 0, 1}
        -1: it begins; 1: it ends; 0: both.
    terminal : bool

    Returns
    -------
    fullbody.events.Occultation
        Its times are those at which the observed light left the barycentre, or sunlight passed it. Bodies are seen, at
        their own times and within cones, as by :func:`mutual_events`. A run in which one of the two bodies reaches as
        far toward the observer, or the Sun, as these are from the barycentre ends in ``InvalidInput``.

    Examples
    --------
    >>> import astropy.units as u, fullbody
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> view = observing.Geometry([-1.0, 2.0] * u.day, to_observer=[0.1, 0.01, 0.0] * u.au)
    >>> first = observing.occultation(system, view, "Dimorphos", "Didymos", direction=-1, terminal=True)
    >>> system.integrate(state, "1 day", events=[first]).stop_reason
    'event'
    """
    choice(kind, "kind", KINDS)
    local = local_geometry(geometry, system)
    span = [float(local.emission(end)) for end in local.ends()]
    times, toward = _table(local, kind, span)
    when = system.context.units.attach(np.array(times), "time")
    places = system.context.index(body, "body"), system.context.index(by, "by")
    slowness = KINDS[kind] / local.light_speed
    options: dict[str, Any] = {"direction": direction, "terminal": terminal}
    return Occultation(*places, toward, when, total, local.distant, slowness, **options)
