"""Stars: the direction to a star as a function of time, with its proper motion and parallax."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.arguments import directions
from ..base.foreign import are_dates, shown
from ..base.units import UNITLESS, as_quantity, is_quantity, need
from ..errors import InvalidInput
from ..forces.ephemeris import barycentric
from ..frames import pole_angles, pole_vector
from ..model.context import SystemLike
from ..typing import Floats
from .times import seconds, system_epoch
from .vectors import Vectors, turn

_EXPECTED = (
    "expected a SkyCoord, (ra, dec) as Quantities such as (41.9 * u.deg, 19.8 * u.deg), or a unit vector of three "
    "numbers along the axes of the geometry"
)


class Star:
    """The direction to a star, of which only the centre counts: it is a point.

    Parameters
    ----------
    given : SkyCoord, (ra, dec) or array_like (3,)
        The star's place in the ICRS; a ``SkyCoord`` may have a proper motion, with ``obstime``, and a distance, from
        which the parallax of an observer at the centre of the Earth follows. A vector is along the axes of the
        geometry.
    geometry : Geometry
    """

    def __init__(self, star: Any, geometry: Vectors) -> None:
        self._vector: Floats | None = None
        self._motion: tuple[Floats, Floats] | None = None
        self._epoch: Any = None
        self._kilometres: float | None = None
        self._frame: Any = "equatorial"
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
        elif np.shape(parts) == (2,):
            raise InvalidInput(f"star is {shown(star)}, angles without a unit; {_EXPECTED}")
        else:
            raise InvalidInput(f"star is {shown(star)}; {_EXPECTED}")

    def _read(self, star: Any) -> None:
        """Read the place, the proper motion and the distance of a ``SkyCoord``."""
        with need("observing", "a star"):
            from astropy import units as u

        if not star.isscalar:
            raise InvalidInput(f"star has {star.size} places; expected one star")
        cartesian = star.icrs.cartesian
        position = cartesian.xyz
        if position.unit.is_equivalent(u.km):
            self._kilometres = float(np.linalg.norm(position.to_value("km")))
            scale = self._kilometres * u.km
        else:
            scale = np.linalg.norm(position.value) * position.unit
        self._vector = np.asarray((position / scale).to_value(""), dtype=np.float64)
        if "s" in cartesian.differentials:
            if not are_dates(star.obstime):
                raise InvalidInput("star has a proper motion without its date; give SkyCoord(..., obstime=)")
            rate = cartesian.differentials["s"].d_xyz / scale
            per_second = rate.to_value(1 / u.s, equivalencies=u.dimensionless_angles())
            self._motion, self._epoch = (self._vector, np.asarray(per_second, dtype=np.float64)), star.obstime.tdb

    @property
    def coordinates(self) -> tuple[float, float]:
        """Right ascension and declination in the ICRS in degrees, at the star's own date; an error for a vector."""
        if self._vector is None or self._frame != "equatorial":
            raise InvalidInput("star is a vector along the axes of the geometry; expected a SkyCoord or (ra, dec)")
        longitude, latitude = pole_angles(self._vector)
        return float(np.degrees(longitude)), float(np.degrees(latitude))

    def directions(self, system: SystemLike, times: Floats) -> Floats:
        """Return unit vectors (..., 3) to the star at times (...) of the system's clock, along the system's axes."""
        assert self._vector is not None
        vector = np.broadcast_to(self._vector, (*np.shape(times), 3))
        if self._motion is not None or self._kilometres is not None:
            from astropy import units as u

            epoch = system_epoch(system, "a star with a proper motion or a distance")
            since = np.asarray(times, dtype=np.float64) * seconds(system, "a star with a proper motion or a distance")
            if self._motion is not None:
                age = float((epoch - self._epoch).to_value("s"))
                vector = vector + self._motion[1] * (since + age)[..., None]
            if self._kilometres is not None:
                earth = barycentric("earth", (epoch + np.ravel(since) * u.s), "builtin")
                vector = vector - earth.reshape(*np.shape(times), 3) / self._kilometres
            vector = vector / np.linalg.norm(vector, axis=-1, keepdims=True)
        if self._frame is None:
            return np.asarray(vector)
        if system.context.frame is None:
            raise InvalidInput(
                "star is a place in the sky, and the axes of the system are not known; "
                "give fullbody.System(..., frame='ecliptic')"
            )
        return np.asarray(vector @ turn(self._frame, system.context.frame).T)
