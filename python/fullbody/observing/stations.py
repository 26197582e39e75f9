"""Stations that watch an occultation: where they are at any time, from the observer of the geometry."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.unit_names import unit_named
from ..base.units import UNITLESS, gathered, is_quantity, need, strip_to
from ..errors import InvalidInput, caution
from ..model.context import SystemLike
from ..typing import Floats
from .star import Star, sky_axes
from .times import LIGHT_SPEED, kilometres, seconds, system_epoch
from .vectors import Vectors, turn

#: The step in s of a table of the Earth's rotation, whose spline has an error of 1e-12.
_STEP = 60.0
#: The longest table of the Earth's rotation in s; times that are farther apart have no table.
_LONGEST = 2.0 * 86400.0
#: The numbers of steps by which a table extends beyond the times, and of those of them that are not used.
_MARGIN, _EDGE = 10.0, 5.0
#: The longest distance in km from the centre of the Earth of a place on it.
_LARGEST = 7000.0

_EXPECTED = (
    "expected EarthLocations, vectors (S, 3) or (S, 2, 3), or places (S, 2, 2) in the plane of the sky, from the "
    "observer of the geometry"
)


class Stations:
    """S stations, whose places are vectors from the observer of the geometry.

    Parameters
    ----------
    given : EarthLocation, sequence of them, or array_like or Quantity, (S, 3), (S, 2, 3) or (S, 2, 2)
        Places on the Earth, which need a geometry from its centre; vectors that do not change; vectors at the times of
        disappearance and of reappearance; or the offsets to the east and to the north at both times in the plane of the
        sky through the observer, across the direction to the star. Vectors are along the axes of the geometry.
    geometry : Geometry
    star : Star
    """

    def __init__(self, given: Any, geometry: Vectors, star: Star) -> None:
        self._star, self._frame = star, geometry.frame
        self._delayed = geometry.light_time
        self._earth: Any = None
        #: The date of time zero, the first and the last time of a table of the Earth's rotation, and its spline.
        self._table: tuple[str, float, float, Any] | None = None
        locations = list(given) if isinstance(given, list | tuple) else [given]
        if locations and all(hasattr(one, "geodetic") for one in locations):
            self._read_locations(locations)
            return
        places = gathered(given, "stations", "length")
        plain = strip_to(places, unit_named("km"), "stations") if is_quantity(places) else places
        plain = UNITLESS.numbers(plain, "number", "stations")
        self._is_united = is_quantity(places)
        #: The vectors (S, 3) or (S, 2, 3), or offsets (S, 2, 2), in km or in the units of a system.
        self._places = plain
        moving = plain.ndim == 3 and plain.shape[1] == 2 and plain.shape[2] in (2, 3)
        if not (moving or (plain.ndim == 2 and plain.shape[1] == 3)):
            raise InvalidInput(f"stations has shape {plain.shape}; {_EXPECTED}")

    def _read_locations(self, locations: list[Any]) -> None:
        """Read geocentric places (S, 3) in km."""
        parts = [np.stack([np.ravel(one.to_value("km")) for one in place.geocentric], axis=-1) for place in locations]
        self._earth = np.concatenate(parts)
        reach = np.linalg.norm(self._earth, axis=1)
        if not ((reach > 0.0) & (reach < _LARGEST)).all():
            worst = int(np.argmax(~((reach > 0.0) & (reach < _LARGEST))))
            raise InvalidInput(
                f"station {worst} is {reach[worst]:.6g} km from the centre of the Earth; expected a place on the Earth"
            )

    def __len__(self) -> int:
        return len(self._places) if self._earth is None else len(self._earth)

    @property
    def locations(self) -> Any:
        """The stations as an ``EarthLocation`` with S places; an error for others than places on the Earth."""
        if self._earth is None:
            raise InvalidInput("the stations are vectors from an observer; expected EarthLocations")
        from astropy.coordinates import EarthLocation

        return EarthLocation.from_geocentric(*self._earth.T, unit="km")

    @property
    def vectors(self) -> Any:
        """The given vectors or places, numbers or a Quantity in km."""
        return self._places * unit_named("km") if self._is_united else self._places

    @property
    def move(self) -> bool:
        """Whether the stations are given at the two times of each chord."""
        return self._earth is None and self._places.ndim == 3

    @property
    def on_earth(self) -> bool:
        """Whether the stations are places on the Earth."""
        return self._earth is not None

    def at(self, system: SystemLike, stations: Any, times: Floats, ends: Floats | None = None) -> Floats:
        """Return vectors (M, 3) from the observer to stations (M,) at times (M,), in the system's units and axes.

        Stations that are given at two times move evenly through their places at the ``ends`` (M, 2), which are these
        times.
        """
        if self._earth is not None:
            return self._on_earth(system, np.asarray(stations), times)
        length = kilometres(system, "stations with a unit") if self._is_united else 1.0
        places = self._places[stations] / length
        if places.ndim == 3:
            if ends is None:
                raise InvalidInput(
                    f"stations has shape {self._places.shape}, vectors at two times, which only data of chords have; "
                    "expected EarthLocations or vectors (S, 3)"
                )
            # A station of which one time is known stays where it was then.
            known = np.isfinite(ends).all(axis=1)
            first, last = (np.where(known, end, offset) for end, offset in zip(ends.T, (0.0, 1.0), strict=True))
            share = np.where(known, (times - first) / (last - first), ~np.isfinite(ends[:, 0]))
            places = places[:, 0] + share[:, None] * (places[:, 1] - places[:, 0])
        if places.shape[-1] == 2:
            east, north = self.plane(system, times)
            return np.asarray(places[:, :1] * east + places[:, 1:] * north)
        return places if self._frame is None else places @ self._axes(system, self._frame).T

    def plane(self, system: SystemLike, times: Floats) -> tuple[Floats, Floats]:
        """Return unit vectors (M, 3) to the east and to the north in the plane of the sky, along the system's axes."""
        north = np.array([0.0, 0.0, 1.0])
        if system.context.frame is not None:
            north = turn("equatorial", system.context.frame) @ north
        return sky_axes(self._star.directions(system, times), north)

    @staticmethod
    def _axes(system: SystemLike, frame: Any) -> Floats:
        if system.context.frame is None:
            raise InvalidInput(
                f"the stations are along the axes {frame!r}, and those of the system are not known; "
                "give fullbody.System(..., frame='ecliptic')"
            )
        return turn(frame, system.context.frame)

    def _on_earth(self, system: SystemLike, stations: Any, times: Floats) -> Floats:
        """Return vectors (M, 3) from the centre of the Earth, in the system's units and axes."""
        what = "a station on the Earth"
        epoch, second, km = system_epoch(system, what), seconds(system, what), kilometres(system, what)
        since = np.asarray(times, dtype=np.float64) * second
        found = np.einsum("kij,kj->ki", self._rotation(epoch, since), self._earth[stations])
        return found @ self._axes(system, "equatorial").T / km

    def _rotation(self, epoch: Any, since: Floats) -> Floats:
        """Return matrices (M, 3, 3) from the frame of the Earth to the axes of the ICRF at times in s after a date."""
        low, high = float(since.min(initial=np.inf)), float(since.max(initial=-np.inf))
        if high - low > _LONGEST or not len(since):
            return _earth_rotations(epoch, since)
        if self._table is None or self._table[0] != str(epoch) or low < self._table[1] or high > self._table[2]:
            from scipy.interpolate import CubicSpline

            low, high = low - _MARGIN * _STEP, high + _MARGIN * _STEP
            nodes = np.linspace(low, high, int((high - low) / _STEP) + 2)
            spline = CubicSpline(nodes, _earth_rotations(epoch, nodes), axis=0)
            # A spline has larger errors near its ends.
            self._table = str(epoch), low + _EDGE * _STEP, high - _EDGE * _STEP, spline
        return np.asarray(self._table[3](since))

    def retarded(self, system: SystemLike, times: Floats, vectors: Floats, rate: Floats, u: Floats) -> Floats:
        """Return vectors (M, 3) to stations on the Earth that account for the light time within the Earth.

        The vector of a geometry begins where the barycentre was when the light left it that reaches the observer. The
        light that reaches a station nearer to the star left it earlier, by the depth over the speed of light, when the
        barycentre had not yet moved on. Its velocity is that of the Earth minus the ``rate`` (M, 3) of the vector.
        """
        if self._earth is None or not self._delayed:
            return vectors
        what = "a station on the Earth"
        epoch, second, km = system_epoch(system, what), seconds(system, what), kilometres(system, what)
        velocity = _earth_velocities(epoch, times * second) @ self._axes(system, "equatorial").T * (second / km) - rate
        delay = np.sum(vectors * u, axis=-1) / (LIGHT_SPEED * second / km)
        return np.asarray(vectors - velocity * delay[:, None])


def _earth_rotations(epoch: Any, since: Floats) -> Floats:
    """Return the matrices (M, 3, 3) from the frame of the Earth to the axes of the ICRF, by tables that are at hand."""
    with need("observing", "a station on the Earth"):
        from astropy import units as u
        from astropy.coordinates import EarthLocation
        from astropy.utils import iers

    unit = EarthLocation.from_geocentric(*(np.eye(3) * 1e3), unit="km")
    times = (epoch + since * u.s)[:, None]
    with iers.conf.set_temp("auto_download", False), iers.conf.set_temp("auto_max_age", None):
        table = iers.earth_orientation_table.get()
        last = float(table["MJD"].to_value("day").max())
        if float(times.mjd.max(initial=0.0)) > last:
            caution(
                f"the date {times.max().iso} is after the end of the table of the Earth's rotation at MJD {last:.0f}; "
                "stations are off by up to 0.46 km for each second by which the Earth's clock differs then"
            )
        with iers.conf.set_temp("iers_degraded_accuracy", "ignore"):
            places = unit.get_gcrs_posvel(times)[0]
    return np.moveaxis(places.xyz.to_value("km"), 0, 1) / 1e3


def _earth_velocities(epoch: Any, since: Floats) -> Floats:
    """Return velocities (M, 3) of the Earth's centre in km/s, from the barycentre of the solar system."""
    from astropy import units as u
    from astropy.coordinates import get_body_barycentric_posvel

    velocity = get_body_barycentric_posvel("earth", epoch + since * u.s, ephemeris="builtin")[1]
    return np.asarray(velocity.xyz.to_value("km/s").T, dtype=np.float64)
