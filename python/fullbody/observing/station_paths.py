"""Paths of stations near the times of K rows, as polynomials in time, which are evaluated many times."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ..typing import Floats
from .contacts import Path

#: The nodes of the polynomials, in units of a step, and the matrix from values there to coefficients.
_NODES = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
_COEFFICIENTS = np.linalg.inv(np.vander(_NODES, increasing=True))


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

    def __init__(self, times: Floats, step: float, places: Callable[[Floats], tuple[Floats, Floats]]) -> None:
        self._times = times
        found = [places(times + node * step) for node in _NODES]
        scale = step ** -np.arange(5.0)
        # The vectors are long, and their changes are taken from that at the middle.
        self._middle = tuple(part.copy() for part in found[2])
        self._polynomials = tuple(
            np.einsum(
                "pn,nkx->pkx", scale[:, None] * _COEFFICIENTS, np.stack([item[k] - found[2][k] for item in found])
            )
            for k in (0, 1)
        )

    def __call__(self, index: npt.NDArray[np.intp], times: Floats) -> Path:
        """Return the path at times (M,) of rows with indices (M,)."""
        since = (times - self._times[index])[:, None]
        place, star = (
            middle[index] + _value(polynomial[:, index], since)
            for middle, polynomial in zip(self._middle, self._polynomials, strict=True)
        )
        rate = np.arange(1.0, 5.0)[:, None, None] * self._polynomials[0][1:, index]
        return Path(place, _value(rate, since), star)


def _value(coefficients: Floats, since: Floats) -> Floats:
    """Return the values (M, 3) of polynomials with coefficients (P, M, 3), from the lowest power on."""
    value = coefficients[-1]
    for part in coefficients[-2::-1]:
        value = value * since + part
    return value
