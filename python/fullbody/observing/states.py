"""States of the bodies at the times of observations: from a run, and when the observed light left each body."""

from __future__ import annotations

import numpy as np

from ..base.rotations import matrices
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .brightness import Epochs
from .vectors import SystemGeometry

__all__ = ["RetardedStates", "refuse_near"]


#: An observer has to be so many times farther than any body reaches from the barycentre: each body is then seen along
#: one direction. At that distance durations of events and brightnesses are off by about 0.3 %.
_DISTANT = 300.0


def refuse_near(
    system: SystemLike,
    what: str,
    place: Floats,
    centre: Floats,
    attitude: Floats,
    times: Floats,
    light_speed: float,
) -> None:
    """Raise an error for an observer, or a Sun, at places (K, 3) that are too near, or even inside a body.

    The centres (K, N, 3) and attitudes (K, N, 4) are those of the bodies, which count as ellipsoids with the same
    moments of inertia. The speed of light is infinite in a geometry without light time, of which only the directions
    count outside the bodies.
    """
    axes = np.array([body.semi_axes for body in system.context.bodies])
    far = np.linalg.norm(place, axis=-1)
    finite = np.isfinite(light_speed)
    least = (_DISTANT if finite else 1.0) * np.max(
        np.linalg.norm(centre, axis=-1) + axes.max(axis=1), axis=1, initial=0.0
    )
    if np.any(far < least):
        away = np.einsum("knij,kni->knj", matrices(attitude), place[:, None] - centre)
        sizes = np.where(axes > 0.0, axes, np.finfo(float).tiny)
        inside = np.argwhere(np.sum((away / sizes) ** 2, axis=2) < 1.0)
        k, body = inside[0] if len(inside) else (int(np.argmin(far / least)), 0)
        if not (finite or len(inside)):
            return
        where = f"inside {system.context.names[body]}" if len(inside) else "too near"
        attach = system.context.units.attach
        raise InvalidInput(
            f"the {what} of the geometry is {where} at time {attach(float(times[k]), 'time')}, "
            f"{attach(float(far[k]), 'length')} from the barycentre; expected a distant one, from "
            f"{attach(float(least[k]), 'length')}, with vectors from the barycentre in the system's unit of length"
        )


class RetardedStates:
    """States of bodies at their retarded times, when the light left them that arrives at the observer at given times
    (K,).

    Each body is taken to move on a straight line and to rotate uniformly about its pose at the time at which the light
    left the barycentre. The error by its acceleration is smaller by the square of the speed over that of light.

    Vectors to the ``observer`` (K, 3), and ``centre`` and ``velocity`` (..., K, N, 3) of the bodies, are relative to
    the system's barycentre; the latter may be complex, and several for each time. The ``delay`` (..., K, N) is the time
    at which the light left each body, minus the time at which it left the barycentre.
    """

    def __init__(self, geometry: SystemGeometry, times: Floats, masses: Floats, states: dict[str, Floats]) -> None:
        weights = masses / masses.sum()
        self.times, self.light_speed, self._geometry = times, geometry.light_speed, geometry
        self.observer = geometry.observer(times)
        position, self.velocity = (
            states[name] - np.einsum("n,...nx->...x", weights, states[name])[..., None, :]
            for name in ("position", "velocity")
        )
        self.delay = geometry.delays(self.observer, position, self.velocity)
        self.centre = position + self.velocity * self.delay[..., None]

    @property
    def observer_velocity(self) -> Floats:
        """Velocity (K, 3) of the observer from the system's barycentre, which needs rows that are dense in time."""
        return self._geometry.observer_velocity(self.times)

    def epochs(self, system: SystemLike, states: dict[str, Floats]) -> Epochs:
        """Return the bodies as observer and Sun see them, after checking that both are far away."""
        attitude, to_sun = self.attitude(states["attitude"], states["spin"]), self._geometry.sun(self.times)
        for what, place in (("observer", self.observer), ("Sun", to_sun)):
            refuse_near(system, what, place, self.centre, attitude, self.times, self.light_speed)
        return Epochs(self.times, self.centre, attitude, self.observer, to_sun, self.velocity / self.light_speed)

    def attitude(self, attitude: Floats, spin: Floats) -> Floats:
        """Return attitudes (K, N, 4) when the light left the bodies, from those when it left the barycentre."""
        angle = np.linalg.norm(spin, axis=-1) * self.delay
        turn = 0.5 * self.delay * np.sinc(0.5 * angle / np.pi)
        w, v = np.cos(0.5 * angle)[..., None], spin * turn[..., None]
        scalar, vector = attitude[..., :1], attitude[..., 1:]
        real = scalar * w - np.sum(vector * v, axis=-1, keepdims=True)
        return np.concatenate([real, scalar * v + w * vector + np.cross(vector, v)], axis=-1)
