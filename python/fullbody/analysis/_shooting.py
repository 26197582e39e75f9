"""Multiple shooting: the motion of a pair over a time with its derivatives, and Newton's method for periodic orbits.

A tangent vector has 18 components, in this order: changes of the separation r and of v = dr/dt, and for each body a
rotation vector in its body frame and the change of its spin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from ..base import rotations
from ..base.tables import number
from ..errors import BodiesOverlap, NotConverged
from ..model.state import strip, wrap
from ..typing import Floats
from ._pair import Pair, Pose, cross, even, free_rotations

#: For both bodies the rows of a tangent vector that hold the rotation vector, and those that hold the spin.
ROTATIONS = (slice(6, 9), slice(12, 15))
SPINS = (slice(9, 12), slice(15, 18))
#: The largest number of steps of Newton's method, and how many in a row may fail to improve the orbit.
_STEPS, _LOST = 40, 6
#: The longest step in the units of :meth:`Shooting.units`, and the relative singular value that counts as zero.
_LONGEST, _UNKNOWN = 0.2, 1e-12
#: The quaternions of no rotation and of half turns about x, y and z.
_HALF_ROTATIONS = np.eye(4)
#: The ends of the segments and their transition matrices (18, 18).
Ends: TypeAlias = "list[tuple[PairPoint, Floats]]"


@dataclass(frozen=True)
class PairPoint:
    """A state of a pair whose barycentre is at rest."""

    pose: Pose
    velocity: Floats
    spin: Floats

    @classmethod
    def of(cls, core: Any) -> PairPoint:
        """Return the point that belongs to a state of the core."""
        r, v = (values[1] - values[0] for values in (core.position, core.velocity))
        return cls(Pose(r, core.attitude), v, core.spin)

    def moved(self, by: Floats) -> PairPoint:
        """Return the point displaced by a tangent vector (18,)."""
        pose = self.pose.moved(np.concatenate([by[:3], by[ROTATIONS[0]], by[ROTATIONS[1]]]))
        return PairPoint(pose, self.velocity + by[3:6], self.spin + np.array([by[SPINS[0]], by[SPINS[1]]]))

    def rotated(self, angle: float, body_rotations: Floats) -> PairPoint:
        """Return the point turned about z, after turning the bodies in their frames by quaternions (2, 4)."""
        q = rotations.about_axis(2, angle)
        R = rotations.matrices(q)
        pairs = zip(self.pose.attitude, body_rotations, strict=True)
        attitude = np.array([rotations.product(q, a, rotation) for a, rotation in pairs])
        spin = np.einsum("kji,kj->ki", rotations.matrices(body_rotations), self.spin)
        return PairPoint(Pose(R @ self.pose.r, attitude), R @ self.velocity, spin)

    def less(self, other: PairPoint) -> Floats:
        """Return the tangent vector (18,) from another point to this one, to first order in their difference."""
        vector = np.zeros(18)
        vector[:3], vector[3:6] = self.pose.r - other.pose.r, self.velocity - other.velocity
        for k in range(2):
            vector[ROTATIONS[k]] = rotations.between(other.pose.attitude[k], self.pose.attitude[k])
            vector[SPINS[k]] = self.spin[k] - other.spin[k]
        return vector

    def rates(self, pair: Pair) -> Floats:
        """Return the time derivatives of the point's numbers (18,)."""
        loads, _ = pair.loads(self.pose)
        vector = np.zeros(18)
        vector[:3], vector[3:6] = self.velocity, loads[:3] / pair.mass
        for k in range(2):
            vector[ROTATIONS[k]] = self.spin[k]
            if not pair.is_point(k):
                moments = pair.inertia[k]
                torque = loads[3 + 3 * k : 6 + 3 * k] - np.cross(self.spin[k], moments * self.spin[k])
                vector[SPINS[k]] = torque / moments
        return vector

    def energy_row(self, pair: Pair) -> Floats:
        """Return the gradient of the total energy (18,) with respect to a tangent vector."""
        loads, _ = pair.loads(self.pose)
        vector = np.zeros(18)
        vector[:3], vector[3:6] = -loads[:3], pair.mass * self.velocity
        for k in range(2):
            vector[ROTATIONS[k]] = -loads[3 + 3 * k : 6 + 3 * k]
            vector[SPINS[k]] = pair.inertia[k] * self.spin[k]
        return vector

    def energy(self, pair: Pair) -> float:
        kinetic = pair.mass * self.velocity @ self.velocity + np.sum(pair.inertia * self.spin**2)
        return float(0.5 * kinetic + pair.loads(self.pose)[1])

    def angular_momentum(self, pair: Pair) -> Floats:
        """Return the total angular momentum (3,)."""
        spin_momentum = np.einsum("kij,kj->i", self.pose.rotation, pair.inertia * self.spin)
        return np.asarray(pair.mass * np.cross(self.pose.r, self.velocity) + spin_momentum)


def momentum_rows(pair: Pair, point: PairPoint) -> Floats:
    """Return the derivatives of the total angular momentum with respect to a tangent vector (3, 18)."""
    rows = np.zeros((3, 18))
    rows[:, :3], rows[:, 3:6] = -pair.mass * cross(point.velocity), pair.mass * cross(point.pose.r)
    for k, R in enumerate(point.pose.rotation):
        rows[:, ROTATIONS[k]] = -R @ cross(pair.inertia[k] * point.spin[k])
        rows[:, SPINS[k]] = R * pair.inertia[k]
    return rows


def generators(point: PairPoint, axes: tuple[int | None, int | None]) -> Floats:
    """Return tangent vectors (18, S) of a turn of the pair about z and of turns of bodies about their symmetry axes."""
    whole = np.zeros(18)
    whole[:3], whole[3:6] = np.cross([0.0, 0.0, 1.0], point.pose.r), np.cross([0.0, 0.0, 1.0], point.velocity)
    columns = [whole]
    for k in range(2):
        whole[ROTATIONS[k]] = point.pose.rotation[k][2]
        for way in free_rotations(axes[k]):
            column = np.zeros(18)
            # The spin keeps its inertial direction while the body turns beneath it.
            column[ROTATIONS[k]], column[SPINS[k]] = way, -np.cross(way, point.spin[k])
            columns.append(column)
    return np.array(columns).T


def flow(pair: Pair, point: PairPoint, time: float) -> tuple[PairPoint, Floats]:
    """Integrate a motion over a time and return the final point and the transition matrix (18, 18)."""
    system = pair.system
    start = wrap(pair.state(point.pose, point.velocity, point.spin), pair.context)
    run = system.integrate(start, pair.context.units.attach(time, "time"), output="ends", derivatives=True)
    end = PairPoint.of(strip(run[-1], pair.context))
    spread = np.zeros((24, 18))
    for body, share in enumerate((-pair.masses[1] / pair.total, pair.masses[0] / pair.total)):
        spread[12 * body : 12 * body + 6, :6] = share * np.eye(6)
        spread[12 * body + 6 : 12 * body + 12, 6 + 6 * body : 12 + 6 * body] = np.eye(6)
    gather = np.zeros((18, 24))
    gather[:6, :6], gather[:6, 12:18] = -np.eye(6), np.eye(6)
    gather[6:12, 6:12] = gather[12:, 18:] = np.eye(6)
    transition = np.asarray(getattr(run.transition, "value", run.transition))[-1]
    return end, gather @ transition @ spread


@dataclass
class Shooting:
    """Points along an orbit at equal times, its period, and the turn of its end relative to its start."""

    pair: Pair
    points: list[PairPoint]
    period: float
    angle: float
    axes: tuple[int | None, int | None]
    #: The index of the half turn of each body: 0 for none, or 1 to 3 for x, y and z.
    half: list[int]
    #: Turns of bodies about their axes of symmetry, in radians.
    body_angles: Floats

    def units(self) -> Floats:
        """Units (18,) of tangent vectors: the separation, its rate, and radians."""
        d = self.points[0].pose.distance
        n = np.sqrt(self.pair.strength / (self.pair.mass * d**3))
        return np.concatenate([np.repeat([d, d * n], 3), np.repeat([1.0, n, 1.0, n], 3)])

    def body_rotations(self) -> Floats:
        """Quaternions (2, 4) by which bodies turn in their frames in addition to the turn of the whole."""
        quaternions = np.array([_HALF_ROTATIONS[half] for half in self.half])
        for k, axis in enumerate(self.axes):
            if axis is not None and axis < 3:
                quaternions[k] = rotations.about_axis(axis, float(self.body_angles[k]))
        return quaternions

    def target(self) -> PairPoint:
        """The state in which the orbit has to end: its start, turned."""
        return self.points[0].rotated(self.angle, self.body_rotations())

    def target_derivatives(self) -> tuple[Floats, Floats]:
        """Return derivatives of the target by the start (18, 18), and by the angle and the own turns (18, 3)."""
        target = self.target()
        whole = rotations.matrices(rotations.about_axis(2, self.angle))
        start, by_angles = np.zeros((18, 18)), np.zeros((18, 3))
        start[:3, :3] = start[3:6, 3:6] = whole
        by_angles[:, 0] = generators(target, (None, None))[:, 0]
        for k, body_angles in enumerate(rotations.matrices(self.body_rotations())):
            start[ROTATIONS[k], ROTATIONS[k]] = start[SPINS[k], SPINS[k]] = body_angles.T
            axis = self.axes[k]
            if axis is not None and axis < 3:
                way = np.eye(3)[axis]
                by_angles[ROTATIONS[k], 1 + k], by_angles[SPINS[k], 1 + k] = way, -np.cross(way, target.spin[k])
        return start, by_angles


def begun(pair: Pair, point: PairPoint, time: float, count: int) -> tuple[Shooting, Ends]:
    """Divide a motion into segments, in axes with z along the angular momentum, and choose the nearest target."""
    axes = (pair.axis(0, point.pose), pair.axis(1, point.pose))
    points: list[PairPoint] = [point]
    ends: Ends = []
    for _ in range(count):
        ends.append(flow(pair, points[-1], time / count))
        points.append(ends[-1][0])
    end = points.pop()
    angle = float(np.arctan2(end.pose.r[1], end.pose.r[0]) - np.arctan2(point.pose.r[1], point.pose.r[0]))
    shooting = Shooting(pair, points, time, angle, axes, [0, 0], np.zeros(2))
    whole = point.rotated(angle, np.array([_HALF_ROTATIONS[0]] * 2))
    for k, axis in enumerate(axes):
        back, final = whole.pose.attitude[k], end.pose.attitude[k]
        if axis is None:
            ways = [rotations.between(rotations.product(back, half), final) for half in _HALF_ROTATIONS]
            shooting.half[k] = int(np.argmin([np.linalg.norm(way) for way in ways]))
        elif axis < 3:
            w, *q = rotations.product(rotations.inverse(back), final)
            shooting.body_angles[k] = 2 * np.arctan2(q[axis], w)
    return shooting, ends


def solved(
    shooting: Shooting,
    ends: Ends,
    held: Sequence[str],
    kept: dict[str, float],
    within: float,
    across: Floats | None = None,
) -> tuple[Shooting, Ends, float]:
    """Return the orbit near a guess with the ends of its segments and its closure; the start may change only across
    a tangent vector, if one is given.
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
    """Return the linear equations of a step (E, 18 K + 4) and their residuals (E,), in units of tangent vectors.

    They say that the segments meet, that quantities are held, and that the start does not move along the orbit or by
    symmetries. The unknowns are the tangent vectors of all points, the logarithm of the period, the angle, and the
    bodies' own turns.
    """
    pair, count, units = shooting.pair, len(ends), shooting.units()
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
        matrix[rows, 18 * count] = end.rates(pair) * shooting.period / count / units
        if last:
            matrix[rows, 18 * count + 1 :] = -by_angles / units[:, np.newaxis]
    # A sphere's attitude and spin are not searched.
    for k, axis in enumerate(shooting.axes):
        if axis == 3:
            each = np.arange(18 * count).reshape(count, 18)
            index = np.concatenate([each[:, ROTATIONS[k]], each[:, SPINS[k]]], axis=1).ravel()
            matrix[index], matrix[:, index], missing[index] = 0.0, 0.0, 0.0
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
        body_angles = shooting.body_angles + step[18 * count + 2 :]
        new = replace(shooting, points=points, period=period, angle=angle, body_angles=body_angles)
        try:
            return new, [flow(shooting.pair, point, period / count) for point in points]
        except BodiesOverlap as error:
            overlap = error
            step = step / 2
    raise overlap
