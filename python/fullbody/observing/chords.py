"""Prediction of stellar occultations: which station sees which body hide a star, and when."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.kinds import instance
from ..errors import interruptible
from ..record.record import Record
from ..typing import Floats
from .chord import Chord, Chords, Miss
from .limbs import Limb, Span, dense_nodes, limbs_of, spans_below_zero, union
from .sightlines import SightLines, span_of
from .star import Star
from .stations import Stations
from .times import in_system
from .vectors import Vectors

#: The numbers of intervals into which an encounter and the passage of a body are divided, and the most of the former.
_ENCOUNTER, _PASSAGE, _MOST = 64, 64, 16384
#: The curvature of the path within an interval of an encounter, and the margin about a body, relative to its reach.
_CURVED, _MARGIN = 1e-3, 1.01
#: The largest rotation of a body, in radians, within an interval of its passage.
_TURN = 0.05


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
    lines = SightLines(run, geometry, source, Stations(stations, geometry, source))
    first, last = lines.span(span_of(span, run.system, in_system))
    lines.refuse_inside(np.linspace(first, last, _ENCOUNTER))
    assert lines.stations is not None
    chords: list[Chord] = []
    misses: list[Miss] = []
    context = run.context
    for body, name in enumerate(context.names):
        if not (limbs := limbs_of(run.system, body)):
            # A point hides nothing.
            continue
        found = _Search(lines, body, limbs, (first, last))
        for station in range(len(lines.stations)):
            spans = found.spans(station)
            ends = [[None if t in (first, last) else context.units.attach(t, "time") for t in span] for span in spans]
            chords += [Chord(station, name, *pair) for pair in ends]
            if not spans:
                time, distance = found.nearest(station)
                time, distance = context.units.attach(time, "time"), context.units.attach(distance, "length")
                misses.append(Miss(station, name, time, distance))

    def order(chord: Chord) -> tuple[int, float]:
        begin = first if chord.disappearance is None else context.units.strip(chord.disappearance, "time", "time")
        return chord.station, float(begin)

    return Chords(sorted(chords, key=order), sorted(misses, key=lambda miss: miss.station), run.system)


class _Search:
    """The search for the spans of time in which a body hides the star from each of the stations."""

    def __init__(self, lines: SightLines, body: int, limbs: list[Limb], span: Span) -> None:
        self._lines, self._body, self._limbs, self._span = lines, body, limbs, span
        assert lines.stations is not None
        self._count = len(lines.stations)
        self.reach = max(limb.reach for limb in limbs)
        #: For each station the nodes (T,) of the encounters, and the distances there of the lines of sight.
        self._encounters = [self._encounter(*part) for part in self._meetings()]

    def _meetings(self) -> list[Span]:
        """Return the spans in which the line of sight of some station may come near the body."""
        every, ends = np.arange(self._count), np.zeros(self._count)
        assert self._lines.stations is not None
        far = [np.linalg.norm(self._lines.stations.at(self._lines.system, every, ends + t), axis=1) for t in self._span]
        radius = 1.02 * float(np.max(far, initial=0.0)) + _MARGIN * self.reach
        return self._lines.meetings(self._body, self._span, radius)

    def _encounter(self, start: float, stop: float) -> tuple[Floats, Floats, Floats]:
        """Return nodes (T,) so dense that paths between them are straight, and places (S, T, 3) of lines of sight.

        The last item has the least distances (S, T - 1) of the lines of sight between nodes.
        """
        count = _ENCOUNTER
        while True:
            nodes = np.linspace(start, stop, count + 1)
            path = self._lines.at(self._body, nodes).w
            bent = np.linalg.norm(path[:-2] - 2.0 * path[1:-1] + path[2:], axis=1).max() / 8.0
            if bent <= _CURVED * self.reach or count >= _MOST:
                break
            count = min(_MOST, int(count * max(2.0, np.sqrt(bent / (_CURVED * self.reach)))))
        least = np.empty((self._count, count))
        for station in range(self._count):
            sight = self._lines.at(self._body, nodes, np.full(len(nodes), station))
            w = np.where(sight.before[:, None], sight.w, np.inf)
            way = (
                w[1:] - w[:-1] if sight.before.all() else np.nan_to_num(w[1:] - w[:-1], nan=0.0, posinf=0.0, neginf=0.0)
            )
            square = np.maximum(np.sum(way * way, axis=1), np.finfo(float).tiny)
            start_w = np.where(np.isfinite(w[:-1]), w[:-1], 1e300)
            share = np.clip(-np.sum(start_w * way, axis=1) / square, 0.0, 1.0)
            least[station] = np.linalg.norm(start_w + share[:, None] * way, axis=1)
        return nodes, nodes[:-1], least

    def spans(self, station: int) -> list[Span]:
        """Return the spans in which the body hides the star from a station."""
        spans: list[Span] = []
        for nodes, _, least in self._encounters:
            near = np.flatnonzero(least[station] < _MARGIN * self.reach)
            for begin, end in union([(float(nodes[k]), float(nodes[k + 1])) for k in near]):
                spans += [part for limb in self._limbs for part in self._passage(limb, station, begin, end)]
        return union(spans)

    def nearest(self, station: int) -> tuple[float, float]:
        """Return the time at which the body's centre is nearest to the line of sight, and its distance then."""
        time = self._span[0]
        if self._encounters:
            parts = [
                (float(least[station].min()), float(nodes[np.argmin(least[station])]))
                for nodes, _, least in self._encounters
            ]
            time = min(parts)[1]
        step = (
            (self._encounters[0][0][1] - self._encounters[0][0][0])
            if self._encounters
            else self._span[1] - self._span[0]
        )
        low, high = max(self._span[0], time - step), min(self._span[1], time + 2.0 * step)
        for _ in range(12):
            trial = np.linspace(low, high, 17)
            distances = self._lines.distances(self._body, trial, np.full(len(trial), station))
            k = int(np.argmin(distances))
            low, high = float(trial[max(k - 1, 0)]), float(trial[min(k + 1, 16)])
        return float(trial[k]), float(distances[k])

    def _passage(self, limb: Limb, station: int, begin: float, end: float) -> list[Span]:
        """Return the spans within an encounter in which a part of the body hides the star."""

        def measure(times: Floats) -> Floats:
            sight = self._lines.at(self._body, times, np.full(len(times), station))
            return np.where(sight.before, limb.measure(*sight.in_body()), 1.0)

        rate = float(
            np.linalg.norm(self._lines.solution.states(np.array([self._emission(begin)]))["spin"][0, self._body])
        )
        count = int(min(_MOST, max(_PASSAGE, rate * (end - begin) / _TURN)))
        nodes = np.linspace(begin, end, count + 1)
        places = self._lines.at(self._body, nodes, np.full(len(nodes), station)).in_body()
        return spans_below_zero(measure, dense_nodes(limb, nodes, *places))

    def _emission(self, time: float) -> float:
        low, high = sorted(self._lines.solution.range)
        return float(np.clip(self._lines.local.emission(time), low, high))
