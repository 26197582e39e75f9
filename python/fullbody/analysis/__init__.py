"""Relative equilibria, periodic orbits, sections and frequencies of motions, by exact derivatives.

Everything here needs scipy: ``pip install fullbody[analysis]``.
"""

from .equilibrium import RelativeEquilibrium, averaged, relative_equilibrium
from .modes import Modes

__all__ = [
    "Modes",
    "RelativeEquilibrium",
    "averaged",
    "relative_equilibrium",
]


def __dir__() -> list[str]:
    return __all__
