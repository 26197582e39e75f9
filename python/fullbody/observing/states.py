"""States of the bodies at the times of observations: from a run, and when the observed light left each body."""

from __future__ import annotations

from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.rotations import matrices, products
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..record.record import Record
from ..typing import Floats
from .vectors import SystemGeometry

#: Brightnesses need an observer who is farther from a body than its radius by this factor: all of its surface is seen
#: along one direction, and at that distance they are off by about 0.3 %.
DISTANT = 300.0
#: The step of a derivative along the imaginary axis, which subtracts no nearly equal numbers.
IMAGINARY_STEP = 1e-100
#: The indices of the next component of a vector, and of the one before, in cyclic order.
_NEXT, _PREVIOUS = np.array([1, 2, 0]), np.array([2, 0, 1])
#: The relative deviations from uniform motion that are neglected: for a continuous solution, and for samples of a run.
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
    """Raise an error for a source, the "observer" or the "Sun", that is too near to the bodies, or even inside one.

    The ``source`` (K, 3) is the vector to it from the barycentre at times (K,), and ``centre`` (K, N, 3) and
    ``attitude`` (K, N, 4) are the poses of the bodies. The least distance is the largest over all bodies of ``orbits``
    times a body's own distance plus ``sizes`` times its radius. Where only the directions of the vectors of the
    geometry count, the source just has to be outside the bodies. Those other than ellipsoids count as ellipsoids with
    the same moments of inertia.
    """
    axes = np.array([body.semi_axes for body in system.context.bodies])
    distance = np.linalg.norm(source, axis=-1)
    if local.distant:
        orbits = sizes = 1.0
    least = np.max(orbits * np.linalg.norm(centre, axis=-1) + sizes * axes.max(axis=1), axis=1, initial=0.0)
    if np.any(distance < least):
        in_body = np.einsum("knij,kni->knj", matrices(attitude), source[:, None] - centre)
        extents = np.where(axes > 0.0, axes, np.finfo(float).tiny)
        inside = np.argwhere(np.sum((in_body / extents) ** 2, axis=2) < 1.0)
        if local.distant and not len(inside):
            return
        k, body = inside[0] if len(inside) else (int(np.argmin(distance / least)), 0)
        position = f"inside {system.context.names[body]}" if len(inside) else "too near"
        attach = system.context.units.attach
        raise InvalidInput(
            f"the {what} of the geometry is {position} at time {attach(float(times[k]), 'time')}, "
            f"{attach(float(distance[k]), 'length')} from the barycentre; expected one from "
            f"{attach(float(least[k]), 'length')} on, with vectors from the barycentre in the system's unit of length"
        )


class RetardedStates:
    """States of bodies at their retarded times, when the light left them that arrives at the observer at times (K,).

    Each body is taken to move on a straight line and to rotate uniformly about its pose at the time of the states, up
    to the ``deviations`` that :func:`retarded` adds to these. The states (..., K, N, 3) and (..., K, N, 4) may be
    complex, and several for each time. Their ``lag``, () or (K,), is their time minus that at which the light left the
    barycentre.
    """

    def __init__(
        self, geometry: SystemGeometry, times: Floats, masses: Floats, states: dict[str, Any], lag: Any = 0.0
    ) -> None:
        weights = masses / masses.sum()
        self.times, self.light_speed, self._geometry = times, geometry.light_speed, geometry
        #: Vectors (K, 3) from the system's barycentre to the observer.
        self.observer = geometry.observer(times)
        position, velocity = (
            states[name] - np.einsum("n,...nx->...x", weights, states[name])[..., None, :]
            for name in ("position", "velocity")
        )
        lag = np.reshape(lag, (-1, 1))
        position = position - velocity * lag[..., None]
        #: The times (..., K, N) at which the light left each body, minus that at which it left the barycentre.
        self.delay = geometry.delays(self.observer, position, velocity)
        #: The times (..., K, N) at which the light left each body, minus those of the states.
        self.elapsed = self.delay - lag
        #: Positions and velocities (..., K, N, 3) of the bodies relative to the system's barycentre.
        self.centre, self.velocity = position + velocity * self.delay[..., None], velocity
        self._attitude_deviation: Any = 0.0
        if "deviations" in states:
            of_position, of_velocity, self._attitude_deviation = states["deviations"]
            self.centre, self.velocity = self.centre + of_position, velocity + of_velocity

    @property
    def observer_velocity(self) -> Floats:
        """Velocity (K, 3) of the observer from the system's barycentre, which needs rows that are dense in time."""
        return self._geometry.observer_velocity(self.times)

    def attitude(self, attitude: Floats, spin: Floats) -> Floats:
        """Return attitudes (..., K, N, 4) when the light left the bodies, from those at the time of the states."""
        return rotated(attitude, spin, self.elapsed) + self._attitude_deviation


def rotated(attitude: Any, spin: Any, time: Any) -> Any:
    """Return attitudes (..., 4) after times (...) of rotation at constant spins (..., 3); all may be complex."""
    half_angle = 0.5 * np.sqrt(np.sum(spin * spin, axis=-1)) * time
    vector = spin * (0.5 * time * np.sinc(half_angle / np.pi))[..., None]
    return products(attitude, np.concatenate([np.cos(half_angle)[..., None], vector], axis=-1))


def into_body(attitude: Any, vectors: Any) -> Any:
    """Return vectors (..., 3) in the frames of bodies with attitudes (..., 4); both may be complex."""
    scalar, axis = attitude[..., :1], attitude[..., 1:]
    product = cross(axis, vectors)
    return vectors - 2.0 * scalar * product + 2.0 * cross(axis, product)


def cross(a: Any, b: Any) -> Any:
    """Return the cross products (..., 3) of vectors, which numpy's function takes longer for."""
    return a[..., _NEXT] * b[..., _PREVIOUS] - a[..., _PREVIOUS] * b[..., _NEXT]


def retarded(run: Record, local: SystemGeometry, times: Floats, what: str) -> tuple[dict[str, Any], RetardedStates]:
    """Return the states of a run for light that arrives at times (K,), and the retarded ones that follow from them.

    The former are those when the light left the barycentre, with the ``deviations`` of positions, velocities and
    attitudes from straight and uniform motions from then until the light left the bodies. These come from a continuous
    solution, if the run has one. Otherwise those of positions follow from the forces of the bodies on each other, with
    an error of a sixth of the acceleration's rate of change times the cube of the delay, and those of attitudes are
    neglected.
    """
    emitted, masses = local.emission(times), run.context.masses
    states: dict[str, Any] = run.states(emitted, what)
    uniform = RetardedStates(local, times, masses, states)
    longest = np.abs(uniform.delay).max(initial=0.0)
    if longest == 0.0 or _is_uniform(run, states, longest):
        return states, uniform
    if run.dense is None:
        cores = (_core.State(0.0, *map(np.ascontiguousarray, rows)) for rows in zip(*states.values(), strict=True))
        force = np.array([run.context.core.interactions(core)[0] for core in cores])
        of_velocity = force / masses[:, None] * uniform.delay[..., None]
        states["deviations"] = 0.5 * of_velocity * uniform.delay[..., None], of_velocity, 0.0
        return states, RetardedStates(local, times, masses, states)
    of_attitude = -uniform.attitude(states["attitude"], states["spin"])
    of_position, of_velocity = -uniform.centre, -uniform.velocity
    first, last = sorted(run.dense.core.range)
    for body in range(len(run.context)):
        # Beyond the ends of a run its bodies move uniformly.
        retarded_times = np.clip(emitted + uniform.delay[:, body], first, last)
        retarded_states = run.states(retarded_times, what)
        exact = RetardedStates(local, times, masses, retarded_states, retarded_times - emitted)
        of_position[:, body] += exact.centre[:, body]
        of_velocity[:, body] += exact.velocity[:, body]
        of_attitude[:, body] += exact.attitude(retarded_states["attitude"], retarded_states["spin"])[:, body]
    states["deviations"] = of_position, of_velocity, of_attitude
    return states, RetardedStates(local, times, masses, states)


def _is_uniform(run: Record, states: dict[str, Floats], duration: float) -> bool:
    """Return whether the deviations from uniform motion within a time are below rounding."""
    position, count = states["position"], len(run.context)
    separations = (position[:, i] - position[:, j] for i in range(count) for j in range(i))
    squares = [np.einsum("kx,kx->k", separation, separation).min() for separation in separations]
    # The squares of the mean motion of the closest pair and of the fastest rotation measure the accelerations.
    orbital = run.context.G * run.context.masses.sum() / min(squares) ** 1.5 if squares else 0.0
    if run.dense is None:
        # The samples have the errors of an integration, and attitudes follow from the spins.
        return bool(orbital * duration**2 < _SAMPLED)
    rotational = np.einsum("knx,knx->kn", states["spin"], states["spin"]).max()
    return bool((orbital + rotational) * duration**2 < _ROUNDING)
