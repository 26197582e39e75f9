"""Numbers that Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35, print of 1999 KW4's year."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CPU_TIME", "ERRORS", "SPIN", "SPIN_HOURS", "YEAR", "YEAR_HOURS", "Printed"]

#: The length of the run, hours.
YEAR_HOURS = 365.25 * 24.0


@dataclass(frozen=True, slots=True)
class Printed:
    """The orbit of Beta about Alpha in one year, section 4 and Fig. 7.

    Attributes
    ----------
    e_max : float
        Largest eccentricity.
    a_min, a_max, a_mean : float
        Semi-major axis, km.
    period : float
        Mean orbital period, hours.
    inclination_period : float
        Time between two maxima of the inclination to the first orbit's plane, hours; "approximately" in the paper.
    """

    e_max: float
    a_min: float
    a_max: float
    a_mean: float
    period: float
    inclination_period: float


YEAR = {
    "ellipsoid": Printed(0.0126, 2.5418, 2.5526, 2.5471, 17.4116, 3900.0),
    "spheroid": Printed(0.0140, 2.5433, 2.5521, 2.5477, 17.4177, 3400.0),
}

#: The range of Beta's spin (ellipsoids, first 200 h), 1e-5 rad/s, Fig. 8. It does not follow from the stated start.
SPIN = {"x": (-1.89, 1.86), "y": (-3.20, 3.23), "z": (9.55, 11.16)}
SPIN_HOURS = 200.0

#: The largest relative errors from step to step, Fig. 9.
ERRORS = {"energy": 1e-14, "angular_momentum": 1e-11}

#: The CPU time of the year, Table 3, in seconds.
CPU_TIME = {"ellipsoid": 4.6 * 3600.0, "spheroid": 1.1 * 3600.0}
