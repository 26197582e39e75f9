"""Stars: the direction to a star as a function of time, with its proper motion and parallax."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.arguments import directions
from ..base.foreign import are_dates, shown
from ..base.unit_names import unit_named
from ..base.units import UNITLESS, as_quantity, is_quantity, need
from ..errors import InvalidInput
from ..forces.ephemeris import barycentric
from ..frames import pole_angles, pole_vector
from ..model.context import SystemLike
from ..typing import Floats
from .times import seconds, system_epoch
from .vectors import Vectors, rotation_to_system

_EXPECTED = (
    "expected a SkyCoord, (ra, dec) as Quantities such as (41.9 * u.deg, 19.8 * u.deg), or a unit vector of three "
    "numbers along the axes of the geometry"
)
_WHAT = "a star with a proper motion or a distance"


class Star:
    """The direction to a star, which is a point.

    It is a ``SkyCoord`` or (ra, dec) in the ICRS, or a vector (3,) along the axes of the geometry. A ``SkyCoord`` may
    have a proper motion, with ``obstime``, and a distance, from which the parallax of an observer at the centre of the
    Earth follows.
    """

    def __init__(self, star: Any, geometry: Vectors) -> None:
        #: The unit vector to the star along the axes of a frame, or of the system without one; its rate of change per s
        #: and the date to which it refers; and the distance in km.
        self._vector: Floats
        self._frame: Any = "equatorial"
        self._rate: Floats | None = None
        self._date: Any = None
        self._distance: float | None = None
        if hasattr(star, "icrs"):
            self._read(star)
            return
        parts = as_quantity(star, "star")
        if is_quantity(parts) and np.shape(parts) == (2,):
            ra, dec = (UNITLESS.number(part, "angle", name) for part, name in zip(parts, ("ra", "dec"), strict=True))
            self._vector = pole_vector(ra, dec)
        elif np.shape(parts) == (3,):
            vector = directions(parts, "star", single=True)
            self._vector, self._frame = vector / np.linalg.norm(vector), geometry.frame
        else:
            angles = ", angles without a unit" if np.shape(parts) == (2,) else ""
            raise InvalidInput(f"star is {shown(star)}{angles}; {_EXPECTED}")

    def _read(self, star: Any) -> None:
        """Read the position, the proper motion and the distance of a ``SkyCoord``."""
        with need("observing", "a star"):
            from astropy import units as u

        if not star.isscalar:
            raise InvalidInput(f"star has {star.size} positions; expected one star")
        cartesian = star.icrs.cartesian
        distance = cartesian.norm()
        if distance.unit.is_equivalent(u.km):
            self._distance = float(distance.to_value("km"))
        self._vector = np.asarray((cartesian.xyz / distance).to_value(""), dtype=np.float64)
        if "s" in cartesian.differentials:
            if not are_dates(star.obstime):
                raise InvalidInput("star has a proper motion without its date; give SkyCoord(..., obstime=)")
            rate = cartesian.differentials["s"].d_xyz / distance
            per_second = rate.to_value(1 / u.s, equivalencies=u.dimensionless_angles())
            self._rate, self._date = np.asarray(per_second, dtype=np.float64), star.obstime.tdb

    @property
    def coordinates(self) -> tuple[float, float]:
        """Right ascension and declination in the ICRS in degrees, at the star's own date; an error for a vector."""
        if self._frame != "equatorial":
            raise InvalidInput("star is a vector along the axes of the geometry; expected a SkyCoord or (ra, dec)")
        longitude, latitude = pole_angles(self._vector)
        return float(np.degrees(longitude)), float(np.degrees(latitude))

    def directions(self, system: SystemLike, times: Floats) -> Floats:
        """Return unit vectors (..., 3) to the star at times (...) of the system's clock, along the system's axes."""
        vector = np.broadcast_to(self._vector, (*np.shape(times), 3))
        if self._rate is not None or self._distance is not None:
            epoch, elapsed = system_epoch(system, _WHAT), np.asarray(times) * seconds(system, _WHAT)
            if self._rate is not None:
                age = float((epoch - self._date).to_value("s"))
                vector = vector + self._rate * (elapsed + age)[..., None]
            if self._distance is not None:
                earth = barycentric("earth", (epoch + np.ravel(elapsed) * unit_named("s")), "builtin")
                vector = vector - earth.reshape(*np.shape(times), 3) / self._distance
            vector = vector / np.linalg.norm(vector, axis=-1, keepdims=True)
        if self._frame is None:
            return np.asarray(vector)
        return np.asarray(vector @ rotation_to_system(self._frame, system, "a star with coordinates in the sky").T)
