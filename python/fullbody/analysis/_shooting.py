"""Multiple shooting: the motion of a pair over a time with its derivatives, and Newton's method for periodic orbits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from ..base import rotations
from ..base.units import without_unit
from ..errors import NotConverged
from ..typing import Floats
from ._pair import SPINS, TURNS, Pair, PairPoint, SymmetryAxes, even, shortened

#: The largest number of steps of Newton's method, and how many in a row may fail to improve the orbit.
_STEPS, _LOST = 40, 6
#: The longest step in the units of :meth:`Shooting.units`, and the relative singular value that counts as zero.
_LONGEST, _UNKNOWN = 0.2, 1e-12
#: The quaternions of no rotation and of half turns about x, y and z.
_HALF_ROTATIONS = np.eye(4)
#: The ends of the segments and their transition matrices (18, 18).
Ends: TypeAlias = "list[tuple[PairPoint, Floats]]"


def flow(point: PairPoint, time: float) -> tuple[PairPoint, Floats]:
    """Integrate a motion over a time and return the final point and the transition matrix (18, 18)."""
    pair = point.pair
    span = pair.context.units.attach(time, "time")
    run = pair.system.integrate(point.state, span, output="ends", derivatives=True)
    # A run's tangent vectors have position, velocity, rotation and spin of the first and of the second body.
    spread, gather = np.zeros((8, 6)), np.zeros((6, 8))
    spread[[0, 4], 0] = spread[[1, 5], 3] = pair.shares
    gather[[0, 3], [0, 1]], gather[[0, 3], [4, 5]] = -1.0, 1.0
    rows, columns = [2, 6, 3, 7], [1, 2, 4, 5]
    spread[rows, columns] = gather[columns, rows] = 1.0
    transition = np.kron(gather, np.eye(3)) @ without_unit(run.transition)[-1] @ np.kron(spread, np.eye(3))
    return PairPoint.of(pair, run[-1]), transition


@dataclass
class Shooting:
    """Points along an orbit at equal times, its period, and the turn of its end relative to its start."""

    points: list[PairPoint]
    period: float
    angle: float
    axes: SymmetryAxes
    #: The index of the half turn of each body: 0 for none, or 1 to 3 for x, y and z.
    half: list[int]
    #: Turns of bodies about their axes of symmetry, in radians.
    body_angles: Floats

    @property
    def pair(self) -> Pair:
        return self.points[0].pair

    def units(self) -> Floats:
        """Units (18,) of tangent vectors: the separation, its rate, and radians."""
        d = self.points[0].pose.distance
        sizes = np.repeat([d, 1.0], [3, 6])
        return np.concatenate([sizes, self.pair.orbital_rate(d) * sizes])

    def body_rotations(self) -> Floats:
        """Quaternions (2, 4) by which bodies turn in their frames in addition to the turn of the whole."""
        quaternions = np.array([_HALF_ROTATIONS[half] for half in self.half])
        for k, axis in enumerate(self.axes):
            if axis is not None and axis < 3:
                quaternions[k] = rotations.about_axis(axis, float(self.body_angles[k]))
        return quaternions

    def target(self) -> PairPoint:
        """The state in which the orbit has to end: its start, turned."""
        return self.points[0].rotated(rotations.about_axis(2, self.angle), self.body_rotations())

    def target_derivatives(self) -> tuple[Floats, Floats]:
        """Return derivatives of the target by the start (18, 18), and by the angle and the bodies' turns (18, 3)."""
        target, pose, by_angles = self.target(), np.zeros((9, 9)), np.zeros((18, 3))
        pose[:3, :3] = rotations.matrices(rotations.about_axis(2, self.angle))
        by_angles[:, 0] = target.symmetries()[:, 0]
        for k, body_rotation in enumerate(rotations.matrices(self.body_rotations())):
            pose[TURNS[k], TURNS[k]] = body_rotation.T
            axis = self.axes[k]
            if axis is not None and axis < 3:
                way = np.eye(3)[axis]
                by_angles[TURNS[k], 1 + k], by_angles[SPINS[k], 1 + k] = way, -np.cross(way, target.spin[k])
        return np.asarray(np.kron(np.eye(2), pose)), by_angles


def begun(point: PairPoint, time: float, count: int) -> tuple[Shooting, Ends]:
    """Divide a motion into segments, in axes with z along the angular momentum, and choose the nearest target."""
    points: list[PairPoint] = [point]
    ends: Ends = []
    for _ in range(count):
        ends.append(flow(points[-1], time / count))
        points.append(ends[-1][0])
    end = points.pop()
    angle = float(np.arctan2(end.pose.r[1], end.pose.r[0]) - np.arctan2(point.pose.r[1], point.pose.r[0]))
    shooting = Shooting(points, time, angle, point.pair.axes(point.pose), [0, 0], np.zeros(2))
    for k, (axis, start, final) in enumerate(
        zip(shooting.axes, shooting.target().pose.attitude, end.pose.attitude, strict=True)
    ):
        if axis is None:
            ways = [rotations.between(rotations.product(start, half), final) for half in _HALF_ROTATIONS]
            shooting.half[k] = int(np.argmin([np.linalg.norm(way) for way in ways]))
        elif axis < 3:
            w, *q = rotations.product(rotations.inverse(start), final)
            shooting.body_angles[k] = 2 * np.arctan2(q[axis], w)
    return shooting, ends


def solved(
    shooting: Shooting, ends: Ends, held: dict[str, float], within: float, across: Floats | None = None
) -> tuple[Shooting, Ends, float]:
    """Return the orbit near a guess that has the values of the quantities held, with the ends of its segments and its
    closure; the start may change only across a tangent vector, if one is given.
    """
    count = len(ends)
    best, lost = np.inf, 0
    for _ in range(_STEPS):
        matrix, missing = _equations(shooting, ends, held, across)
        closure = float(np.abs(missing).max())
        if closure <= within and closure >= 0.1 * best:
            break
        lost = 0 if closure < 0.5 * best else lost + 1
        best = min(best, closure)
        if lost > _LOST:
            break
        step: Floats = np.asarray(np.linalg.lstsq(matrix, -missing, rcond=_UNKNOWN)[0])
        step *= min(1.0, _LONGEST / max(float(np.abs(step).max()), 1e-300))
        shooting, ends = shortened(partial(_stepped, shooting), step, 6)
    if closure > within:
        period = shooting.pair.context.units.text(shooting.period, "time")
        raise NotConverged(
            f"no periodic orbit found: the best that Newton's method came by misses its start by {best:.2g}, of the "
            f"separation or in radians, the last one after the period {period}; expected a start nearer to one, more "
            f"segments than {count}, or less to hold"
        )
    return shooting, ends, closure


def _equations(shooting: Shooting, ends: Ends, held: dict[str, float], across: Floats | None) -> tuple[Floats, Floats]:
    """Return the linear equations of a step (E, 18 K + 4) and their residuals (E,), in units of tangent vectors.

    They say that the segments meet, that quantities are held, and that the start does not move along the orbit or by
    symmetries. The unknowns are the tangent vectors of all points, the logarithm of the period, the angle, and the
    bodies' turns about their axes.
    """
    count, units = len(ends), shooting.units()
    matrix = np.zeros((18 * count + len(held), 18 * count + 4))
    missing = np.zeros(len(matrix))
    start, by_angles = shooting.target_derivatives()
    for k, (end, transition) in enumerate(ends):
        rows = slice(18 * k, 18 * k + 18)
        last = k == count - 1
        target = shooting.target() if last else shooting.points[k + 1]
        missing[rows] = end.less(target) / units
        matrix[rows, rows] += transition * units / units[:, np.newaxis]
        following = slice(0, 18) if last else slice(18 * k + 18, 18 * k + 36)
        matrix[rows, following] -= (start if last else np.eye(18)) * units / units[:, np.newaxis]
        matrix[rows, 18 * count] = end.rates() * shooting.period / count / units
        if last:
            matrix[rows, 18 * count + 1 :] = -by_angles / units[:, np.newaxis]
    # A sphere's attitude and spin are not searched.
    for k, axis in enumerate(shooting.axes):
        if axis == 3:
            numbers = np.arange(18 * count).reshape(count, 18)
            index = np.concatenate([numbers[:, TURNS[k]], numbers[:, SPINS[k]]], axis=1).ravel()
            matrix[index], matrix[:, index], missing[index] = 0.0, 0.0, 0.0
    point = shooting.points[0]
    for row, (name, goal) in enumerate(held.items(), start=18 * count):
        if name == "period":
            matrix[row, 18 * count] = 1.0
            missing[row] = np.log(shooting.period / goal)
            continue
        slope = point.energy_row() if name == "energy" else point.momentum_rows()[2]
        value = point.energy if name == "energy" else float(point.angular_momentum[2])
        unit = float(np.abs(slope * units).max())
        matrix[row, :18] = slope * units / unit
        missing[row] = (value - goal) / unit
    along = np.column_stack([point.rates(), point.symmetries(shooting.axes)]).T / units
    along = along if across is None else np.vstack([along, across / units])
    still = np.zeros((len(along), matrix.shape[1]))
    still[:, :18] = even(along)
    return np.concatenate([matrix, still]), np.concatenate([missing, np.zeros(len(still))])


def _stepped(shooting: Shooting, step: Floats) -> tuple[Shooting, Ends]:
    """Return the orbit after a step, or raise the error of bodies that overlap."""
    units, count = shooting.units(), len(shooting.points)
    new = replace(
        shooting,
        points=[p.moved(by * units) for p, by in zip(shooting.points, step[: 18 * count].reshape(-1, 18), strict=True)],
        period=shooting.period * float(np.exp(step[18 * count])),
        angle=shooting.angle + float(step[18 * count + 1]),
        body_angles=shooting.body_angles + step[18 * count + 2 :],
    )
    return new, [flow(point, new.period / count) for point in new.points]
