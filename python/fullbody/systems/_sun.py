"""The Sun of a published system, on its heliocentric orbit."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..base.units import need
from ..errors import InvalidInput
from ..forces import ThirdBody
from ..frames import pole_vector, rotation
from ..motion.system import System
from ..orbit.elements import KeplerElements
from ._published import Published, Value

__all__ = ["ELEMENTS", "EPOCH", "SOURCE", "heliocentric", "with_sun"]

ELEMENTS = "heliocentric orbit (a, e, i, Omega, omega, M), ecliptic"
EPOCH = "epoch of the heliocentric orbit"
SOURCE = (
    "JPL's Small-Body Database, https://ssd.jpl.nasa.gov, osculating elements of that epoch, as Wikipedia's article "
    "quotes them"
)
#: G times the Sun's mass in km^3/hour^2, from DE440 (Park et al. 2021), and the astronomical unit in km.
_MU = 132712440041.279419 * 3600.0**2
_AU = 149597870.7


def heliocentric(elements: tuple[float, ...], epoch: float) -> dict[str, Value]:
    """Return a heliocentric orbit in au and degrees, and the Julian date of its mean anomaly."""
    return {ELEMENTS: Value(elements, "au, deg", "", "JPL"), EPOCH: Value(epoch, "JD TDB", "", "JPL")}


def with_sun(system: System, facts: Published, sun: bool, frame: str | None, pole: tuple[float, float]) -> System:
    """Add the Sun's gravity to a system if it is requested.

    Parameters
    ----------
    frame
        The state's axes: a name, or the orbit's plane with its node on the x-axis for ``"orbit"`` and ``None``.
    pole
        Pole of the orbit's plane in the frame of the published numbers, degrees.
    """
    if not isinstance(sun, bool | np.bool_):
        raise InvalidInput(f"sun is {sun!r}; expected True or False")
    if not sun:
        return system
    a, e, *degrees = facts[ELEMENTS]
    i, node, argument, mean = np.radians(degrees)
    if system.epoch is not None:
        mean += np.sqrt(_MU / (a * _AU) ** 3) * 24.0 * (system.epoch.tdb.jd - facts[EPOCH])
    r, v = KeplerElements(a * _AU, e, i, node, argument, np.remainder(mean, 2 * np.pi)).to_cartesian(_MU)
    axes = _axes(frame, facts.frame, pole)
    orbit = KeplerElements.from_cartesian(axes @ r, axes @ v, _MU)
    if system.units is None:
        third = ThirdBody(mu=_MU, orbit=orbit, of="system", name="Sun")
    else:
        with need("units", "a system with units"):
            from astropy import units as u
        angles = (orbit.i, orbit.Omega, orbit.omega, orbit.M)
        united = KeplerElements(orbit.a * u.km, orbit.e, *angles)
        third = ThirdBody(mu=_MU * u.km**3 / u.hour**2, orbit=united, of="system", name="Sun")
    return system.with_force(third)


def _axes(frame: str | None, published: str, pole: tuple[float, float]) -> npt.NDArray[np.float64]:
    """Return the matrix from the ecliptic of J2000 to the state's axes."""
    if frame in ("ecliptic", "equatorial"):
        return rotation("ecliptic", frame)
    longitude, latitude = np.radians(pole)
    z = pole_vector(longitude, latitude)
    x = np.array([-np.sin(longitude), np.cos(longitude), 0.0])
    named = "ecliptic" if published == "orbit" else published
    return np.array([x, np.cross(z, x), z]) @ rotation("ecliptic", named)
