"""Prediction of stellar occultations: which station sees which body hide a star, and when."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.kinds import instance
from ..errors import interruptible
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .event_tables import masked_times, table_of, time_column
from .limbs import Limb, dense_nodes, limbs_of
from .sightlines import SightLines
from .spans import Span, minimum, spans_below_zero, union
from .star import Star
from .stations import Stations
from .vectors import Vectors

if TYPE_CHECKING:
    from ..typing import Scalar

#: The numbers of intervals into which an encounter and the passage of a body are divided, and the most of the former.
_ENCOUNTER, _PASSAGE, _MOST = 64, 64, 16384
#: The curvature of the path within an interval of an encounter, and the margin about a body, relative to its radius.
_CURVATURE, _MARGIN = 1e-3, 1.01
#: The largest rotation of a body, in radians, within an interval of its passage.
_ROTATION = 0.05
#: The number of times in a search for the nearest one, and of searches, each of which narrows it down to two intervals.
_TRIALS, _SEARCHES = 17, 12


@dataclass(frozen=True, slots=True)
class Chord:
    """The occultation of a star by a body as one station sees it.

    Attributes
    ----------
    station : int
        The index of the station.
    body : str
        The name of the body.
    disappearance, reappearance : float, Quantity or None
        Times at the station on the system's clock, numbers or Quantities since the epoch; ``None`` where the searched
        span begins or ends while the star is hidden.
    """

    station: int
    body: str
    disappearance: Scalar | None
    reappearance: Scalar | None

    @property
    def duration(self) -> Scalar | None:
        """The time from disappearance to reappearance, or ``None`` if one of them is ``None``."""
        if self.disappearance is None or self.reappearance is None:
            return None
        return self.reappearance - self.disappearance


@dataclass(frozen=True, slots=True)
class Miss:
    """The closest approach of a body to the line of sight of a station from which it hides nothing.

    Attributes
    ----------
    station : int
    body : str
    time : float or Quantity
        The time at which the body's centre is nearest to the line of sight, on the system's clock.
    distance : float or Quantity
        The distance of the body's centre from the line of sight then.
    """

    station: int
    body: str
    time: Scalar
    distance: Scalar


class Chords(list[Chord]):
    """A list of chords by station and time, made by :func:`occultation_chords`.

    Parameters
    ----------
    chords : iterable of Chord
    misses : iterable of Miss
    system : System
        The system on whose clock the times are.

    Attributes
    ----------
    misses : list of Miss
        For each station and each body that hides nothing from it in the searched span, its closest approach.
    """

    def __init__(self, chords: Iterable[Chord], misses: Iterable[Miss], system: SystemLike) -> None:
        super().__init__(chords)
        self.misses = list(misses)
        self._system = system

    def to_table(self) -> Any:
        """Return an astropy ``QTable`` with a row for each chord.

        It has the columns ``station``, ``body``, ``disappearance``, ``reappearance`` and ``duration``. Times are dates
        in UTC if the system has an epoch, by the clock of the station. A time that a chord does not have is masked.

        Examples
        --------
        >>> import astropy.units as u, fullbody
        >>> from fullbody import observing
        >>> system, state = fullbody.systems.didymos(units=True)
        >>> run = system.integrate(state, "10 min", dense=True)
        >>> path = {"to_observer": [[1e7, -2.0, 0.0], [1e7, 4.0, 0.0]] * u.km, "frame": "ecliptic"}
        >>> geometry = observing.Geometry([0.0, 300.0] * u.s, **path)
        >>> chords = observing.occultation_chords(run, [-1.0, 0.0, 0.0], [[0.0, 0.0, 0.0]] * u.km, geometry)
        >>> chords.to_table()["station", "body"].pformat()[-1].split()
        ['0', 'Dimorphos']
        """
        table = table_of({name: [getattr(chord, name) for chord in self] for name in ("station", "body")})
        for name in ("disappearance", "reappearance"):
            table[name] = time_column([getattr(chord, name) for chord in self], self._system)
        table["duration"] = masked_times([chord.duration for chord in self], self._system)
        return table


@interruptible("a search for chords")
def occultation_chords(run: Record, star: Any, stations: Any, geometry: Vectors, span: Any = None) -> Chords:
    """Find which stations see which bodies of a run hide a star, and when.

    A body hides the star where the ray from the station passes through the body as it was when the light passed it, at
    the time t - abs(X - r)/c, with X the station at t and r the body's centre. Each disappearance and reappearance is
    located on the continuous solution to the last digits of its time. Grazes between samples are searched for.

    Parameters
    ----------
    run : Run
        A run with ``dense=True``.
    star : SkyCoord, (ra, dec) or array_like (3,)
        The star, a point: a ``SkyCoord``, whose proper motion and parallax count if it has them; right ascension and
        declination in the ICRS as Quantities; or a unit vector along the axes of the geometry.
    stations : EarthLocation, sequence of them, or array_like or Quantity, (S, 3)
        Places on the Earth, for a geometry from its centre; or vectors from the observer of the geometry, along its
        axes.
    geometry : Geometry
    span : pair of times, optional
        The first and the last time of the search, at the observer; by default all that run and geometry cover.

    Returns
    -------
    Chords
        A list of :class:`Chord` by station and time, with the attribute ``misses`` and the method ``to_table``. It is
        empty if the star is hidden from no station.

    Raises
    ------
    InvalidInput
        For a run without its continuous solution, a star that is on the observer's side of the system, an observer
        within the system, angles without a unit, and a span that run and geometry do not cover.

    Notes
    -----
    Ellipsoids and polyhedra are exact. A body that is not convex may hide the star several times. A composite hides
    what one of its parts hides; voids are within its parts. Points hide nothing.

    The Earth's rotation is that of the tables of astropy that are at hand; the network is not asked.

    Examples
    --------
    >>> import astropy.units as u, fullbody
    >>> from fullbody import observing
    >>> system, state = fullbody.systems.didymos(units=True)
    >>> run = system.integrate(state, "10 min", dense=True)
    >>> path = {"to_observer": [[1e7, -2.0, 0.0], [1e7, 4.0, 0.0]] * u.km, "frame": "ecliptic"}
    >>> geometry = observing.Geometry([0.0, 300.0] * u.s, **path)
    >>> stations = [[0.0, 0.0, 0.0], [0.0, 0.0, 9.0]] * u.km
    >>> chords = observing.occultation_chords(run, [-1.0, 0.0, 0.0], stations, geometry)
    >>> [(chord.station, chord.body) for chord in chords], len(chords.misses)
    ([(0, 'Didymos'), (0, 'Dimorphos')], 2)
    """
    instance(geometry, "geometry", Vectors, "an observing.Geometry")
    source = Star(star, geometry)
    sites = Stations(stations, geometry, source)
    lines = SightLines(run, geometry, source, sites)
    first, last = lines.span(span)
    lines.refuse_inside(np.linspace(first, last, _ENCOUNTER))
    chords: list[Chord] = []
    misses: list[Miss] = []
    attach = run.context.units.attach
    for body, name in enumerate(run.context.names):
        if not (limbs := limbs_of(run.system, body)):
            # A point hides nothing.
            continue
        search = _Search(lines, sites, body, limbs, (first, last))
        for station in range(len(sites)):
            spans = search.spans(station)
            ends = [[None if t in (first, last) else attach(t, "time") for t in span] for span in spans]
            chords += [Chord(station, name, *pair) for pair in ends]
            if not spans:
                time, distance = search.closest_approach(station)
                misses.append(Miss(station, name, attach(time, "time"), attach(distance, "length")))

    def order(chord: Chord) -> tuple[int, float]:
        begin = first if chord.disappearance is None else run.context.units.strip(chord.disappearance, "time", "time")
        return chord.station, float(begin)

    return Chords(sorted(chords, key=order), sorted(misses, key=lambda miss: miss.station), run.system)


class _Search:
    """The search for the spans of time in which a body hides the star from each of the stations."""

    def __init__(self, lines: SightLines, stations: Stations, body: int, limbs: list[Limb], span: Span) -> None:
        self._lines, self._body, self._limbs, self._span = lines, body, limbs, span
        self._radius = max(limb.radius for limb in limbs)
        indices, zeros = np.arange(len(stations)), np.zeros(len(stations))
        offsets = [np.linalg.norm(stations.offsets(lines.system, indices, zeros + time), axis=1) for time in span]
        radius = 1.02 * float(np.max(offsets, initial=0.0)) + _MARGIN * self._radius
        #: Nodes (T,) of the encounters, and the least distances (S, T - 1) of lines of sight of stations between them.
        self._encounters = [self._encounter(len(stations), *part) for part in lines.encounters(body, span, radius)]

    def _encounter(self, count: int, start: float, stop: float) -> tuple[Floats, Floats]:
        """Return nodes so dense that paths between them are straight, and the distances of ``count`` stations."""
        intervals = _ENCOUNTER
        while True:
            nodes = np.linspace(start, stop, intervals + 1)
            path = self._lines.past(self._body, nodes).w
            sagitta = np.linalg.norm(path[:-2] - 2.0 * path[1:-1] + path[2:], axis=1).max() / 8.0
            ratio = sagitta / (_CURVATURE * self._radius)
            if ratio <= 1.0 or intervals >= _MOST:
                break
            intervals = min(_MOST, int(intervals * max(2.0, np.sqrt(ratio))))
        return nodes, np.stack([self._least_distances(nodes, station) for station in range(count)])

    def _least_distances(self, nodes: Floats, station: int) -> Floats:
        """Return the least distances (T - 1,) of straight lines between nodes; infinite if the body is behind."""
        sight = self._lines.past(self._body, nodes, np.full(len(nodes), station))
        start, path = sight.w[:-1], np.diff(sight.w, axis=0)
        square = np.maximum(np.sum(path * path, axis=1), np.finfo(float).tiny)
        share = np.clip(-np.sum(start * path, axis=1) / square, 0.0, 1.0)
        is_ahead = sight.is_ahead[1:] | sight.is_ahead[:-1]
        return np.where(is_ahead, np.linalg.norm(start + share[:, None] * path, axis=1), np.inf)

    def spans(self, station: int) -> list[Span]:
        """Return the spans in which the body hides the star from a station."""
        spans: list[Span] = []
        for nodes, least in self._encounters:
            near = np.flatnonzero(least[station] < _MARGIN * self._radius)
            for begin, end in union([(float(nodes[k]), float(nodes[k + 1])) for k in near]):
                spans += [part for limb in self._limbs for part in self._passage(limb, station, begin, end)]
        return union(spans)

    def closest_approach(self, station: int) -> tuple[float, float]:
        """Return the time at which the body's centre is nearest to the line of sight, and its distance then."""
        low, high = self._span
        if self._encounters:
            nodes, least = min(self._encounters, key=lambda encounter: encounter[1][station].min())
            k = int(np.argmin(least[station]))
            low, high = nodes[max(k - 1, 0)], nodes[min(k + 2, len(nodes) - 1)]

        def distances(times: Floats) -> Floats:
            return self._lines.distances(self._body, times, np.full(len(times), station))

        return minimum(distances, low, high, _TRIALS, _SEARCHES)

    def _passage(self, limb: Limb, station: int, begin: float, end: float) -> list[Span]:
        """Return the spans within an encounter in which a part of the body hides the star."""

        def measure(times: Floats) -> Floats:
            sight = self._lines.past(self._body, times, np.full(len(times), station))
            return np.where(sight.is_ahead, limb.measure(*sight.in_body()), 1.0)

        rate = float(np.linalg.norm(self._lines.states(np.array([begin]))["spin"][0, self._body]))
        count = int(min(_MOST, max(_PASSAGE, rate * (end - begin) / _ROTATION)))
        nodes = np.linspace(begin, end, count + 1)
        rays = self._lines.past(self._body, nodes, np.full(len(nodes), station)).in_body()
        return spans_below_zero(measure, dense_nodes(limb, nodes, *rays))
