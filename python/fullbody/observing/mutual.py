"""Mutual events: occultations and eclipses of the bodies of a run by each other."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..base.kinds import choice
from ..base.limits import Limits
from ..base.units import UNITLESS
from ..errors import interruptible
from ..events import Occultation
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Array, Floats
from .laws import Law
from .light_curve import light_curve
from .mutual_event import MutualEvent, MutualEvents
from .spans import minimum
from .states import refuse_near
from .vectors import SystemGeometry, Vectors, local_geometry

#: Kinds of events, and the sign of the light's direction: 1 toward the observer, -1 from the Sun.
KINDS = {"occultation": 1.0, "eclipse": -1.0}
#: The least number of rows of a table of directions, which keeps its spline equal to that of the geometry.
_ROWS = 64
#: The number of points on the limb of the Sun, and the factor by which interpolation makes them denser.
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
    """Find all occultations and eclipses among the bodies of a run, in the order of time.

    Contacts are located on the continuous solution to the last digits of their time. Extrema within a step are searched
    too, so that grazing events are found. Each body is where the light left it, and lies within its cone
    from the observer, or from the Sun, at any distance. Shadows contain the light time from body to body.

    Parameters
    ----------
    run : Run
        A run with ``dense=True``.
    geometry : Geometry
        The positions of the observer and of the Sun. Events are searched in the time that both the run and the geometry
        cover. Without the Sun only occultations are found.
    sun_radius : float, Quantity or str
        Angular radius of the Sun's disc in radians, 0.00465 at 1 au. With it eclipses have the contacts of the penumbra
        and of the umbra. The Sun is a point if it is zero.
    law : Law or dict, optional
        The scattering law for the depths of the events in magnitudes; without it events have no depth.
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
    The outline of an ellipsoid is an ellipse, that of a polyhedron is the convex hull of its projected vertices, and
    that of a composite is the union of its parts' outlines. A body behind a composite counts as totally hidden only
    within the outline of one part.

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
    system, solution = run.system, run.continuous().core
    local = local_geometry(geometry, system)
    first, last = sorted(solution.range)
    local.common_span(system, first, last)
    begin, end = local.ends()
    span = [max(first, float(local.emission(begin))), min(last, float(local.emission(end)))]
    radius = UNITLESS.number(sun_radius, "angle", "sun_radius", Limits(least=0.0, below=0.5 * np.pi))
    kinds = [kind for kind in KINDS if kind == "occultation" or geometry.has_sun]
    pairs = [(i, j) for i in range(len(system.context)) for j in range(len(system.context)) if i != j]
    points = {kind: range(_LIMB if radius > 0.0 and kind == "eclipse" else 1) for kind in kinds}
    keys = [(kind, i, j, total, q) for kind in kinds for i, j in pairs for total in (False, True) for q in points[kind]]
    directions = {}
    weights = system.context.masses / system.context.masses.sum()
    for kind in kinds:
        knots, toward = _table(local, kind, span)
        states = solution.states(np.clip(np.array(knots), span[0], span[1]))
        centre = states["position"] - np.einsum("n,tnx->tx", weights, states["position"])[:, None]
        what = "observer" if kind == "occultation" else "Sun"
        refuse_near(system, local, what, np.array(toward), centre, states["attitude"], np.array(knots), 1.0, 1.0)
        for q, limb in enumerate(_limb(np.array(toward), radius if len(points[kind]) > 1 else 0.0)):
            slowness = KINDS[kind] / local.light_speed
            directions[kind, q] = _core.Viewpoint(knots, limb.tolist(), slowness, local.distant, False)
    conditions = [_core.Condition.Occultation(i, j, total, directions[kind, q]) for kind, i, j, total, q in keys]
    forward = solution.range[0] < solution.range[1]
    crossings = solution.crossings(system.context.core, conditions, span)
    intervals = {key: _intervals(*crossing, span, forward) for key, crossing in zip(keys, crossings, strict=True)}
    contacts_of_events = []
    for kind, i, j in ((kind, i, j) for kind in kinds for i, j in pairs):
        partial, total = ([intervals[kind, i, j, total, q] for q in points[kind]] for total in (False, True))
        contacts_of_events += [(contacts, kind, i, j) for contacts in _contacts(partial, total, span)]
    contacts_of_events.sort(key=lambda event: event[0][:2])
    times = np.array([contacts for contacts, _, _, _ in contacts_of_events]).reshape(-1, 6)
    hidden = np.array([i for _, _, i, _ in contacts_of_events], dtype=np.intp)
    eclipsed = np.array([kind == "eclipse" for _, kind, _, _ in contacts_of_events], dtype=bool)
    # Ends of the span are no contacts.
    is_contact = ~(np.isnan(times) | np.isin(times, span))
    rows = np.nonzero(is_contact)[0]
    times[is_contact] = _arrivals(run, local, times[is_contact], hidden[rows], eclipsed[rows])

    def attached(time: float, exists: bool) -> Any:
        return system.context.units.attach(float(time), "time") if exists else None

    events = [
        MutualEvent(kind, system.context.names[i], system.context.names[j], *map(attached, row, mask))
        for (_, kind, i, j), row, mask in zip(contacts_of_events, times, is_contact, strict=True)
    ]
    if law is not None:
        edges = local.arrival(np.array(span))
        ends = [np.where(is_contact[:, k], times[:, k], edges[k]) for k in (0, 1)]

        def gain(moments: Floats) -> Floats:
            options: dict[str, Any] = {"law": law, "albedo": albedo, "sun_radius": sun_radius}
            times = system.context.units.attach(moments, "time")
            dimmed, undimmed = (light_curve(run, times, geometry, mutual=mutual, **options) for mutual in (True, False))
            return undimmed - dimmed

        for k, (first, last) in enumerate(zip(*ends, strict=True)):
            moment, gained = minimum(gain, first, last, _DEPTHS, _SEARCHES)
            events[k] = replace(events[k], depth=-gained, deepest=attached(moment, True))
    return MutualEvents(events, system)


def _limb(toward: Floats, radius: float) -> list[Floats]:
    """Return vectors (T, 3) to points on the limb of a disc of an angular radius about vectors, or to its centre."""
    if radius == 0.0:
        return [toward]
    length = np.linalg.norm(toward, axis=1, keepdims=True)
    # The axes across are computed from one fixed vector, so that they follow the direction without jumps.
    least = np.eye(3)[np.argmin(np.abs(toward[0]))]
    first = np.cross(toward, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(toward / length, first)
    angles = 2.0 * np.pi * np.arange(_LIMB) / _LIMB
    return [toward + np.tan(radius) * length * (np.cos(a) * first + np.sin(a) * second) for a in angles]


def _contacts(
    partial: list[list[tuple[float, float]]], total: list[list[tuple[float, float]]], span: list[float]
) -> list[list[float]]:
    """Return begin and end of events, of their totality and of the umbra; nan where they do not exist.

    The lists have the intervals in which a body is hidden, and totally so, from each of several points.
    """
    contacts: list[list[float]] = []
    groups: list[list[tuple[int, float, float]]] = []
    for begin, end, q in sorted((*interval, q) for q, intervals in enumerate(partial) for interval in intervals):
        if groups and begin <= max(group[2] for group in groups[-1]):
            groups[-1].append((q, begin, end))
        else:
            groups.append([(q, begin, end)])
    for group in groups:
        begins, ends = np.full((2, len(partial)), np.nan)
        for q, begin, end in group:
            begins[q], ends[q] = np.fmin(begins[q], begin), np.fmax(ends[q], end)
        first, last = _extreme(begins, -1.0, span), _extreme(ends, 1.0, span)
        inner = [[ends for ends in intervals if first <= ends[0] and ends[1] <= last] for intervals in total]
        totality = umbra = (np.nan, np.nan)
        if all(inner):
            totality = (
                _extreme(np.array([intervals[0][0] for intervals in inner]), 1.0, span),
                _extreme(np.array([intervals[-1][1] for intervals in inner]), -1.0, span),
            )
        if len(partial) > 1 and not np.isnan(begins).any():
            umbra = _extreme(begins, 1.0, span), _extreme(ends, -1.0, span)
        pairs = (pair if pair[0] < pair[1] else (np.nan, np.nan) for pair in (totality, umbra))
        contacts.append([first, last, *next(pairs), *next(pairs)])
    return contacts


def _extreme(times: Floats, sign: float, span: list[float]) -> float:
    """Return the latest (sign 1) or first (-1) of the times of points around a limb, interpolated between the points.

    If a point has no time, or a time at an end of the span, nothing is interpolated.
    """
    if len(times) > 1 and not (np.isnan(times).any() or np.isin(times, span).any()):
        middle = times.mean()
        times = middle + np.fft.irfft(np.fft.rfft(times - middle), _FINE * len(times)) * _FINE
    return float(sign * np.nanmax(sign * times))


def _arrivals(
    run: Record, local: SystemGeometry, times: Floats, hidden: npt.NDArray[np.intp], eclipsed: npt.NDArray[np.bool_]
) -> Floats:
    """Return the times (T,) when the observer sees contacts, from those of the conditions and the hidden bodies."""
    arrivals = local.arrival(times)
    if np.isinf(local.light_speed) or not eclipsed.any():
        return arrivals
    solution = run.continuous().core
    # The time of an eclipse's condition is that at which sunlight passes the barycentre; it leaves the body at another.
    passing = emitted = times[eclipsed]
    sun = local.sun(arrivals[eclipsed])
    weights = run.context.masses / run.context.masses.sum()
    for _ in range(_ITERATIONS):
        position = solution.states(np.clip(emitted, min(solution.range), max(solution.range)))["position"]
        body = position[np.arange(len(position)), hidden[eclipsed]] - np.einsum("n,tnx->tx", weights, position)
        detour = np.linalg.norm(sun - body, axis=1) - np.linalg.norm(sun, axis=1)
        emitted = passing + detour / local.light_speed
    arrivals[eclipsed] = local.arrival(emitted, body)
    return arrivals


def _intervals(at_start: float, zeros: list[float], span: list[float], forward: bool) -> list[tuple[float, float]]:
    """Return the spans in which a function is negative, from a value before its first zero along the run."""
    below = at_start < 0.0
    if not forward:
        below ^= len(zeros) % 2 == 1
        zeros = zeros[::-1]
    edges = [-np.inf, *zeros] if below else [*zeros]
    edges += [np.inf] if len(edges) % 2 else []
    pairs = zip(edges[::2], edges[1::2], strict=True)
    # Rounding may give a zero twice, and such an interval has no length.
    clipped = ((max(a, span[0]), min(b, span[1])) for a, b in pairs)
    return [(a, b) for a, b in clipped if a < b]


def _table(local: SystemGeometry, kind: str, span: list[float]) -> tuple[list[float], list[list[float]]]:
    """Return times of emission in a span, and vectors to the observer, or to the Sun, for light that leaves then."""
    ends = [float(local.arrival(time)) for time in span]
    rows = local.rows()
    inside = rows[(rows > ends[0]) & (rows < ends[1])]
    # The spline of the geometry is a cubic between its rows, which a few points on each piece reproduce.
    knots = np.unique(np.concatenate([[ends[0]], inside, [ends[1]]]))
    parts = max(3, -(-_ROWS // len(knots)))
    positions = np.linspace(0, len(knots) - 1, (len(knots) - 1) * parts + 1)
    arrivals = np.interp(positions, np.arange(len(knots)), knots)
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
    """Make an event of :mod:`fullbody.events` from a mutual event in a geometry, which a run records or ends with.

    Parameters
    ----------
    system : System
        The system that gives the event its times, units and axes.
    geometry : Geometry
        The geometry, which has to cover the run.
    body, by : int or str
        The hidden body and the one that hides it, by their indices in the system or their names.
    kind : {"occultation", "eclipse"}
        Whether the body is hidden from the observer or from the Sun.
    total : bool
        Whether the event is that of the whole outline of the body being hidden.
    direction : {-1, 0, 1}
        -1 for its begin, 1 for its end, 0 for both.
    terminal : bool
        Whether the run ends with it.

    Returns
    -------
    fullbody.events.Occultation
        The event, whose times are those at which the observed light left the barycentre, or sunlight passed it. Bodies
        are seen as by :func:`mutual_events`.

    Raises
    ------
    InvalidInput
        For a body, a kind or a direction that does not exist. A run also raises it if one of the two bodies reaches as
        far toward the observer, or the Sun, as these are from the barycentre.

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
    numbers, toward = _table(local, kind, span)
    times = system.context.units.attach(np.array(numbers), "time")
    indices = system.context.index(body, "body"), system.context.index(by, "by")
    slowness = KINDS[kind] / local.light_speed
    options: dict[str, Any] = {"direction": direction, "terminal": terminal}
    return Occultation(*indices, toward, times, total, local.distant, slowness, **options)
