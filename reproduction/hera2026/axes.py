"""The first 67 days for a grid of axis ratios: the time at which Dimorphos begins to roll."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import fullbody
import numpy as np
from fullbody import Run, State, System, Verner98, observables

from . import measures, model
from .inputs import INPUTS

if TYPE_CHECKING:
    import xarray

__all__ = ["GRID", "setup", "sweep"]

GRID: Final = {"a_b": np.round(np.arange(1.05, 1.46, 0.04), 2), "b_c": np.round(np.arange(1.02, 1.51, 0.04), 2)}
DRAFT: Final = {"a_b": [1.13, 1.33], "b_c": [1.10, 1.30]}
#: Values of the start that are the same for all axis ratios; those that move the pair out of its plane are one standard
#: error.
FIXED: Final = {
    name: INPUTS[name].value
    for name in ("separation", "equatorial", "polar", "diameter", "density", "along", "radial", "miss_radial", "yaw")
}
ACROSS: Final = {name: INPUTS[name].sigma for name in ("normal", "miss_normal")}


def setup(a_b: float, b_c: float) -> tuple[System, State]:
    """Return the start with the values of the table of inputs, with one standard error across the plane."""
    bodies, state = model.start(**FIXED, **ACROSS, a_b=a_b, b_c=b_c)
    return System(bodies, G=model.G, gravity=model.GRAVITY), state


def measure(run: Run) -> dict[str, Any]:
    """Return the time at which the roll passed the limit, and the orbit that observers would fit."""
    return {"tumbling_time": observables.tumbles(run, limit=measures.LIMIT).time} | measures.observed_orbit("", run)


def sweep(folder: Path | None, draft: bool = False, progress: bool = False) -> xarray.Dataset:
    """Return the map; runs are saved in the folder as they end."""
    return fullbody.sweep(
        setup,
        DRAFT if draft else GRID,
        measures.WINDOW,
        measure=measure,
        output=measures.SPACING,
        integrator=Verner98(1e-8, 1e-8),
        store=None if folder is None else folder / "axes.nc",
        key="hera2026 axes 2",
        threads=1,
        progress=progress,
    )
