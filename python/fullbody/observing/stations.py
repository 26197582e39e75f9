"""Stations that watch an occultation: where they are at any time, from the observer of the geometry."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.unit_names import unit_named
from ..base.units import UNITLESS, as_quantity, is_quantity, strip_to
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .contacts import Path
from .earth import Earth
from .sky import east_and_north, pole_of
from .star import Star
from .times import kilometres
from .vectors import Vectors, turn

#: The longest distance in km from the centre of the Earth of a place on it.
_LARGEST = 7000.0

#: The nodes of the polynomials, in units of a step, and the matrix from values there to coefficients.
_NODES = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
_COEFFICIENTS = np.linalg.inv(np.vander(_NODES, increasing=True))

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

    def __init__(self, stations: Any, geometry: Vectors, star: Star) -> None:
        self._star, self._frame = star, geometry.frame
        #: The Earth and the geocentric places (S, 3) in km along its axes, if the stations are on it.
        self._earth: Earth | None = None
        self._geocentric: Any = None
        locations = list(stations) if isinstance(stations, list | tuple) else [stations]
        if locations and all(hasattr(coordinate, "geodetic") for coordinate in locations):
            self._read_locations(locations)
            self._earth = Earth(geometry.light_time)
            return
        positions = as_quantity(stations, "stations", "length")
        numbers = strip_to(positions, unit_named("km"), "stations") if is_quantity(positions) else positions
        numbers = UNITLESS.numbers(numbers, "number", "stations")
        self._is_united = is_quantity(positions)
        #: The vectors (S, 3) or (S, 2, 3), or offsets (S, 2, 2), in km or in the units of a system.
        self._positions = numbers
        moving = numbers.ndim == 3 and numbers.shape[1] == 2 and numbers.shape[2] in (2, 3)
        if not (moving or (numbers.ndim == 2 and numbers.shape[1] == 3)):
            raise InvalidInput(f"stations has shape {numbers.shape}; {_EXPECTED}")

    def _read_locations(self, locations: list[Any]) -> None:
        """Read geocentric places (S, 3) in km."""
        self._geocentric = np.concatenate(
            [np.stack([np.ravel(x.to_value("km")) for x in location.geocentric], axis=-1) for location in locations]
        )
        reach = np.linalg.norm(self._geocentric, axis=1)
        if not ((reach > 0.0) & (reach < _LARGEST)).all():
            worst = int(np.argmax(~((reach > 0.0) & (reach < _LARGEST))))
            raise InvalidInput(
                f"station {worst} is {reach[worst]:.6g} km from the centre of the Earth; expected a place on the Earth"
            )

    def __len__(self) -> int:
        return len(self._positions) if self._earth is None else len(self._geocentric)

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
        return self._positions * unit_named("km") if self._is_united else self._positions

    @property
    def move(self) -> bool:
        """Whether the stations are given at the two times of each chord."""
        return self._earth is None and self._positions.ndim == 3

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
            positions = self._geocentric[stations] / kilometres(system, "a station on the Earth")
            return np.einsum("kij,kj->ki", self._earth.axes(system, times), positions)
        length = kilometres(system, "stations with a unit") if self._is_united else 1.0
        positions = self._positions[stations] / length
        if positions.ndim == 3:
            if ends is None:
                raise InvalidInput(
                    f"stations has shape {self._positions.shape}, vectors at two times, which only data of chords "
                    "have; expected EarthLocations or vectors (S, 3)"
                )
            # A station of which one time is known stays where it was then.
            has_both = np.isfinite(ends).all(axis=1)
            first, last = (np.where(has_both, end, offset) for end, offset in zip(ends.T, (0.0, 1.0), strict=True))
            share = np.where(has_both, (times - first) / (last - first), ~np.isfinite(ends[:, 0]))
            positions = positions[:, 0] + share[:, None] * (positions[:, 1] - positions[:, 0])
        if positions.shape[-1] == 2:
            return np.einsum("ka,kax->kx", positions, self.plane(system, times))
        return positions if self._frame is None else positions @ self._axes(system, self._frame).T

    def plane(self, system: SystemLike, times: Floats) -> Floats:
        """Return unit vectors (M, 2, 3) to the east and to the north in the plane of the sky, in the system's axes."""
        return east_and_north(self._star.directions(system, times), pole_of(system))

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


class StationPaths:
    """The paths of the stations of K rows: quartic polynomials about the times of the rows.

    Parameters
    ----------
    times : ndarray, (K,)
    step : float
        The time between the nodes. The Earth turns by 7e-5 rad in a second, so that the error after n steps of s
        seconds is below (7e-5 n s)^5 of its radius.
    places : callable
        The function from times (K,) to the vectors (K, 3) from the barycentre to the stations, and to unit vectors
        (K, 3) to the star.
    """

    def __init__(self, times: Floats, step: float, positions: Callable[[Floats], tuple[Floats, Floats]]) -> None:
        self._times = times
        at_nodes = [positions(times + node * step) for node in _NODES]
        scale = step ** -np.arange(5.0)
        # The vectors are long, and their changes are taken from that at the middle.
        self._middle = tuple(part.copy() for part in at_nodes[2])
        self._polynomials = tuple(
            np.einsum(
                "pn,nkx->pkx", scale[:, None] * _COEFFICIENTS, np.stack([item[k] - at_nodes[2][k] for item in at_nodes])
            )
            for k in (0, 1)
        )

    def __call__(self, index: npt.NDArray[np.intp], times: Floats) -> Path:
        """Return the path at times (M,) of rows with indices (M,)."""
        since = (times - self._times[index])[:, None]
        position, star = (
            middle[index] + _value(polynomial[:, index], since)
            for middle, polynomial in zip(self._middle, self._polynomials, strict=True)
        )
        rate = np.arange(1.0, 5.0)[:, None, None] * self._polynomials[0][1:, index]
        return Path(position, _value(rate, since), star)


def _value(coefficients: Floats, since: Floats) -> Floats:
    """Return the values (M, 3) of polynomials with coefficients (P, M, 3), from the lowest power on."""
    value = coefficients[-1]
    for part in coefficients[-2::-1]:
        value = value * since + part
    return value
