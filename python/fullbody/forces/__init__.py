"""Forces from outside a system, and those that its bodies have from each other beside gravity.

They are given to a system, and its runs tell what each of them did: :attr:`fullbody.Run.work`,
:attr:`fullbody.Run.impulse`, :attr:`fullbody.Run.angular_impulse`. The drifts of energy and angular momentum of a run
are what is left after them.

A third body moves on a prescribed path. The coordinates of states fall with the system's barycentre in its gravity:
what acts on a body is the difference between its pull there and at the barycentre.
"""

from __future__ import annotations

from ..model.force import Force
from .function import Function
from .radiation import Byorp, Yorp, solar_pressure
from .third_body import ThirdBody
from .tide import Tide, lag_from_quality_factor

__all__ = ["Byorp", "Force", "Function", "ThirdBody", "Tide", "Yorp", "lag_from_quality_factor", "solar_pressure"]


def __dir__() -> list[str]:
    return __all__
