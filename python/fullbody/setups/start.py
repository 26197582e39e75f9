"""The start of a binary: its orbit, the attitudes and spins of its bodies, and the point at rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import rotations
from ..base.arguments import longitude_latitude, warn_if_degrees
from ..model.failures import explaining
from ..model.state import State, strip
from ..motion.system import System
from ..orbit.elements import KeplerElements
from ..typing import Floats
from .component import Component, angle_towards, attitude, rotation_rate
from .masses import BinarySolution


@dataclass(frozen=True)
class Orbit:
    """Shape and orientation of a Kepler orbit, and the anomaly at the start; angles in radians."""

    eccentricity: float
    inclination: float
    node: float
    periapsis: float
    anomaly: float

    @classmethod
    def published(cls, arguments: Mapping[str, Any], numbers: Mapping[str, float]) -> Orbit:
        """Make an orbit from the arguments of :func:`binary`, of which the numbers are unitless."""
        pole, node, inclination = arguments["pole"], 0.0, 0.0
        if pole is not None:
            longitude, latitude = longitude_latitude(pole, "pole")
            node, inclination = longitude + np.pi / 2, np.pi / 2 - latitude
        angles = ("argument_of_periapsis", "mean_anomaly")
        for name in angles:
            warn_if_degrees(arguments[name], name)
        return cls(numbers["eccentricity"], inclination, node, *(numbers[name] for name in angles))

    def cartesian(self, semi_major_axis: float, mu: float) -> tuple[Floats, Floats]:
        """Return the secondary's position and velocity relative to the primary."""
        angles = (self.inclination, self.node, self.periapsis, self.anomaly)
        return KeplerElements(semi_major_axis, self.eccentricity, *angles).to_cartesian(mu)

    @property
    def plane(self) -> Floats:
        """The attitude of the orbit's plane: x towards the node, z towards the pole."""
        return rotations.of_plane(self.node, self.inclination)


@dataclass(frozen=True)
class Start:
    """The start of a binary except the size and the speed of the orbit, in plain numbers.

    The ``separation`` (3,) is the vector from the primary to the secondary, on the Kepler orbit of the masses; the
    ``attitudes`` are (2, 4). The ``rates`` of rotation about each z-axis are ``None`` for a synchronous secondary,
    whose rate is the orbit's. The ``shares`` (2,) are the bodies' positions and velocities divided by the relative
    ones. ``primary_rotates`` says whether the primary rotates relative to the line that joins the bodies.
    """

    orbit: Orbit
    separation: Floats
    attitudes: Floats
    rates: tuple[float, float | None]
    shares: Floats
    primary_rotates: bool

    @classmethod
    def of(
        cls,
        system: System,
        components: tuple[Component, Component],
        solution: BinarySolution,
        orbit: Orbit,
        libration: float | None,
        at_rest: str,
    ) -> Start:
        """Make the start of a system's bodies; the libration is ``None`` for a secondary that is not synchronous."""
        primary, secondary = components
        separation, _ = orbit.cartesian(solution.semi_major_axis, system.context.G * sum(solution.masses))
        plane = orbit.plane
        synchronous = libration is not None
        angle = None if libration is None else angle_towards(secondary, plane, -separation) + libration
        attitudes = np.array([attitude(primary, plane, None), attitude(secondary, plane, angle)])
        rates = [
            rotation_rate(part, system.context.units, name) for part, name in zip(components, system.names, strict=True)
        ]
        spin = rates[0] * solution.period / (2 * np.pi) * rotations.matrices(attitudes[0])[:, 2]
        shares = np.array([0.0, 1.0])
        if at_rest == "barycentre":
            shares = np.array([-solution.masses[1], solution.masses[0]]) / sum(solution.masses)
        rotates = bool(np.linalg.norm(spin - rotations.matrices(plane)[:, 2]) > 1e-6)
        return cls(orbit, separation, attitudes, (rates[0], None if synchronous else rates[1]), shares, rotates)

    @property
    def direction(self) -> Floats:
        """The unit vector from the primary to the secondary."""
        return self.separation / np.linalg.norm(self.separation)

    @property
    def locked(self) -> list[int]:
        """The indices of the bodies that rotate with the orbit."""
        return [k for k, rotates in enumerate((self.primary_rotates, self.rates[1] is not None)) if not rotates]

    def state(self, semi_major_axis: float, mu: float, period: float) -> State:
        """Return the state on an orbit of this size and speed; a synchronous secondary rotates once in the period."""
        r, v = self.orbit.cartesian(semi_major_axis, mu)
        spins = [2 * np.pi / period if rate is None else rate for rate in self.rates]
        shares = self.shares[:, None]
        return State(shares * r, shares * v, self.attitudes, [[0.0, 0.0, spin] for spin in spins])

    def refuse_overlap(self, system: System, separation: Floats) -> None:
        """Raise :class:`fullbody.errors.BodiesOverlap` for bodies that overlap at a separation."""
        state = strip(State([np.zeros(3), separation], np.zeros((2, 3)), self.attitudes), system.context)
        with explaining(system.context, state, " at the start"):
            system.context.core.energy(state)
