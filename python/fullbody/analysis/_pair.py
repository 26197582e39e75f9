"""Two bodies in plain numbers of their system's units: poses, motions, loads and symmetries.

A tangent vector has 18 components: changes of the separation r, rotation vectors of the bodies in their own frames, and
changes of dr/dt and of the spins. Pairs of nine numbers, such as loads and velocities, have the order of its halves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias, TypeVar

import numpy as np

import fullbody._core as _core

from ..base import rotations
from ..base.kinds import instance
from ..errors import BodiesOverlap, InvalidInput
from ..model.composite import Composite
from ..model.failures import explaining
from ..model.polyhedron import Polyhedron
from ..model.state import State, strip, wrap
from ..model.stokes import StokesCoefficients
from ..motion.system import System
from ..typing import Floats

_T = TypeVar("_T")
#: For each body its axis of symmetry (0, 1 or 2), 3 for a sphere or a point, and ``None`` for a body without one.
SymmetryAxes: TypeAlias = tuple[int | None, int | None]
#: For each body the components of a tangent vector that hold its rotation vector, and those that hold its spin.
ROTATIONS = (slice(3, 6), slice(6, 9))
SPINS = (slice(12, 15), slice(15, 18))
#: Moments of inertia that differ by less than this are equal; a torque below this, relative to G m m / r, is zero.
_EQUAL = 1e-10
#: Angles in radians, no fractions of a full turn, by which a body is rotated to test its symmetry about an axis.
_TEST_ANGLES = (0.3, 0.7, 1.1, 1.9, 2.6)
#: The tilt of the axis in this test in radians, and the least distance relative to that of contact.
_TILT, _CLEARANCE = 0.5, 1.05


def skew(v: Any) -> Floats:
    """Return the matrix (3, 3) of the vector product with v on the left."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def kernel(matrix: Floats) -> Floats:
    """Return orthonormal columns that span the kernel of a matrix."""
    _, values, rows = np.linalg.svd(matrix)
    return rows[int(np.sum(values > 1e-10 * values.max(initial=0.0))) :].T


def normalized(rows: Floats) -> Floats:
    """Return the rows divided by their lengths."""
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def without_symmetries(conserved: Floats, symmetries: Floats, units: Floats) -> Floats:
    """Return a basis (18, 2 M), in units, of tangent vectors that change nothing conserved and are no symmetry.

    The rows of ``conserved`` are gradients of conserved quantities, the columns of ``symmetries`` tangent vectors.
    """
    conserving = kernel(normalized(conserved * units))
    return conserving @ kernel(normalized((conserving.T @ (symmetries / units[:, np.newaxis])).T))


def without_overlap(displace: Callable[[Floats], _T], step: Floats, attempts: int = 8) -> _T:
    """Return the result of a step, which is halved a few times where the bodies would overlap."""
    for _ in range(attempts):
        try:
            return displace(step)
        except BodiesOverlap as error:
            overlap, step = error, step / 2
    raise overlap


@dataclass(frozen=True)
class Pose:
    """The pose of two bodies in a rotating frame: the separation (3,) from the first to the second, both attitudes."""

    r: Floats
    attitude: Floats

    @cached_property
    def rotation(self) -> Floats:
        """The rotation matrices (2, 3, 3) from the body frames."""
        return rotations.matrices(self.attitude)

    @property
    def distance(self) -> float:
        return float(np.linalg.norm(self.r))

    def displaced(self, change: Floats) -> Pose:
        """Return the pose after a change (9,): of the separation, and rotation vectors in both body frames."""
        attitude = rotations.products(self.attitude, rotations.of_vectors(np.reshape(change[3:9], (2, 3))))
        return Pose(self.r + change[:3], attitude / np.linalg.norm(attitude, axis=1, keepdims=True))


class Pair:
    """A system of two bodies without external forces, with their reduced mass ``mass``."""

    def __init__(self, system: System) -> None:
        instance(system, "system", System)
        if len(system) != 2:
            raise InvalidInput(f"the system has {len(system)} bodies; expected two")
        if system.forces:
            names = ", ".join(force.name for force in system.forces)
            raise InvalidInput(f"the system has external forces ({names}); expected system.with_forces([])")
        self.system, self.context = system, system.context
        masses: Floats = np.asarray(self.context.masses)
        #: The positions of both bodies from the barycentre, in units of the separation.
        self.offsets: Floats = np.array([-masses[1], masses[0]]) / masses.sum()
        self.mass = float(masses.prod() / masses.sum())
        self.strength = float(self.context.G * masses.prod())
        self.inertia: Floats = np.array([np.asarray(core.inertia) for core in self.context.bodies])
        #: The mass three times and both bodies' moments of inertia (9,), by which velocities become momenta.
        self.weights: Floats = np.concatenate([np.full(3, self.mass), self.inertia.ravel()])
        #: The sum of the radii of the spheres about the bodies' centres that contain the bodies.
        self.contact_distance = sum(core.circumradius for core in self.context.bodies)

    def state(self, pose: Pose, velocity: Any = (0.0, 0.0, 0.0), spin: Any = None) -> _core.State:
        """Return the core's state of a pose, with the barycentre at rest in the origin."""
        offsets, spin = self.offsets[:, np.newaxis], np.zeros((2, 3)) if spin is None else spin
        attitude = np.ascontiguousarray(pose.attitude)
        return _core.State(0.0, offsets * pose.r, offsets * np.asarray(velocity), attitude, spin)

    def loads(self, pose: Pose) -> tuple[Floats, float]:
        """Return the force on the second body with both torques (9,), and the potential energy."""
        state = self.state(pose)
        with explaining(self.context, state):
            force, torque, energy, _ = self.context.core.interactions(state)
        return np.concatenate([force[1], torque[0], torque[1]]), float(energy)

    def derivatives(self, pose: Pose) -> Floats:
        """Return the Jacobian (9, 9) of the loads with respect to the pose."""
        state = self.state(pose)
        with explaining(self.context, state):
            full = self.context.core.jacobian(state, [])[0]
        # The position of the second body and both rotation vectors; the core has these body by body.
        order = [6, 7, 8, 3, 4, 5, 9, 10, 11]
        return full[np.ix_(order, order)]

    def orbital_rate(self, distance: float) -> float:
        """Return the rate of a circular orbit of points at a distance."""
        return float(np.sqrt(self.strength / (self.mass * distance**3)))

    def axes(self, pose: Pose) -> SymmetryAxes:
        """Return the bodies' axes of symmetry, by their inertia and their torques near a pose."""
        return self._axis(0, pose), self._axis(1, pose)

    def _axis(self, body: int, pose: Pose) -> int | None:
        if isinstance(self.system.bodies[body].shape, Composite | Polyhedron | StokesCoefficients):
            axes = [axis for axis in range(3) if self._is_symmetric(body, axis, pose)]
        else:
            lengths = self.context.bodies[body].semi_axes
            axes = [k for k in range(3) if lengths[k - 1] == lengths[k - 2]]
        return 3 if len(axes) == 3 else axes[0] if axes else None

    def _is_symmetric(self, body: int, axis: int, pose: Pose) -> bool:
        moment, other = self.inertia[body][[axis - 1, axis - 2]]
        if abs(moment - other) > _EQUAL * max(moment, other):
            return False
        # The axis is inclined to the line of the centres, about which a sphere causes no torque on any body.
        stretch = max(1.0, _CLEARANCE * self.contact_distance / pose.distance)
        first, column = 3 + 3 * body, 3 + 3 * body + axis
        tilt = _TILT * (np.eye(9)[first + (axis + 1) % 3] + 0.7 * np.eye(9)[first + (axis + 2) % 3])
        inclined = Pose(stretch * pose.r, pose.attitude).displaced(tilt)
        rotated = [inclined.displaced(angle * np.eye(9)[column]) for angle in _TEST_ANGLES]
        torque = max(abs(self.loads(rotation)[0][column]) for rotation in rotated)
        return bool(torque <= _EQUAL * self.strength / inclined.distance)


def free_rotations(axis: int | None) -> Floats:
    """Return rotation vectors (S, 3) of a body with an axis of symmetry that leave its gravity as it is."""
    return np.eye(3) if axis == 3 else np.zeros((0, 3)) if axis is None else np.eye(3)[[axis]]


@dataclass(frozen=True)
class PairPoint:
    """A state of a pair whose barycentre is at rest, which gives conserved quantities and their derivatives."""

    pair: Pair
    pose: Pose
    velocity: Floats
    spin: Floats

    @classmethod
    def of(cls, pair: Pair, state: State, what: str = "state") -> PairPoint:
        """Return the point that belongs to a state of the system, whose barycentre may move."""
        core = strip(state, pair.context)
        if len(core.position) != 2:
            raise InvalidInput(f"{what} has {len(core.position)} bodies; expected two")
        r, v = (values[1] - values[0] for values in (core.position, core.velocity))
        return cls(pair, Pose(r, core.attitude), v, core.spin)

    @property
    def state(self) -> State:
        return wrap(self.pair.state(self.pose, self.velocity, self.spin), self.pair.context)

    @property
    def velocities(self) -> Floats:
        """The velocity dr/dt and both spins (9,)."""
        return np.concatenate([self.velocity, self.spin.ravel()])

    def displaced(self, tangent: Floats) -> PairPoint:
        """Return the point displaced by a tangent vector (18,)."""
        velocity, spin = self.velocity + tangent[9:12], self.spin + tangent[12:].reshape(2, 3)
        return PairPoint(self.pair, self.pose.displaced(tangent[:9]), velocity, spin)

    def rotated(self, rotation: Floats, body_rotations: Floats | None = None) -> PairPoint:
        """Return the point rotated by a quaternion, after rotations of the bodies in their frames, (2, 4)."""
        R = rotations.matrices(rotation)
        attitude, spin = self.pose.attitude, self.spin
        if body_rotations is not None:
            attitude = rotations.products(attitude, body_rotations)
            spin = np.einsum("kji,kj->ki", rotations.matrices(body_rotations), spin)
        pose = Pose(R @ self.pose.r, rotations.products(rotation, attitude))
        return PairPoint(self.pair, pose, R @ self.velocity, spin)

    def tangent_from(self, other: PairPoint) -> Floats:
        """Return the tangent vector (18,) from another point to this one, to first order in their difference."""
        vectors = rotations.between(other.pose.attitude, self.pose.attitude)
        return np.concatenate([self.pose.r - other.pose.r, vectors.ravel(), self.velocities - other.velocities])

    @cached_property
    def energy(self) -> float:
        return float(0.5 * self.pair.weights @ self.velocities**2 + self.pair.loads(self.pose)[1])

    @property
    def angular_momentum(self) -> Floats:
        """The total angular momentum (3,)."""
        spin_momentum = np.einsum("kij,kj->i", self.pose.rotation, self.pair.inertia * self.spin)
        return np.asarray(self.pair.mass * np.cross(self.pose.r, self.velocity) + spin_momentum)

    def rates(self) -> Floats:
        """Return the time derivatives of the point's numbers (18,)."""
        change, weights = self.pair.loads(self.pose)[0], self.pair.weights
        change[3:] -= np.cross(self.spin, self.pair.inertia * self.spin).ravel()
        # A point has no moments of inertia, and its spin is constant.
        accelerations = np.divide(change, weights, out=np.zeros(9), where=weights > 0.0)
        return np.concatenate([self.velocities, accelerations])

    def energy_row(self) -> Floats:
        """Return the gradient of the total energy (18,) with respect to a tangent vector."""
        return np.concatenate([-self.pair.loads(self.pose)[0], self.pair.weights * self.velocities])

    def momentum_rows(self, axes: SymmetryAxes = (None, None)) -> Floats:
        """Return the derivatives (3 + S, 18) of the total angular momentum and of the spins about axes of symmetry."""
        pair = self.pair
        rows = np.zeros((3, 18))
        rows[:, :3], rows[:, 9:12] = -pair.mass * skew(self.velocity), pair.mass * skew(self.pose.r)
        spins = [np.zeros((len(free_rotations(axis)), 18)) for axis in axes]
        for k, R in enumerate(self.pose.rotation):
            rows[:, ROTATIONS[k]] = -R @ skew(pair.inertia[k] * self.spin[k])
            rows[:, SPINS[k]] = R * pair.inertia[k]
            spins[k][:, SPINS[k]] = free_rotations(axes[k])
            if axes[k] == 3:
                # The spin of a sphere is counted in the inertial frame.
                spins[k][:, ROTATIONS[k]] = -skew(self.spin[k])
        return np.concatenate([rows, *spins])

    def symmetries(self, axes: SymmetryAxes = (None, None)) -> Floats:
        """Return tangent vectors (18, 1 + S): a rotation of the pair about z, those of bodies about symmetry axes."""
        z, poles = np.array([0.0, 0.0, 1.0]), self.pose.rotation[:, 2].ravel()
        columns = [np.concatenate([np.cross(z, self.pose.r), poles, np.cross(z, self.velocity), np.zeros(6)])]
        for k, axis in enumerate(axes):
            for vector in free_rotations(axis):
                column = np.zeros(18)
                # The spin keeps its inertial direction while the body frame rotates.
                column[ROTATIONS[k]], column[SPINS[k]] = vector, -np.cross(vector, self.spin[k])
                columns.append(column)
        return np.array(columns).T
