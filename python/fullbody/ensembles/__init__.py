"""Many runs at once, and maps of results over parameters."""

from .conversion import in_units
from .measures import attitude, drift, fate, libration, orbit
from .parameters import Draws, Paired, draws, paired
from .sweep import sweep

__all__ = [
    "Draws",
    "Paired",
    "attitude",
    "draws",
    "drift",
    "fate",
    "in_units",
    "libration",
    "orbit",
    "paired",
    "sweep",
]
