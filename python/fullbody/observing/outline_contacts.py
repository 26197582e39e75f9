"""Contacts of a star with the outline of a body that is no ellipsoid: a polyhedron or a composite."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..typing import Floats
from .contacts import ApparentBody, ContactRows, EllipsoidContacts, Indices, Passage, PathFunction, continued
from .limbs import EllipsoidLimb, Limb, dense_nodes
from .spans import Span, spans_below_zero, union
from .states import into_body

#: The number of intervals of a passage, and its length relative to the time in which the body's radius passes.
_INTERVALS, _LENGTH = 64, 1.05
#: The iterations in which a contact is located, and the share of a passage within which the last one has to end.
_ITERATIONS, _LAST_STEP = 4, 1e-7
#: The iterations of the time at which a body's centre is nearest to a line of sight.
_NEAREST = 6


class _RowContacts(NamedTuple):
    """The contacts of a row: the ends of the chord with the limbs there, or the nearest time with the limb.

    Where the body misses the station, both ends are the nearest time.
    """

    begin: float
    end: float
    limbs: tuple[int, int]
    is_miss: bool


class OutlineContacts(Passage):
    """The contacts of K rows with the outline of a body, which may have several chords."""

    def __init__(self, rows: ContactRows, path: PathFunction, limbs: Sequence[Limb]) -> None:
        super().__init__(rows, path, limbs)
        self._contacts: list[_RowContacts] = []
        self._speed = rows.times

    def solve(self, body: ApparentBody) -> Floats:
        """Find the contacts, and return predictions (K,) relative to the times of the rows."""
        self._speed = self.speed(body)
        ends = self._search_intervals(body)
        passages = [self._spans_of_straight_paths(body, limb, ends) for limb in self.limbs]
        self._contacts = [
            self._row_contacts(body, k, ends[k], [spans[k] for spans in passages]) for k in range(len(ends))
        ]
        return np.asarray(self.linearised(body))

    def _search_intervals(self, body: ApparentBody) -> Floats:
        """Return the ends (K, 2) of the times at which lines of sight may be near the body, and a miss was watched."""
        rows, width, middle = self.rows, self.radius / self._speed, self.rows.times
        for _ in range(_NEAREST):
            points = (self.rays_in_body(body, self.indices, middle + step * width)[0] for step in (-1.0, 0.0, 1.0))
            previous, value, following = (np.sum(w * w, axis=-1) for w in points)
            middle = middle - 0.5 * width * (following - previous) / (following - 2.0 * value + previous)
        ends = middle[:, None] + _LENGTH * width[:, None] * [-1.0, 1.0]
        watched = np.clip(ends, rows.interval[:, :1], rows.interval[:, 1:])
        return np.where((rows.sign == 0.0)[:, None], watched, ends)

    def _row_contacts(
        self, body: ApparentBody, k: int, ends: Floats, passages: list[list[Span] | None]
    ) -> _RowContacts:
        """Return the chord of a row that overlaps most with the observed one, or is nearest to it."""
        nodes = np.linspace(ends[0], ends[1], _INTERVALS + 1)

        def rays(times: Floats) -> tuple[Floats, Floats]:
            return self.rays_in_body(body, np.full(len(times), k), times)

        spans: list[tuple[Span, int]] = []
        for number, (limb, passage) in enumerate(zip(self.limbs, passages, strict=True)):

            def measure(times: Floats, limb: Limb = limb) -> Floats:
                return np.asarray(limb.measure(*rays(times)))

            if passage is None:
                passage = spans_below_zero(measure, dense_nodes(limb, nodes, *rays(nodes)))
            spans += [(span, number) for span in passage]
        if not spans:
            lengths = np.array([limb.length(limb.measure(*rays(nodes))) for limb in self.limbs])
            nearest, node = np.unravel_index(np.argmin(lengths), lengths.shape)
            return _RowContacts(float(nodes[node]), float(nodes[node]), (int(nearest), int(nearest)), True)
        observed = np.clip(self.rows.interval[k], *ends)

        def overlap(span: Span) -> float:
            return float(min(span[1], observed[1]) - max(span[0], observed[0]))

        chord = max(union([span for span, _ in spans]), key=overlap)
        first, last = (next(number for span, number in spans if span[side] == chord[side]) for side in (0, 1))
        return _RowContacts(*chord, (first, last), False)

    def _spans_of_straight_paths(self, body: ApparentBody, limb: Limb, ends: Floats) -> list[list[Span] | None]:
        """Return for each row the spans in which its ray is within an outline, from the crossings of a straight path.

        The attitude of the middle gives the crossings, which are then located with that of their own time. ``None``
        stands for a row for which this finds no crossing, or does not converge, as near a graze. Misses have no spans.
        """
        count, length = len(ends), ends[:, 1] - ends[:, 0]
        w, u, attitude = self.rays(body, np.tile(self.indices, 3), np.concatenate([*ends.T, ends.mean(axis=1)]))
        start, stop = (into_body(attitude[2 * count :], w[k * count : (k + 1) * count]) for k in (0, 1))
        row, shares = limb.crossings(start, into_body(attitude[2 * count :], u[2 * count :]), stop - start)
        # Between the crossings of a row there is a time at which its ray is inside or outside.
        breaks = np.sort(np.concatenate([np.arange(count + 1.0), row + shares]))
        between = 0.5 * (breaks[1:] + breaks[:-1])
        index = np.minimum(between.astype(np.intp), count - 1)
        inside = limb.measure(*self.rays_in_body(body, index, ends[index, 0] + length[index] * (between - index))) < 0.0
        same_row, changes = index[1:] == index[:-1], inside[1:] != inside[:-1]
        outer = ~np.concatenate([[False], same_row]) | ~np.concatenate([same_row, [False]])
        usable = np.bincount(row, minlength=count) > 0
        usable[index[outer & inside]] = False
        row, times = row[changes[same_row]], (ends[row, 0] + length[row] * shares)[changes[same_row]]
        step = np.zeros(len(times))
        for _ in range(_ITERATIONS if len(times) else 0):
            step = limb.measure(*self.rays_in_body(body, row, times)) / self.rates(body, row, times, limb)
            times = times - step
        usable[row[~(np.abs(step) <= _LAST_STEP * length[row])]] = False
        usable[row[1:][(row[1:] == row[:-1]) & ~(np.diff(times) > 0.0)]] = False
        spans: list[list[Span] | None] = []
        for k in self.indices:
            edges = times[row == k].tolist()
            pairs = list(zip(edges[::2], edges[1::2], strict=True)) if usable[k] else None
            spans.append([] if self.rows.sign[k] == 0.0 else pairs)
        return spans

    def linearised(self, body: ApparentBody, limbs: Sequence[Limb] | None = None) -> Any:
        """Return predictions (..., K) for changes of the body, or of its limbs, to first order about the contacts."""
        rows, is_miss = self.rows, np.array([contacts.is_miss for contacts in self._contacts])
        ends = []
        for side in (0, 1):
            times = np.array([contacts[side] for contacts in self._contacts])
            number = np.array([contacts.limbs[side] for contacts in self._contacts])
            ends.append((times, *self._measured(body, times, number, self.limbs if limbs is None else limbs)))
        begin, end = (times - measure / np.where(is_miss, np.inf, rate) for times, measure, rate, _ in ends)
        half = 0.5 * (end - begin)
        times, _, _, distance = ends[0]
        square = np.where(is_miss, -2.0 * self.radius * distance / self._speed**2, half * half)
        middle = 0.5 * (begin + end) + np.where(is_miss, self._change_of_nearest_time(body, times), 0.0)
        is_exact = ~is_miss & (np.real(half) >= rows.shortest)
        half = np.where(is_exact, half, continued(rows.shortest, square))
        depth = np.where(np.real(distance) < 0.0, -distance / self._speed, 0.0)
        return np.where(rows.sign == 0.0, depth, middle + rows.sign * half - rows.times)

    def _measured(
        self, body: ApparentBody, times: Floats, number: Indices, limbs: Sequence[Limb]
    ) -> tuple[Any, Floats, Any]:
        """Return measures (..., K) of chosen limbs at times (K,), their rates (K,), and the distances (..., K)."""
        w, u = self.rays_in_body(body, self.indices, times)
        measures = np.zeros(w.shape[:-1], dtype=w.dtype)
        distances, rates = np.zeros_like(measures), np.ones(len(times))
        for k in set(number.tolist()):
            index = np.flatnonzero(number == k)
            measure = limbs[k].measure(w[..., index, :], u[..., index, :])
            measures[..., index], distances[..., index] = measure, limbs[k].length(measure)
            rates[index] = self.rates(body, index, times[index], self.limbs[k])
        return measures, rates, distances

    def _change_of_nearest_time(self, body: ApparentBody, times: Floats) -> Any:
        """Return the changes (..., K) of the times at which the centre is nearest, for changes of the body alone."""
        w, step = self.rays_in_body(body, self.indices, times)[0], 1e-3 * self.radius / self._speed
        velocity = (self.rays_in_body(body.real, self.indices, times + step)[0] - w.real) / step[:, None]
        return -np.sum((w - w.real) * velocity, axis=-1) / np.sum(velocity * velocity, axis=-1)


def passage_of(rows: ContactRows, path: PathFunction, limbs: Sequence[Limb]) -> Passage:
    """Return the passage of lines of sight past a body of one part or several."""
    is_ellipsoid = len(limbs) == 1 and isinstance(limbs[0], EllipsoidLimb)
    return (EllipsoidContacts if is_ellipsoid else OutlineContacts)(rows, path, limbs)
