"""The rotating frame of a pair of bodies, and the field in it."""

from __future__ import annotations

import numpy as np

from .. import _core
from ..base.units import Units
from ..errors import InvalidInput, caution
from ..model.context import Context
from ..model.failures import explaining
from ..model.gravity import Gravity, gravity_at
from ..typing import Floats

#: Relative rates of change of accelerations or figures above which they do not rest in the frame.
_STEADY = 1e-3


class Frame:
    """The frame that turns with a pair of bodies, in numbers of the units of its system.

    It has an angular velocity, the ``rate``, and the ``distance`` between the bodies' centres, which are at ``centres``
    (2, 3) in it; ``origin`` and ``drift`` (3,) are position and velocity of the barycentre, inertial. The matrices
    ``rotation`` (3, 3) and ``attitudes`` (2, 3, 3) lead from the rotating frame and from the body frames to the
    inertial frame, and ``primary`` is the index of the heavier body.
    """

    def __init__(self, context: Context, core: _core.State) -> None:
        if len(context) != 2:
            raise InvalidInput(f"system has {len(context)} bodies; expected 2")
        self.context, masses = context, context.masses
        self.primary = int(masses[1] > masses[0])
        first, second = self.primary, 1 - self.primary
        shares = masses / masses.sum()
        self.origin, self.drift = shares @ core.position, shares @ core.velocity
        r, v = core.position[second] - core.position[first], core.velocity[second] - core.velocity[first]
        h = np.cross(r, v)
        self.distance = float(np.linalg.norm(r))
        if not np.linalg.norm(h) > 1e-12 * self.distance * np.linalg.norm(v):
            raise InvalidInput("the bodies move along a line; expected bodies that go round each other")
        self.rate = float(np.linalg.norm(h) / self.distance**2)
        x, z = r / self.distance, h / np.linalg.norm(h)
        self.rotation = np.stack([x, np.cross(z, x), z], axis=1)
        self._poses, self.attitudes = (core.position[None], core.attitude[None]), core.rotation_matrix
        self.centres = (core.position - self.origin) @ self.rotation
        self._check_rest(core)

    def _check_rest(self, core: _core.State) -> None:
        """Warn of a pair that is not at rest in the frame."""
        with explaining(self.context, core):
            force = self.context.core.interactions(core)[0]
        needed = -self.context.masses[:, None] * self.rate**2 * (self.centres * [1.0, 1.0, 0.0]) @ self.rotation.T
        off = float(np.abs(force - needed).max() / np.abs(needed).max())
        way = core.velocity[1] - core.velocity[0]
        radial = float(abs(way @ self.rotation[:, 0]) / np.linalg.norm(way))
        told = {
            f"their pull is off by {off:.2g} of what keeps them at rest in the rotating frame": off,
            f"they approach or recede at {radial:.2g} of their speed": radial,
        }
        large = ", and ".join(text for text, share in told.items() if share > _STEADY)
        deviations = [f"the bodies are not on a circular orbit ({large})"] if large else []
        for k, (turn, name) in enumerate(zip(core.rotation_matrix, self.context.names, strict=True)):
            spin, inertia = core.spin[k], turn @ np.diag(self.context.bodies[k].inertia) @ turn.T
            cross = np.cross(np.eye(3), turn @ spin - self.rate * self.rotation[:, 2])
            change = float(np.abs(inertia @ cross - cross @ inertia).max())
            if change > _STEADY * self.rate * float(np.abs(inertia).max()):
                deviations.append(f"{name} turns in the rotating frame, and its figure with it")
        if deviations:
            caution(f"{'; '.join(deviations)}: the rotating frame and the field in it are those of the moment")

    def jacobi(self, x: Floats) -> Floats:
        """Return Jacobi's constant at rest at points (..., 3) of the frame."""
        return 2.0 * self.gravity(x).potential + self.rate**2 * (x[..., 0] ** 2 + x[..., 1] ** 2)

    def gravity(self, x: Floats) -> Gravity:
        """Return gravity as numbers, at points of the frame and along inertial axes."""
        return gravity_at(self.context.attraction, *self._poses, self.origin + x @ self.rotation.T, Units())

    def acceleration_and_gradient(self, x: Floats) -> tuple[Floats, Floats]:
        """Return half the gradient of C, which is the acceleration at rest in the frame, and its derivatives."""
        gravity = self.gravity(x)
        outward = self.rate**2 * np.array([1.0, 1.0, 0.0])
        return (
            gravity.field @ self.rotation + outward * x,
            self.rotation.T @ gravity.gradient @ self.rotation + np.diag(outward),
        )
