"""The time in which the inelastic dissipation that the study leaves out would damp a roll."""

from __future__ import annotations

from typing import Final

import numpy as np

from .inputs import INPUTS

__all__ = ["SHAPE_FACTORS", "years"]

#: The assumed range of the factor D of the shape, which is "a few times 10^2" (S05).
SHAPE_FACTORS: Final = (200.0, 400.0)
G: Final = 6.6743e-11
YEAR: Final = 365.25 * 86400.0


def years(k2_q: float, shape_factor: float) -> float:
    """Return the time in years in which a rotation about no principal axis is damped, by its order of magnitude.

    Parameters
    ----------
    k2_q : float
        k2/Q of Dimorphos, as for its tides.
    shape_factor : float

    Notes
    -----
    The time is D mu Q/(rho R^2 omega^3) (S05), with rigidity mu, density rho, radius R and rotation omega. An elastic
    sphere that is stiffer than its gravity has k2 = 3 rho g R/(19 mu), with g = 4/3 pi G rho R. Together they give
    4 pi G rho D/(19 omega^3 k2/Q), in which neither mu nor R remains.
    """
    rotation = 2.0 * np.pi / (3600.0 * INPUTS["period"].value)
    time = 4.0 * np.pi * G * INPUTS["density"].value * shape_factor / (19.0 * rotation**3 * k2_q)
    return float(time / YEAR)
