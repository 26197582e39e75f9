"""Two points on an orbit, by the elements that are published."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import fullbody
import numpy as np
from astropy.time import Time

__all__ = ["INTEGRATOR", "LOOSE", "UNITS", "G", "orbiting", "points"]

#: The gravitational constant in km^3 / (kg day^2).
G = 6.6743e-20 * 86400.0**2
UNITS = ("km", "day", "kg")
INTEGRATOR = fullbody.Verner98(rtol=1e-9, atol=1e-9)
#: The integrator for spheroids and three bodies.
LOOSE = fullbody.Verner98(rtol=1e-8, atol=1e-8)

#: A function that makes a system and its start from the parameters of a fit.
Setup = Callable[..., tuple[fullbody.System, fullbody.State]]


def orbiting(
    a: float, period: float, e: float, i: float, node: float, periapsis: float, longitude: float
) -> tuple[float, Any, Any]:
    """Return G times the mass, and position and velocity (3,) on an orbit.

    Lengths are in km, times in days, angles in degrees. Periapsis and mean longitude are measured from the node of the
    reference plane.
    """
    mu = 4.0 * np.pi**2 * a**3 / period**2
    angles = np.radians([i, node, periapsis - node, longitude - periapsis])
    return mu, *fullbody.KeplerElements(a, e, *angles).to_cartesian(mu)


def points(epoch: Time, share: float, names: Sequence[str] = ("primary", "secondary")) -> Setup:
    """Return the setup of a pair of points in the frame of the equator; ``share`` is the second's share of the mass."""

    def setup(
        a: float, period: float, e: float, i: float, node: float, periapsis: float, longitude: float
    ) -> tuple[fullbody.System, fullbody.State]:
        mu, r, v = orbiting(a, period, e, i, node, periapsis, longitude)
        masses = (1.0 - share) * mu / G, share * mu / G
        bodies = [fullbody.Body(fullbody.PointMass(), mass=m, name=n) for m, n in zip(masses, names, strict=True)]
        system = fullbody.System(bodies, G=G, epoch=epoch, units=UNITS, frame="equatorial", gravity="point")
        shares = [-share, 1.0 - share]
        return system, fullbody.State(position=np.outer(shares, r), velocity=np.outer(shares, v))

    return setup
