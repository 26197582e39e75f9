"""The rotating frame of a pair of bodies, and the field in it."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.units import Units
from ..errors import InvalidInput, caution
from ..model.context import SystemLike
from ..model.gravity import Gravity, gravity_at, points_in
from ..model.interactions import interactions
from ..model.state import State, strip
from ..typing import Array, Scalar

__all__ = ["Frame"]

_Numbers = npt.NDArray[np.float64]
#: Relative rates of change of accelerations or figures above which they do not rest in the frame.
_STEADY = 1e-3


class Frame:
    """Base class of :class:`fullbody.fields.Synodic`: the frame itself."""

    def __init__(self, system: SystemLike, state: State) -> None:
        if len(system.context) != 2:
            raise InvalidInput(f"system has {len(system.context)} bodies; expected 2")
        self.system, self._state, self._units = system, state, system.context.units
        core, masses = strip(state, system.context), system.context.masses
        self._masses = masses
        self.primary = int(masses[1] > masses[0])
        first, second = self.primary, 1 - self.primary
        shares = masses / masses.sum()
        self._origin, self._drift = shares @ core.position, shares @ core.velocity
        r, v = core.position[second] - core.position[first], core.velocity[second] - core.velocity[first]
        h = np.cross(r, v)
        self._distance = float(np.linalg.norm(r))
        if not np.linalg.norm(h) > 1e-12 * self._distance * np.linalg.norm(v):
            raise InvalidInput("the bodies move along a line; expected bodies that go round each other")
        self._rate = float(np.linalg.norm(h) / self._distance**2)
        x, z = r / self._distance, h / np.linalg.norm(h)
        #: The matrix from the rotating frame to the inertial frame.
        self._turn = np.stack([x, np.cross(z, x), z], axis=1)
        self._poses, self._attitudes = (core.position[None], core.attitude[None]), core.rotation_matrix
        self._centres = (core.position - self._origin) @ self._turn
        self._bodies = system.context.bodies
        self._check_rest(core)

    def __reduce__(self) -> Any:
        # The warnings of a pair that is not at rest were given when it was made.
        return _remade, (type(self), self.system, self._state)

    def _check_rest(self, core: Any) -> None:
        """Warn of a pair that is not at rest in the frame."""
        force = self._units.strip(interactions(self.system, self._state).force, "force", "force")
        needed = -self._masses[:, None] * self._rate**2 * (self._centres * [1.0, 1.0, 0.0]) @ self._turn.T
        off = float(np.abs(force - needed).max() / np.abs(needed).max())
        way = core.velocity[1] - core.velocity[0]
        radial = float(abs(way @ self._turn[:, 0]) / np.linalg.norm(way))
        deviations = []
        told = {
            f"their pull is off by {off:.2g} of what keeps them at rest in the rotating frame": off,
            f"they approach or recede at {radial:.2g} of their speed": radial,
        }
        if large := [text for text, share in told.items() if share > _STEADY]:
            deviations.append(f"the bodies are not on a circular orbit ({', and '.join(large)})")
        for body, turn, spin, name in zip(
            self._bodies, core.rotation_matrix, core.spin, self.system.context.names, strict=True
        ):
            inertia = turn @ np.diag(body.inertia) @ turn.T
            cross = np.cross(np.eye(3), turn @ spin - self._rate * self._turn[:, 2])
            change = float(np.abs(inertia @ cross - cross @ inertia).max())
            if change > _STEADY * self._rate * float(np.abs(inertia).max()):
                deviations.append(f"{name} turns in the rotating frame, and its figure with it")
        if deviations:
            caution(f"{'; '.join(deviations)}: the rotating frame and the field in it are those of the moment")

    @property
    def rate(self) -> Scalar:
        """Angular velocity of the frame."""
        rate: Scalar = self._units.attach(self._rate, "spin")
        return rate

    @property
    def separation(self) -> Scalar:
        """Distance between the centres."""
        distance: Scalar = self._units.attach(self._distance, "length")
        return distance

    @property
    def position(self) -> Array:
        """Positions (2, 3) of the bodies' centres in the frame."""
        centres: Array = self._units.attach(self._centres, "length")
        return centres

    def to_inertial(self, points: Any, velocity: Any = None) -> tuple[Array, Array]:
        """Convert points of the frame, with velocities relative to it or at rest, to inertial positions and velocities.

        Parameters
        ----------
        points, velocity : array_like or Quantity, (..., 3)

        Returns
        -------
        position, velocity : ndarray or Quantity, (..., 3)
        """
        x = points_in(points, self._units)
        v = np.zeros(3) if velocity is None else self._units.strip(velocity, "velocity", "velocity")
        moving = v + self._rate * np.cross([0.0, 0.0, 1.0], x)
        place, speed = self._origin + x @ self._turn.T, self._drift + moving @ self._turn.T
        return self._units.attach(place, "length"), self._units.attach(speed, "velocity")

    def jacobi(self, points: Any, velocity: Any = None) -> Array:
        """Compute Jacobi's constant C = 2 Phi + Omega^2 (x^2 + y^2) - v^2 at points of the frame.

        Parameters
        ----------
        points : array_like or Quantity, (..., 3)
        velocity : array_like or Quantity, (..., 3), optional
            Velocities relative to the frame; zero by default.

        Returns
        -------
        ndarray or Quantity, (...)
        """
        found = self._jacobi(points_in(points, self._units))
        if velocity is not None:
            found = found - (self._units.strip(velocity, "velocity", "velocity") ** 2).sum(axis=-1)
        constant: Array = self._units.attach(found, "potential")
        return constant

    def _jacobi(self, x: _Numbers) -> _Numbers:
        value: _Numbers = 2.0 * self._gravity(x).potential + self._rate**2 * (x[..., 0] ** 2 + x[..., 1] ** 2)
        return value

    def _gravity(self, x: _Numbers) -> Gravity:
        """Return gravity as numbers, at points of the frame and along inertial axes."""
        return gravity_at(self.system.context.attraction, *self._poses, self._origin + x @ self._turn.T, Units())

    def _acceleration_and_gradient(self, x: _Numbers) -> tuple[_Numbers, _Numbers]:
        """Return half the gradient of C, which is the acceleration at rest in the frame, and its derivatives."""
        gravity = self._gravity(x)
        outward = self._rate**2 * np.array([1.0, 1.0, 0.0])
        return gravity.field @ self._turn + outward * x, self._turn.T @ gravity.gradient @ self._turn + np.diag(outward)

    def _is_inside(self, x: _Numbers) -> bool:
        """Return whether a point is within a body, where gravity has a source."""
        return bool(np.trace(self._gravity(x).gradient) < -0.01 * self._rate**2)


def _remade(kind: type[Frame], system: SystemLike, state: State) -> Frame:
    """Rebuild the frame of a copy or a pickle, without the warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return kind(system, state)
