"""States of the bodies at the times of observations: from a run, and when the observed light left each body."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _core
from ..base.rotations import matrices
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .vectors import SystemGeometry

#: Brightnesses need an observer who is farther from a body than its radius by this factor: all of its surface is seen
#: along one direction, and at that distance they are off by about 0.3 %.
DISTANT = 300.0
#: The square of an angle that counts as none, and the displacement relative to the separation of samples of a run.
_ROUNDING, _SAMPLED = 1e-15, 1e-14


def refuse_near(
    system: SystemLike,
    local: SystemGeometry,
    what: str,
    source: Floats,
    centre: Floats,
    attitude: Floats,
    times: Floats,
    orbits: float,
    sizes: float,
) -> None:
    """Raise an error for an observer, or a Sun, that is too near, or even inside a body.

    Parameters
    ----------
    system : System
    local : SystemGeometry
        The geometry. Where only the directions of its vectors count, the source just has to be outside the bodies.
    what : str
        The source, "observer" or "Sun", for the message.
    source : ndarray, (K, 3)
        Vectors from the barycentre to the source.
    centre, attitude : ndarray, (K, N, 3) and (K, N, 4)
        Poses of the bodies. Those other than ellipsoids count as ellipsoids with the same moments of inertia.
    times : ndarray, (K,)
        Times, for the message.
    orbits, sizes : float
        The least distance from the barycentre is the largest over all bodies of ``orbits`` times a body's own distance
        plus ``sizes`` times its radius.
    """
    axes = np.array([body.semi_axes for body in system.context.bodies])
    far = np.linalg.norm(source, axis=-1)
    if local.distant:
        orbits = sizes = 1.0
    least = np.max(orbits * np.linalg.norm(centre, axis=-1) + sizes * axes.max(axis=1), axis=1, initial=0.0)
    if np.any(far < least):
        away = np.einsum("knij,kni->knj", matrices(attitude), source[:, None] - centre)
        extents = np.where(axes > 0.0, axes, np.finfo(float).tiny)
        inside = np.argwhere(np.sum((away / extents) ** 2, axis=2) < 1.0)
        k, body = inside[0] if len(inside) else (int(np.argmin(far / least)), 0)
        if local.distant and not len(inside):
            return
        where = f"inside {system.context.names[body]}" if len(inside) else "too near"
        attach = system.context.units.attach
        raise InvalidInput(
            f"the {what} of the geometry is {where} at time {attach(float(times[k]), 'time')}, "
            f"{attach(float(far[k]), 'length')} from the barycentre; expected one from "
            f"{attach(float(least[k]), 'length')} on, with vectors from the barycentre in the system's unit of length"
        )


class RetardedStates:
    """States of bodies at their retarded times, when the light left them that arrives at the observer at given times.

    Each body is taken to move on a straight line and to rotate uniformly about its pose at the time of the states, up
    to the curvature that :func:`retarded` adds to these.

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
    elapsed : ndarray, (..., K, N)
        The time at which the light left each body, minus that of the given states.
    light_speed : float
        The speed of light in the system's units.
    """

    def __init__(
        self,
        geometry: SystemGeometry,
        times: Floats,
        masses: Floats,
        states: dict[str, Any],
        since: Floats | None = None,
    ) -> None:
        weights = masses / masses.sum()
        self.times, self.light_speed, self._geometry = times, geometry.light_speed, geometry
        self.observer = geometry.observer(times)
        position, velocity = (
            states[name] - np.einsum("n,...nx->...x", weights, states[name])[..., None, :]
            for name in ("position", "velocity")
        )
        #: The time of the states minus that at which the light left the barycentre, (K, 1) or zero.
        self._since: Any = 0.0 if since is None else since[:, None]
        if since is not None:
            position = position - velocity * since[:, None, None]
        self.delay = geometry.delays(self.observer, position, velocity)
        self.elapsed = self.delay - self._since
        self.centre, self.velocity = position + velocity * self.delay[..., None], velocity
        self._twist: Any = None
        if "curvature" in states:
            bend, change, self._twist = states["curvature"]
            self.centre, self.velocity = self.centre + bend, velocity + change

    @property
    def observer_velocity(self) -> Floats:
        """Velocity (K, 3) of the observer from the system's barycentre, which needs rows that are dense in time."""
        return self._geometry.observer_velocity(self.times)

    def attitude(self, attitude: Floats, spin: Floats) -> Floats:
        """Return attitudes (..., K, N, 4) when the light left the bodies, from those at the time of the states."""
        turned = rotated(attitude, spin, self.elapsed)
        return turned if self._twist is None else turned + self._twist


def rotated(attitude: Any, spin: Any, delay: Any) -> Any:
    """Return attitudes (..., 4) after times (...) of rotation at constant spins (..., 3); all may be complex."""
    angle = np.sqrt(np.sum(spin * spin, axis=-1)) * delay
    half_angle_factor = 0.5 * delay * np.sinc(0.5 * angle / np.pi)
    w, v = np.cos(0.5 * angle)[..., None], spin * half_angle_factor[..., None]
    scalar, vector = attitude[..., :1], attitude[..., 1:]
    real = scalar * w - np.sum(vector * v, axis=-1, keepdims=True)
    return np.concatenate([real, scalar * v + w * vector + np.cross(vector, v)], axis=-1)


def retarded(run: Record, local: SystemGeometry, times: Floats, what: str) -> tuple[dict[str, Any], RetardedStates]:
    """Return the states of a run for light that arrives at times (K,), and the retarded ones that follow from them.

    The former are those when the light left the barycentre, with the ``curvature`` of the motions from then until it
    left the bodies: what straight and uniform motions lack in positions, velocities and attitudes. It is that of a
    continuous solution, if the run has one. Otherwise positions follow from the forces of the bodies on each other,
    with an error of a sixth of the acceleration's rate of change times the cube of the delay, and attitudes from the
    spins.
    """
    emitted, masses = local.emission(times), run.context.masses
    states: dict[str, Any] = run.states(emitted, what)
    uniform = RetardedStates(local, times, masses, states)
    late = np.abs(uniform.delay).max(initial=0.0)
    if late == 0.0 or _is_straight(run, states, late):
        return states, uniform
    if run.dense is None:
        cores = (_core.State(0.0, *map(np.ascontiguousarray, rows)) for rows in zip(*states.values(), strict=True))
        force = np.array([run.context.core.interactions(core)[0] for core in cores])
        change = force / masses[:, None] * uniform.delay[..., None]
        states["curvature"] = 0.5 * change * uniform.delay[..., None], change, 0.0
        return states, RetardedStates(local, times, masses, states)
    twist = -uniform.attitude(states["attitude"], states["spin"])
    bend, change = -uniform.centre, -uniform.velocity
    first, last = sorted(run.dense.core.range)
    for body in range(len(run.context)):
        # Beyond the ends of a run its bodies go on straight.
        inside = np.clip(emitted + uniform.delay[:, body], first, last)
        states_inside = run.states(inside, what)
        exact = RetardedStates(local, times, masses, states_inside, inside - emitted)
        bend[:, body] += exact.centre[:, body]
        change[:, body] += exact.velocity[:, body]
        twist[:, body] += exact.attitude(states_inside["attitude"], states_inside["spin"])[:, body]
    states["curvature"] = bend, change, twist
    return states, RetardedStates(local, times, masses, states)


def _is_straight(run: Record, states: dict[str, Floats], late: float) -> bool:
    """Return whether the curvature of the motions within a time is below rounding."""
    position, count = states["position"], len(run.context)
    pairs = (position[:, i] - position[:, j] for i in range(count) for j in range(i))
    apart = [np.einsum("kx,kx->k", way, way).min() for way in pairs]
    fall = run.context.G * run.context.masses.sum() / min(apart) ** 1.5 if apart else 0.0
    if run.dense is None:
        # The samples have the errors of an integration, and attitudes follow from the spins.
        return bool(fall * late**2 < _SAMPLED)
    change = np.einsum("knx,knx->kn", states["spin"], states["spin"]).max()
    return bool((fall + change) * late**2 < _ROUNDING)
