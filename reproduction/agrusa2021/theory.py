"""Small motions of a synchronous ellipsoid on a circular orbit about a point, and where they are in resonance.

With moments A < B < C about axes towards the point, along the motion and along the normal, and with the mean motion as
the unit of frequency, rotations (roll, pitch, yaw) by small angles obey

    C yaw'' + 3 (B - A) yaw = 0,
    A roll'' - (A + B - C) pitch' + (C - B) roll = 0,
    B pitch'' + (A + B - C) roll' + 4 (C - A) pitch = 0,

so that the libration has the frequency sqrt(3 (B - A)/C), and the squares of the other two are the roots x of

    A B x^2 - [4 A (C - A) + B (C - B) + (A + B - C)^2] x + 4 (C - A) (C - B) = 0.

For a nearly round body the larger root is near 1: the slow precession of a pole, seen from the rotating frame. The
smaller one is the nutation.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

__all__ = ["RESONANCES", "frequencies"]


def frequencies(a_b: Any, b_c: Any) -> tuple[Any, Any, Any]:
    """Return the frequencies of libration, precession and nutation of a homogeneous ellipsoid, in mean motions."""
    a, b, c = np.asarray(a_b) * b_c, np.asarray(b_c), 1.0
    # The moments of inertia up to a common factor.
    small, middle, large = b * b + c * c, a * a + c * c, a * a + b * b
    libration = np.sqrt(3 * (middle - small) / large)
    gyric = small + middle - large
    linear = 4 * small * (large - small) + middle * (large - middle) + gyric**2
    root = np.sqrt(linear**2 - 16 * small * middle * (large - small) * (large - middle))
    fast, slow = (np.sqrt((linear + sign * root) / (2 * small * middle)) for sign in (1, -1))
    return libration, fast, slow


#: Combinations of the frequencies (libration, precession, nutation) that vanish at a resonance. The libration resonates
#: with the orbit; the libration, or the orbit with its eccentricity, feeds roll and pitch at the sum, the difference or
#: twice their frequencies.
RESONANCES: dict[str, Callable[[Any, Any, Any], Any]] = {
    "libration = 1": lambda yaw, fast, slow: yaw - 1.0,
    "2 libration = 1": lambda yaw, fast, slow: 2 * yaw - 1.0,
    "libration = 2 nutation": lambda yaw, fast, slow: yaw - 2 * slow,
    "libration = nutation": lambda yaw, fast, slow: yaw - slow,
    "libration = precession - nutation": lambda yaw, fast, slow: yaw - fast + slow,
    "1 = 2 nutation": lambda yaw, fast, slow: 1.0 - 2 * slow,
    "1 = precession - nutation": lambda yaw, fast, slow: 1.0 - fast + slow,
    "2 libration = precession": lambda yaw, fast, slow: 2 * yaw - fast,
    "2 libration = precession + nutation": lambda yaw, fast, slow: 2 * yaw - fast - slow,
}
