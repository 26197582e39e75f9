"""The Sun of a published system, on its heliocentric orbit."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..base import rotations
from ..base.kinds import flag
from ..base.units import need
from ..errors import InvalidInput
from ..forces import ThirdBody
from ..frames import rotation
from ..motion.system import System
from ..orbit.elements import KeplerElements

__all__ = ["with_sun"]

#: G times the Sun's mass in km^3/hour^2, from DE440 (Park et al. 2021), and the astronomical unit in km.
_MU = 132712440041.279419 * 3600.0**2
_AU = 149597870.7


def with_sun(
    system: System, table: dict[str, Any] | None, sun: Any, axes: tuple[str | None, npt.NDArray[np.float64] | None]
) -> System:
    """Add the Sun's gravity to a system if it is requested.

    Parameters
    ----------
    table
        The heliocentric orbit in the ecliptic of J2000 (au, degrees), and the Julian date of its mean anomaly.
    axes
        The state's axes: the name of a frame, and a quaternion by which vectors turn from there or ``None``.
    """
    flag(sun, "sun")
    if not sun:
        return system
    if table is None:
        raise InvalidInput("sun is True; expected False: the heliocentric orbit of this system is not tabulated")
    a, e, *degrees = table["orbit"]["value"]
    i, node, argument, mean = np.radians(degrees)
    if system.epoch is not None:
        mean += np.sqrt(_MU / (a * _AU) ** 3) * 24.0 * (system.epoch.tdb.jd - table["epoch"]["value"])
    r, v = KeplerElements(a * _AU, e, i, node, argument, np.remainder(mean, 2 * np.pi)).to_cartesian(_MU)
    frame, quaternion = axes
    matrix = rotation("ecliptic", frame)
    if quaternion is not None:
        matrix = rotations.matrices(quaternion) @ matrix
    orbit = KeplerElements.from_cartesian(matrix @ r, matrix @ v, _MU)
    if system.units is None:
        third = ThirdBody(mu=_MU, orbit=orbit, of="system", name="Sun")
    else:
        with need("units", "a system with units"):
            from astropy import units as u
        angles = (orbit.i, orbit.Omega, orbit.omega, orbit.M)
        united = KeplerElements(orbit.a * u.km, orbit.e, *angles)
        third = ThirdBody(mu=_MU * u.km**3 / u.hour**2, orbit=united, of="system", name="Sun")
    return system.with_force(third)
