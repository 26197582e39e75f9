"""Samples of the posterior distribution of a fit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.arguments import generator
from ..base.kinds import choice, whole
from ..base.units import need

if TYPE_CHECKING:
    import xarray


__all__ = ["sample"]


def sample(fit: Any, sampler: Any, steps: Any, walkers: Any, rng: Any, progress: bool) -> xarray.Dataset:
    """Sample the posterior distribution; see :meth:`fullbody.fitting.Fit.sample`."""
    choice(sampler, "sampler", ("emcee",))
    with need("fit", "a sample of the posterior distribution"):
        import emcee
    with need("data", "a sample of the posterior distribution"):
        import xarray

    length, least = whole(steps, "steps"), 2 * len(fit.names)
    count = 2 * least if walkers is None else whole(walkers, "walkers", least)
    ensemble = emcee.EnsembleSampler(count, len(fit.names), fit.log_posterior)
    random = generator(rng)
    begin = fit.draws_as_array(count, random)
    numbers = np.random.RandomState(np.random.MT19937(random.integers(2**63))).get_state()
    state = emcee.State(begin, random_state=numbers)
    ensemble.run_mcmc(state, length, progress=progress)
    chain = np.moveaxis(ensemble.get_chain(), 0, 1)
    dimensions = ("chain", "draw")
    variables: dict[str, Any] = {}
    for k, (name, value) in enumerate(fit.values.items()):
        unit = getattr(value, "unit", None)
        variables[name] = (dimensions, chain[..., k], {} if unit is None else {"units": str(unit)})
    variables["log_posterior"] = (dimensions, ensemble.get_log_prob().T)
    notes = {"title": "posterior samples by emcee", "acceptance_fraction": float(ensemble.acceptance_fraction.mean())}
    return xarray.Dataset(variables, attrs=notes)
