"""The common part of observations of angles in the sky, which are kept in radians."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..model.context import SystemLike
from ..typing import Floats
from .columns import Rows, positive_rows
from .data import Observations
from .sky import in_unit, warn_if_wide
from .vectors import turn


class SkyObservations(Observations):
    """Base of observations of angles in the sky: K rows of C numbers in radians, with their standard errors.

    Attributes
    ----------
    unit : unit or None
        The unit of the angles; ``None`` for plain numbers, which are radians.
    frame : str or astropy frame
        The axes of the sky.
    """

    _error_unit = "rad"
    _values: Floats
    _sigma: Floats

    def _keep(self, values: Floats, sigma: Floats, unit: Any, frame: Any) -> None:
        """Keep values (K, C) and standard errors in radians, after checks of their sizes."""
        owner = type(self).__name__
        turn("equatorial", frame)
        if unit is None:
            warn_if_wide(values, f"the offsets of {owner}")
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
        self._keep(np.stack([rows.of("east"), rows.of("north")], axis=1), rows.of("sigma", *shape), unit, frame)
        return rows

    @property
    def east(self) -> Any:
        """Offsets (K,) along the parallel to the east."""
        return in_unit(self._values[:, 0], self.unit)

    @property
    def north(self) -> Any:
        """Offsets (K,) along the meridian to the north."""
        return in_unit(self._values[:, 1], self.unit)
