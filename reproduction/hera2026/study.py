"""The members: draws from the posterior of the published values, run from the impact of DART to the arrival of Hera."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import fullbody
import numpy as np
from fullbody import Verner98, ensembles
from fullbody.base.atomic import replacing

from . import measures, model, posterior

if TYPE_CHECKING:
    import xarray

__all__ = ["MEMBERS", "members", "sweep", "workers"]

#: Members of the whole study, and the seed of their draws.
MEMBERS: Final = 2000
SEED: Final = 1
INTEGRATOR: Final = Verner98(1e-7, 1e-7)


def members(folder: Path, count: int, progress: bool = False) -> dict[str, Any]:
    """The numbers of the members, by the names of the setup's arguments.

    They are drawn once and kept in the folder, so that a study that goes on has the same ones; of a smaller number
    these are the first.
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


def sweep(
    folder: Path, count: int = MEMBERS, progress: bool = False, end: float = measures.END, **options: Any
) -> xarray.Dataset:
    """The members' outcomes, kept in the folder while they come; called again, the study goes on from there.

    Options are those of :func:`fullbody.sweep`, as ``executor``. In memory there are the runs of one chunk alone.
    """
    options.setdefault("chunk", 16)
    return fullbody.sweep(
        model.setup,
        ensembles.paired(**members(folder, count, progress)),
        end,
        measure=partial(measures.measure, end=end),
        output=np.append(np.arange(0.0, end, measures.SPACING), end),
        integrator=INTEGRATOR,
        store=folder / "map.nc",
        progress=progress,
        **options,
    )


@contextmanager
def workers() -> Iterator[Any]:
    """The executor of the study: none, or by the variable HERA_DASK that of a cluster of dask.

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
