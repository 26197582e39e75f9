"""Many runs at once, and maps of results over parameters."""

from .dataset import in_units
from .parameters import Draws, Paired, draws, paired
from .sweep import sweep

__all__ = ["Draws", "Paired", "draws", "in_units", "paired", "sweep"]
