"""Relative equilibria, periodic orbits, sections and frequencies of motions, by exact derivatives.

Everything here needs scipy: ``pip install scipy``.
"""

from .equilibrium import RelativeEquilibrium, averaged, relative_equilibrium
from .families import Branch, Equilibria, Fold, Touching, branch, equilibria
from .modes import Modes
from .periodic import PeriodicOrbit, periodic_family, periodic_orbit
from .section import Frequencies, Section, frequencies, section

__all__ = [
    "Branch",
    "Equilibria",
    "Fold",
    "Frequencies",
    "Modes",
    "PeriodicOrbit",
    "RelativeEquilibrium",
    "Section",
    "Touching",
    "averaged",
    "branch",
    "equilibria",
    "frequencies",
    "periodic_family",
    "periodic_orbit",
    "relative_equilibrium",
    "section",
]
