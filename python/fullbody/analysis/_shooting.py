"""Multiple shooting: points along a periodic orbit, and Newton's method for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ..base import rotations
from ..base.tables import number
from ..errors import BodiesOverlap, NotConverged
from ..motion.system import System
from ..typing import Floats
from ._flow import SPINS, TURNS, Point, flow, generators, momentum_rows
from ._linear import even
from ._pair import Pair

__all__ = ["Ends", "Shooting", "begun", "solved"]

#: The largest number of steps of Newton's method, and how many in a row may fail to improve the orbit.
_STEPS, _LOST = 40, 6
#: The longest step in the units of :meth:`Shooting.units`, and the relative singular value that counts as zero.
_LONGEST, _UNKNOWN = 0.2, 1e-12
#: The quaternions of no rotation and of half turns about x, y and z.
_HALF_TURNS = np.eye(4)
#: The ends of the segments and their transition matrices (18, 18).
Ends: TypeAlias = list[tuple[Point, Floats]]


@dataclass
class Shooting:
    """Points along an orbit at equal times, its period, and the turn of its end relative to its start."""

    system: System
    pair: Pair
    points: list[Point]
    period: float
    angle: float
    axes: tuple[int | None, int | None]
    #: The index of the half turn of each body: 0 for none, or 1 to 3 for x, y and z.
    half: list[int]
    #: Turns of bodies about their axes of symmetry, in radians.
    own: Floats

    def units(self) -> Floats:
        """Units (18,) of tangent vectors: the separation, its rate, and radians."""
        d = self.points[0].pose.distance
        n = np.sqrt(self.pair.strength / (self.pair.mass * d**3))
        return np.concatenate([np.repeat([d, d * n], 3), np.repeat([1.0, n, 1.0, n], 3)])

    def own_turns(self) -> Floats:
        """Quaternions (2, 4) by which bodies turn in their frames in addition to the turn of the whole."""
        found = np.array([_HALF_TURNS[half] for half in self.half])
        for k, axis in enumerate(self.axes):
            if axis is not None and axis < 3:
                found[k] = rotations.turn(axis, float(self.own[k]))
        return found

    def target(self) -> Point:
        """The state in which the orbit has to end: its start, turned."""
        return self.points[0].turned(self.angle, self.own_turns())

    def target_derivatives(self) -> tuple[Floats, Floats]:
        """Return derivatives of the target with respect to the start (18, 18), and to the angle and the own turns (18,
        3).
        """
        target = self.target()
        whole = rotations.matrices(rotations.turn(2, self.angle))
        start, turns = np.zeros((18, 18)), np.zeros((18, 3))
        start[:3, :3] = start[3:6, 3:6] = whole
        turns[:, 0] = generators(target, (None, None))[:, 0]
        for k, own in enumerate(rotations.matrices(self.own_turns())):
            start[TURNS[k], TURNS[k]] = start[SPINS[k], SPINS[k]] = own.T
            axis = self.axes[k]
            if axis is not None and axis < 3:
                way = np.eye(3)[axis]
                turns[TURNS[k], 1 + k], turns[SPINS[k], 1 + k] = way, -np.cross(way, target.spin[k])
        return start, turns


def begun(system: System, pair: Pair, point: Point, time: float, count: int) -> tuple[Shooting, Ends]:
    """Divide a motion into segments, in axes with z along the angular momentum, and choose the nearest target."""
    axes = (pair.axis(0, point.pose), pair.axis(1, point.pose))
    points: list[Point] = [point]
    ends: Ends = []
    for _ in range(count):
        ends.append(flow(pair, points[-1], time / count))
        points.append(ends[-1][0])
    end = points.pop()
    angle = float(np.arctan2(end.pose.r[1], end.pose.r[0]) - np.arctan2(point.pose.r[1], point.pose.r[0]))
    shooting = Shooting(system, pair, points, time, angle, axes, [0, 0], np.zeros(2))
    whole = point.turned(angle, np.array([_HALF_TURNS[0]] * 2))
    for k in range(2):
        axis, back = axes[k], whole.pose.attitude[k]
        if axis is None:
            misses = [
                float(np.linalg.norm(rotations.between(rotations.product(back, half), end.pose.attitude[k])))
                for half in _HALF_TURNS
            ]
            shooting.half[k] = int(np.argmin(misses))
        elif axis is not None and axis < 3:
            w, *q = rotations.product(rotations.inverse(back), end.pose.attitude[k])
            shooting.own[k] = 2 * np.arctan2(q[axis], w)
    return shooting, ends


def solved(
    shooting: Shooting,
    ends: Ends,
    held: Sequence[str],
    kept: dict[str, float],
    within: float,
    across: Floats | None = None,
) -> tuple[Shooting, Ends, float]:
    """Find the orbit near a guess and return it with the ends of its segments and its closure; the start may be
    restricted to changes across a tangent vector.
    """
    count = len(ends)
    best, lost = np.inf, 0
    for _ in range(_STEPS):
        matrix, missing = _equations(shooting, ends, held, kept, across)
        closure = float(np.abs(missing).max())
        if closure <= within and closure >= 0.1 * best:
            break
        lost = 0 if closure < 0.5 * best else lost + 1
        best = min(best, closure)
        if lost > _LOST:
            break
        step: Floats = np.asarray(np.linalg.lstsq(matrix, -missing, rcond=_UNKNOWN)[0])
        step *= min(1.0, _LONGEST / max(float(np.abs(step).max()), 1e-300))
        shooting, ends = _stepped(shooting, step, count)
    if closure > within:
        period = number(shooting.pair.context.units.attach(np.float64(shooting.period), "time"))
        raise NotConverged(
            f"no periodic orbit found: the best that Newton's method came by misses its start by {best:.2g}, of the "
            f"separation or in radians, the last one after the period {period}; expected a start nearer to one, more "
            f"segments than {count}, or less to hold"
        )
    return shooting, ends, closure


def _equations(
    shooting: Shooting, ends: Ends, held: Sequence[str], kept: dict[str, float], across: Floats | None
) -> tuple[Floats, Floats]:
    """Return the linear equations of a step (E, 18 K + 4) and their residuals (E,), in units of tangent vectors. The
    equations are 18 K that the segments meet, one for each quantity held, and those that keep the start from moving
    along the orbit or by symmetries.

    The unknowns are the tangent vectors of all points, the logarithm of the period, the angle, and the bodies' own
    turns.
    """
    pair, count, units = shooting.pair, len(ends), shooting.units()
    matrix = np.zeros((18 * count + len(held), 18 * count + 4))
    missing = np.zeros(len(matrix))
    start, turns = shooting.target_derivatives()
    for k, (end, transition) in enumerate(ends):
        rows = slice(18 * k, 18 * k + 18)
        last = k == count - 1
        target = shooting.target() if last else shooting.points[k + 1]
        missing[rows] = end.less(target) / units
        matrix[rows, rows] += transition * units / units[:, np.newaxis]
        following = slice(0, 18) if last else slice(18 * k + 18, 18 * k + 36)
        matrix[rows, following] -= (start if last else np.eye(18)) * units / units[:, np.newaxis]
        matrix[rows, 18 * count] = end.rates(pair) * shooting.period / count / units
        if last:
            matrix[rows, 18 * count + 1 :] = -turns / units[:, np.newaxis]
    for k, axis in enumerate(shooting.axes):
        if axis == 3:
            for part in range(count):
                for rows in (TURNS[k], SPINS[k]):
                    place = slice(18 * part + rows.start, 18 * part + rows.stop)
                    matrix[place], missing[place] = 0.0, 0.0
                    matrix[:, place] = 0.0
    point = shooting.points[0]
    for row, name in enumerate(held, start=18 * count):
        if name == "period":
            matrix[row, 18 * count] = 1.0
            missing[row] = np.log(shooting.period / kept[name])
            continue
        slope = point.energy_row(pair) if name == "energy" else momentum_rows(pair, point)[2]
        value = point.energy(pair) if name == "energy" else float(point.angular_momentum(pair)[2])
        unit = float(np.abs(slope * units).max())
        matrix[row, :18] = slope * units / unit
        missing[row] = (value - kept[name]) / unit
    along = np.column_stack([point.rates(pair), generators(point, shooting.axes)]).T / units
    along = along if across is None else np.vstack([along, across / units])
    still = np.zeros((len(along), matrix.shape[1]))
    still[:, :18] = even(along)
    return np.concatenate([matrix, still]), np.concatenate([missing, np.zeros(len(still))])


def _stepped(shooting: Shooting, step: Floats, count: int) -> tuple[Shooting, Ends]:
    """Return the orbit after a step, which is shortened where the bodies would overlap."""
    units = shooting.units()
    for _ in range(6):
        points = [p.moved(step[18 * k : 18 * k + 18] * units) for k, p in enumerate(shooting.points)]
        period = shooting.period * float(np.exp(step[18 * count]))
        angle = shooting.angle + float(step[18 * count + 1])
        own = shooting.own + step[18 * count + 2 :]
        new = replace(shooting, points=points, period=period, angle=angle, own=own)
        try:
            return new, [flow(shooting.pair, point, period / count) for point in points]
        except BodiesOverlap as error:
            overlap = error
            step = step / 2
    raise overlap
