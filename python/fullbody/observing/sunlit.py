"""The common part of observations of the light of all bodies of a system together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.kinds import flag
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .brightness import Epochs, Photometer
from .data import Observations
from .laws import Law
from .light_curve import epochs_at
from .states import DISTANT, RetardedStates
from .vectors import local_geometry


class SunlitObservations(Observations):
    """Base of observations of the light of all bodies of a system together."""

    #: What is observed, with its article, for errors.
    _quantity = "a magnitude"
    _depends_on_figures = True

    def _set_light_options(self, law: Law | dict[str, Law], albedo: Any, mutual: bool, sun_radius: Any) -> None:
        """Keep the options of the light, after checking that the geometry has the Sun."""
        if not self.geometry.has_sun:
            raise InvalidInput(f"geometry of {type(self).__name__} has no Sun; give to_sun=")
        flag(mutual, "mutual")
        self.law, self.albedo, self.mutual, self.sun_radius = law, albedo, mutual, sun_radius

    def _photometer(self, system: SystemLike) -> Photometer:
        return Photometer(system, self.law, self.albedo, self.mutual, self.sun_radius)

    def _epochs(self, system: SystemLike, states: dict[str, Floats], retarded: RetardedStates) -> Epochs:
        """Return what a photometer sees at the observations, after checking that observer and Sun are far enough."""
        return epochs_at(system, local_geometry(self.geometry, system), states, retarded, DISTANT, DISTANT)

    def _direct_partials(
        self,
        system: SystemLike,
        states: dict[str, Floats],
        parameters: Sequence[str],
        known_derivatives: dict[str, Floats],
    ) -> dict[str, Floats]:
        """Return derivatives (K, C) with respect to parameters at given states, some of which are known."""
        return {
            name: known_derivatives[name] if name in known_derivatives else self._partial(system, states, name)
            for name in parameters
        }

    def _total(self, light: Floats) -> Floats:
        """Return the light (K,) of all bodies together, (K, N), after checking that there is some."""
        total = light.sum(axis=1)
        if not (total > 0.0).all():
            raise InvalidInput(
                f"no light comes from the system at {self.times[np.argmin(total)]}, but {self._quantity} was observed"
            )
        return np.asarray(total)


def derivatives_by_states(
    system: SystemLike, states: dict[str, Floats], retarded: RetardedStates, position: Floats, rotation: Floats
) -> tuple[Floats, Floats]:
    """Return the derivatives of K numbers with respect to states, (K, 12 N), and to masses, (K, N).

    ``position`` and ``rotation`` are the derivatives of these numbers with respect to retarded positions and rotation
    vectors, (K, N, 3). Let e be the unit vector from a body to the observer, u the body's velocity, d its delay and s
    the time that has elapsed since the state. Then c d' = e.(r' + s u' + u d') for a change r' of the position, which
    also changes the time at which the light left. A mass moves the barycentre, relative to which the directions and
    distances of observer and Sun are given.
    """
    to_observer = retarded.observer[:, None] - retarded.centre
    direction = to_observer / np.linalg.norm(to_observer, axis=-1, keepdims=True)
    by_time = np.sum(position * retarded.velocity + rotation * states["spin"], axis=-1)
    speed = retarded.light_speed - np.sum(direction * retarded.velocity, axis=-1)
    position = position + direction * (by_time / speed)[..., None]
    elapsed, weights = retarded.elapsed[..., None], (system.context.masses / system.context.masses.sum())[:, None]
    by_attitude, by_spin = _by_rotation(elapsed * states["spin"], rotation)
    # A change of a position or a velocity moves the barycentre too.
    moved = (part - weights * part.sum(axis=1, keepdims=True) for part in (position, elapsed * position))
    parts = [*moved, by_attitude, elapsed * by_spin]
    by_barycentre = np.einsum("kx,knx->kn", position.sum(axis=1), retarded.centre) / system.context.masses.sum()
    return np.concatenate(parts, axis=-1).reshape(len(to_observer), -1), -by_barycentre


def _by_rotation(angle: Floats, rotation: Floats) -> tuple[Floats, Floats]:
    """Return derivatives (..., 3) with respect to rotation vectors before a rotation, and to the rotation itself.

    ``rotation`` are the derivatives with respect to rotation vectors after a rotation by the vectors ``angle``, all in
    body frames. The rotation changes what is before it, and the right Jacobian of the exponential map relates a change
    of its vector to a rotation after it.
    """
    size = np.linalg.norm(angle, axis=-1, keepdims=True)
    first = np.cross(angle, rotation)
    second = np.cross(angle, first)
    # The coefficients sin(x) / x, (1 - cos(x)) / x^2 and (x - sin(x)) / x^3 of the size x are finite at zero.
    half = 0.5 * np.sinc(0.5 * size / np.pi) ** 2
    is_small = size < 1e-2
    cube = np.where(is_small, 1.0, size) ** 3
    sixth = np.where(is_small, (1.0 - size**2 / 20.0) / 6.0, (size - np.sin(size)) / cube)
    return rotation + np.sinc(size / np.pi) * first + half * second, rotation + half * first + sixth * second
