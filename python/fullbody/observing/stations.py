"""Stations that watch an occultation: their positions at any time, from the observer of the geometry."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..base.unit_names import unit_named
from ..base.units import UNITLESS, as_quantity, is_quantity, strip_to
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats
from .contacts import Indices, StationPath
from .earth import Earth
from .sky import east_and_north, pole_of
from .star import Star
from .times import kilometres
from .vectors import SystemGeometry, Vectors, rotation_to_system

#: The longest distance in km from the centre of the Earth of a place on it.
_LARGEST = 7000.0

#: The nodes of the polynomials, in units of a step, and the matrix from values there to coefficients.
_NODES = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
_COEFFICIENTS = np.linalg.inv(np.vander(_NODES, increasing=True))

_EXPECTED = (
    "expected EarthLocations, vectors (S, 3) or (S, 2, 3), or offsets (S, 2, 2) in the plane of the sky, from the "
    "observer of the geometry"
)


class Stations:
    """S stations, whose positions are vectors from the observer of the geometry.

    They are places on the Earth, ``EarthLocation``, which need a geometry from its centre; vectors (S, 3) that do not
    change; vectors (S, 2, 3) at the times of disappearance and of reappearance; or the offsets (S, 2, 2) to the east
    and to the north at both times in the plane of the sky through the observer, across the direction to the star.
    Vectors are along the axes of the geometry.
    """

    def __init__(self, stations: Any, geometry: Vectors, star: Star) -> None:
        self._star, self._frame = star, geometry.frame
        #: The Earth, if the stations are on it.
        self._earth: Earth | None = None
        #: Geocentric positions (S, 3) in km along the Earth's axes; or vectors (S, 3) or (S, 2, 3), or offsets
        #: (S, 2, 2), in km if they have a unit and otherwise in the unit of a system.
        self._positions: Floats
        locations = list(stations) if isinstance(stations, list | tuple) else [stations]
        if locations and all(hasattr(location, "geodetic") for location in locations):
            rows = [np.stack([np.ravel(x.to_value("km")) for x in place.geocentric], axis=-1) for place in locations]
            self._positions, self._earth = np.concatenate(rows), Earth(geometry.light_time)
            distance = np.linalg.norm(self._positions, axis=1)
            if not (on_earth := (distance > 0.0) & (distance < _LARGEST)).all():
                worst = int(np.argmin(on_earth))
                raise InvalidInput(
                    f"station {worst} is {distance[worst]:.6g} km from the centre of the Earth; expected a place on "
                    "the Earth"
                )
            return
        positions = as_quantity(stations, "stations", "length")
        self._has_unit = is_quantity(positions)
        positions = strip_to(positions, unit_named("km"), "stations") if self._has_unit else positions
        self._positions = UNITLESS.numbers(positions, "number", "stations")
        shape = self._positions.shape
        if shape[1:] not in ((3,), (2, 2), (2, 3)):
            raise InvalidInput(f"stations has shape {shape}; {_EXPECTED}")

    def __len__(self) -> int:
        return len(self._positions)

    @property
    def locations(self) -> Any:
        """The stations as an ``EarthLocation`` with S places; an error for others than places on the Earth."""
        if self._earth is None:
            raise InvalidInput("the stations are vectors from an observer; expected EarthLocations")
        from astropy.coordinates import EarthLocation

        return EarthLocation.from_geocentric(*self._positions.T, unit="km")

    @property
    def vectors(self) -> Any:
        """The given vectors or offsets, numbers or a Quantity in km."""
        return self._positions * unit_named("km") if self._has_unit else self._positions

    @property
    def has_two_times(self) -> bool:
        """Whether the stations are given at the two times of each chord."""
        return self._positions.ndim == 3

    @property
    def on_earth(self) -> bool:
        """Whether the stations are places on the Earth."""
        return self._earth is not None

    def offsets(self, system: SystemLike, stations: Any, times: Floats, ends: Floats | None = None) -> Floats:
        """Return vectors (M, 3) from the observer to stations (M,) at times (M,), in the system's units and axes.

        Stations that are given at two times move uniformly through these positions at the ``ends`` (M, 2), which are
        these times.
        """
        positions = self._positions[stations]
        if self._earth is not None:
            positions = positions / kilometres(system, "a station on the Earth")
            return np.einsum("kij,kj->ki", self._earth.axes(system, times), positions)
        if self._has_unit:
            positions = positions / kilometres(system, "stations with a unit")
        if positions.ndim == 3:
            if ends is None:
                raise InvalidInput(
                    f"stations has shape {self._positions.shape}, vectors at two times, which only data of chords "
                    "have; expected EarthLocations or vectors (S, 3)"
                )
            # A station with one known time does not move.
            has_both = np.isfinite(ends).all(axis=1)
            first, last = (np.where(has_both, end, default) for end, default in zip(ends.T, (0.0, 1.0), strict=True))
            share = np.where(has_both, (times - first) / (last - first), ~np.isfinite(ends[:, 0]))
            positions = positions[:, 0] + share[:, None] * (positions[:, 1] - positions[:, 0])
        if positions.shape[-1] == 2:
            return np.einsum("ka,kax->kx", positions, self.sky_axes(system, times))
        if self._frame is None:
            return positions
        what = f"a station along the axes {self._frame!r}"
        return np.asarray(positions @ rotation_to_system(self._frame, system, what).T)

    def positions(
        self, system: SystemLike, local: SystemGeometry, stations: Any, times: Floats, ends: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Return vectors from the barycentre to stations (M,) at times (M,), and unit vectors to the star, (M, 3) both.

        They account for the light time within the Earth. Before and after the ``local`` geometry the observer moves
        uniformly.
        """
        inside, u = np.clip(times, *local.ends()), self._star.directions(system, times)
        offsets, rate = self.offsets(system, stations, times, ends), None
        if self._earth is not None:
            rate = local.observer_velocity(inside)
            offsets = self._earth.retarded(system, times, offsets, rate, u)
        observer = local.observer(inside)
        if (outside := times - inside).any():
            observer = observer + (local.observer_velocity(inside) if rate is None else rate) * outside[:, None]
        return observer + offsets, u

    def sky_axes(self, system: SystemLike, times: Floats) -> Floats:
        """Return unit vectors (M, 2, 3) to the east and to the north in the plane of the sky, in the system's axes."""
        return east_and_north(self._star.directions(system, times), pole_of(system))


class StationPaths:
    """The paths of the stations of K rows: quartic polynomials about the times (K,) of the rows.

    The function ``positions`` from times (K,) to vectors (K, 3) from the barycentre to the stations and to unit vectors
    (K, 3) to the star is called at nodes that are a ``step`` apart. The Earth rotates by 7e-5 rad in a second, so that
    the error after n steps of s seconds is below (7e-5 n s)^5 of its radius.
    """

    def __init__(self, times: Floats, step: float, positions: Callable[[Floats], tuple[Floats, Floats]]) -> None:
        self._times = times
        scale = step ** -np.arange(5.0)
        #: The vectors at the times, which are long, and the polynomials (4, K, 3) of their changes.
        self._vectors, self._polynomials = [], []
        for at_nodes in zip(*(positions(times + node * step) for node in _NODES), strict=True):
            changes = np.stack([vectors - at_nodes[2] for vectors in at_nodes])
            self._vectors.append(at_nodes[2].copy())
            self._polynomials.append(np.einsum("pn,nkx->pkx", scale[:, None] * _COEFFICIENTS, changes))

    def __call__(self, index: Indices, times: Floats) -> StationPath:
        """Return the path at times (M,) of rows with indices (M,)."""
        elapsed = (times - self._times[index])[:, None]
        position, star = (
            vectors[index] + np.polynomial.polynomial.polyval(elapsed, polynomial[:, index], tensor=False)
            for vectors, polynomial in zip(self._vectors, self._polynomials, strict=True)
        )
        rate = np.arange(1.0, 5.0)[:, None, None] * self._polynomials[0][1:, index]
        return StationPath(position, np.polynomial.polynomial.polyval(elapsed, rate, tensor=False), star)
