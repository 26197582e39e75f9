"""The uncertainty of fitted parameters and of derived quantities: covariance, and samples of the posterior."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..base.arguments import generator
from ..base.kinds import choice, whole_number
from ..base.units import need
from ..base.values import same
from ..errors import InvalidInput, once
from ..observing.measured import Measured
from ..typing import Floats
from .free import Parameters
from .problem import Problem, Refused

if TYPE_CHECKING:
    import xarray


#: The ratio of singular values below which a combination of parameters counts as unconstrained.
_SINGULAR = 1e-9
#: The smallest coefficient of a combination that its text includes.
_NAMED = 0.05


class Covariance:
    """The inverse of an information matrix J^T J, given by its root J (R, P).

    In ``matrix`` (P, P) rows and columns of unconstrained parameters are zero, with infinity on the diagonal.
    ``condition`` is the ratio of the largest to the smallest singular value of J with columns of length one,
    ``weakest`` (P,) the combination of parameters, in units of the inverse lengths of the columns, that is constrained
    least, and ``unconstrained`` that combination as text, if it is not constrained at all.
    """

    def __init__(self, matrix: Floats, parameters: Parameters) -> None:
        norms = np.linalg.norm(matrix, axis=0)
        scale = np.divide(1.0, norms, out=np.zeros_like(norms), where=norms > 0.0)
        _, sizes, vectors = np.linalg.svd(matrix * scale, full_matrices=False)
        determined = sizes > _SINGULAR * sizes[0]
        self.weakest = vectors[-1]
        # Beyond the precision of doubles this value is only a lower bound of the ratio.
        self.condition = float(sizes[0] / max(sizes[-1], 1e-16 * sizes[0])) if sizes[0] > 0.0 else np.inf
        self.unconstrained = None if determined.all() else _combination(vectors[-1], norms, parameters)
        self.matrix = (
            vectors[determined].T @ (vectors[determined] / sizes[determined, None] ** 2) * np.outer(scale, scale)
        )
        unconstrained = (np.abs(vectors[~determined]) > _NAMED).any(axis=0)
        self.matrix[unconstrained] = self.matrix[:, unconstrained] = 0.0
        self.matrix[unconstrained, unconstrained] = np.inf


def _combination(vector: Floats, norms: Floats, parameters: Parameters) -> str:
    """Return the combination of parameters along a unit vector of scaled ones as text."""
    parts = []
    for k in np.argsort(-np.abs(vector), kind="stable"):
        if abs(vector[k]) > _NAMED:
            # A parameter without any effect has no scale, and is shown in its own unit.
            per = 1.0 / norms[k] if norms[k] > 0.0 else 1.0
            sign = "+" if vector[k] > 0.0 else "-"
            parts.append(f"{parameters.names[k]} {sign} {parameters.shown(k, abs(vector[k]) * per)} s")
    if len(parts) == 1:
        return str(parameters.names[int(np.argmax(np.abs(vector)))])
    return ", ".join(parts) + " together, for any s"


class Derived(NamedTuple):
    """A quantity derived from the parameters of a fit, with its standard error.

    Attributes
    ----------
    value : float, ndarray or Quantity
        The value at the parameters of the fit.
    sigma : float, ndarray or Quantity
        The standard error to first order, or the standard deviation of the ``draws``.
    draws : ndarray, Quantity or None
        The values (n, ...) for samples of the posterior distribution.
    """

    value: Any
    sigma: Any
    draws: Any = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Derived) and same(tuple(self), tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other


def derived(
    fit: Any,
    function: Callable[[Any], Any],
    times: Any = (),
    *,
    samples: xarray.Dataset | None = None,
    n: int = 100,
    rng: int | np.random.Generator | None = None,
) -> Derived:
    """Return a quantity that follows from the fitted motion, with its standard error by the chain rule or by samples.

    Parameters
    ----------
    function : callable
        A smooth function of a :class:`fullbody.Run` that returns a number, a Quantity or an array (C,).
    times : astropy Time, or array_like or Quantity, (K,), optional
        The times at which the run is sampled; none for a function of the system alone.
    samples : xarray.Dataset, optional
        What :meth:`sample` returns, without the steps before it has settled. The function is then computed for draws of
        it, and need not be smooth.
    n : int
        The number of these draws.
    rng : int or numpy Generator, optional
        The random numbers that choose the draws, needed with ``samples``.

    Returns
    -------
    Derived
        ``.value`` and ``.sigma`` (C,); with ``samples`` also the values of the ``.draws`` (n, C).
    """
    problem, values = fit._minimised().problem, fit.numbers[: len(fit.parameters)]
    probe = Measured("the derived quantity", function, 0.0, 1.0, times)

    def sampled(values: Floats) -> Any:
        return problem.run(problem.make(values), [probe])

    value = function(sampled(values))
    unit = getattr(value, "unit", 1.0)
    # The derivatives are those of the pulls of a measured value of the same size, whose error is one.
    measured = Measured(probe.name, function, value, np.ones(np.shape(value)) * unit, times)
    if samples is not None:
        rows = rows_of(samples, problem.parameters)
        chosen = generator(rng).choice(len(rows), whole_number(n, "n", 2, len(rows)), replace=False)
        with once():
            draws = [measured.predict(sampled(row)) for row in rows[np.sort(chosen)]]
        stacked = np.stack(draws).reshape(len(draws), *np.shape(value))
        return Derived(value, stacked.std(axis=0, ddof=1), stacked)
    setup, indices = problem.setup, problem.setup.indices
    motion = Problem(setup.function, setup.parameters, measured, problem.integrator)
    try:
        rows = motion.jacobian(motion.point(values[indices])).rows
    except Refused as error:
        raise InvalidInput(f"function cannot be differentiated at the values of the fit: {error}") from error
    spread = np.sqrt(np.einsum("ck,kl,cl->c", rows, fit.covariance[np.ix_(indices, indices)], rows))
    return Derived(value, spread.reshape(np.shape(value)) * unit)


def rows_of(samples: Any, parameters: Parameters) -> Floats:
    """Return the parameters (n, P) of all samples of a posterior."""
    names = parameters.arguments
    if not set(names) <= set(getattr(samples, "data_vars", ())):
        raise InvalidInput(f"samples is {samples!r:.60}; expected a Dataset with {', '.join(names)}")
    parts = [samples[name].values for name in names]
    return np.concatenate([part.reshape(part.shape[0] * part.shape[1], -1) for part in parts], axis=1)


def sample(
    fit: Any,
    sampler: str = "emcee",
    *,
    steps: int = 1000,
    walkers: int | None = None,
    rng: int | np.random.Generator,
    progress: bool = False,
) -> xarray.Dataset:
    """Sample the posterior distribution.

    Parameters
    ----------
    sampler : {"emcee"}
        The ensemble sampler of Foreman-Mackey et al. (2013); the extra ``fit`` installs it.
    steps : int
        Steps of each walker; one evaluation takes a run.
    walkers : int, optional
        Four for each parameter unless given. They start at draws of the fit.
    rng : int or numpy Generator
    progress : bool

    Returns
    -------
    xarray.Dataset
        Parameters, without linear unknowns, and ``log_posterior`` over ``chain`` (the walkers) and ``draw``, as arviz
        takes them, from the first step on.
    """
    choice(sampler, "sampler", ("emcee",))
    with need("fit", "a sample of the posterior distribution"):
        import emcee
    with need("data", "a sample of the posterior distribution"):
        import xarray

    names = fit.parameters.names
    length, least = whole_number(steps, "steps"), 2 * len(names)
    count = 2 * least if walkers is None else whole_number(walkers, "walkers", least)
    ensemble = emcee.EnsembleSampler(count, len(names), fit.log_posterior)
    random = generator(rng)
    with once():
        start = fit.draws_as_array(count, random)
        random_state = np.random.RandomState(np.random.MT19937(random.integers(2**63))).get_state()
        ensemble.run_mcmc(emcee.State(start, random_state=random_state), length, progress=progress)
    chain = np.moveaxis(ensemble.get_chain(), 0, 1)
    dimensions = ("chain", "draw")
    variables: dict[str, Any] = {}
    for name, values in fit.parameters.named(np.moveaxis(chain, -1, 0)).items():
        # The further dimensions of arrays have the names that arviz gives them.
        inner = tuple(f"{name}_dim_{axis}" for axis in range(np.ndim(values) - 2))
        numbers, unit = getattr(values, "value", values), getattr(values, "unit", None)
        variables[name] = ((*dimensions, *inner), numbers, {} if unit is None else {"units": str(unit)})
    variables["log_posterior"] = (dimensions, ensemble.get_log_prob().T)
    notes = {"title": "posterior samples by emcee", "acceptance_fraction": float(ensemble.acceptance_fraction.mean())}
    return xarray.Dataset(variables, attrs=notes)
