"""Positions and velocities of particles that leave the surface of a body."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _core
from ..base.arguments import generator
from ..base.limits import FINITE, LATITUDE, NOT_NEGATIVE
from ..base.rotations import towards
from ..base.units import UNITLESS
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..model.state import State, strip
from ..typing import Floats


class LaunchSite:
    """The surface of a body, with the motion of the body in a state."""

    def __init__(self, system: SystemLike, state: State, body: int | str) -> None:
        self.system, self.index = system, system.context.index(body, "body")
        core = strip(state, system.context)
        if len(core.position) != len(system.context):
            count = len(system.context)
            raise InvalidInput(f"state has {len(core.position)} bodies; expected {count}, as the system has")
        self.position, self.velocity = core.position[self.index], core.velocity[self.index]
        self.rotation, self.spin = core.rotation_matrix[self.index], core.spin[self.index]

    def surface(self, directions: Floats) -> tuple[Floats, Floats]:
        """Return points (P, 3) of the surface in directions from the centre and their outward normals, in the body
        frame.
        """
        return _core.surface(self.system.context.core, self.index, np.ascontiguousarray(directions))

    def moved(self, point: Floats, velocity: Floats) -> tuple[Any, Any]:
        """Return inertial positions and velocities of points that move relative to the body, with units."""
        attach, moving = self.system.context.units.attach, velocity + np.cross(self.spin, point)
        position, velocity = self.position + point @ self.rotation.T, self.velocity + moving @ self.rotation.T
        return attach(position, "length"), attach(velocity, "velocity")


def launched(
    site: LaunchSite, longitude: Any, latitude: Any, speed: Any, azimuth: Any, elevation: Any
) -> tuple[Any, Any]:
    """Return inertial positions and velocities of particles that leave a surface, with the system's units.

    Angles are in radians, speeds are relative to the surface and in the system's units; their shapes broadcast.
    """
    angles = {"longitude": longitude, "latitude": latitude, "speed": speed, "azimuth": azimuth, "elevation": elevation}
    limits = {"latitude": LATITUDE, "speed": NOT_NEGATIVE}
    for name, values in angles.items():
        UNITLESS.numbers(values, "number", name, None, limits.get(name, FINITE))
    try:
        both = np.broadcast_arrays(*angles.values())
    except ValueError as error:
        shapes = ", ".join(f"{name} {np.shape(values)}" for name, values in angles.items())
        raise InvalidInput(f"the shapes {shapes} do not go together; expected shapes that broadcast") from error
    lon, lat, rate, az, el = (np.ravel(values).astype(np.float64) for values in both)
    point, normal = site.surface(towards(lon, lat))
    east = np.cross([0.0, 0.0, 1.0], normal)
    length = np.linalg.norm(east, axis=1, keepdims=True)
    # At a pole, the longitude defines the direction of east.
    towards_east = np.stack([-np.sin(lon), np.cos(lon), np.zeros_like(lon)], axis=1)
    east = np.where(length > 1e-12, east / np.maximum(length, 1e-300), towards_east)
    north = np.cross(normal, east)
    horizontal = np.sin(az)[:, None] * east + np.cos(az)[:, None] * north
    velocity = rate[:, None] * (np.cos(el)[:, None] * horizontal + np.sin(el)[:, None] * normal)
    return site.moved(point, velocity)


def cone(n: int, opening: float, filled: bool, rng: Any) -> tuple[Floats, Floats]:
    """Return azimuths and elevations of random directions in a cone about the normal."""
    random = generator(rng)
    azimuth = random.uniform(0.0, 2.0 * np.pi, n)
    half = 0.5 * opening
    if not filled:
        return azimuth, np.full(n, np.pi / 2 - half)
    return azimuth, np.arcsin(random.uniform(np.cos(half), 1.0, n))
