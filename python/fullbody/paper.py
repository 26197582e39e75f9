"""What the paper prints: Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35.

The one source of these numbers for the tables, the figures and the tests.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CPU_TIME", "KW4", "KW4_ERRORS", "KW4_SPIN", "KW4_YEAR", "PaperKW4"]

#: Length of the run of 1999 KW4 in hours.
KW4_YEAR = 365.25 * 24.0

#: CPU time in seconds, the paper's Table 3.
CPU_TIME = {"case1": 22.8, "case2": 129.0, "ellipsoid": 4.6 * 3600.0, "spheroid": 1.1 * 3600.0}


@dataclass(frozen=True, slots=True)
class PaperKW4:
    """One year of 1999 KW4, section 4 of the paper.

    Attributes
    ----------
    e_max : float
        Largest eccentricity.
    a_min, a_max, a_mean : float
        Semi-major axis, km.
    period : float
        Mean orbital period, hours.
    inclination_period : float
        Between two maxima of the inclination to the first orbit's plane, hours; "approximately".
    """

    e_max: float
    a_min: float
    a_max: float
    a_mean: float
    period: float
    inclination_period: float


KW4 = {
    "ellipsoid": PaperKW4(0.0126, 2.5418, 2.5526, 2.5471, 17.4116, 3900.0),
    "spheroid": PaperKW4(0.0140, 2.5433, 2.5521, 2.5477, 17.4177, 3400.0),
}

#: Range of Beta's spin (ellipsoids, first 200 h), 1e-5 rad/s. Does not follow from the stated start.
KW4_SPIN = {"x": (-1.89, 1.86), "y": (-3.20, 3.23), "z": (9.55, 11.16)}

#: Largest relative errors from step to step.
KW4_ERRORS = {"energy": 1e-14, "angular_momentum": 1e-11}
