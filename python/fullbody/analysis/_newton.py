"""Newton's method for uniform rotations of a pair."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from ..errors import BodiesOverlap, NotConverged
from ..typing import Floats
from ._linear import Rotation
from ._pair import Pair, Pose, cross

Kind: TypeAlias = Literal["separation", "angular_momentum", "rate"]

_STEPS = 60
#: One step moves the centres by at most this fraction of their distance and turns bodies by at most as many radians.
_LONGEST = 0.2
#: Residuals relative to the forces: the one that counts as solved, and the one below which further steps are round-off.
_SOLVED, _ROUNDING = 1e-10, 1e-14
#: A matrix is singular if its smallest singular value is below this fraction of its largest one.
_SINGULAR = 1e-9


@dataclass(frozen=True)
class Condition:
    """The condition that selects one rotation of a family: a quantity and its value, in the system's units."""

    kind: Kind
    value: float


@dataclass(frozen=True)
class EquilibriumProblem:
    """The equations of uniform rotation, with the choice of locked bodies and the spins of the free ones.

    ``axes`` are those of :class:`Rotation`, and ``spin`` has the total spin about its axis of each body that is not
    locked.
    """

    pair: Pair
    axes: tuple[int | None, int | None]
    spin: dict[int, float]

    def rotation(self, pose: Pose, rate: float) -> Rotation:
        """Return the uniform rotation at a rate in a pose."""
        free = (0 in self.spin, 1 in self.spin)
        bare = Rotation(self.pair, pose, rate, self.axes, np.zeros(2), free)
        spins = [self.spin[k] - bare.frame_spins[k] @ bare.axis(k) if k in self.spin else 0.0 for k in range(2)]
        return Rotation(self.pair, pose, rate, self.axes, np.array(spins), free)

    def residual(self, rotation: Rotation) -> Floats:
        """Return the residual (9,) of uniform rotation: unbalanced force on the second body and torques."""
        pair, omega = self.pair, rotation.omega
        missing, _ = pair.loads(rotation.pose)
        missing[:3] -= pair.mass * cross(omega) @ rotation.velocity
        for k in range(2):
            missing[3 + 3 * k : 6 + 3 * k] -= cross(rotation.frame_spins[k]) @ rotation.momenta[k]
        return missing

    def jacobian(self, rotation: Rotation) -> Floats:
        """Return the Jacobian (9, 10) of the residual with respect to the pose and the rate."""
        pair, pose = self.pair, rotation.pose
        derivatives = np.zeros((9, 10))
        derivatives[:, :9] = pair.derivatives(pose)
        spin = cross(rotation.omega)
        derivatives[:3, :3] -= pair.mass * spin @ spin
        derivatives[:3, 9] = 2 * pair.mass * rotation.rate * pose.r * [1.0, 1.0, 0.0]
        for k in range(2):
            if self.axes[k] == 3:
                continue
            rows = slice(3 + 3 * k, 6 + 3 * k)
            frame_spin, momentum = rotation.frame_spins[k], rotation.momenta[k]
            frame_spin_by, spun = self._spin_derivatives(rotation, k)
            derivatives[rows] += cross(momentum) @ frame_spin_by - cross(frame_spin) @ (
                pair.inertia[k][:, np.newaxis] * spun
            )
        return derivatives

    def _spin_derivatives(self, rotation: Rotation, body: int) -> tuple[Floats, Floats]:
        """Return the derivatives (3, 10) of Omega and of the spin in a body's frame with respect to the pose and the
        rate.
        """
        frame_spin_by = np.zeros((3, 10))
        frame_spin_by[:, 3 + 3 * body : 6 + 3 * body] = cross(rotation.frame_spins[body])
        frame_spin_by[:, 9] = rotation.pose.rotation[body][2]
        if body not in self.spin:
            return frame_spin_by, frame_spin_by
        axis = rotation.axis(body)
        return frame_spin_by, frame_spin_by - np.outer(axis, axis @ frame_spin_by)

    def quantity(self, kind: Kind, rotation: Rotation) -> float:
        """Return the value of a quantity that selects a rotation."""
        if kind == "separation":
            return rotation.pose.distance
        return float(rotation.angular_momentum[2]) if kind == "angular_momentum" else rotation.rate

    def quantity_gradient(self, kind: Kind, rotation: Rotation) -> Floats:
        """Return the gradient (10,) of a quantity with respect to the pose and the rate."""
        derivatives = np.zeros(10)
        pose = rotation.pose
        if kind == "separation":
            derivatives[:3] = pose.r / pose.distance
        elif kind == "rate":
            derivatives[9] = 1.0
        else:
            across = pose.r * [1.0, 1.0, 0.0]
            derivatives[:3] = 2 * self.pair.mass * rotation.rate * across
            derivatives[9] = self.pair.mass * across @ across
            for k in range(2):
                pole = pose.rotation[k][2]
                spun = self._spin_derivatives(rotation, k)[1]
                derivatives += (pole * self.pair.inertia[k]) @ spun
                derivatives[3 + 3 * k : 6 + 3 * k] += rotation.momenta[k] @ cross(pole)
        return derivatives

    def scales(self, rotation: Rotation) -> tuple[Floats, Floats]:
        """Return the units of the residual (9,) and of the pose and the rate (10,)."""
        d = rotation.pose.distance
        force = self.pair.strength / d**2
        rate = np.sqrt(force / (self.pair.mass * d))
        return np.repeat([force, force * d], [3, 6]), np.repeat([d, 1.0, rate], [3, 6, 1])

    def equations(self, rotation: Rotation) -> tuple[Floats, Floats]:
        """Return the linear equations of Newton's step: matrix (9 + S, 10) and residuals (9 + S,).

        The last S rows keep the step from moving along symmetries. The equations are in the units of :meth:`scales`,
        but torques in units in which they change by about one in a radian.
        """
        rows, columns = self.scales(rotation)
        jacobian = self.jacobian(rotation) * columns
        for k in range(2):
            if self.axes[k] != 3:
                rows[3 + 3 * k : 6 + 3 * k] = np.abs(jacobian[3 + 3 * k : 6 + 3 * k]).max()
        jacobian /= rows[:, np.newaxis]
        still = rotation.symmetries() / columns[:9, np.newaxis]
        gauge = np.zeros((still.shape[1], 10))
        gauge[:, :9] = np.linalg.qr(still)[0].T
        missing = np.concatenate([self.residual(rotation) / rows, np.zeros(len(gauge))])
        return np.concatenate([jacobian, gauge]), missing


def converged(problem: EquilibriumProblem, guess: Rotation, condition: Condition) -> Rotation:
    """Find by Newton's method the uniform rotation near a guess at which a quantity has a given value.

    Raises
    ------
    NotConverged
        If the matrix of the steps is nearly singular, as at a fold in the quantity, or if nothing is found.
    BodiesOverlap
    """

    def row(rotation: Rotation, columns: Floats) -> tuple[Floats, float]:
        slope = problem.quantity_gradient(condition.kind, rotation) * columns
        unit = max(abs(condition.value), np.abs(slope).max())
        return slope / unit, (problem.quantity(condition.kind, rotation) - condition.value) / unit

    quantity = condition.kind.replace("_", " ")
    return _solved(problem, guess, row, f"{quantity} {condition.value:.9g}", quantity)


def corrected(problem: EquilibriumProblem, rotation: Rotation, tangent: Floats, length: float) -> Rotation:
    """Find the uniform rotation in the plane across a step (10,), which is in units of `scales`.

    Raises
    ------
    NotConverged, BodiesOverlap
        If the step is too long.
    """
    if length == 0.0:
        return rotation
    step = length * tangent * problem.scales(rotation)[1]
    guess = problem.rotation(rotation.pose.moved(step[:9]), rotation.rate + step[9])
    return _solved(problem, guess, lambda rotation, columns: (tangent, 0.0), "the branch", "the branch", 12)


def _solved(
    problem: EquilibriumProblem,
    rotation: Rotation,
    row: Callable[[Rotation, Floats], tuple[Floats, float]],
    wanted: str,
    quantity: str,
    most: int = _STEPS,
) -> Rotation:
    """Apply Newton's method with one additional equation, given by its row (10,) and its residual."""
    size = np.inf
    for _ in range(most):
        _, columns = problem.scales(rotation)
        last, lack = row(rotation, columns)
        matrix, missing = problem.equations(rotation)
        matrix, missing = np.concatenate([matrix, [last]]), np.append(missing, lack)
        previous, size = size, float(np.abs(missing).max())
        if size <= _ROUNDING or (size <= _SOLVED and size >= 0.5 * previous):
            return rotation
        left, values, right = np.linalg.svd(matrix, full_matrices=False)
        if values[-1] <= _SINGULAR * values[0]:
            raise NotConverged(
                f"a relative equilibrium of {wanted}: the matrix of Newton's step is singular (condition "
                f"{values[0] / max(values[-1], 1e-300):.2g}), as at a fold in {quantity}; expected another quantity to "
                "be given, or a start away from it"
            )
        step = -right.T @ ((left.T @ missing) / values)
        step *= min(1.0, _LONGEST / max(np.abs(step[:9]).max(), 1e-300))
        rotation = _moved(problem, rotation, step * columns)
    raise NotConverged(
        f"a relative equilibrium of {wanted}: not found in {most} steps of Newton's method, forces are out of balance "
        f"by {size:.2g} of their size; there may be none of this kind (fullbody.analysis.equilibria lists those of an "
        "angular momentum), or the start is too far from it"
    )


def _moved(problem: EquilibriumProblem, rotation: Rotation, step: Floats) -> Rotation:
    """Return the rotation after a step, which is shortened where the bodies would overlap."""
    for _ in range(8):
        pose = rotation.pose.moved(step[:9])
        try:
            problem.pair.loads(pose)
        except BodiesOverlap as error:
            overlap = error
            step = step / 2
        else:
            return problem.rotation(pose, rotation.rate + step[9])
    raise overlap
