"""Observations of systems: geometry of observer and Sun, predictions, and comparison with data.

A :class:`Geometry` contains the directions of the observer and the Sun. :func:`brightness` and :func:`light_curve`
compute the light of the bodies, :func:`combined_light` its centre, :func:`outline` their limbs, :func:`mutual_events`
their occultations and eclipses, :func:`occultation_chords` the occultations of stars by them, and
:func:`radar_spectrum` and :func:`delay_doppler` their radar echoes. :class:`Astrometry`, :class:`Photometry`,
:class:`Photocentre`, :class:`Outline`, :class:`StellarOccultation`, :class:`RadarAstrometry`, :class:`RadarSpectrum`,
:class:`DelayDoppler` and :class:`Measured` hold data, and compute the predictions of a run for them, with residuals and
chi2. :func:`read_damit` and :func:`read_alcdef` read light curves of archives.

Install the dependencies with the extra ``observing``.
"""

from __future__ import annotations

from .alcdef import read_alcdef, write_alcdef
from .astrometry import Astrometry
from .brightness import BrightnessDerivatives, brightness, brightness_derivatives
from .chords import Chord, Chords, Miss, occultation_chords
from .damit import DamitModel, read_damit, read_damit_model
from .data import Observations
from .geometry import Geometry
from .laws import (
    HG,
    HG1G2,
    Cosine,
    Gaussian,
    Hagfors,
    Hapke,
    Lambert,
    LinearExponential,
    LommelSeeliger,
    LommelSeeligerLambert,
    RadarLaw,
)
from .light_centres import CombinedLight, combined_light
from .light_curve import light_curve, zero_point
from .linear import Held, LinearModel, LinearUnknown
from .measured import Measured
from .mutual import mutual_events, occultation
from .mutual_event import MutualEvent, MutualEvents
from .outlines import Outline, SkyOutlines, outline
from .photocentres import Photocentre
from .photometry import Photometry
from .radar import RadarAstrometry, RangeAndRate
from .radar_data import DelayDoppler, RadarSpectrum
from .radar_echoes import RadarEcho, delay_doppler, radar_spectrum
from .series import RotationSeries
from .shadow import ShadowPath, shadow_paths
from .stellar_occultation import StellarOccultation

__all__ = [
    "HG",
    "HG1G2",
    "Astrometry",
    "BrightnessDerivatives",
    "Chord",
    "Chords",
    "CombinedLight",
    "Cosine",
    "DamitModel",
    "DelayDoppler",
    "Gaussian",
    "Geometry",
    "Hagfors",
    "Hapke",
    "Held",
    "Lambert",
    "LinearExponential",
    "LinearModel",
    "LinearUnknown",
    "LommelSeeliger",
    "LommelSeeligerLambert",
    "Measured",
    "Miss",
    "MutualEvent",
    "MutualEvents",
    "Observations",
    "Outline",
    "Photocentre",
    "Photometry",
    "RadarAstrometry",
    "RadarEcho",
    "RadarLaw",
    "RadarSpectrum",
    "RangeAndRate",
    "RotationSeries",
    "ShadowPath",
    "SkyOutlines",
    "StellarOccultation",
    "brightness",
    "brightness_derivatives",
    "combined_light",
    "delay_doppler",
    "light_curve",
    "mutual_events",
    "occultation",
    "occultation_chords",
    "outline",
    "radar_spectrum",
    "read_alcdef",
    "read_damit",
    "read_damit_model",
    "shadow_paths",
    "write_alcdef",
    "zero_point",
]


def __dir__() -> list[str]:
    return __all__
