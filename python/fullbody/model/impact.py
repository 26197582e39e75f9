"""The impact of a projectile on a body's surface."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base.arguments import directions, warn_if_degrees
from ..base.tables import number
from ..base.units import scalar
from ..errors import InvalidInput
from ..model.context import SystemLike

__all__ = ["impulse"]

_Array = npt.NDArray[np.float64]


def impulse(
    system: SystemLike,
    core: _core.State,
    index: int,
    axes: _Array,
    mass: Any,
    velocity: Any,
    longitude: Any,
    latitude: Any,
    beta: Any,
    ejecta: Any,
) -> tuple[_Array, _Array]:
    """Return the changes of a body's velocity (inertial) and spin (body frame); see :meth:`fullbody.State.impact`."""
    units, turn = system.context.units, core.rotation_matrix[index]
    amount = units.number(mass, "mass", "mass of the projectile")
    if amount <= 0.0:
        raise InvalidInput(f"mass of the projectile is {mass!r}; expected a number above zero")
    coming = units.strip(velocity, "velocity", "velocity of the projectile")
    if coming.shape != (3,) or not np.isfinite(coming).all():
        raise InvalidInput(f"velocity of the projectile is {velocity!r}; expected three finite numbers")
    enhanced = scalar(units.strip(beta, "angle", "beta"), "beta")
    if not np.isfinite(enhanced):
        raise InvalidInput(f"beta is {beta!r}; expected a finite number")
    angles = [units.number(value, "angle", name) for name, value in (("longitude", longitude), ("latitude", latitude))]
    warn_if_degrees(longitude, "longitude")
    if abs(angles[1]) > np.pi / 2:
        raise InvalidInput(f"latitude is {latitude!r}; expected an angle from -pi/2 to pi/2")
    way = np.array([np.cos(angles[1]) * np.cos(angles[0]), np.cos(angles[1]) * np.sin(angles[0]), np.sin(angles[1])])
    (point,), (normal,) = _core.surface(system.context.core, index, way[None])
    spin = core.spin[index]
    # This is the velocity in the body frame, relative to the surface at the point that is struck.
    relative = turn.T @ (axes @ coming) - np.cross(spin, point)
    if relative @ normal >= 0.0:
        speed = number(units.attach(np.float64(relative @ normal), "velocity"), 4)
        raise InvalidInput(
            f"velocity of the projectile is {velocity!r}, by which it leaves the surface there at {speed} along the "
            "normal; expected one that comes from outside, relative to the body's centre"
        )
    out = normal if ejecta is None else turn.T @ (axes @ directions(ejecta, "ejecta", one=True))
    out = out / np.linalg.norm(out)
    momentum = amount * (relative + (enhanced - 1.0) * (out @ relative) * out)
    body = system.context.bodies[index]
    return turn @ momentum / body.mass, np.cross(point, momentum) / body.inertia
