"""Observations of systems: geometry of observer and Sun, predictions, and comparison with data.

A :class:`Geometry` contains the directions of the observer and the Sun. :func:`brightness` and :func:`light_curve`
compute the light of the bodies, :func:`mutual_events` their occultations and eclipses. :class:`Astrometry`,
:class:`Photometry`, :class:`RadarAstrometry` and :class:`Measured` hold data, and compute the predictions of a run for
them, with residuals and chi2.

Install the dependencies with the extra ``observing``.
"""

from __future__ import annotations

from .astrometry import Astrometry
from .brightness import BrightnessDerivatives, brightness, brightness_derivatives
from .geometry import Geometry
from .laws import HG, HG1G2, Hapke, Lambert, LommelSeeliger, LommelSeeligerLambert
from .light_curve import light_curve, zero_point
from .linear import Held, LinearModel, LinearUnknown
from .measured import Measured
from .mutual import mutual_events, occultation
from .mutual_event import MutualEvent, MutualEvents
from .photometry import Photometry
from .radar import RadarAstrometry, RangeAndRate
from .series import RotationSeries

__all__ = [
    "HG",
    "HG1G2",
    "Astrometry",
    "BrightnessDerivatives",
    "Geometry",
    "Hapke",
    "Held",
    "Lambert",
    "LinearModel",
    "LinearUnknown",
    "LommelSeeliger",
    "LommelSeeligerLambert",
    "Measured",
    "MutualEvent",
    "MutualEvents",
    "Photometry",
    "RadarAstrometry",
    "RangeAndRate",
    "RotationSeries",
    "brightness",
    "brightness_derivatives",
    "light_curve",
    "mutual_events",
    "occultation",
    "zero_point",
]


def __dir__() -> list[str]:
    return __all__
