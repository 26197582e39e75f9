"""Two ellipsoids at the moment of rotational fission: a contact binary that rotates just fast enough to separate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from fullbody import Body, Ellipsoid, State, System
from scipy.optimize import brentq, minimize_scalar
from scipy.special import elliprd

from . import paper

__all__ = ["CASES", "Case", "centre_distance", "fission", "spin_limit"]


_Axes: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Case:
    """A secondary: its density, kg/m^3, and its axes b/a and c/a."""

    density: float
    axes: tuple[float, float]


#: The cases, which are assumed: see the table in the folder's README.
CASES = {
    "A1": Case(1200.0, (0.70, 0.65)),
    "A2": Case(1600.0, (0.70, 0.65)),
    "A3": Case(2000.0, (0.70, 0.65)),
    "B1": Case(2000.0, (0.90, 0.85)),
    "B2": Case(2000.0, (0.60, 0.55)),
    "B3": Case(2000.0, (0.50, 0.45)),
}
#: The semi-axes of the primary in km, and its density in kg/m^3.
PRIMARY, DENSITY = (1.0, 0.70, 0.65), 2000.0


def fission(case: str, mass_ratio: float, tilt: float, gravity: str = "focal") -> tuple[System, State]:
    """Return the start, in km, hours and kg.

    Both bodies rotate about z at one rate, with the long axis of the primary along x. The secondary is rotated from
    that attitude about its y-axis by ``tilt`` degrees, and its surface is 1 cm from the primary's. The rate is that at
    which the attraction along the line of the centres is the centripetal force of the secondary's circular motion.
    """
    secondary = CASES[case]
    first = Ellipsoid(*PRIMARY)
    b, c = secondary.axes
    a = float((mass_ratio * DENSITY / secondary.density * np.prod(PRIMARY) / (b * c)) ** (1 / 3))
    second = Ellipsoid(a, a * b, a * c)
    bodies = [
        Body(first, density=DENSITY * 1e9, name="primary"),
        Body(second, density=secondary.density * 1e9, name="secondary"),
    ]
    system = System(bodies, G=paper.G, gravity=gravity)
    angle = np.deg2rad(tilt)
    distance = centre_distance(PRIMARY, (a, a * b, a * c), angle, paper.GAP)
    masses = system.masses
    positions = np.array([[-masses[1], 0.0, 0.0], [masses[0], 0.0, 0.0]]) * distance / masses.sum()
    attitude = np.array([[1.0, 0.0, 0.0, 0.0], [np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0]])
    resting = State(positions, np.zeros((2, 3)), attitude, np.zeros((2, 3)))
    attraction = -system.interactions(resting).force[1, 0]
    rate = np.sqrt(attraction * masses.sum() / (masses[0] * masses[1] * distance))
    axis = np.array([0.0, 0.0, rate])
    # The common rate in the frame of each body.
    spin = np.einsum("nji,j->ni", resting.rotation_matrix, axis)
    return system, resting.replace(velocity=np.cross(axis, positions), spin=spin)


def spin_limit(axes: _Axes, density: float) -> float:
    """Return the rate, rad/h, at which dust at the end of an ellipsoid's long axis has no weight: sqrt(2 pi G rho A1).

    Semi-axes in km, the density in kg/km^3. A1 = 2/3 a b c R_D(b^2, c^2, a^2) is the index symbol of that axis
    (Chandrasekhar 1969): the attraction there is 2 pi G rho A1 a.
    """
    a, b, c = axes
    symbol = 2 / 3 * a * b * c * elliprd(b * b, c * c, a * a)
    return float(np.sqrt(2 * np.pi * paper.G * density * symbol))


def centre_distance(first: _Axes, second: _Axes, tilt: float, gap: float) -> float:
    """Return the distance of the centres at which the gap between the surfaces has this width.

    Both bodies are symmetric about the plane y = 0, so that their nearest points lie in it. The gap is the largest
    difference, over directions in that plane, between the distance of the centres and the extents of both bodies.
    """

    def extent(axes: _Axes, direction: float) -> float:
        return float(np.hypot(axes[0] * np.cos(direction), axes[2] * np.sin(direction)))

    def width(distance: float) -> float:
        def overlap(direction: float) -> Any:
            return extent(first, direction) + extent(second, direction + tilt) - distance * np.cos(direction)

        return -float(minimize_scalar(overlap, bounds=(-1.2, 1.2), method="bounded", options={"xatol": 1e-10}).fun)

    longest = first[0] + second[0]
    return float(brentq(lambda distance: width(distance) - gap, 0.3 * longest, longest + 2 * gap, xtol=1e-13))
