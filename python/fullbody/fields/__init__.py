"""Fields that people look at: geopotential and slope of a surface, and the rotating frame of a synchronous pair with
its equilibrium points, zero-velocity curves and Roche lobes.

Pictures of them are drawn by :mod:`fullbody.plots`.
"""

from __future__ import annotations

from .equilibria import Equilibrium
from .lobes import RocheLobe
from .surface import SurfaceField, surface
from .synodic import Synodic

__all__ = ["Equilibrium", "RocheLobe", "SurfaceField", "Synodic", "surface"]


def __dir__() -> list[str]:
    return __all__
