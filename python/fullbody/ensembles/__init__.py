"""Many runs at once, and maps over parameters."""

from .parameters import Draws, Paired, draws, paired
from .sweep import sweep

__all__ = ["Draws", "Paired", "draws", "paired", "sweep"]


def __dir__() -> list[str]:
    return __all__
