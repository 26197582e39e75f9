"""Fields of a pair: geopotential and slope of a surface, and the rotating frame of a synchronous pair with its
equilibrium points, zero-velocity curves and Roche lobes.

The module :mod:`fullbody.plots` draws them.
"""

from __future__ import annotations

from .frame import Equilibrium, RocheLobe
from .surface import SurfaceField, SurfaceRange, surface, surface_along
from .synodic import Synodic

__all__ = ["Equilibrium", "RocheLobe", "SurfaceField", "SurfaceRange", "Synodic", "surface", "surface_along"]
