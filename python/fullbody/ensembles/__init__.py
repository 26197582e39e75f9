"""Many runs at once, and maps over parameters."""

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
    "libration",
    "orbit",
    "paired",
    "sweep",
]


def __dir__() -> list[str]:
    return __all__
