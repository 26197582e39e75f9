"""Contacts of a star with the outline of a body that is no ellipsoid: a polyhedron or a composite."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
        self._passed = [self._row(body, k) for k in range(len(self.every))]
        return np.asarray(self.linearised(body))

    def _row(self, body: Body, k: int) -> _Passed:
        """Return the chord of a row that overlaps most with the observed one, or is nearest to it."""
        rows, width = self.rows, self.reach / float(self._speed[k])
        middle = float(rows.times[k])
        for _ in range(_NEAREST):
            earlier, value, after = (self._square(body, k, middle + step * width) for step in (-1.0, 0.0, 1.0))
            middle -= 0.5 * width * (after - earlier) / (after - 2.0 * value + earlier)
        first, last = middle - _LONG * width, middle + _LONG * width
        if rows.sign[k] == 0.0:
            first, last = max(first, float(rows.interval[k, 0])), min(last, float(rows.interval[k, 1]))
            if not first < last:
                first = last = float(np.clip(middle, *rows.interval[k]))
        nodes = np.linspace(first, last, _PASSAGE + 1)
        index = np.full(len(nodes), k)
        places = self.sight(body, index, nodes)
        spans: list[tuple[Span, int]] = []
        for number, limb in enumerate(self.limbs if rows.sign[k] != 0.0 else ()):

            def measure(times: Floats, limb: Limb = limb) -> Floats:
                return np.asarray(limb.measure(*self.sight(body, np.full(len(times), k), times)))

            passed = self._straight(body, k, limb, (first, last), measure)
            if passed is None:
                passed = spans_below_zero(measure, dense_nodes(limb, nodes, *places))
            spans += [(span, number) for span in passed]
        if not spans:
            lengths = np.array([limb.length(limb.measure(*places)) for limb in self.limbs])
            nearest, node = np.unravel_index(np.argmin(lengths), lengths.shape)
            return _Passed(float(nodes[node]), float(nodes[node]), (int(nearest), int(nearest)), True)
        observed = np.clip(rows.interval[k], first, last)

        def overlap(span: Span) -> float:
            return float(min(span[1], observed[1]) - max(span[0], observed[0]))

        begin, end = max(union([span for span, _ in spans]), key=overlap)
        first_limb = next(number for span, number in spans if span[0] == begin)
        return _Passed(begin, end, (first_limb, next(number for span, number in spans if span[1] == end)), False)

    def _straight(
        self, body: Body, k: int, limb: Limb, ends: Span, measure: Callable[[Floats], Floats]
    ) -> list[Span] | None:
        """Return the spans in which a ray is within an outline, from the crossings of a straight path with the outline.

        The attitude of the middle gives the crossings, which are then located with that of their own time. ``None`` is
        returned where this finds no crossing, and where it does not converge, as near a graze.
        """
        index = np.array([k, k, k])
        w, u, attitude = self.lines(body, index, np.array([*ends, 0.5 * sum(ends)]))
        ends_in_body, toward = into_body(attitude[[2, 2]], w[:2]), into_body(attitude[[2]], u[[2]])
        _, shares = limb.crossings(ends_in_body[:1], toward, ends_in_body[1:] - ends_in_body[:1])
        if not len(shares):
            return None
        length = ends[1] - ends[0]
        times = ends[0] + length * shares
        nodes = np.concatenate([ends[:1], times, ends[1:]])
        inside = measure(0.5 * (nodes[1:] + nodes[:-1])) < 0.0
        if inside[0] or inside[-1]:
            return None
        times = times[inside[1:] != inside[:-1]]
        for _ in range(_POLISHED):
            step = measure(times) / self.rates(body, np.full(len(times), k), times, limb)
            times = times - step
        if not (np.abs(step) <= _CLOSE * length).all() or (np.diff(times) <= 0.0).any():
            return None
        return list(zip(times[::2].tolist(), times[1::2].tolist(), strict=True))

    def _square(self, body: Body, k: int, time: float) -> float:
        """Return the square of the distance of a row's line of sight from the body's centre at a time."""
        w, _ = self.sight(body, np.array([k]), np.array([time]))
        return float(np.sum(w * w))

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
