"""Statements of the abstract of Agrusa et al. (2021), and the assumptions of this study."""

from __future__ import annotations

from typing import Final

__all__ = ["ASSUMED", "STATED"]

STATED: Final = {
    "question": "the attitude stability of Dimorphos after DART as a function of a/b, b/c and beta",
    "theory": "on a circular orbit about a point there are four fundamental frequencies: the mean motion and those of "
    "libration, precession and nutation; where they are in resonance, attitude instabilities are possible",
    "runs": "fully coupled runs recover many of these resonances, and the attitude is unstable near them",
    "roll": "Dimorphos is especially prone to unstable rotation about its long axis",
}
ASSUMED: Final = {
    "Didymos": "an ellipsoid of 0.838 x 0.832 x 0.786 km that rotates in 2.26 h",
    "Dimorphos": "the volume of a sphere of 0.164 km in diameter, with Didymos' density; synchronous and upright",
    "orbit": "circular before the impact, at 1.19 km; the total mass is that of a Kepler orbit of 11.9217 h there",
    "impact": "against the motion, 10 degrees out of the orbit's plane, through the centre: 535 kg at 6.6 km/s, times "
    "beta",
    "beta": "1 and 3",
    "grid": "a/b and b/c from 1.02 to 1.50 by 0.02",
    "length": "365 days, sampled every half hour",
    "unstable": "a roll, pitch or yaw beyond 60 degrees",
}
