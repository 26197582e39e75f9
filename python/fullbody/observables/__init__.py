"""What observers measure, from a run: periods, precession, libration, obliquities.

Each function takes a :class:`fullbody.Run` and two places in its system, the body looked at and the one it goes about.
Runs are to be sampled several times an orbit: ``output=`` a tenth of the period or less. Between the samples the motion
is followed along Kepler orbits, so that an eccentric orbit needs no more of them than a round one; where samples are
too far apart for that, the error says what spacing to ask for. Lengths of time and rates are Quantities where the
system has units. They need scipy: ``pip install fullbody[analysis]``.
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


def __dir__() -> list[str]:
    return __all__
