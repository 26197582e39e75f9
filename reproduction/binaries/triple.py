"""Three bodies by their masses and two nested orbits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import fullbody
import numpy as np
import numpy.typing as npt
from astropy.time import Time
from fullbody.frames import rotation

from .pair import UNITS, G

__all__ = ["ORBIT", "elements", "nested", "on_equator", "state_on_orbit"]

_Array = npt.NDArray[np.float64]

#: The parameters of an orbit about a given mass.
ORBIT = ("period", "e", "i", "node", "periapsis", "longitude")


def on_equator(
    a: float, e: float, i: float, node: float, argument: float, anomaly: float, mu: float
) -> tuple[_Array, _Array]:
    """Return position and velocity (3,) on the equator of J2000, from elements on its ecliptic in km and degrees."""
    axes = rotation("ecliptic", "equatorial")
    r, v = fullbody.KeplerElements(a, e, *np.radians([i, node, argument, anomaly])).to_cartesian(mu)
    return axes @ r, axes @ v


def elements(r: _Array, v: _Array, mu: float) -> dict[str, float]:
    """Return ``a`` and the elements of ``ORBIT`` from position and velocity."""
    orbit = fullbody.KeplerElements.from_cartesian(r, v, mu)
    i, node, argument, anomaly = np.degrees([orbit.i, orbit.Omega, orbit.omega, orbit.M])
    period = 2.0 * np.pi * np.sqrt(orbit.a**3 / mu)
    values = (orbit.a, period, orbit.e, i, node, node + argument, node + argument + anomaly)
    return {name: float(value) for name, value in zip(("a", *ORBIT), values, strict=True)}


def state_on_orbit(
    mass: float, period: float, e: float, i: float, node: float, periapsis: float, longitude: float
) -> tuple[_Array, _Array]:
    """Return position and velocity (3,) on an orbit about a mass in kg, with lengths in km, days and degrees."""
    mu = G * mass
    a = (mu * (period / (2.0 * np.pi)) ** 2) ** (1.0 / 3.0)
    return fullbody.KeplerElements(a, e, *np.radians([i, node, periapsis - node, longitude - periapsis])).to_cartesian(
        mu
    )


def nested(
    names: Sequence[str],
    masses: Sequence[float],
    inner: Sequence[float],
    outer: Sequence[float],
    epoch: Time,
    first: Any = None,
    attitude: Any = None,
    spin: float = 0.0,
    mass_factor: float = 1.0,
) -> tuple[fullbody.System, fullbody.State]:
    """Make a system in the frame of the equator.

    Parameters
    ----------
    names : sequence of str
    masses : sequence of float, (3,)
        In kg.
    inner, outer : sequence of float, (6,)
        Orbits of the second body about the first, and of the third about the barycentre of the other two: arguments
        of :func:`state_on_orbit` after the mass.
    epoch : Time
    first : shape, optional
        The shape of the first body, which is a point by default.
    attitude : array_like, (4,), optional
        The attitude of the first body.
    spin : float
        The spin of the first body about its z-axis in rad/day.
    mass_factor : float
        The factor by which the figure of the first body strengthens the gravity at the inner orbit, whose elements
        refer to the mass times this factor.
    """
    m = np.asarray(masses, dtype=np.float64)
    (r, v), (r3, v3) = state_on_orbit(mass_factor * m[:2].sum(), *inner), state_on_orbit(m.sum(), *outer)
    share = m[1] / m[:2].sum()
    shapes = [first or fullbody.PointMass(), fullbody.PointMass(), fullbody.PointMass()]
    bodies = [fullbody.Body(shape, mass=mass, name=name) for shape, mass, name in zip(shapes, m, names, strict=True)]
    options: dict[str, Any] = {"gravity": "point"} if first is None else {"gravity": "focal"}
    system = fullbody.System(bodies, G=G, epoch=epoch, units=UNITS, frame="equatorial", **options)
    rotation: dict[str, Any] = {}
    if first is not None:
        identity = [1.0, 0.0, 0.0, 0.0]
        rotation = {"attitude": [attitude, identity, identity], "spin": [[0.0, 0.0, spin], [0.0] * 3, [0.0] * 3]}
    position, velocity = ([-share * x, (1.0 - share) * x, y] for x, y in ((r, r3), (v, v3)))
    return system, fullbody.State(position=position, velocity=velocity, **rotation)
