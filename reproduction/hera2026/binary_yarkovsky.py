"""The binary Yarkovsky effect on Dimorphos after Zhou et al. (2024), and its consequences until Hera arrives."""

from __future__ import annotations

from typing import Final

from . import measures
from .inputs import INPUTS

__all__ = ["RATE", "consequences"]

#: The drift of the semi-major axis if Dimorphos left synchronous rotation, cm a year (Z24, first version's abstract).
RATE: Final = -7.0
#: Hours in a Julian year.
YEAR: Final = 8766.0


def consequences(rate: float, semi_major_axis: float, hours: float = measures.ARRIVAL_TIME) -> dict[str, float]:
    """Return the changes of period and longitude by a steady drift of the semi-major axis from the impact on.

    Parameters
    ----------
    rate : float
        The drift in cm a year.
    semi_major_axis : float
        The semi-major axis in m.
    hours : float
        The time since the impact, by default that of the arrival of Hera.

    Returns
    -------
    dict
        ``period``, the change of the period in s, and ``longitude``, that of Dimorphos along its orbit in degrees.

    Notes
    -----
    By Kepler's third law the period P changes by 3/2 P da/a, and the longitude by -3/4 (2 pi/P) t^2 (da/dt)/a.
    """
    years = hours / YEAR
    relative = rate / 100.0 / semi_major_axis
    period = INPUTS["period"].value
    return {
        "period": 1.5 * 3600.0 * period * relative * years,
        "longitude": -0.75 * 360.0 / period * hours * relative * years,
    }
