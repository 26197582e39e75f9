"""Shapes, bodies, states and forces: the objects of which systems are made and that they return."""

from .external import Loads
from .gravity import Gravity
from .interactions import Energy, Interactions, Invariants
from .jacobian import Jacobian

__all__ = ["Energy", "Gravity", "Interactions", "Invariants", "Jacobian", "Loads"]
