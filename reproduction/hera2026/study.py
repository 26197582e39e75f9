"""The members: draws from the posterior of the published values, run from the impact of DART to the arrival of Hera."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import fullbody
import numpy as np
from fullbody import Verner98, ensembles
from fullbody.base.atomic import replacing

from . import measures, model, posterior

if TYPE_CHECKING:
    import xarray

__all__ = ["MEMBERS", "OUTPUT", "members", "sweep"]

#: Members of the whole study; the seed of its draws.
MEMBERS: Final = 2000
SEED: Final = 1
OUTPUT: Final = np.append(np.arange(0.0, measures.END, measures.SPACING), measures.END)
INTEGRATOR: Final = Verner98(1e-7, 1e-7)


def members(folder: Path, count: int, progress: bool = False) -> dict[str, Any]:
    """The numbers of the members, by the names of the setup's arguments.

    They are drawn once and kept in the folder, so that a study that goes on has the same ones; of a smaller number these
    are the first.
    """
    file = folder / "members.json"
    if not file.exists():
        fit = posterior.posterior(progress)
        drawn = posterior.draws(fit, MEMBERS, SEED)
        whole = {
            "columns": {name: column.tolist() for name, column in drawn.items()},
            "posterior": {name: [float(fit.values[name]), float(fit.sigma[name])] for name in posterior.FITTED},
            "chi2": float(fit.chi2),
        }
        with replacing(file) as temporary:
            temporary.write_text(json.dumps(whole))
    columns = json.loads(file.read_text())["columns"]
    return {name: np.array(column[:count]) for name, column in columns.items()}


def sweep(folder: Path, count: int = MEMBERS, progress: bool = False, **options: Any) -> xarray.Dataset:
    """The members' outcomes, kept in the folder while they come; called again, the study goes on from there."""
    return fullbody.sweep(
        model.setup,
        ensembles.paired(**members(folder, count, progress)),
        measures.END,
        measure=measures.measure,
        output=OUTPUT,
        integrator=INTEGRATOR,
        store=folder / "map.nc",
        chunk=options.pop("chunk", 16),
        progress=progress,
        **options,
    )
