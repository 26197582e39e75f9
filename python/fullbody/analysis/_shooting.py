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
from ._pair import ROTATIONS, SPINS, Pair, PairPoint, SymmetryAxes, normalized, without_overlap

#: The largest number of steps of Newton's method, and how many in a row may fail to improve the orbit.
_MAX_STEPS, _MAX_FAILURES = 40, 6
#: The longest step in the units of :meth:`Shooting.units`, and the relative singular value that counts as zero.
_LONGEST, _UNKNOWN = 0.2, 1e-12
#: The quaternions of no rotation and of half turns about x, y and z.
_HALF_TURNS = np.eye(4)
#: The ends of the segments and their transition matrices (18, 18).
Ends: TypeAlias = "list[tuple[PairPoint, Floats]]"


def flow(point: PairPoint, time: float) -> tuple[PairPoint, Floats]:
    """Integrate a motion over a time and return the final point and the transition matrix (18, 18)."""
    pair = point.pair
    span = pair.context.units.attach(time, "time")
    run = pair.system.integrate(point.state, span, output="ends", derivatives=True)
    # A run's tangent vectors have position, velocity, rotation and spin of the first and of the second body.
    spread, gather = np.zeros((8, 6)), np.zeros((6, 8))
    spread[[0, 4], 0] = spread[[1, 5], 3] = pair.offsets
    gather[[0, 3], [0, 1]], gather[[0, 3], [4, 5]] = -1.0, 1.0
    rows, columns = [2, 6, 3, 7], [1, 2, 4, 5]
    spread[rows, columns] = gather[columns, rows] = 1.0
    transition = np.kron(gather, np.eye(3)) @ without_unit(run.transition)[-1] @ np.kron(spread, np.eye(3))
    return PairPoint.of(pair, run[-1]), transition


@dataclass
class Shooting:
    """Points along an orbit at equal times, its period, and the angle by which its end is rotated from its start."""

    points: list[PairPoint]
    period: float
    angle: float
    axes: SymmetryAxes
    #: The axis of each body's half turn: 0 for none, or 1 to 3 for x, y and z.
    half_turns: list[int]
    #: The rotation angles of the bodies about their axes of symmetry, in radians.
    body_angles: Floats

    @property
    def pair(self) -> Pair:
        return self.points[0].pair

    def units(self) -> Floats:
        """Return units (18,) of tangent vectors: the separation, its rate, and radians."""
        d = self.points[0].pose.distance
        sizes = np.repeat([d, 1.0], [3, 6])
        return np.concatenate([sizes, self.pair.orbital_rate(d) * sizes])

    def body_rotations(self) -> Floats:
        """Return the quaternions (2, 4) by which bodies rotate in their frames beside the rotation of the pair."""
        quaternions = _HALF_TURNS[self.half_turns]
        for k, axis in enumerate(self.axes):
            if axis is not None and axis < 3:
                quaternions[k] = rotations.about_axis(axis, float(self.body_angles[k]))
        return quaternions

    def target(self) -> PairPoint:
        """Return the state in which the orbit has to end: its start, rotated."""
        return self.points[0].rotated(rotations.about_axis(2, self.angle), self.body_rotations())

    def target_derivatives(self) -> tuple[Floats, Floats]:
        """Return derivatives of the target by the start (18, 18), and by the angle and the bodies' angles (18, 3)."""
        target, pose, by_angles = self.target(), np.zeros((9, 9)), np.zeros((18, 3))
        pose[:3, :3] = rotations.matrices(rotations.about_axis(2, self.angle))
        by_angles[:, 0] = target.symmetries()[:, 0]
        for k, body_rotation in enumerate(rotations.matrices(self.body_rotations())):
            pose[ROTATIONS[k], ROTATIONS[k]] = body_rotation.T
            axis = self.axes[k]
            if axis is not None and axis < 3:
                unit = np.eye(3)[axis]
                by_angles[ROTATIONS[k], 1 + k], by_angles[SPINS[k], 1 + k] = unit, -np.cross(unit, target.spin[k])
        return np.asarray(np.kron(np.eye(2), pose)), by_angles


def segmented(point: PairPoint, time: float, count: int) -> tuple[Shooting, Ends]:
    """Divide a motion into segments, in axes with z along the angular momentum, and choose the nearest target."""
    points: list[PairPoint] = [point]
    ends: Ends = []
    for _ in range(count):
        ends.append(flow(points[-1], time / count))
        points.append(ends[-1][0])
    end = points.pop()
    angle = float(np.arctan2(end.pose.r[1], end.pose.r[0]) - np.arctan2(point.pose.r[1], point.pose.r[0]))
    shooting = Shooting(points, time, angle, point.pair.axes(point.pose), [0, 0], np.zeros(2))
    attitudes = zip(shooting.target().pose.attitude, end.pose.attitude, strict=True)
    for k, (axis, (start, final)) in enumerate(zip(shooting.axes, attitudes, strict=True)):
        if axis is None:
            misfits = [rotations.between(rotations.product(start, half_turn), final) for half_turn in _HALF_TURNS]
            shooting.half_turns[k] = int(np.argmin(np.linalg.norm(misfits, axis=-1)))
        elif axis < 3:
            w, *q = rotations.product(rotations.inverse(start), final)
            shooting.body_angles[k] = 2 * np.arctan2(q[axis], w)
    return shooting, ends


def closed_orbit(
    shooting: Shooting, ends: Ends, held: dict[str, float], tolerance: float, normal: Floats | None = None
) -> tuple[Shooting, Ends, float]:
    """Find the orbit near a guess that has given values of the quantities held.

    Its segments' ends and its closure come with it. If a tangent vector ``normal`` is given, the start changes only
    within the plane normal to it.
    """
    count = len(ends)
    least, failures = np.inf, 0
    for _ in range(_MAX_STEPS):
        matrix, residual = _equations(shooting, ends, held, normal)
        closure = float(np.abs(residual).max())
        if closure <= tolerance and closure >= 0.1 * least:
            break
        failures = 0 if closure < 0.5 * least else failures + 1
        least = min(least, closure)
        if failures > _MAX_FAILURES:
            break
        step: Floats = np.asarray(np.linalg.lstsq(matrix, -residual, rcond=_UNKNOWN)[0])
        step *= min(1.0, _LONGEST / max(float(np.abs(step).max()), 1e-300))
        shooting, ends = without_overlap(partial(_stepped, shooting), step, 6)
    if closure > tolerance:
        period = shooting.pair.context.units.text(shooting.period, "time")
        raise NotConverged(
            f"no periodic orbit found: the best one of Newton's method does not close by {least:.2g}, of the "
            f"separation or in radians, and the last one has the period {period}; expected a start nearer to a "
            f"periodic orbit, more segments than {count}, or fewer quantities to hold"
        )
    return shooting, ends, closure


def _equations(shooting: Shooting, ends: Ends, held: dict[str, float], normal: Floats | None) -> tuple[Floats, Floats]:
    """Return the linear equations of a step (E, 18 K + 4) and their residuals (E,), in units of tangent vectors.

    They say that the segments meet, that quantities are held, and that the start does not move along the orbit or by
    symmetries. The unknowns are the tangent vectors of all points, the logarithm of the period, the angle, and the
    bodies' rotation angles about their axes.
    """
    count, units = len(ends), shooting.units()
    matrix = np.zeros((18 * count + len(held), 18 * count + 4))
    residual = np.zeros(len(matrix))
    start, by_angles = shooting.target_derivatives()
    for k, (end, transition) in enumerate(ends):
        rows = slice(18 * k, 18 * k + 18)
        last = k == count - 1
        target = shooting.target() if last else shooting.points[k + 1]
        residual[rows] = end.tangent_from(target) / units
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
            index = np.concatenate([numbers[:, ROTATIONS[k]], numbers[:, SPINS[k]]], axis=1).ravel()
            matrix[index], matrix[:, index], residual[index] = 0.0, 0.0, 0.0
    point = shooting.points[0]
    for row, (name, goal) in enumerate(held.items(), start=18 * count):
        if name == "period":
            matrix[row, 18 * count] = 1.0
            residual[row] = np.log(shooting.period / goal)
            continue
        gradient = point.energy_row() if name == "energy" else point.momentum_rows()[2]
        value = point.energy if name == "energy" else float(point.angular_momentum[2])
        unit = float(np.abs(gradient * units).max())
        matrix[row, :18] = gradient * units / unit
        residual[row] = (value - goal) / unit
    directions = np.column_stack([point.rates(), point.symmetries(shooting.axes)]).T / units
    directions = directions if normal is None else np.vstack([directions, normal / units])
    gauge = np.zeros((len(directions), matrix.shape[1]))
    gauge[:, :18] = normalized(directions)
    return np.concatenate([matrix, gauge]), np.concatenate([residual, np.zeros(len(gauge))])


def _stepped(shooting: Shooting, step: Floats) -> tuple[Shooting, Ends]:
    """Return the orbit after a step, or raise the error of bodies that overlap."""
    count = len(shooting.points)
    tangents = step[: 18 * count].reshape(-1, 18) * shooting.units()
    new = replace(
        shooting,
        points=[point.displaced(tangent) for point, tangent in zip(shooting.points, tangents, strict=True)],
        period=shooting.period * float(np.exp(step[18 * count])),
        angle=shooting.angle + float(step[18 * count + 1]),
        body_angles=shooting.body_angles + step[18 * count + 2 :],
    )
    return new, [flow(point, new.period / count) for point in new.points]
