"""States of the bodies at the times of observations: from a run, and when the observed light left each body."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..base.rotations import matrices
from ..errors import InvalidInput
from ..model.context import SystemLike
from .vectors import SystemGeometry

__all__ = ["RetardedStates", "refuse_near"]

_Array = npt.NDArray[np.float64]


#: An observer has to be so many times farther than any body reaches from the barycentre: each body is then seen along
#: one direction. At that distance durations of events and brightnesses are off by about 0.3 %.
_DISTANT = 300.0


def refuse_near(
    system: SystemLike,
    what: str,
    source: _Array,
    centre: _Array,
    attitude: _Array,
    times: _Array,
    light_speed: float,
) -> None:
    """Raise an error for an observer, or a Sun, that is too near, or even inside a body.

    Parameters
    ----------
    system : System
    what : str
        Which of the two it is.
    source : ndarray, (K, 3)
        Where it is.
    centre, attitude : ndarray, (K, N, 3) and (K, N, 4)
        Of the bodies at these times. Those other than ellipsoids count as ellipsoids with the same moments of inertia.
    times : ndarray, (K,)
    light_speed : float
        Infinite in a geometry without light time, of which only the directions count outside the bodies.
    """
    axes = np.array([body.semi_axes for body in system.context.bodies])
    far = np.linalg.norm(source, axis=-1)
    finite = np.isfinite(light_speed)
    least = (_DISTANT if finite else 1.0) * np.max(
        np.linalg.norm(centre, axis=-1) + axes.max(axis=1), axis=1, initial=0.0
    )
    if np.any(far < least):
        away = np.einsum("knij,kni->knj", matrices(attitude), source[:, None] - centre)
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
    """States of bodies at their retarded times, when the light left them that arrives at the observer at given times.

    Each body is taken to move on a straight line and to rotate uniformly about its pose at the time at which the light
    left the barycentre. The error by its acceleration is smaller by the square of the speed over that of light.

    Attributes
    ----------
    times : ndarray, (K,)
        Times when the light arrives.
    observer : ndarray, (K, 3)
        Vectors from the system's barycentre to the observer.
    centre, velocity : ndarray, (..., K, N, 3)
        Positions and velocities of the bodies relative to the system's barycentre. They may be complex, and several for
        each time.
    delay : ndarray, (..., K, N)
        The time at which the light left each body, minus the time at which it left the barycentre.
    light_speed : float
        The speed of light in the system's units.
    """

    def __init__(self, geometry: SystemGeometry, times: _Array, masses: _Array, states: dict[str, _Array]) -> None:
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
    def observer_velocity(self) -> _Array:
        """Velocity (K, 3) of the observer from the system's barycentre, which needs rows that are dense in time."""
        return self._geometry.observer_velocity(self.times)

    def attitude(self, attitude: _Array, spin: _Array) -> _Array:
        """Return attitudes (K, N, 4) when the light left the bodies, from those when it left the barycentre."""
        angle = np.linalg.norm(spin, axis=-1) * self.delay
        half_angle_factor = 0.5 * self.delay * np.sinc(0.5 * angle / np.pi)
        w, v = np.cos(0.5 * angle)[..., None], spin * half_angle_factor[..., None]
        scalar, vector = attitude[..., :1], attitude[..., 1:]
        real = scalar * w - np.sum(vector * v, axis=-1, keepdims=True)
        return np.concatenate([real, scalar * v + w * vector + np.cross(vector, v)], axis=-1)
