"""The motion of a pair over a time and its derivatives, in 18 numbers relative to the barycentre.

A tangent vector has 18 components, in this order: changes of the separation r and of v = dr/dt, and for each body a
rotation vector in its body frame and the change of its spin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import rotations
from ..model.state import strip, wrap
from ..typing import Floats
from ._pair import Pair, Pose, cross

#: For both bodies the rows of a tangent vector that hold the rotation vector, and those that hold the spin.
ROTATIONS = (slice(6, 9), slice(12, 15))
SPINS = (slice(9, 12), slice(15, 18))


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
        attitude = [
            rotations.product(q, a, rotation) for a, rotation in zip(self.pose.attitude, body_rotations, strict=True)
        ]
        spin = np.einsum("kji,kj->ki", rotations.matrices(body_rotations), self.spin)
        return PairPoint(Pose(R @ self.pose.r, np.array(attitude)), R @ self.velocity, spin)

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
    """Return tangent vectors (18, S) of a turn of the whole pair about z and of turns of bodies about their symmetry
    axes.
    """
    whole = np.zeros(18)
    whole[:3], whole[3:6] = np.cross([0.0, 0.0, 1.0], point.pose.r), np.cross([0.0, 0.0, 1.0], point.velocity)
    columns = [whole]
    for k in range(2):
        whole[ROTATIONS[k]] = point.pose.rotation[k][2]
        axis = axes[k]
        if axis is None:
            continue
        for way in np.eye(3) if axis == 3 else np.eye(3)[[axis]]:
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
