"""Two ellipsoids at the moment of rotational fission: a contact binary that turns just fast enough to come apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from fullbody import Body, Ellipsoid, State, System
from scipy.optimize import brentq, minimize_scalar
from scipy.special import elliprd

from . import paper

__all__ = ["CASES", "Case", "closest", "fission", "spin_limit"]


_Axes: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Case:
    """A secondary: its density, kg/m^3, and its axes b/a and c/a."""

    density: float
    axes: tuple[float, float]


#: Not read, but assumed: see the table in the folder's README.
CASES = {
    "A1": Case(1200.0, (0.70, 0.65)),
    "A2": Case(1600.0, (0.70, 0.65)),
    "A3": Case(2000.0, (0.70, 0.65)),
    "B1": Case(2000.0, (0.90, 0.85)),
    "B2": Case(2000.0, (0.60, 0.55)),
    "B3": Case(2000.0, (0.50, 0.45)),
}
#: The primary: km, kg/m^3.
PRIMARY, DENSITY = (1.0, 0.70, 0.65), 2000.0


def fission(case: str, mass_ratio: float, tilt: float, gravity: str = "focal") -> tuple[System, State]:
    """Return the start, in km, hours and kg.

    The long axes lie on the x-axis, both bodies turn about z. The secondary is then tilted about its y-axis by some
    degrees, and put where its surface is 1 cm from the primary's. The common rate is that at which the secondary
    weighs nothing: attraction along the line of the centres equals what keeps it on its circle about the barycentre.
    """
    chosen = CASES[case]
    first = Ellipsoid(*PRIMARY)
    b, c = chosen.axes
    a = float((mass_ratio * DENSITY / chosen.density * np.prod(PRIMARY) / (b * c)) ** (1 / 3))
    second = Ellipsoid(a, a * b, a * c)
    bodies = [
        Body(first, density=DENSITY * 1e9, name="primary"),
        Body(second, density=chosen.density * 1e9, name="secondary"),
    ]
    system = System(bodies, G=paper.G, gravity=gravity)
    angle = np.deg2rad(tilt)
    distance = closest(PRIMARY, (a, a * b, a * c), angle, paper.GAP)
    masses = system.masses
    positions = np.array([[-masses[1], 0.0, 0.0], [masses[0], 0.0, 0.0]]) * distance / masses.sum()
    attitude = np.array([[1.0, 0.0, 0.0, 0.0], [np.cos(angle / 2), 0.0, np.sin(angle / 2), 0.0]])
    still = State(positions, np.zeros((2, 3)), attitude, np.zeros((2, 3)))
    pull = -system.interactions(still).force[1, 0]
    rate = np.sqrt(pull * masses.sum() / (masses[0] * masses[1] * distance))
    axis = np.array([0.0, 0.0, rate])
    # The common rate in each body's own frame.
    spin = np.einsum("nji,j->ni", still.rotation_matrix, axis)
    return system, still.replace(velocity=np.cross(axis, positions), spin=spin)


def spin_limit(axes: _Axes, density: float) -> float:
    """Return the rate, rad/h, at which dust at the end of an ellipsoid's long axis weighs nothing: sqrt(2 pi G rho A1).

    Semi-axes in km, the density in kg/km^3. A1 = 2/3 a b c R_D(b^2, c^2, a^2) is the index symbol of that axis
    (Chandrasekhar 1969): the attraction there is 2 pi G rho A1 a.
    """
    a, b, c = axes
    symbol = 2 / 3 * a * b * c * elliprd(b * b, c * c, a * a)
    return float(np.sqrt(2 * np.pi * paper.G * density * symbol))


def closest(first: _Axes, second: _Axes, tilt: float, gap: float) -> float:
    """Return the distance of the centres at which the surfaces are so far apart.

    Both bodies are symmetric about the plane y = 0, so that their nearest points lie in it. The gap is the largest,
    over directions in that plane, of the centres' distance less both bodies' extents.
    """

    def extent(axes: _Axes, direction: float) -> float:
        return float(np.hypot(axes[0] * np.cos(direction), axes[2] * np.sin(direction)))

    def room(distance: float) -> float:
        def less(direction: float) -> Any:
            return extent(first, direction) + extent(second, direction + tilt) - distance * np.cos(direction)

        return -float(minimize_scalar(less, bounds=(-1.2, 1.2), method="bounded", options={"xatol": 1e-10}).fun)

    longest = first[0] + second[0]
    return float(brentq(lambda distance: room(distance) - gap, 0.3 * longest, longest + 2 * gap, xtol=1e-13))
