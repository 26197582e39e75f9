"""The result of a fit: values with their errors, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import integer, seed_of
from ..base.tables import Table, Tabled, to_text
from ..ensembles.parameters import Paired, paired
from ..errors import InvalidInput
from .losses import Loss
from .problem import Jacobian, Point, Problem, Refused

if TYPE_CHECKING:
    import xarray

    from ..motion.run import Run
    from .pictures import FitPlots

__all__ = ["Fit", "Minimum"]

_Array = npt.NDArray[np.float64]

#: The ratio of singular values below which a combination of parameters counts as unconstrained.
_SINGULAR = 1e-9
#: The smallest coefficient of a combination that its text includes.
_NAMED = 0.05
#: The largest number of draws for each requested one; more are an error, since hardly any are within the bounds.
_MOST_DRAWS = 1000


@dataclass(frozen=True)
class Minimum:
    """A minimum of chi2 that a fit has found.

    Attributes
    ----------
    values : dict
        The parameters at the minimum.
    chi2 : float
    found : int
        The number of starts that ended at the minimum.
    message : str
        The reason why the solver stopped before it was at a minimum; empty otherwise.
    """

    values: dict[str, Any]
    chi2: float
    found: int
    message: str


class Fit(Tabled):
    """Parameters fitted to observations; made by :func:`fullbody.fit`.

    Attributes
    ----------
    names : tuple of str
        The parameters, in the order of all arrays.
    values, sigma : dict
        Values and standard errors by name, with the units of the initial values. The error of a parameter in a
        combination that the data do not constrain is infinite.
    covariance, correlation : ndarray, (P, P)
        In the units of the values. For a loss that is not linear the covariance is that of an M-estimator. Rows and
        columns of unconstrained parameters are zero beside the diagonal.
    chi2 : float
        Sum of the squares of the pulls, priors included.
    loss : float
        The sum that was minimised: of the losses of the pulls, and of the logarithms of variances if jitter is free.
    dof : int
        Data and priors minus parameters and zero points.
    p_value : float or None
        Probability of a larger chi2, for a linear loss and at least one degree of freedom.
    residuals : list
        Observed minus predicted values of each of the observations, in their units.
    pulls : list of ndarray
        The residuals made independent and divided by their errors.
    condition : float
        The ratio of the largest to the smallest singular value of the derivatives, with each parameter in units of the
        error that it would have if it alone were free.
    weakest : dict of float
        The combination of parameters in these units that the data constrain least, a unit vector.
    unconstrained : str or None
        That combination as text, if the data do not constrain it at all.
    differenced : dict of str
        The parameters whose derivatives are differences of complete runs, with the reason.
    at_bounds : tuple of str
        The parameters at their bounds, for which errors have no meaning.
    minima : tuple of Minimum
        All minima that were found, the lowest first.
    system, state : System, State
    observations : list
        The observations; those that are functions of parameters at the fitted values.
    message : str
        The reason why the solver stopped before it was at a minimum, such as an interrupt; empty otherwise.
    iterations, runs, refused : int
        Numbers of iterations; of runs, those with derivatives and those of differences included; and of proposals that
        were refused, in all starts.
    last_refusal : str
        The reason why the last of the refused proposals was refused.
    """

    minima: tuple[Minimum, ...]
    starts: int

    def __init__(
        self, problem: Problem, loss: Loss, point: Point, jacobian: Jacobian, message: str, iterations: int
    ) -> None:
        known = problem.parameters
        self._problem, self._loss, self._point, self._jacobian = problem, loss, point, jacobian
        self.names = known.names
        self.values = known.named(point.values)
        self.system, self.state = point.made.system, point.made.state
        self.observations = point.observations
        self.pulls = point.pulls
        self.residuals = [
            problem.of(one, point.run, "residuals" if hasattr(one, "residuals") else "pulls")
            for one in point.observations
        ]
        self.differenced = jacobian.differenced
        self.message, self.iterations = message, iterations
        self.runs, self.refused = problem.runs + problem.differentiated, problem.refused
        self.last_refusal = problem.reason
        norms = np.linalg.norm(jacobian.rows, axis=0)
        close = 0.05 / np.where(norms > 0.0, norms, np.inf)
        at = (point.values - known.lower <= close) | (known.upper - point.values <= close)
        self.at_bounds = tuple(name for name, one in zip(self.names, at, strict=True) if one)
        flat = np.concatenate([np.ravel(part) for part in point.pulls])
        on = np.isfinite(known.sigma)
        prior = (point.values[on] - known.mean[on]) / known.sigma[on]
        self.chi2 = float(np.sum(flat**2) + np.sum(prior**2))
        self.loss = float(np.sum(loss.roots(flat)[0] ** 2) + np.sum(point.rows[len(flat) :] ** 2) + np.sum(prior**2))
        solved = sum(getattr(one, "free_zeros", 0) for one in point.observations)
        self.dof = len(flat) + int(on.sum()) - len(self.names) - solved
        self._errors(flat, on)

    def _errors(self, flat: _Array, on: Any) -> None:
        """Compute the covariance from the information of data, jitter and priors."""
        known, point, rows = self._problem.parameters, self._point, self._jacobian.rows
        data, wide = rows[: len(flat)].copy(), rows[len(flat) :]
        # A jitter changes the size of the residuals. Its expected information is half the square of the derivative of
        # the logarithm of the variance.
        noise = wide.any(axis=0)
        data[:, noise] = 0.0
        wide = np.sqrt(2.0) * point.rows[len(flat) :, None] * wide
        shrink = 1.0 if self._loss.linear else self._loss.inflation(flat, len(self.names)) ** -0.5
        prior = np.diag(np.where(on, 1.0 / known.sigma, 0.0))
        matrix = np.concatenate([shrink * data, wide, prior])
        norms = np.linalg.norm(matrix, axis=0)
        unit = matrix / np.where(norms > 0.0, norms, 1.0)
        _, sizes, vectors = np.linalg.svd(unit, full_matrices=False)
        good = sizes > _SINGULAR * sizes[0] if sizes[0] > 0.0 else np.zeros(len(sizes), bool)
        self.weakest = dict(zip(self.names, (float(part) for part in vectors[-1]), strict=True))
        # Beyond the precision of doubles this value is only a lower bound of the ratio.
        self.condition = float(sizes[0] / max(sizes[-1], 1e-16 * sizes[0])) if sizes[0] > 0.0 else np.inf
        self.unconstrained = None if good.all() else self._combination(vectors[-1], norms)
        scale = np.where(norms > 0.0, 1.0 / np.where(norms > 0.0, norms, 1.0), 0.0)
        inverse = vectors[good].T @ (vectors[good] / sizes[good, None] ** 2)
        covariance = inverse * np.outer(scale, scale)
        lost = (np.abs(vectors[~good]) > _NAMED).any(axis=0)
        covariance[lost] = covariance[:, lost] = 0.0
        covariance[lost, lost] = np.inf
        self.covariance = covariance
        errors = np.sqrt(np.diag(covariance))
        self.sigma = known.named(errors)
        finite = np.where(np.isfinite(errors) & (errors > 0.0), errors, 1.0)
        self.correlation = np.where(np.eye(len(errors), dtype=bool), 1.0, covariance / np.outer(finite, finite))

    def _combination(self, vector: _Array, norms: _Array) -> str:
        """Return the combination of parameters along a unit vector of scaled ones as text."""
        known = self._problem.parameters
        parts = []
        for k in np.argsort(-np.abs(vector), kind="stable"):
            if abs(vector[k]) > _NAMED:
                # A parameter without any effect has no scale, and is shown in its own unit.
                per = 1.0 / norms[k] if norms[k] > 0.0 else 1.0
                sign = "+" if vector[k] > 0.0 else "-"
                parts.append(f"{self.names[k]} {sign} {known.shown(k, abs(vector[k]) * per)} s")
        if len(parts) == 1:
            return str(self.names[int(np.argmax(np.abs(vector)))])
        return ", ".join(parts) + " together, for any s"

    @property
    def p_value(self) -> float | None:
        """The probability of a larger chi2."""
        if self.dof < 1 or not self._loss.linear:
            return None
        from scipy.stats import chi2

        return float(chi2.sf(self.chi2, self.dof))

    @cached_property
    def run(self) -> Run:
        """A run with a continuous solution over the epoch and all observations, integrated at the first access.

        Where there are observations before the epoch of the state, the run starts at the first of them.
        """
        times, epoch = self._problem.times(self._point.made, self.observations), self._point.made.core.time
        first, last = min(epoch, times.min(initial=epoch)), max(epoch, times.max(initial=epoch))
        integrate, integrator = self.system.integrate, self._problem.integrator
        if last == epoch > first:
            return integrate(self.state, first, integrator=integrator, dense=True)
        state = self.state if first == epoch else integrate(self.state, first, "ends", integrator=integrator)[-1]
        return integrate(state, last, integrator=integrator, dense=True)

    def draw(self, n: int, seed: int) -> Paired:
        """Draw parameters from the normal distribution of the fit, within the bounds.

        Parameters
        ----------
        n : int
            Number of draws.
        seed : int

        Returns
        -------
        Paired
            Parameters for :func:`fullbody.sweep`, without those that only observations take; ``.columns`` has the
            values (n,) by name.

        Raises
        ------
        InvalidInput
            If the data leave a combination of parameters unconstrained.
        """
        count = integer(n)
        if count is None or count < 1:
            raise InvalidInput(f"n is {n!r}; expected a whole number above zero")
        columns = self._problem.parameters.named(self.draws_as_array(count, seed).T)
        return paired(**{name: columns[name] for name in self._problem.of_setup})

    def draws_as_array(self, count: int, seed: Any) -> _Array:
        """Draw numbers (n, P) in the order of ``names`` and the units of ``values``; see :meth:`draw`."""
        if self.unconstrained is not None:
            raise InvalidInput(f"there is no distribution to draw from: the data do not constrain {self.unconstrained}")
        known, mean = self._problem.parameters, self._point.values
        errors = np.sqrt(np.diag(self.covariance))
        scale = np.where(errors > 0.0, errors, 1.0)
        values, vectors = np.linalg.eigh(self.covariance / np.outer(scale, scale))
        factor = vectors * np.sqrt(np.maximum(values, 0.0))
        rng = np.random.default_rng(seed_of(seed))
        kept = np.empty((0, len(mean)))
        for _ in range(_MOST_DRAWS):
            drawn = mean + scale * (rng.normal(size=(count, len(mean))) @ factor.T)
            kept = np.concatenate([kept, drawn[((drawn >= known.lower) & (drawn <= known.upper)).all(axis=1)]])
            if len(kept) >= count:
                return kept[:count]
        raise InvalidInput(f"hardly any draw is within the bounds of {', '.join(self.at_bounds) or 'the parameters'}")

    def log_posterior(self, values: Any, gradient: bool = False) -> Any:
        """Compute the logarithm of the posterior density, up to a constant that depends on the data and their errors.

        It is minus half the sum of the losses, of the squares of the priors' pulls, and of the logarithms of variances
        where a jitter is free.

        Parameters
        ----------
        values : dict or array_like, (P,)
            By name with units, or numbers in the order of ``names`` and the units of ``values``.
        gradient : bool
            Whether to compute the derivatives with respect to the parameters too.

        Returns
        -------
        float, or (float, ndarray (P,))
            Minus infinity outside the bounds and where the setup refuses the values or a run ends with an error, with
            a gradient of zero: the density is zero there.
        """
        known, problem = self._problem.parameters, self._problem
        plain = known.numbers(values)
        nothing = (-np.inf, np.zeros(len(plain))) if gradient else -np.inf
        if ((plain < known.lower) | (plain > known.upper)).any():
            return nothing
        try:
            point = problem.point(plain)
        except Refused:
            return nothing
        count = sum(part.size for part in point.pulls)
        rows = point.rows
        on = np.isfinite(known.sigma)
        prior = np.where(on, (plain - known.mean) / known.sigma, 0.0)
        roots, weights = self._loss.roots(rows[:count])
        vector = np.concatenate([roots, rows[count:]])
        density = -0.5 * float(np.sum(vector**2) + np.sum(prior**2))
        if not gradient:
            return density
        jacobian = problem.jacobian(point).rows
        scaled = np.concatenate([roots * weights, rows[count:]])
        return density, -(jacobian.T @ scaled) - np.where(on, prior / known.sigma, 0.0)

    def sample(
        self,
        sampler: str = "emcee",
        *,
        steps: int = 1000,
        walkers: int | None = None,
        seed: int,
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
        seed : int
        progress : bool

        Returns
        -------
        xarray.Dataset
            Parameters and ``log_posterior`` over ``chain`` (the walkers) and ``draw``, as arviz takes them, from the
            first step on.
        """
        from .posterior import sample

        return sample(self, sampler, steps, walkers, seed, progress)

    @property
    def plot(self) -> FitPlots:
        """The plots ``fit.plot.residuals()`` and ``fit.plot.corner()``."""
        from .pictures import FitPlots

        return FitPlots(self)

    def _tables(self) -> tuple[Table, ...]:
        known = self._problem.parameters
        head = ("parameter", "value", "error", "unit", "note")
        rows: list[Any] = []
        for k, name in enumerate(self.names):
            value, error = self._point.values[k], float(np.sqrt(self.covariance[k, k]))
            flags = (("at its bound", self.at_bounds), ("differenced", self.differenced))
            notes = [note for note, which in flags if name in which]
            rows.append((name, *_with_error(value, error), str(known.units[k] or ""), ", ".join(notes)))
        p_value = self.p_value
        about: list[Any] = [
            ("chi2", f"{self.chi2:.6g} for {self.dof} degrees of freedom"),
            ("p-value", "-" if p_value is None else f"{p_value:.3g}"),
            ("condition", f"{self.condition:.3g}"),
            ("iterations", f"{self.iterations}, {self.runs} runs, {self.refused} proposals refused"),
        ]
        if not self._loss.linear:
            about.append(("loss", f"{self.loss:.6g} by {self._loss.given!r}"))
        if self.refused:
            about.append(("last refused", self.last_refusal))
        if self.unconstrained is not None:
            about.append(("not constrained", self.unconstrained))
        if self.message:
            about.append(("ended", self.message))
        about += [(f"{name} differenced", reason) for name, reason in self.differenced.items()]
        tables = [Table("Fit", head, rows), Table("Quality", (), about)]
        if len(self.minima) > 1:
            header = ("chi2", "starts", *self.names)
            lines: list[Any] = [
                (f"{one.chi2:.6g}", str(one.found), *(f"{getattr(v, 'value', v):.6g}" for v in one.values.values()))
                for one in self.minima
            ]
            tables.append(Table(f"Minima from {self.starts} starts", header, lines))
        return tuple(tables)

    def __repr__(self) -> str:
        return to_text(*self._tables())


def _with_error(value: float, error: float) -> tuple[str, str]:
    """Return a value and its error as texts, to two digits of the error."""
    if not (np.isfinite(error) and error > 0.0):
        return f"{value:.8g}", "infinite" if error else "0"
    digits = max(0, 1 - int(np.floor(np.log10(error))))
    if digits > 12 or error >= 1e6 or abs(value) >= 1e9:
        places = max(1, int(np.floor(np.log10(max(abs(value), error)))) - int(np.floor(np.log10(error))) + 2)
        return f"{value:.{min(places, 17)}g}", f"{error:.2g}"
    return f"{value:.{digits}f}", f"{error:.{digits}f}"
