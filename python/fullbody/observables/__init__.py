"""Observables of a run: periods, precession, libration, obliquities, fates.

Each function takes a :class:`fullbody.Run` and two bodies of its system, by their indices or names: ``body``, which is
observed, and ``about``, which it orbits. Runs should be sampled several times per orbit: ``output=`` a tenth of the
period or less. Between samples the motion follows Kepler orbits, so that an eccentric orbit needs no more samples than
a circular one. A run of fewer revolutions than a function needs is an :class:`fullbody.errors.InvalidInput`, and so are
samples half a revolution apart or more; the error says what spacing to ask for. Angles are in radians; times and rates
are Quantities if the system has units. Results have a method ``as_dict()`` of single numbers by names, for tables and
the maps of :func:`fullbody.sweep`. The functions need scipy, except :func:`fate` and :func:`drift`: ``pip install
scipy``.
"""

from .orbit import (
    ElementRates,
    MeanElements,
    MutualPeriod,
    Precession,
    element_rates,
    mean_elements,
    mutual_period,
    orbit_precession,
)
from .outcome import Drift, Fate, drift, fate
from .shape import Eccentricity, OrbitShape, eccentricity, orbit_shape
from .spin import Libration, Tumbling, libration, obliquity, roll_pitch_yaw, spin_precession, tumbles

__all__ = [
    "Drift",
    "Eccentricity",
    "ElementRates",
    "Fate",
    "Libration",
    "MeanElements",
    "MutualPeriod",
    "OrbitShape",
    "Precession",
    "Tumbling",
    "drift",
    "eccentricity",
    "element_rates",
    "fate",
    "libration",
    "mean_elements",
    "mutual_period",
    "obliquity",
    "orbit_precession",
    "orbit_shape",
    "roll_pitch_yaw",
    "spin_precession",
    "tumbles",
]
