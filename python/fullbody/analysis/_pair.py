"""Two bodies in plain numbers of their system's units: poses, loads, symmetries, and motion near uniform rotation.

A tangent vector has 18 components: changes of the separation r, rotation vectors v_k of the bodies in their own frames,
changes of p = m dr/dt and of pi_k = I_k omega_k. They are measured in a frame that turns at Omega about z; the frame of
a body that is not locked turns back at its spin s_k about its axis e_k.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .. import _core
from ..base import rotations
from ..base.kinds import instance
from ..errors import InvalidInput
from ..model.composite import Composite
from ..model.failures import explaining
from ..model.polyhedron import Polyhedron
from ..model.stokes import StokesCoefficients
from ..motion.system import System
from ..typing import Floats

#: Moments of inertia that differ by less than this are equal; a torque below this, relative to G m m / r, is zero.
_EQUAL = 1e-10
#: Test angles in radians, not fractions of a full turn, by which a body is turned to test its symmetry about an axis.
_TEST_ANGLES = (0.3, 0.7, 1.1, 1.9, 2.6)
#: The tilt of the axis in this test in radians, and the least distance in radii, at which no turn makes contact.
_TILT, _CLEAR = 0.5, 1.05


def cross(v: Any) -> Floats:
    """Return the matrix of the vector product with v on the left."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _radius(core: _core.Body) -> float:
    """Return an upper bound of the distance of a body's points from its centre."""
    solids = (_core.Polyhedron, _core.StokesCoefficients)
    sizes = [
        np.linalg.norm(position) + (shape.circumradius if isinstance(shape, solids) else max(shape))
        for shape, _, position, _ in core.parts
        if shape is not None
    ]
    return float(max(sizes, default=0.0))


@dataclass(frozen=True)
class Pose:
    """The pose of two bodies in a frame that turns with them: their separation and both attitudes."""

    r: Floats
    attitude: Floats

    @cached_property
    def rotation(self) -> Floats:
        """The rotation matrices (2, 3, 3) from the body frames."""
        return rotations.matrices(self.attitude)

    @property
    def distance(self) -> float:
        return float(np.linalg.norm(self.r))

    def moved(self, by: Floats) -> Pose:
        """Return the pose after a change (9,): of the separation, and rotation vectors in both body frames."""
        attitude = rotations.products(self.attitude, rotations.of_vectors(np.reshape(by[3:9], (2, 3))))
        return Pose(self.r + by[:3], attitude / np.linalg.norm(attitude, axis=1, keepdims=True))


class Pair:
    """A system of two bodies without external forces.

    With m the reduced mass and r the separation, everything is a function of r, the attitudes, p = m dr/dt and the
    bodies' angular momenta pi_k = I_k omega_k in their own frames.
    """

    def __init__(self, system: System) -> None:
        instance(system, "system", System)
        if len(system) != 2:
            raise InvalidInput(f"the system has {len(system)} bodies; expected two")
        if system.forces:
            names = ", ".join(force.name for force in system.forces)
            raise InvalidInput(f"the system has external forces ({names}); expected system.with_forces([])")
        self.system, self.context = system, system.context
        self.masses: Floats = np.asarray(self.context.masses)
        self.total = float(self.masses.sum())
        self.mass = float(self.masses.prod() / self.total)
        self.strength = float(self.context.G * self.masses.prod())
        self.inertia: Floats = np.array([np.asarray(core.inertia) for core in self.context.bodies])
        self.reach = [_radius(core) for core in self.context.bodies]

    def state(self, pose: Pose, velocity: Any = (0.0, 0.0, 0.0), spin: Any = None, time: float = 0.0) -> _core.State:
        """Return the core's state of a pose, with the barycentre at rest in the origin."""
        shares = np.array([-self.masses[1], self.masses[0]])[:, np.newaxis] / self.total
        spin = np.zeros((2, 3)) if spin is None else np.asarray(spin)
        attitude = np.ascontiguousarray(pose.attitude)
        return _core.State(time, shares * pose.r, shares * np.asarray(velocity), attitude, spin)

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
        kept = [6, 7, 8, 3, 4, 5, 9, 10, 11]
        return full[np.ix_(kept, kept)]

    def is_point(self, body: int) -> bool:
        """Return whether a body is a point, which has no attitude."""
        return not self.inertia[body].any()

    def axis(self, body: int, pose: Pose) -> int | None:
        """Return a body's axis of symmetry, by its inertia and its torques: ``None`` without one, 3 for a sphere."""
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
        apart = max(1.0, _CLEAR * sum(self.reach) / pose.distance)
        first, column = 3 + 3 * body, 3 + 3 * body + axis
        tilt = _TILT * (np.eye(9)[first + (axis + 1) % 3] + 0.7 * np.eye(9)[first + (axis + 2) % 3])
        inclined = Pose(apart * pose.r, pose.attitude).moved(tilt)
        torque = max(abs(self.loads(inclined.moved(angle * np.eye(9)[column]))[0][column]) for angle in _TEST_ANGLES)
        return bool(torque <= _EQUAL * self.strength / inclined.distance)


#: The matrix of the vector product with the unit vector along z.
_UP = cross((0.0, 0.0, 1.0))
#: For both bodies the components of a tangent vector that hold the rotation vector, and those of the angular momentum.
TURNS = (slice(3, 6), slice(6, 9))
MOMENTA = (slice(12, 15), slice(15, 18))


def kernel(matrix: Floats, tolerance: float = 1e-10) -> Floats:
    """Return orthonormal columns that span the null space of a matrix."""
    _, values, rows = np.linalg.svd(matrix)
    rank = int(np.sum(values > tolerance * values.max(initial=0.0))) if len(values) else 0
    return rows[rank:].T


def complement(vectors: Floats) -> Floats:
    """Return orthonormal columns orthogonal to the given columns, which may be linearly dependent."""
    return kernel(vectors.T)


def free_rotations(axis: int | None) -> Floats:
    """Return rotation vectors (S, 3) of a body with an axis of symmetry that leave its gravity as it is."""
    return np.eye(3) if axis == 3 else np.zeros((0, 3)) if axis is None else np.eye(3)[[axis]]


@dataclass(frozen=True)
class Rotation:
    """A pose that turns uniformly about z, and the additional spins s_k of bodies about their axes of symmetry.

    ``axes`` has for each body its axis of symmetry, 3 for a sphere or a point, and ``None`` for a body without one;
    ``spin`` (2,) the s_k, which are zero for locked bodies; ``free`` whether each body is not locked.
    """

    pair: Pair
    pose: Pose
    rate: float
    axes: tuple[int | None, int | None]
    spin: Floats
    free: tuple[bool, bool]

    @property
    def omega(self) -> Floats:
        return np.array([0.0, 0.0, self.rate])

    @property
    def frame_spins(self) -> Floats:
        """The angular velocity Omega in both body frames (2, 3)."""
        return np.einsum("kji,j->ki", self.pose.rotation, self.omega)

    def axis(self, body: int) -> Floats:
        """Return the unit vector e_k (3,) of a body's additional spin in its frame; for a sphere it is along Omega."""
        axis = self.axes[body]
        return self.pose.rotation[body].T @ [0.0, 0.0, 1.0] if axis in (None, 3) else np.eye(3)[axis]

    @property
    def spins(self) -> Floats:
        """Return the angular velocities (2, 3) of the bodies in their frames."""
        return self.frame_spins + np.array([self.spin[k] * self.axis(k) for k in range(2)])

    @property
    def momenta(self) -> Floats:
        """Return the angular momenta pi_k (2, 3) of the bodies in their frames."""
        return self.pair.inertia * self.spins

    @property
    def velocity(self) -> Floats:
        """The rate of change dr/dt of the separation."""
        return cross(self.omega) @ self.pose.r

    @property
    def angular_momentum(self) -> Floats:
        """The total angular momentum (3,)."""
        spin_momentum = np.einsum("kij,kj->i", self.pose.rotation, self.momenta)
        return self.pair.mass * cross(self.pose.r) @ self.velocity + spin_momentum

    @cached_property
    def energy(self) -> float:
        kinetic = self.pair.mass * self.velocity @ self.velocity + np.sum(self.momenta * self.spins)
        return float(0.5 * kinetic + self.pair.loads(self.pose)[1])

    @property
    def units(self) -> Floats:
        """Units (18,) of tangent vectors: d, u_k = sqrt(m d^2 / I_k), m d n and m d^2 n / u_k, with n Kepler's rate."""
        d, m = self.pose.distance, self.pair.mass
        n = np.sqrt(self.pair.strength / (m * d**3))
        largest = self.pair.inertia.max(axis=1)
        rotation_sizes = np.sqrt(m * d * d / np.where(largest > 0.0, largest, m * d * d))
        return np.repeat([d, *rotation_sizes, m * d * n, *(m * d * d * n / rotation_sizes)], 3)

    def symmetries(self) -> Floats:
        """Return changes (9, S) of the pose that leave the system as it is: turns of the whole and about its axes."""
        columns = [np.concatenate([_UP @ self.pose.r, *(R[2] for R in self.pose.rotation)])]
        for body in range(2):
            for way in free_rotations(self.axes[body]):
                column = np.zeros(9)
                column[TURNS[body]] = way
                columns.append(column)
        return np.array(columns).T

    def rates(self) -> Floats:
        """The matrix (18, 18) of the linear equations of motion of tangent vectors."""
        pair, omega = self.pair, cross(self.omega)
        jacobian = pair.derivatives(self.pose)
        A = np.zeros((18, 18))
        A[:3, :3], A[:3, 9:12] = -omega, np.eye(3) / pair.mass
        A[9:12, :9], A[9:12, 9:12] = jacobian[:3], -omega
        for k, (v, p) in enumerate(zip(TURNS, MOMENTA, strict=True)):
            A[p, :9] = jacobian[v]
            if pair.is_point(k):
                continue
            inverse, frame_spin = np.diag(1.0 / pair.inertia[k]), cross(self.frame_spins[k])
            A[v, v], A[v, p] = -frame_spin, inverse
            A[p, p] = cross(self.momenta[k]) @ inverse - frame_spin
        return A

    def energy_form(self) -> Floats:
        """The matrix (18, 18) of twice the energy of tangent vectors, less Omega and s_k times their momenta."""
        pair = self.pair
        jacobian = pair.derivatives(self.pose)
        Q = np.zeros((18, 18))
        Q[:9, :9] = -(jacobian + jacobian.T) / 2
        Q[9:12, 9:12] = np.eye(3) / pair.mass
        # This is -Omega . (dr x dp).
        Q[:3, 9:12] = cross(self.omega)
        Q[9:12, :3] = -cross(self.omega)
        for k, (v, p) in enumerate(zip(TURNS, MOMENTA, strict=True)):
            if pair.is_point(k):
                continue
            frame_spin, momentum = self.frame_spins[k], self.momenta[k]
            # These are -Omega_k . (v x dpi) and -Omega_k . (v x (v x pi)) / 2.
            Q[p, p] = np.diag(1.0 / pair.inertia[k])
            Q[v, p], Q[p, v] = cross(frame_spin), -cross(frame_spin)
            both = np.outer(frame_spin, momentum)
            Q[v, v] += (frame_spin @ momentum) * np.eye(3) - (both + both.T) / 2
        return Q

    def momentum_rows(self) -> Floats:
        """Return the derivatives (3 + S, 18) of the total angular momentum and of conserved momenta of free bodies."""
        rows = np.zeros((3, 18))
        rows[:, :3] = -self.pair.mass * cross(self.velocity)
        rows[:, 9:12] = cross(self.pose.r)
        more = []
        for k, R in enumerate(self.pose.rotation):
            by_momenta = np.zeros((3, 18))
            by_momenta[:, TURNS[k]], by_momenta[:, MOMENTA[k]] = -cross(self.momenta[k]), np.eye(3)
            rows += R @ by_momenta
            more.append(free_rotations(self.axes[k]) @ by_momenta)
        return np.concatenate([rows, *more])

    def generators(self) -> Floats:
        """Return tangent vectors (18, S) of the turns in :meth:`symmetries`, which leave all rates as they are."""
        matrix = np.zeros((18, self.symmetries().shape[1]))
        matrix[:9] = self.symmetries()
        matrix[9:12, 0] = self.pair.mass * _UP @ self.velocity
        for k in range(2):
            # When a body turns, its angular momentum keeps its inertial direction and so turns back in the body frame.
            matrix[MOMENTA[k], 1:] = cross(self.momenta[k]) @ matrix[TURNS[k], 1:]
        return matrix

    def reduced(self) -> tuple[Floats, Floats, Floats]:
        """Return a basis (18, 2 M) of tangent vectors that change no conserved momentum and are no symmetry.

        With it, in :attr:`units`, come the matrices (2 M, 2 M) of their rates and of their energy.
        """
        units = self.units
        still = kernel(even(self.momentum_rows() * units))
        basis = still @ complement(still.T @ (self.generators() / units[:, np.newaxis]))
        A = self.rates() * units / units[:, np.newaxis]
        Q = self.energy_form() * np.outer(units, units)
        return basis * units[:, np.newaxis], basis.T @ A @ basis, basis.T @ Q @ basis

    def amended_hessian(self) -> tuple[Floats, Floats]:
        """Return eigenvalues (D,) of the Hessian of the amended potential, ascending, and its eigenvectors (9, D).

        V = U + J . I^-1 J / 2, with I the tensor of inertia of the whole, is the least energy of a pose with the total
        angular momentum J; bodies that are not locked keep theirs about their axes.
        """
        units = self.units
        Q = self.energy_form() * np.outer(units, units) / (units[9] ** 2 / self.pair.mass)
        rows = [row * units for row in self.momentum_rows()[:3]]
        kept = [9, 10, 11]
        for k, (v, p) in enumerate(zip(TURNS, MOMENTA, strict=True)):
            if self.pair.is_point(k) or (self.free[k] and self.axes[k] == 3):
                # A point has no angular momentum, and the one of a sphere that is not locked stays constant.
                Q[v], Q[:, v] = 0.0, 0.0
                for row in rows:
                    row[v] = 0.0
                continue
            kept += range(p.start, p.stop)
            if self.free[k]:
                row = np.zeros(18)
                row[p] = self.axis(k)
                rows.append(row)
        conserved = even(np.array(rows))
        P, mixed, R = Q[np.ix_(kept, kept)], Q[np.ix_(range(9), kept)], conserved[:, kept]
        # The momenta of least energy at a given pose are a particular solution that keeps the conserved momenta,
        # minimised over the remaining ones.
        free, best = kernel(R), -np.linalg.pinv(R) @ conserved[:, :9]
        best -= free @ np.linalg.solve(free.T @ P @ free, free.T @ (mixed.T + P @ best))
        V = Q[:9, :9] + mixed @ best + best.T @ mixed.T + best.T @ P @ best
        ways = complement(self.symmetries() / units[:9, np.newaxis])
        values, vectors = np.linalg.eigh(ways.T @ (V + V.T) @ ways / 2)
        return values, (ways @ vectors) * units[:9, np.newaxis]


def even(rows: Floats) -> Floats:
    """Return the rows scaled to length one."""
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)
