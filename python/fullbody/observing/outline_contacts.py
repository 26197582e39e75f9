"""Contacts of a star with the outline of a body that is no ellipsoid: a polyhedron or a composite."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..typing import Floats
from .contacts import Body, EllipsoidContacts, Passage, Paths, Rows, continued, into_body
from .limbs import EllipsoidLimb, Limb, dense_nodes
from .spans import Span, spans_below_zero, union

#: The number of intervals of a passage, and its length relative to the time in which the body's reach passes.
_PASSAGE, _LONG = 64, 1.05
#: The iterations in which a contact is located, and the share of a passage within which the last one has to end.
_POLISHED, _CLOSE = 4, 1e-7
#: The iterations of the time at which a body's centre is nearest to a line of sight.
_NEAREST = 6


class _Passed(NamedTuple):
    """The contacts of a row: the ends of the chord with the limbs there, or the nearest time with the limb.

    Where the body misses the station, both ends are the nearest time.
    """

    begin: float
    end: float
    limbs: tuple[int, int]
    missed: bool


class OutlineContacts(Passage):
    """The contacts of K rows with the outline of a body, which may have several chords."""

    def __init__(self, rows: Rows, path: Paths, limbs: Sequence[Limb]) -> None:
        super().__init__(rows, path, limbs)
        self._passed: list[_Passed] = []
        self._speed = rows.times

    def solve(self, body: Body) -> Floats:
        """Find the contacts, and return predictions (K,) relative to the times of the rows."""
        self._speed = self.speed(body)
        ends = self._ends(body)
        passages = [self._straight(body, limb, ends) for limb in self.limbs]
        self._passed = [self._row(body, k, ends[k], [spans[k] for spans in passages]) for k in range(len(ends))]
        return np.asarray(self.linearised(body))

    def _ends(self, body: Body) -> Floats:
        """Return the ends (K, 2) of the times at which lines of sight may be near the body, and a miss was watched."""
        rows, width, middle = self.rows, self.reach / self._speed, self.rows.times
        for _ in range(_NEAREST):
            earlier, value, later = (self._square(body, middle + step * width) for step in (-1.0, 0.0, 1.0))
            middle = middle - 0.5 * width * (later - earlier) / (later - 2.0 * value + earlier)
        ends = middle[:, None] + _LONG * width[:, None] * [-1.0, 1.0]
        watched = np.clip(ends, rows.interval[:, :1], rows.interval[:, 1:])
        return np.where((rows.sign == 0.0)[:, None], watched, ends)

    def _row(self, body: Body, k: int, ends: Floats, passages: list[list[Span] | None]) -> _Passed:
        """Return the chord of a row that overlaps most with the observed one, or is nearest to it."""
        nodes = np.linspace(ends[0], ends[1], _PASSAGE + 1)
        spans: list[tuple[Span, int]] = []
        for number, (limb, passage) in enumerate(zip(self.limbs, passages, strict=True)):

            def measure(times: Floats, limb: Limb = limb) -> Floats:
                return np.asarray(limb.measure(*self.sight(body, np.full(len(times), k), times)))

            if passage is None:
                passage = spans_below_zero(measure, dense_nodes(limb, nodes, *self._at_nodes(body, k, nodes)))
            spans += [(span, number) for span in passage]
        if not spans:
            rays = self._at_nodes(body, k, nodes)
            lengths = np.array([limb.length(limb.measure(*rays)) for limb in self.limbs])
            nearest, node = np.unravel_index(np.argmin(lengths), lengths.shape)
            return _Passed(float(nodes[node]), float(nodes[node]), (int(nearest), int(nearest)), True)
        observed = np.clip(self.rows.interval[k], *ends)

        def overlap(span: Span) -> float:
            return float(min(span[1], observed[1]) - max(span[0], observed[0]))

        begin, end = max(union([span for span, _ in spans]), key=overlap)
        first_limb = next(number for span, number in spans if span[0] == begin)
        return _Passed(begin, end, (first_limb, next(number for span, number in spans if span[1] == end)), False)

    def _at_nodes(self, body: Body, k: int, nodes: Floats) -> tuple[Floats, Floats]:
        """Return points and directions of the rays of a row at times."""
        return self.sight(body, np.full(len(nodes), k), nodes)

    def _straight(self, body: Body, limb: Limb, ends: Floats) -> list[list[Span] | None]:
        """Return for each row the spans in which its ray is within an outline, from the crossings of a straight path.

        The attitude of the middle gives the crossings, which are then located with that of their own time. ``None``
        stands for a row for which this finds no crossing, or does not converge, as near a graze. Misses have no spans.
        """
        count, length = len(ends), ends[:, 1] - ends[:, 0]
        w, u, attitude = self.lines(body, np.tile(self.every, 3), np.concatenate([*ends.T, ends.mean(axis=1)]))
        start, stop = (into_body(attitude[2 * count :], w[k * count : (k + 1) * count]) for k in (0, 1))
        row, shares = limb.crossings(start, into_body(attitude[2 * count :], u[2 * count :]), stop - start)
        # Between the crossings of a row there is a time at which its ray is inside or outside.
        breaks = np.sort(np.concatenate([np.arange(count + 1.0), row + shares]))
        between = 0.5 * (breaks[1:] + breaks[:-1])
        of = np.minimum(between.astype(np.intp), count - 1)
        inside = limb.measure(*self.sight(body, of, ends[of, 0] + length[of] * (between - of))) < 0.0
        same_row, changes = of[1:] == of[:-1], inside[1:] != inside[:-1]
        outer = ~np.concatenate([[False], same_row]) | ~np.concatenate([same_row, [False]])
        usable = np.bincount(row, minlength=count) > 0
        usable[of[outer & inside]] = False
        row, times = row[changes[same_row]], (ends[row, 0] + length[row] * shares)[changes[same_row]]
        step = np.zeros(len(times))
        for _ in range(_POLISHED if len(times) else 0):
            step = limb.measure(*self.sight(body, row, times)) / self.rates(body, row, times, limb)
            times = times - step
        usable[row[~(np.abs(step) <= _CLOSE * length[row])]] = False
        usable[row[1:][(row[1:] == row[:-1]) & ~(np.diff(times) > 0.0)]] = False
        spans: list[list[Span] | None] = []
        for k in self.every:
            edges = times[row == k].tolist()
            pairs = list(zip(edges[::2], edges[1::2], strict=True)) if usable[k] else None
            spans.append([] if self.rows.sign[k] == 0.0 else pairs)
        return spans

    def _square(self, body: Body, times: Floats) -> Floats:
        """Return the squares (K,) of the distances of the lines of sight from the body's centre at times (K,)."""
        w, _ = self.sight(body, self.every, times)
        return np.asarray(np.sum(w * w, axis=-1))

    def linearised(self, body: Body, limbs: Sequence[Limb] | None = None) -> Any:
        """Return predictions (..., K) for changes of the body, or of its limbs, to first order about what was found."""
        rows = self.rows
        ends = []
        for side in (0, 1):
            times = np.array([passed[side] for passed in self._passed])
            which = np.array([passed.limbs[side] for passed in self._passed])
            ends.append((times, *self._measured(body, times, which, self.limbs if limbs is None else limbs)))
        missed = np.array([passed.missed for passed in self._passed])
        begin, end = (times - value / np.where(missed, np.inf, rate) for times, value, rate, _ in ends)
        half = 0.5 * (end - begin)
        away, later = ends[0][3], self._later(body, ends[0][0])
        square = np.where(missed, -2.0 * self.reach * away / self._speed**2, half * half)
        middle = 0.5 * (begin + end) + np.where(missed, later, 0.0)
        is_exact = ~missed & (np.real(half) >= rows.least)
        half = np.where(is_exact, half, continued(rows.least, square))
        depth = np.where(np.real(away) < 0.0, -away / self._speed, 0.0)
        return np.where(rows.sign == 0.0, depth, middle + rows.sign * half - rows.times)

    def _measured(self, body: Body, times: Floats, which: Any, limbs: Sequence[Limb]) -> tuple[Any, Floats, Any]:
        """Return measures (..., K) of chosen limbs at times (K,), their rates (K,), and the distances (..., K)."""
        w, u = self.sight(body, self.every, times)
        values = np.zeros(w.shape[:-1], dtype=w.dtype)
        lengths, rates = np.zeros_like(values), np.ones(len(times))
        for number in set(which.tolist()):
            rows_of_limb = np.flatnonzero(which == number)
            measure = limbs[number].measure(w[..., rows_of_limb, :], u[..., rows_of_limb, :])
            values[..., rows_of_limb], lengths[..., rows_of_limb] = measure, limbs[number].length(measure)
            rates[rows_of_limb] = self.rates(body, rows_of_limb, times[rows_of_limb], self.limbs[number])
        return values, rates, lengths

    def _later(self, body: Body, times: Floats) -> Any:
        """Return by how much later (..., K) the body's centre is nearest, for changes of the body alone."""
        here, step = self.sight(body, self.every, times)[0], 1e-3 * self.reach / self._speed
        way = (self.sight(body.real, self.every, times + step)[0] - here.real) / step[:, None]
        changed = np.sum((here - here.real) * way, axis=-1)
        return -changed / np.sum(way * way, axis=-1)


def contacts_of(rows: Rows, path: Paths, limbs: Sequence[Limb]) -> Passage:
    """Return what finds the contacts of rows with a body of one part or several."""
    is_ellipsoid = len(limbs) == 1 and isinstance(limbs[0], EllipsoidLimb)
    return (EllipsoidContacts if is_ellipsoid else OutlineContacts)(rows, path, limbs)
