"""External forces on a system, and forces between its bodies in addition to gravity.

Forces are given to a system, and its runs record the effect of each: :attr:`fullbody.Run.work`,
:attr:`fullbody.Run.impulse`, :attr:`fullbody.Run.angular_impulse`. The drifts of energy and angular momentum of a run
are the changes that these do not explain.

A third body moves on a prescribed path. The coordinates of states fall freely with the system's barycentre in the third
body's gravity, so that the force on a body is the difference between its gravity there and at the barycentre.
"""

from __future__ import annotations

from ..model.force import Force
from .binary_yarkovsky import BinaryYarkovsky
from .coefficients import RadiationCoefficients, radiation_coefficients
from .function import Function
from .radiation import Byorp, Yorp, solar_pressure
from .third_body import ThirdBody
from .tide import Tide, lag_from_quality_factor

__all__ = [
    "BinaryYarkovsky",
    "Byorp",
    "Force",
    "Function",
    "RadiationCoefficients",
    "ThirdBody",
    "Tide",
    "Yorp",
    "lag_from_quality_factor",
    "radiation_coefficients",
    "solar_pressure",
]
