"""Two bodies in plain numbers of their system's units: poses, loads, derivatives and symmetries."""

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
