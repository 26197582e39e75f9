"""The stages of the study: pilot runs, candidates over the days observed, and members up to Hera's survey.

Each stage saves its runs in the folder as they end, so that an interrupted study can be resumed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import fullbody
import numpy as np
from fullbody import Verner98, ensembles

from . import measures, model, posterior, weights
from .inputs import inputs_with_shape

if TYPE_CHECKING:
    import xarray

__all__ = ["FULL", "INTEGRATOR", "SMALL", "Sizes", "members", "sweep", "workers"]

#: The seed of all draws.
SEED: Final = 1
INTEGRATOR: Final = Verner98(1e-9, 1e-9)


@dataclass(frozen=True)
class Sizes:
    """The numbers of pilot runs and of candidates, and the expected number of members that are run to the end."""

    pilot: int
    candidates: int
    members: float


#: The numbers of a study that takes twenty minutes, and of that of the page.
SMALL: Final = Sizes(300, 250, 40.0)
FULL: Final = Sizes(500, 1600, 220.0)


def sweep(
    setup: Any, folder: Path, name: str, columns: Any, end: float, measure: Any, progress: bool = False, **options: Any
) -> xarray.Dataset:
    """Run starts to an end, and save their measurements in the folder under a name.

    Options are those of :func:`fullbody.sweep`, as ``executor``. Only the runs of one chunk are in memory.
    """
    return fullbody.sweep(
        setup,
        ensembles.paired(**columns),
        end,
        measure=measure,
        output=np.append(np.arange(0.0, end, measures.SPACING), end),
        integrator=options.pop("integrator", INTEGRATOR),
        store=folder / f"{name}.nc",
        key=f"hera2026 {name} 2",
        progress=progress,
        **{"chunk": 16} | options,
    )


def members(
    folder: Path, sizes: Sizes, shape: str = "v003", progress: bool = False, **options: Any
) -> tuple[xarray.Dataset, xarray.Dataset]:
    """Run all stages, and return the candidates and the members, both with their weights.

    Parameters
    ----------
    folder : Path
    sizes : Sizes
    shape : str
        The shape of Didymos, a name in :data:`reproduction.hera2026.inputs.SHAPES`.
    progress : bool
    **options
        Those of :func:`fullbody.sweep`.

    Returns
    -------
    candidates, members : xarray.Dataset
        Variables over ``row``. ``log_weight`` is the logarithm of the weight in the posterior; that of members includes
        the probability with which candidates become members.
    """
    inputs = inputs_with_shape(shape)
    starts = posterior.pilot(inputs, sizes.pilot, SEED)
    pilot = sweep(model.setup, folder, f"pilot_{shape}", starts, measures.WINDOW, observed, progress, **options)
    orbits = {name: pilot[f"observed_{name}"].values for name in (*posterior.OBSERVED, "coherence")}
    surrogate = posterior.Surrogate.fitted(starts, orbits)
    starts = posterior.draws(surrogate, sizes.candidates, SEED, inputs)
    end = measures.CHANGE_DAYS * model.DAY
    candidates = sweep(model.setup, folder, f"candidates_{shape}", starts, end, measures.early, progress, **options)
    orbits = {name: candidates[f"observed_{name}"].values for name in posterior.OBSERVED}
    logarithm = posterior.log_weights(starts, orbits, surrogate, inputs)
    candidates["log_weight"] = "row", logarithm
    candidates["changed"] = "row", weights.changed(candidates)
    chance = weights.inclusion(logarithm, candidates.changed.values, sizes.members)
    chosen = np.random.default_rng([SEED, 3]).random(len(chance)) < chance
    starts = {name: column[chosen] for name, column in starts.items()}
    result = sweep(
        model.setup,
        folder,
        f"members_{shape}",
        starts,
        measures.END,
        partial(measures.measure, end=measures.END),
        progress,
        **options,
    )
    result["log_weight"] = "row", logarithm[chosen] - np.log(chance[chosen])
    result["changed"] = "row", candidates.changed.values[chosen]
    return candidates, result


def observed(run: fullbody.Run) -> dict[str, float]:
    """Measure the orbit of the first interval of observations."""
    return measures.observed_orbit("", run)


@contextmanager
def workers() -> Iterator[Any]:
    """Yield the executor of the study: none, or that of a cluster of dask by the variable HERA_DASK.

    ``HERA_DASK=local`` starts workers on this machine; otherwise it is the address of a scheduler.
    """
    address = os.environ.get("HERA_DASK")
    if not address:
        yield None
        return
    from dask.distributed import Client

    client_of: Any = Client
    with client_of(None if address == "local" else address) as client, client.get_executor() as executor:
        yield executor
