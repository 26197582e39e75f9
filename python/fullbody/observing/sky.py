"""The plane of the sky: its axes, offsets of bodies in it, angles with units, and observations of such angles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.unit_names import unit_named
from ..errors import InvalidInput, caution
from ..model.context import SystemLike
from ..typing import Floats
from .columns import Rows, positive_rows
from .data import Observations
from .vectors import cached_rotation, rotation_to_system

#: The largest offset, a degree in radians, that causes no warning if it is a plain number.
_WIDEST = np.pi / 180.0


def sky_axes(system: SystemLike, frame: Any, what: str) -> Floats:
    """Return the matrix (3, 3) from a system's axes to those of the sky."""
    return rotation_to_system(frame, system, what).T


def pole_of(system: SystemLike) -> Floats:
    """Return the north pole (3,) of the sky along the axes of a system, or its z-axis if they are not known."""
    pole = np.array([0.0, 0.0, 1.0])
    return pole if system.context.frame is None else cached_rotation("equatorial", system.context.frame) @ pole


def east_and_north(directions: Floats, pole: Floats) -> Floats:
    """Return unit vectors (..., 2, 3) to the east and to the north at directions (..., 3), for a pole of the sky (3,).

    A direction to a pole of the sky is refused.
    """
    east = np.cross(pole, directions)
    size = np.linalg.norm(east, axis=-1, keepdims=True)
    if not (size > 0.0).all():
        raise InvalidInput(
            "a star or a body is at the pole of the sky, where east and north are not defined; expected another one"
        )
    east = east / size
    return np.stack([east, np.cross(directions, east)], axis=-2)


def offsets(about: Floats, separation: Floats) -> Floats:
    """Return the offsets (K, 2) of bodies on the tangent plane, to the east and to the north.

    The vectors ``about`` (K, 3) go from the observer to the reference body, and ``separation`` (K, 3) from there to
    the other body. The function is analytic and takes complex numbers.
    """
    (x, y, z), (dx, dy, dz) = (np.moveaxis(vectors, -1, 0) for vectors in (about, separation))
    level = np.sqrt(x * x + y * y)
    length = np.sqrt(x * x + y * y + z * z)
    outward = (x * dx + y * dy) / level
    depth = length + (level * outward + z * dz) / length
    return np.stack([(x * dy - y * dx) / level / depth, (level * dz - z * outward) / length / depth], axis=-1)


def in_unit(radians: Floats, unit: Any, power: int = 1) -> Any:
    """Return numbers in a power of radians as a Quantity in that power of a unit; unchanged without a unit."""
    if unit is None:
        return radians
    from astropy import units as u

    # The unit may be dimensionless.
    return (radians * u.rad**power).to(unit**power, equivalencies=u.dimensionless_angles())


def in_mas(radians: Floats, system: SystemLike) -> Any:
    """Return angles in the sky in mas if a system has units, otherwise as they are."""
    return in_unit(radians, unit_named("mas") if system.context.units.defined else None)


def warn_if_wide(radians: Floats, what: str) -> None:
    """Warn of offsets in the sky, given as plain numbers, that are too large for radians."""
    largest = float(np.abs(radians).max())
    if largest > _WIDEST:
        caution(
            f"{what} have values up to {largest:.6g} radians, {np.degrees(largest):.3g} degrees; give arc seconds as "
            f"Quantities, such as {largest:.6g} * u.arcsec"
        )


class SkyObservations(Observations):
    """Base of observations of angles in the sky: K rows of C numbers in radians, with their standard errors."""

    _error_unit = "rad"
    _values: Floats
    _sigma: Floats

    def _set_angles(self, values: Floats, sigma: Floats, unit: Any, frame: Any) -> None:
        """Keep values (K, C) and standard errors in radians, after checks of their sizes."""
        owner = type(self).__name__
        cached_rotation("equatorial", frame)
        if unit is None:
            warn_if_wide(values, f"the offsets of {owner}")
        #: The unit of the angles, ``None`` for plain numbers, which are radians; and the axes of the sky.
        self.unit, self.frame = unit, frame
        self._values, self._sigma = values, positive_rows(sigma, f"sigma of {owner}")

    @property
    def sigma(self) -> Any:
        """Standard errors (K,), or (K, C) with one for each number of a row."""
        return in_unit(self._sigma, self.unit)

    def _observed(self, system: SystemLike) -> Floats:
        return self._values

    def _attach(self, values: Floats, system: SystemLike) -> Any:
        return in_unit(values, self.unit)


class SkyPoints(SkyObservations):
    """Base of observations of points in the sky, each with offsets to the east and to the north."""

    def _read_points(
        self, times: Any, points: Mapping[str, Any], others: dict[str, Floats], geometry: Any, frame: Any, *shape: int
    ) -> Rows:
        """Read ``east``, ``north`` and ``sigma``, which has a shape in each row, and return the rows."""
        rows, unit = self._read(times, points, "rad", ("east", "north"), others)
        super().__init__(rows, geometry)
        self._set_angles(
            np.stack([rows.column("east"), rows.column("north")], axis=1), rows.column("sigma", *shape), unit, frame
        )
        return rows

    @property
    def east(self) -> Any:
        """Offsets (K,) along the parallel to the east."""
        return in_unit(self._values[:, 0], self.unit)

    @property
    def north(self) -> Any:
        """Offsets (K,) along the meridian to the north."""
        return in_unit(self._values[:, 1], self.unit)
