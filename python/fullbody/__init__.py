"""Rigid bodies (ellipsoids, polyhedra, composites) moving and rotating in each other's exact gravity.

Examples
--------
>>> import fullbody
>>> system, state = fullbody.systems.kw4_ho2021()
>>> run = system.integrate(state, 17.0, output=1.0)
>>> run.elements().a.shape
(18,)
"""

import typing as _typing

from . import ensembles, errors, events, forces, frames, observables, particles, systems
from ._core import vector_paths
from .base.version import version
from .ensembles.members import integrate_many
from .errors import FullbodyError
from .loading import load, load_flight
from .model.bodies import Body
from .model.composite import Composite, Part, WorkingFrame
from .model.freeform import ConvexShape, HarmonicShape
from .model.polyhedron import Polyhedron
from .model.shapes import Ellipsoid, PointMass, Sphere
from .model.state import State
from .model.stokes import StokesCoefficients
from .motion.run import Run
from .motion.simulation import Simulation
from .motion.system import System
from .orbit.elements import KeplerElements
from .particles import Flight, Particles
from .record.integrators import (
    DormandPrince54,
    LieGroupVariational,
    SymplecticSplitting,
    Verner65,
    Verner76,
    Verner87,
    Verner98,
)
from .setups.binary import binary
from .setups.component import Component
from .setups.toml import Configuration, read_toml

if _typing.TYPE_CHECKING:
    from . import analysis, fields, fitting, observing, plots, spice, view
    from .ensembles.sweep import sweep
    from .fitting import fit
    from .peers import from_rebound, read_gubas, read_sians, to_rebound
    from .view import explore

    __version__: str
else:
    #: The modules of names that are imported when they are first used, since most sessions need none of them.
    _MODULES = {
        **dict.fromkeys(("analysis", "fields", "fitting", "observing", "plots", "spice", "view"), ""),
        **dict.fromkeys(("from_rebound", "read_gubas", "read_sians", "to_rebound"), "peers"),
        **{"fit": "fitting", "explore": "view", "sweep": "ensembles.sweep"},
    }

    def __getattr__(name):
        if name == "__version__":
            return version()
        if name not in _MODULES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from importlib import import_module

        if not _MODULES[name]:
            return import_module(f".{name}", __name__)
        return getattr(import_module(f".{_MODULES[name]}", __name__), name)


del _typing


__all__ = [
    "Body",
    "Component",
    "Composite",
    "Configuration",
    "ConvexShape",
    "DormandPrince54",
    "Ellipsoid",
    "Flight",
    "FullbodyError",
    "HarmonicShape",
    "KeplerElements",
    "LieGroupVariational",
    "Part",
    "Particles",
    "PointMass",
    "Polyhedron",
    "Run",
    "Simulation",
    "Sphere",
    "State",
    "StokesCoefficients",
    "SymplecticSplitting",
    "System",
    "Verner65",
    "Verner76",
    "Verner87",
    "Verner98",
    "WorkingFrame",
    "__version__",
    "analysis",
    "binary",
    "ensembles",
    "errors",
    "events",
    "explore",
    "fields",
    "fit",
    "fitting",
    "forces",
    "frames",
    "from_rebound",
    "integrate_many",
    "load",
    "load_flight",
    "observables",
    "observing",
    "particles",
    "plots",
    "read_gubas",
    "read_sians",
    "read_toml",
    "spice",
    "sweep",
    "systems",
    "to_rebound",
    "vector_paths",
    "view",
]


def __dir__() -> list[str]:
    return __all__
