"""Rigid bodies (ellipsoids, polyhedra, composites) moving and turning in each other's exact gravity.

Examples
--------
>>> import fullbody
>>> system, state = fullbody.systems.kw4_ho2021()
>>> run = system.integrate(state, 17.0, output=1.0)
>>> run.elements().a.shape
(18,)
"""

import typing as _typing

from . import ensembles, events, forces, frames, observables, systems
from ._core import vector_paths
from .base.version import version
from .ensembles.many import integrate_many
from .ensembles.sweep import sweep
from .errors import (
    BodiesOverlap,
    ChartSingularity,
    ForceFailed,
    FullbodyError,
    InconsistentInput,
    Interrupted,
    InvalidInput,
    NotConverged,
    PrecisionWarning,
    StepSizeTooSmall,
    UncheckedFile,
)
from .model.bodies import Body
from .model.composite import Composite, Part, WorkingFrame
from .model.interactions import Energy, Interactions, Invariants, Loads
from .model.jacobian import Jacobian
from .model.polyhedron import Polyhedron
from .model.shapes import Ellipsoid, PointMass, Sphere
from .model.state import State
from .motion.loading import load
from .motion.simulation import Run, Simulation, System
from .orbit.elements import KeplerElements
from .peers import from_rebound, read_gubas, read_sians, to_rebound
from .record.dense import Dense, Samples
from .record.derivatives import EventDerivatives
from .record.integrators import (
    DormandPrince54,
    LieGroupVariational,
    SymplecticSplitting,
    Verner65,
    Verner76,
    Verner87,
    Verner98,
)
from .record.statistics import Statistics
from .record.track import Track
from .setups.binary import binary
from .setups.component import Component
from .setups.toml import Setup, read_toml

if _typing.TYPE_CHECKING:
    from . import analysis, plots, view

    __version__: str
else:

    def __getattr__(name):
        if name == "__version__":
            return version()
        # Not every run is drawn or analysed.
        if name in ("analysis", "plots", "view"):
            from importlib import import_module

            return import_module(f".{name}", __name__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


del _typing


__all__ = [
    "BodiesOverlap",
    "Body",
    "ChartSingularity",
    "Component",
    "Composite",
    "Dense",
    "DormandPrince54",
    "Ellipsoid",
    "Energy",
    "EventDerivatives",
    "ForceFailed",
    "FullbodyError",
    "InconsistentInput",
    "Interactions",
    "Interrupted",
    "InvalidInput",
    "Invariants",
    "Jacobian",
    "KeplerElements",
    "LieGroupVariational",
    "Loads",
    "NotConverged",
    "Part",
    "PointMass",
    "Polyhedron",
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
    "UncheckedFile",
    "Verner65",
    "Verner76",
    "Verner87",
    "Verner98",
    "WorkingFrame",
    "__version__",
    "analysis",
    "binary",
    "ensembles",
    "events",
    "forces",
    "frames",
    "from_rebound",
    "integrate_many",
    "load",
    "observables",
    "plots",
    "read_gubas",
    "read_sians",
    "read_toml",
    "sweep",
    "systems",
    "to_rebound",
    "vector_paths",
    "view",
]


def __dir__() -> list[str]:
    return __all__
