"""Rigid ellipsoids moving and turning in each other's exact gravity.

Examples
--------
>>> import fullbody
>>> system, state = fullbody.systems.kw4_ho2021()
>>> run = system.integrate(state, 17.0, output=1.0)
>>> run.elements().a.shape
(18,)
"""

import typing as _typing

from . import events, frames, observables, systems
from ._core import vector_paths
from .bodies import Body, Ellipsoid, PointMass, Sphere
from .dense import Dense, Samples
from .elements import KeplerElements
from .errors import (
    BodiesOverlap,
    ChartSingularity,
    FullbodyError,
    InconsistentInput,
    Interrupted,
    InvalidInput,
    NotConverged,
    PrecisionWarning,
    StepSizeTooSmall,
)
from .integrators import (
    DormandPrince54,
    LieGroupVariational,
    SymplecticSplitting,
    Verner65,
    Verner76,
    Verner87,
    Verner98,
)
from .interactions import Energy, Interactions
from .io import load
from .pair import Component, binary
from .peers import from_rebound, read_gubas, read_sians, to_rebound
from .run import Run, Statistics
from .simulation import Simulation
from .state import State
from .system import System
from .toml_setup import Setup, read_toml
from .track import Track

if _typing.TYPE_CHECKING:
    from . import plots, view

    __version__: str
else:

    def __getattr__(name):
        # The package's metadata takes a third of the import's time, and few ask for it.
        if name == "__version__":
            from importlib.metadata import version

            return version("fullbody")
        # Not every run is drawn or reported.
        if name in ("cli", "paper", "plots", "reproduce", "view"):
            from importlib import import_module

            return import_module(f".{name}", __name__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


del _typing


__all__ = [
    "BodiesOverlap",
    "Body",
    "ChartSingularity",
    "Component",
    "Dense",
    "DormandPrince54",
    "Ellipsoid",
    "Energy",
    "FullbodyError",
    "InconsistentInput",
    "Interactions",
    "Interrupted",
    "InvalidInput",
    "KeplerElements",
    "LieGroupVariational",
    "NotConverged",
    "PointMass",
    "PrecisionWarning",
    "Run",
    "Samples",
    "Setup",
    "Simulation",
    "Sphere",
    "State",
    "Statistics",
    "StepSizeTooSmall",
    "SymplecticSplitting",
    "System",
    "Track",
    "Verner65",
    "Verner76",
    "Verner87",
    "Verner98",
    "__version__",
    "binary",
    "events",
    "frames",
    "from_rebound",
    "load",
    "observables",
    "plots",
    "read_gubas",
    "read_sians",
    "read_toml",
    "systems",
    "to_rebound",
    "vector_paths",
    "view",
]


def __dir__() -> list[str]:
    return __all__
