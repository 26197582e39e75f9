"""The Earth as a place of stations: its rotation, its motion, and the direction of the Sun."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.unit_names import unit_named
from ..base.units import need
from ..errors import caution
from ..forces.ephemeris import barycentric
from ..model.context import SystemLike
from ..typing import Floats
from .times import LIGHT_SPEED, kilometres, seconds, system_epoch
from .vectors import rotation_to_system

#: The step in s of a table of the Earth's rotation, whose spline has an error of 1e-12.
_STEP = 60.0
#: The longest table of the Earth's rotation in s; times that are farther apart have no table.
_LONGEST = 2.0 * 86400.0
#: The numbers of steps by which a table extends beyond the times, and of those of them that are not used, since a
#: spline has larger errors near its ends.
_MARGIN, _EDGE = 10.0, 5.0
_WHAT = "a place on the Earth"


class Earth:
    """The Earth at times of a system's clock, along the system's axes.

    It is ``delayed`` if times are those of arrival of the light, so that the light time within the Earth counts.
    """

    def __init__(self, delayed: bool) -> None:
        self._delayed = delayed
        #: The date of time zero, the first and the last time of a table of the rotation, and its spline.
        self._table: tuple[str, float, float, Any] | None = None

    def axes(self, system: SystemLike, times: Floats) -> Floats:
        """Return the matrices (M, 3, 3) from the frame of the Earth to the axes of a system at times (M,)."""
        elapsed = np.asarray(times, dtype=np.float64) * seconds(system, _WHAT)
        to_system = rotation_to_system("equatorial", system, _WHAT)
        return np.asarray(to_system @ self._rotations(system_epoch(system, _WHAT), elapsed))

    def retarded(self, system: SystemLike, times: Floats, vectors: Floats, rate: Floats, u: Floats) -> Floats:
        """Return vectors (M, 3) from the Earth's centre to places that account for the light time within the Earth.

        The vector of a geometry begins where the barycentre was when the light left it that reaches the Earth's centre.
        The light that reaches a place nearer to the star, which is along ``u`` (M, 3), left it earlier by the depth
        over the speed of light. The vectors are corrected for the motion of the barycentre in this time, whose velocity
        is that of the Earth minus the ``rate`` (M, 3) of the geometry's vector.
        """
        if not self._delayed:
            return vectors
        epoch, second, km = system_epoch(system, _WHAT), seconds(system, _WHAT), kilometres(system, _WHAT)
        velocity = _velocities(epoch, times * second) * (second / km)
        velocity = velocity @ rotation_to_system("equatorial", system, _WHAT).T - rate
        delay = np.sum(vectors * u, axis=-1) / (LIGHT_SPEED * second / km)
        return np.asarray(vectors - velocity * delay[:, None])

    def sunward(self, system: SystemLike, times: Floats) -> Floats:
        """Return unit vectors (M, 3) from the Earth's centre to the Sun at times (M,)."""
        dates = system_epoch(system, _WHAT) + times * seconds(system, _WHAT) * unit_named("s")
        to_sun = barycentric("sun", dates, "builtin") - barycentric("earth", dates, "builtin")
        to_sun /= np.linalg.norm(to_sun, axis=1, keepdims=True)
        return np.asarray(to_sun @ rotation_to_system("equatorial", system, _WHAT).T)

    def _rotations(self, epoch: Any, elapsed: Floats) -> Floats:
        """Return matrices (M, 3, 3) from the frame of the Earth to the axes of the ICRF at times in s after a date."""
        low, high = float(elapsed.min(initial=np.inf)), float(elapsed.max(initial=-np.inf))
        if high - low > _LONGEST or not len(elapsed):
            return _rotations(epoch, elapsed)
        if self._table is None or self._table[0] != str(epoch) or low < self._table[1] or high > self._table[2]:
            from scipy.interpolate import CubicSpline

            low, high = low - _MARGIN * _STEP, high + _MARGIN * _STEP
            nodes = np.linspace(low, high, int((high - low) / _STEP) + 2)
            spline = CubicSpline(nodes, _rotations(epoch, nodes), axis=0)
            self._table = str(epoch), low + _EDGE * _STEP, high - _EDGE * _STEP, spline
        return np.asarray(self._table[3](elapsed))


def _rotations(epoch: Any, elapsed: Floats) -> Floats:
    """Return the matrices (M, 3, 3) from the frame of the Earth to the axes of the ICRF, without downloads."""
    with need("observing", _WHAT):
        from astropy.coordinates import EarthLocation
        from astropy.utils import iers

    axes = EarthLocation.from_geocentric(*(np.eye(3) * 1e3), unit="km")
    times = (epoch + elapsed * unit_named("s"))[:, None]
    with iers.conf.set_temp("auto_download", False), iers.conf.set_temp("auto_max_age", None):
        table = iers.earth_orientation_table.get()
        last = float(table["MJD"].to_value("day").max())
        if float(times.mjd.max(initial=0.0)) > last:
            caution(
                f"the date {times.max().iso} is after the end of the table of the Earth's rotation at MJD {last:.0f}; "
                "stations are off by up to 0.46 km for each second by which the Earth's clock differs then"
            )
        with iers.conf.set_temp("iers_degraded_accuracy", "ignore"):
            positions = axes.get_gcrs_posvel(times)[0]
    return np.moveaxis(positions.xyz.to_value("km"), 0, 1) / 1e3


def _velocities(epoch: Any, elapsed: Floats) -> Floats:
    """Return velocities (M, 3) of the Earth's centre in km/s, from the barycentre of the solar system."""
    from astropy.coordinates import get_body_barycentric_posvel

    velocity = get_body_barycentric_posvel("earth", epoch + elapsed * unit_named("s"), ephemeris="builtin")[1]
    return np.asarray(velocity.xyz.to_value("km/s").T, dtype=np.float64)
