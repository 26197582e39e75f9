"""The forces besides mutual gravity in GUBAS's input."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..forces import Force, ThirdBody, Tide
from ..orbit.elements import KeplerElements

__all__ = ["Deformed", "Orbit", "Outside"]

#: The elements of an orbit in the order of a file: semi-major axis, eccentricity, inclination, node, argument of
#: periapsis, time of periapsis.
Orbit = tuple[float, float, float, float, float, float]
_LEFT_OUT = "GUBAS leaves out its torques, which are computed here"
_DISPLACED = (
    "GUBAS puts the secondary at 1 - nu r instead of (1 - nu) r from the barycentre, so that its pull is one across a "
    "fixed vector (GUBAS-RS does not)"
)


@dataclass
class Deformed:
    """The tide of a body: its Love number, radius in km and lag angle in radians."""

    k2: float
    radius: float
    angle: float


@dataclass
class Outside:
    """The forces in a file, each ``None`` if it is switched off; masses are in kg and lengths in km."""

    flyby: tuple[float, Orbit] | None = None
    sun: tuple[float, Orbit] | None = None
    #: The mass and the distance of a Sun on a circular orbit.
    circular: tuple[float, float] | None = None
    tides: tuple[Deformed, Deformed] | None = None

    def forces(self, start: float, relative: npt.NDArray[Any], spins: npt.NDArray[Any]) -> list[Force]:
        """Return the forces; tides need the relative position, velocity (2, 3) and spins (2, 3), all inertial."""
        models: list[Force] = []
        for name, third in (("flyby", self.flyby), ("Sun", self.sun)):
            if third is not None:
                mass, (a, e, i, node, argument, periapsis) = third
                orbit = KeplerElements(a, e, i, node, argument, 0.0)
                models.append(ThirdBody(mass=mass, orbit=orbit, of="body", time=periapsis, name=name))
        if self.circular is not None:
            mass, distance = self.circular
            orbit = KeplerElements(distance, 0.0, 0.0, 0.0, 0.0, 0.0)
            models.append(ThirdBody(mass=mass, orbit=orbit, of="system", time=start, name="Sun"))
        if self.tides is not None:
            position, velocity = relative
            orbital = np.cross(position, velocity) / (position @ position)
            names = ("primary", "secondary")
            for k, tide in enumerate(self.tides):
                # The tide with the highest frequency has the shortest lag.
                frequency = max(2.0 * np.linalg.norm(spins[k] - orbital), np.linalg.norm(orbital))
                lag = float(np.sin(2.0 * tide.angle) / frequency)
                models.append(Tide(names[k], names[1 - k], tide.k2, lag, radius=tide.radius))
        return models

    def input_warnings(self) -> Iterator[str]:
        """Return warnings of input for which GUBAS's own result differs from the result of this package."""
        if self.flyby is not None:
            yield f"a flyby: {_LEFT_OUT}, and {_DISPLACED}"
        if self.sun is not None:
            yield f"a heliocentric orbit: {_LEFT_OUT}, and {_DISPLACED}"
        if self.circular is not None:
            yield (
                "the Sun of Hill's problem: GUBAS holds its direction fixed along x and adds the Coriolis acceleration "
                "of axes that turn, which its state has not; here the Sun goes round on a circle, and turns the bodies"
            )
        if self.tides is not None:
            yield (
                "tidal torques: GUBAS's have the sign that drives spins away from the orbit's rate, which adds energy, "
                "and take a radius in metres beside kilometres; here tides of a constant time lag dissipate"
            )
