"""Uniform rotation of a pair: its equations, which Newton's method solves, and the linear motion near it.

Motion near the rotation is described by tangent vectors with momenta, p = m dr/dt and pi_k = I_k omega_k, in place of
velocities. They are measured in a frame that turns at Omega about z; the frame of a body that is not locked turns back
at its additional spin about its axis e_k.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np

from ..typing import Floats
from ._pair import ROTATIONS, SPINS, Pair, PairPoint, Pose, SymmetryAxes, kernel, normalized, skew, without_symmetries

Kind: TypeAlias = Literal["separation", "angular_momentum", "rate"]


def _crosses(vectors: Iterable[Floats]) -> Floats:
    """Return the matrix (9, 9) of the vector products of three vectors with those on their right."""
    matrix = np.zeros((9, 9))
    for k, vector in enumerate(vectors):
        matrix[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = skew(vector)
    return matrix


@dataclass(frozen=True)
class Rotation:
    """A pose that rotates uniformly about z at a ``rate``.

    ``spin`` has the total spins of the bodies that are not locked about their axes of symmetry, by their indices.
    """

    pair: Pair
    pose: Pose
    rate: float
    axes: SymmetryAxes
    spin: dict[int, float]

    def at(self, pose: Pose, rate: float) -> Rotation:
        """Return the rotation with the same spins in another pose at another rate."""
        return replace(self, pose=pose, rate=rate)

    def stepped(self, step: Floats) -> Rotation:
        """Return the rotation after a change (10,) of the pose and the rate, or raise the error of an overlap."""
        rotation = self.at(self.pose.displaced(step[:9]), self.rate + step[9])
        self.pair.loads(rotation.pose)
        return rotation

    def balanced(self, pose: Pose) -> Rotation | None:
        """Return the rotation whose rate balances the force along the line, or ``None`` where that force repels."""
        loads, _ = self.pair.loads(pose)
        inward = -float(loads[:3] @ pose.r) / (self.pair.mass * float(pose.r[:2] @ pose.r[:2]))
        return self.at(pose, np.sqrt(inward)) if inward > 0.0 else None

    @cached_property
    def frame_spins(self) -> Floats:
        """The angular velocity Omega in both body frames (2, 3)."""
        return self.rate * self.pose.rotation[:, 2]

    def axis(self, body: int) -> Floats:
        """Return the unit vector e_k (3,) of a body's additional spin in its frame; for a sphere it is along Omega."""
        axis = self.axes[body]
        return self.pose.rotation[body][2] if axis in (None, 3) else np.eye(3)[axis]

    @cached_property
    def point(self) -> PairPoint:
        """The state of the pair."""
        spins = self.frame_spins.copy()
        for k, total in self.spin.items():
            spins[k] += (total - spins[k] @ self.axis(k)) * self.axis(k)
        return PairPoint(self.pair, self.pose, np.cross([0.0, 0.0, self.rate], self.pose.r), spins)

    def displaced(self, change: Floats) -> PairPoint:
        """Return the state of the pair after a change (18,) of the pose and the momenta."""
        return self.point.displaced(np.concatenate([change[:9], change[9:] / self._weights]))

    @cached_property
    def _weights(self) -> Floats:
        """The mass and the moments of inertia (9,); those of a point, which no result depends on, are above zero."""
        return np.where(self.pair.weights > 0.0, self.pair.weights, self.pair.mass * self.pose.distance**2)

    @cached_property
    def _frame(self) -> Floats:
        """The matrix (9, 9) of the vector products with Omega, in the inertial frame and in both body frames."""
        return _crosses([np.array([0.0, 0.0, self.rate]), *self.frame_spins])

    @property
    def _momenta(self) -> Floats:
        return self._weights * self.point.velocities

    def residual(self) -> Floats:
        """Return the residual (9,) of uniform rotation: unbalanced force on the second body and torques."""
        return self.pair.loads(self.pose)[0] - self._frame @ (self.pair.weights * self.point.velocities)

    def jacobian(self) -> Floats:
        """Return the Jacobian (9, 10) of the residual with respect to the pose and the rate."""
        frame, velocities = self._velocity_derivatives()
        inertial = _crosses(self._momenta.reshape(3, 3)) @ frame - self._frame @ (self._weights[:, None] * velocities)
        for k, axis in enumerate(self.axes):
            if axis == 3:
                inertial[ROTATIONS[k]] = 0.0
        inertial[:, :9] += self.pair.derivatives(self.pose)
        return inertial

    def _velocity_derivatives(self) -> tuple[Floats, Floats]:
        """Return the derivatives (9, 10) by the pose and the rate of Omega in the three frames, and of velocities."""
        poles = self.pose.rotation[:, 2].ravel()
        frame = np.column_stack([self._frame, np.concatenate([[0.0, 0.0, 1.0], poles])])
        frame[:3, :9] = 0.0
        velocities = np.column_stack([self._frame, np.concatenate([np.cross([0.0, 0.0, 1.0], self.pose.r), poles])])
        for k in self.spin:
            axis, rows = self.axis(k), frame[ROTATIONS[k]]
            velocities[ROTATIONS[k]] = rows - np.outer(axis, axis @ rows)
        return frame, velocities

    def quantity(self, kind: Kind) -> float:
        """Return the value of a quantity that selects a rotation."""
        if kind == "separation":
            return self.pose.distance
        return float(self.point.angular_momentum[2]) if kind == "angular_momentum" else self.rate

    def quantity_gradient(self, kind: Kind) -> Floats:
        """Return the gradient (10,) of a quantity with respect to the pose and the rate."""
        if kind == "rate":
            return np.eye(10)[9]
        if kind == "separation":
            return np.concatenate([self.pose.r / self.pose.distance, np.zeros(7)])
        row = self.point.momentum_rows()[2]
        return np.append(row[:9], 0.0) + row[9:] @ self._velocity_derivatives()[1]

    def scales(self) -> tuple[Floats, Floats]:
        """Return the units of the residual (9,) and of the pose and the rate (10,)."""
        d = self.pose.distance
        force = self.pair.strength / d**2
        return np.repeat([force, force * d], [3, 6]), np.repeat([d, 1.0, self.pair.orbital_rate(d)], [3, 6, 1])

    def equations(self) -> tuple[Floats, Floats]:
        """Return the linear equations of Newton's step: matrix (9 + S, 10) and residuals (9 + S,).

        The last S rows keep the step from moving along symmetries. The equations are in the units of :meth:`scales`,
        but torques in units in which they change by about one in a radian.
        """
        rows, columns = self.scales()
        jacobian = self.jacobian() * columns
        for k, axis in enumerate(self.axes):
            if axis != 3:
                rows[ROTATIONS[k]] = np.abs(jacobian[ROTATIONS[k]]).max()
        jacobian /= rows[:, np.newaxis]
        symmetries = self.point.symmetries(self.axes)[:9] / columns[:9, np.newaxis]
        gauge = np.zeros((symmetries.shape[1], 10))
        gauge[:, :9] = np.linalg.qr(symmetries)[0].T
        residual = np.concatenate([self.residual() / rows, np.zeros(len(gauge))])
        return np.concatenate([jacobian, gauge]), residual

    @property
    def units(self) -> Floats:
        """Units (18,) of tangent vectors: d, u_k = sqrt(m d^2 / I_k), m d n and m d^2 n / u_k, with n Kepler's rate."""
        d, m = self.pose.distance, self.pair.mass
        sizes = np.array([d, *np.sqrt(m * d * d / self._weights[3:].reshape(2, 3).max(axis=1))])
        return np.repeat([*sizes, *(m * d * d * self.pair.orbital_rate(d) / sizes)], 3)

    def rates(self) -> Floats:
        """Return the matrix (18, 18) of the linear equations of motion of tangent vectors."""
        inverse = np.diag(1.0 / self._weights)
        momentum_rows = [self.pair.derivatives(self.pose), self._spin_momenta() @ inverse - self._frame]
        return np.block([[-self._frame, inverse], momentum_rows])

    def energy_form(self) -> Floats:
        """Return the matrix (18, 18) of twice the energy of tangent vectors, less Omega and s_k times their momenta."""
        # The parts are -Omega . (dr x dp) and -Omega_k . (v x dpi), and -Omega_k . (v x (v x pi)) / 2.
        forces = self.pair.derivatives(self.pose) + self._frame @ self._spin_momenta()
        return np.block([[-(forces + forces.T) / 2, self._frame], [self._frame.T, np.diag(1.0 / self._weights)]])

    def _spin_momenta(self) -> Floats:
        """Return the matrix (9, 9) of the vector products with the bodies' angular momenta."""
        return _crosses([np.zeros(3), *self._momenta[3:].reshape(2, 3)])

    def _momentum_rows(self, axes: SymmetryAxes = (None, None)) -> Floats:
        """Return the derivatives (3 + S, 18) of conserved angular momenta by tangent vectors."""
        rows = self.point.momentum_rows(axes)
        rows[:, 9:] /= self._weights
        return rows

    def generators(self) -> Floats:
        """Return tangent vectors (18, 1 + S) of the symmetries of the system, which leave all rates as they are."""
        columns = self.point.symmetries(self.axes)
        columns[9:] *= self._weights[:, np.newaxis]
        return columns

    def reduced(self) -> tuple[Floats, Floats, Floats]:
        """Return a basis (18, 2 M) of tangent vectors that change no conserved momentum and are no symmetry.

        With it, in :attr:`units`, come the matrices (2 M, 2 M) of their rates and of their energy.
        """
        units = self.units
        basis = without_symmetries(self._momentum_rows(self.axes), self.generators(), units)
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
        rows = [*self._momentum_rows()]
        momenta = [9, 10, 11]
        for k, (v, p) in enumerate(zip(ROTATIONS, SPINS, strict=True)):
            if not self.pair.inertia[k].any() or (k in self.spin and self.axes[k] == 3):
                # A point has no angular momentum, and the one of a sphere that is not locked stays constant.
                Q[v], Q[:, v] = 0.0, 0.0
                for row in rows:
                    row[v] = 0.0
                continue
            momenta += range(p.start, p.stop)
            if k in self.spin:
                row = np.zeros(18)
                row[p] = self.axis(k)
                rows.append(row)
        conserved = normalized(np.array(rows) * units)
        P, mixed, R = Q[np.ix_(momenta, momenta)], Q[np.ix_(range(9), momenta)], conserved[:, momenta]
        # The momenta of least energy at a given pose are a particular solution that keeps the conserved momenta,
        # minimised over the remaining ones.
        free, least = kernel(R), -np.linalg.pinv(R) @ conserved[:, :9]
        least -= free @ np.linalg.solve(free.T @ P @ free, free.T @ (mixed.T + P @ least))
        V = Q[:9, :9] + mixed @ least + least.T @ mixed.T + least.T @ P @ least
        basis = kernel((self.generators()[:9] / units[:9, np.newaxis]).T)
        values, vectors = np.linalg.eigh(basis.T @ (V + V.T) @ basis / 2)
        return values, (basis @ vectors) * units[:9, np.newaxis]
