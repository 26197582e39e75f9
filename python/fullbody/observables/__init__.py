"""Observables of a run: periods, precession, libration, obliquities.

Each function takes a :class:`fullbody.Run` and two bodies of its system: ``body``, which is observed, and ``about``,
which it orbits. Runs should be sampled several times per orbit: ``output=`` a tenth of the period or less. Between
samples the motion follows Kepler orbits, so that an eccentric orbit needs no more samples than a circular one; if
samples are too far apart for that, the error says what spacing to ask for. Times and rates are Quantities if the system
has units. The functions need scipy: ``pip install fullbody[analysis]``.
"""

from .orbit import ElementRates, MutualPeriod, Precession, element_rates, mutual_period, orbit_precession
from .shape import Eccentricity, OrbitShape, eccentricity, orbit_shape
from .spin import Libration, libration, obliquity, roll_pitch_yaw, spin_precession
from .tumbling import Tumbling, tumbles

__all__ = [
    "Eccentricity",
    "ElementRates",
    "Libration",
    "MutualPeriod",
    "OrbitShape",
    "Precession",
    "Tumbling",
    "eccentricity",
    "element_rates",
    "libration",
    "mutual_period",
    "obliquity",
    "orbit_precession",
    "orbit_shape",
    "roll_pitch_yaw",
    "spin_precession",
    "tumbles",
]
