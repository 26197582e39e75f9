"""Shapes, bodies, states and forces: the objects of which systems are made and that they return."""

from .gravity import Gravity
from .interactions import Energy, Interactions, Invariants, Jacobian, Loads

__all__ = ["Energy", "Gravity", "Interactions", "Invariants", "Jacobian", "Loads"]
