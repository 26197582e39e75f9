"""Mutual events: occultations and eclipses of the bodies of a run by each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base.kinds import choice
from ..base.limits import Limits
from ..base.units import UNITLESS
from ..errors import InvalidInput, interruptible
from ..events import Occultation
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Array, Floats
from .light_curve import light_curve
from .mutual_event import MutualEvent, MutualEvents
from .states import refuse_near
from .vectors import SystemGeometry, Vectors, local_geometry

if TYPE_CHECKING:
    from .laws import Law

#: Kinds of events, and the sign of the light's way: toward the distant point or from there.
KINDS = {"occultation": 1.0, "eclipse": -1.0}
#: Rows of a table of directions, at least: with fewer the spline of a geometry would be another one.
_ROWS = 64
#: The number of points on the limb of the Sun, and that between them at which contacts are interpolated.
_LIMB, _FINE = 16, 64
#: The number of magnitudes in a search for the greatest depth, each of which narrows it down to two intervals, and the
#: number of searches.
_DEPTHS, _SEARCHES = 33, 4
#: The number of iterations of a light time, each of which gains the digits of c over the bodies' speed.
_ITERATIONS = 4


@interruptible("a search for mutual events")
def mutual_events(
    run: Record,
    geometry: Vectors,
    *,
    sun_radius: Any = 0.0,
    law: Law | dict[str, Law] | None = None,
    albedo: float | Array | dict[str, Any] = 1.0,
) -> MutualEvents:
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
    sun_radius : float, Quantity or str
        Angular radius of the Sun's disc, radians: 0.00465 at 1 au. With it eclipses have the contacts of the penumbra
        and of the umbra; zero for a Sun that is a point.
    law : Law or dict, optional
        The scattering law, with which events have their depth in magnitudes; without it they have none.
    albedo : float, array_like or dict
        Option of :func:`brightness` for the depths.

    Returns
    -------
    MutualEvents
        A list of :class:`MutualEvent`, with the method ``to_table``.

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
    radius = UNITLESS.number(sun_radius, "angle", "sun_radius", Limits(least=0.0, below=0.5 * np.pi))
    kinds = [kind for kind in KINDS if kind == "occultation" or geometry.has_sun]
    pairs = [(i, j) for i in range(len(system.context)) for j in range(len(system.context)) if i != j]
    points = {kind: range(_LIMB if radius > 0.0 and kind == "eclipse" else 1) for kind in kinds}
    asked = [
        (kind, i, j, total, q) for kind in kinds for i, j in pairs for total in (False, True) for q in points[kind]
    ]
    towards = {}
    weights = system.context.masses / system.context.masses.sum()
    for kind in kinds:
        knots, toward = _table(local, kind, span)
        states = run.dense.core.states(np.clip(np.array(knots), span[0], span[1]))
        centre = states["position"] - np.einsum("n,tnx->tx", weights, states["position"])[:, None]
        what = "observer" if kind == "occultation" else "Sun"
        refuse_near(system, local, what, np.array(toward), centre, states["attitude"], np.array(knots), 1.0, 1.0)
        for q, limb in enumerate(_limb(np.array(toward), radius if len(points[kind]) > 1 else 0.0)):
            slowness = KINDS[kind] / local.light_speed
            towards[kind, q] = _core.Toward(knots, limb.tolist(), slowness, local.distant, False)
    conditions = [_core.Condition.Occultation(i, j, total, towards[kind, q]) for kind, i, j, total, q in asked]
    crossings = run.dense.core.crossings(system.context.core, conditions, span)
    intervals = {key: _intervals(*found, span, start < stop) for key, found in zip(asked, crossings, strict=True)}
    found = []
    for kind, i, j in ((kind, i, j) for kind in kinds for i, j in pairs):
        seen, totals = ([intervals[kind, i, j, total, q] for q in points[kind]] for total in (False, True))
        found += [(contacts, kind, i, j) for contacts in _contacts(seen, totals, span)]
    found.sort(key=lambda one: one[0][:2])
    times = np.array([one[0] for one in found]).reshape(-1, 6)
    hidden = np.array([i for _, _, i, _ in found], dtype=np.intp)
    eclipsed = np.array([kind == "eclipse" for _, kind, _, _ in found], dtype=bool)
    known = ~(np.isnan(times) | np.isin(times, span))
    which = np.nonzero(known)[0]
    times[known] = _arrivals(run, local, times[known], hidden[which], eclipsed[which])

    def attached(time: float, is_known: bool) -> Any:
        return system.context.units.attach(float(time), "time") if is_known else None

    events = [
        MutualEvent(kind, system.context.names[i], system.context.names[j], *map(attached, row, mask))
        for (_, kind, i, j), row, mask in zip(found, times, known, strict=True)
    ]
    if law is not None:
        edges = local.arrival(np.array(span))
        ends = [np.where(known[:, k], times[:, k], edges[k]) for k in (0, 1)]

        def loss(moments: Floats) -> Floats:
            options: dict[str, Any] = {"law": law, "albedo": albedo, "sun_radius": sun_radius}
            when = system.context.units.attach(moments, "time")
            hidden, free = (light_curve(run, when, geometry, mutual=mutual, **options) for mutual in (True, False))
            return hidden - free

        for k, (first, last) in enumerate(zip(*ends, strict=True)):
            moment, depth = _deepest(loss, first, last)
            events[k] = replace(events[k], depth=depth, deepest=attached(moment, True))
    return MutualEvents(events, system)


def _limb(toward: Floats, radius: float) -> list[Floats]:
    """Return vectors (T, 3) to points on the limb of a disc of an angular radius about vectors, or to its centre."""
    if radius == 0.0:
        return [toward]
    length = np.linalg.norm(toward, axis=1, keepdims=True)
    # The two axes across turn with the direction, without jumps, from those of the first one.
    least = np.eye(3)[np.argmin(np.abs(toward[0]))]
    first = np.cross(toward, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(toward / length, first)
    angles = 2.0 * np.pi * np.arange(_LIMB) / _LIMB
    return [toward + np.tan(radius) * length * (np.cos(a) * first + np.sin(a) * second) for a in angles]


def _contacts(
    seen: list[list[tuple[float, float]]], totals: list[list[tuple[float, float]]], span: list[float]
) -> list[list[float]]:
    """Return begin, end, those of totality and those of the umbra of events, nan where there is none.

    The lists have the intervals in which a body is hidden, and totally so, from each of several points.
    """
    found: list[list[float]] = []
    groups: list[list[tuple[int, float, float]]] = []
    for begin, end, q in sorted((*interval, q) for q, own in enumerate(seen) for interval in own):
        if groups and begin <= max(group[2] for group in groups[-1]):
            groups[-1].append((q, begin, end))
        else:
            groups.append([(q, begin, end)])
    for group in groups:
        begins, ends = np.full((2, len(seen)), np.nan)
        for q, begin, end in group:
            begins[q], ends[q] = np.fmin(begins[q], begin), np.fmax(ends[q], end)
        first, last = _extreme(begins, -1.0, span), _extreme(ends, 1.0, span)
        inner = [[ends for ends in own if first <= ends[0] and ends[1] <= last] for own in totals]
        total = umbra = (np.nan, np.nan)
        if all(inner):
            total = (
                _extreme(np.array([own[0][0] for own in inner]), 1.0, span),
                _extreme(np.array([own[-1][1] for own in inner]), -1.0, span),
            )
        if len(seen) > 1 and not np.isnan(begins).any():
            umbra = _extreme(begins, 1.0, span), _extreme(ends, -1.0, span)
        pairs = (pair if pair[0] < pair[1] else (np.nan, np.nan) for pair in (total, umbra))
        found.append([first, last, *next(pairs), *next(pairs)])
    return found


def _extreme(times: Floats, sign: float, span: list[float]) -> float:
    """Return the latest (sign 1) or first (-1) of times for points around a limb, interpolated between these.

    Where some of the points have no time, or one at an end of the span, it is that of a point.
    """
    if len(times) > 1 and not (np.isnan(times).any() or np.isin(times, span).any()):
        middle = times.mean()
        times = middle + np.fft.irfft(np.fft.rfft(times - middle), _FINE * len(times)) * _FINE
    return float(sign * np.nanmax(sign * times))


def _deepest(loss: Callable[[Floats], Floats], first: float, last: float) -> tuple[float, float]:
    """Return the time between two at which a loss of light is largest, and the loss."""
    for _ in range(_SEARCHES):
        times = np.linspace(first, last, _DEPTHS)
        losses = loss(times)
        k = int(np.argmax(losses))
        first, last = times[max(k - 1, 0)], times[min(k + 1, len(times) - 1)]
    return float(times[k]), float(losses[k])


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
