"""Stations that watch an occultation: where they are at any time, from the observer of the geometry."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.unit_names import unit_named
from ..base.units import UNITLESS, gathered, is_quantity, strip_to
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .earth import Earth
from .star import Star, sky_axes
from .times import kilometres
from .vectors import Vectors, turn

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
        #: The Earth and the geocentric places (S, 3) in km along its axes, if the stations are on it.
        self._earth: Earth | None = None
        self._geocentric: Any = None
        locations = list(given) if isinstance(given, list | tuple) else [given]
        if locations and all(hasattr(one, "geodetic") for one in locations):
            self._read_locations(locations)
            self._earth = Earth(geometry.light_time)
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
        self._geocentric = np.concatenate(parts)
        reach = np.linalg.norm(self._geocentric, axis=1)
        if not ((reach > 0.0) & (reach < _LARGEST)).all():
            worst = int(np.argmax(~((reach > 0.0) & (reach < _LARGEST))))
            raise InvalidInput(
                f"station {worst} is {reach[worst]:.6g} km from the centre of the Earth; expected a place on the Earth"
            )

    def __len__(self) -> int:
        return len(self._places) if self._earth is None else len(self._geocentric)

    @property
    def locations(self) -> Any:
        """The stations as an ``EarthLocation`` with S places; an error for others than places on the Earth."""
        if self._earth is None:
            raise InvalidInput("the stations are vectors from an observer; expected EarthLocations")
        from astropy.coordinates import EarthLocation

        return EarthLocation.from_geocentric(*self._geocentric.T, unit="km")

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
            places = self._geocentric[stations] / kilometres(system, "a station on the Earth")
            return np.einsum("kij,kj->ki", self._earth.axes(system, times), places)
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

    def retarded(self, system: SystemLike, times: Floats, vectors: Floats, rate: Floats, u: Floats) -> Floats:
        """Return vectors (M, 3) to the stations that account for the light time within the Earth, if they are on it."""
        return vectors if self._earth is None else self._earth.retarded(system, times, vectors, rate, u)
