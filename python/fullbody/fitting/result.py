"""The result of a fit: values with their errors, and the quantities that follow from them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.arguments import generator
from ..base.kinds import whole_number
from ..base.tables import Table, Tabled, to_text
from ..base.units import need
from ..base.values import ArrayFields
from ..ensembles.parameters import Paired, paired
from ..errors import InvalidInput
from ..model.state import strip
from ..motion.simulation import Simulation
from ..typing import Floats
from . import files
from .problem import Refused
from .uncertainty import Covariance, derived, sample

if TYPE_CHECKING:
    from ..motion.run import Run
    from .free import Parameters
    from .pictures import FitPlots
    from .solver import Linearised, Objective


#: The largest number of draws for each requested one; more are an error, since hardly any are within the bounds.
_MOST_DRAWS = 1000
#: The number of numbers above which tables of minima leave an array out.
_LONG = 6


@dataclass(frozen=True)
class Minimum:
    """A minimum at which a fit ended.

    Attributes
    ----------
    values : dict
        The parameters at the minimum, without linear unknowns; a fit can start there.
    loss : float
        The sum that is minimised, which is chi2 unless a loss is not linear or a jitter is free.
    chi2 : float
    starts : int
        The number of starts that ended at the minimum.
    message : str
        The reason why the solver stopped before it was at a minimum; empty otherwise.
    """

    values: dict[str, Any]
    loss: float
    chi2: float
    starts: int
    message: str


class Fit(ArrayFields, Tabled):
    """Parameters fitted to observations; made by :func:`fullbody.fit`.

    Attributes
    ----------
    names : tuple of str
        The P parameters and the L linear unknowns of the observations, such as zero points, in the order of all arrays.
    numbers : ndarray, (P + L,)
        The values in the units of the initial values.
    linear : list of dict
        The linear unknowns of each of the observations, by the names that it has for them: what its ``predict`` and
        ``residuals`` take as ``linear``. An unknown of several observations that is not shared has a longer name in
        ``names``.
    covariance : ndarray, (P + L, P + L)
        In the units of the values. For a loss that is not linear the covariance is that of an M-estimator. Rows and
        columns of unconstrained parameters are zero beside the diagonal.
    chi2 : float
        Sum of the squares of the pulls, priors included.
    loss : float
        The sum that was minimised: of the losses of the pulls, and of the logarithms of determinants if jitter is free.
    dof : int
        Data and priors minus parameters and linear unknowns.
    p_value : float or None
        Probability of a larger chi2, for a linear loss, errors without free parameters and at least one degree of
        freedom.
    residuals : list
        Observed minus predicted values of each of the observations, in their units.
    pulls : list of ndarray
        The residuals made independent and divided by their errors.
    times : list of ndarray or Quantity
        The times of a clock at the system to which these belong.
    labels : tuple of str
        The kinds of the observations.
    condition : float
        The ratio of the largest to the smallest singular value of the derivatives, with each parameter in units of the
        error that it would have if it alone were free.
    weakest : dict of float
        The combination of parameters in these units that the data constrain least, a unit vector.
    unconstrained : str or None
        That combination as text, if the data do not constrain it at all.
    differenced : dict of str
        The parameters whose derivatives are differences of complete runs, with the reason.
    differenced_observations : dict of str
        The observations, by ``"observations[0]"`` and so on, whose predictions were differenced with respect to the
        states, since they give no derivatives of their own, with the reason.
    at_bounds : tuple of str
        The parameters at their bounds, for which errors have no meaning.
    minima : tuple of Minimum
        All minima that were found, the lowest first.
    system, state : System, State
    integrator : Integrator or None
    observations : list
        The observations; those that are functions of parameters at the fitted values.
    starts : int
        The number of starts.
    message : str
        The reason why the solver stopped before it was at a minimum, such as an interrupt; empty otherwise. Where it is
        not empty, tables show no standard errors, since ``sigma`` and ``covariance`` are those of another point.
    iterations, runs, refused : int
        Numbers of iterations; of runs, those with derivatives and those of differences included; and of proposals that
        were refused, in all starts.
    last_refusal : str
        The reason why the last of the refused proposals was refused.
    """

    minima: tuple[Minimum, ...]
    starts: int

    def __init__(self, objective: Objective, linearised: Linearised, message: str, iterations: int) -> None:
        from scipy.special import chdtrc

        problem, point, parameters = objective.problem, linearised.point, objective.parameters
        self._objective: Objective | None = objective
        self.parameters = parameters
        self._unknowns = tuple((unknown.name, unknown.unit) for unknown in point.inner.unknowns)
        self.names = self.described.names
        self.numbers = np.append(point.values, point.inner.values)
        self._of_setup = problem.setup.arguments
        self.system, self.state, self.integrator = (
            point.setup_result.system,
            point.setup_result.state,
            problem.integrator,
        )
        self.observations, self.pulls = point.observations, point.pulls
        self.residuals = problem.residuals(point)
        self.linear = [point.linear_values(i) for i in range(len(point.observations))]
        self.times = [observation.emission(self.system) for observation in point.observations]
        self.labels = tuple(repr(observation).partition("(")[0] for observation in point.observations)
        self.differenced = linearised.jacobian.differenced
        self.differenced_observations = linearised.jacobian.differenced_observations
        self.message, self.iterations = message, iterations
        self.runs, self.refused = problem.runs + problem.differentiated, problem.refused
        self.last_refusal = problem.reason
        at = np.logical_or(*parameters.at_bounds(point.values, np.linalg.norm(linearised.matrix, axis=0)))
        self.at_bounds = tuple(name for name, is_at in zip(parameters.names, at, strict=True) if is_at)
        rows, priors = point.rows, np.isfinite(parameters.sigma)
        self.loss = 2.0 * linearised.cost
        pull = (point.values[priors] - parameters.mean[priors]) / parameters.sigma[priors]
        self.chi2 = float(np.sum(rows**2) + np.sum(pull**2))
        self.dof = len(rows) + int(priors.sum()) - len(self.names)
        linear = objective.loss.linear
        is_distributed = linear and self.dof >= 1 and not linearised.jacobian.noise
        self.p_value = float(chdtrc(self.dof, self.chi2)) if is_distributed else None
        shrink = 1.0 if linear else objective.loss.inflation(rows, len(self.names)) ** -0.5
        # Beside all others the linear unknowns have the correlations that they would have as parameters.
        explicit = np.concatenate([linearised.jacobian.explicit, -point.inner.design], axis=1)
        prior_rows = np.pad(linearised.rows, ((0, 0), (0, len(self._unknowns))))
        covariance = Covariance(np.concatenate([shrink * explicit, prior_rows]), self.described)
        self.covariance, self.condition = covariance.matrix, covariance.condition
        self.unconstrained = covariance.unconstrained
        self.weakest = dict(zip(self.names, covariance.weakest.tolist(), strict=True))

    @property
    def described(self) -> Parameters:
        """The names, units, bounds and priors of the parameters, and of the linear unknowns after them."""
        return self.parameters.extended(*zip(*self._unknowns, strict=True)) if self._unknowns else self.parameters

    @property
    def values(self) -> dict[str, Any]:
        """The parameters by name, with the units of their initial values, and the linear unknowns after them."""
        return self.described.named(self.numbers)

    @property
    def sigma(self) -> dict[str, Any]:
        """The standard errors by name; infinite for a parameter in a combination that the data do not constrain."""
        return self.described.named(np.sqrt(np.diag(self.covariance)))

    @property
    def correlation(self) -> Floats:
        """The correlation (P + L, P + L)."""
        errors = np.sqrt(np.diag(self.covariance))
        finite = np.where(np.isfinite(errors) & (errors > 0.0), errors, 1.0)
        scaled = self.covariance / np.outer(finite, finite)
        return np.where(np.eye(len(errors), dtype=bool), 1.0, scaled)

    def __getstate__(self) -> dict[str, Any]:
        # The continuous solution of the run does not pickle.
        return {name: value for name, value in self.__dict__.items() if name != "run"}

    def _parts(self) -> tuple[Any, ...]:
        return files.description(self), tuple(self.pulls), tuple(self.times)

    @cached_property
    def run(self) -> Run:
        """A run with a continuous solution over the epoch and all observations, integrated at the first access.

        It continues from the epoch of the state: where there are observations before that, it goes back to the first of
        them and from there over all of them, with the nominal barycentre of the epoch.
        """
        units, epoch = self.system.context.units, strip(self.state, self.system.context).time
        times = np.concatenate([[epoch], *(units.strip(times, "time", "times") for times in self.times)])
        simulation = Simulation(self.system, self.state, integrator=self.integrator)
        if times.min() == epoch:
            return simulation.integrate(times.max(), dense=True)
        back = simulation.integrate(times.min(), dense=True)
        return simulation.integrate(times.max(), dense=True) if times.max() > epoch else back

    def draw(self, n: int, rng: int | np.random.Generator) -> Paired:
        """Draw parameters from the normal distribution of the fit, within the bounds.

        Parameters
        ----------
        n : int
            Number of draws.
        rng : int or numpy Generator

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
        columns = self.parameters.named(self.draws_as_array(n, rng).T)
        return paired(**{name: columns[name] for name in self._of_setup})

    def draws_as_array(self, n: Any, rng: Any) -> Floats:
        """Draw numbers (n, P) of the parameters, without linear unknowns, in their units; see :meth:`draw`."""
        count = whole_number(n, "n")
        random = generator(rng)
        if self.unconstrained is not None:
            raise InvalidInput(f"there is no distribution to draw from: the data do not constrain {self.unconstrained}")
        size, lower, upper = len(self.parameters), self.parameters.lower, self.parameters.upper
        accepted, covariance = np.empty((0, size)), self.covariance[:size, :size]
        errors = np.sqrt(np.diag(covariance))
        scale = np.where(errors > 0.0, errors, 1.0)
        normal, zeros = covariance / np.outer(scale, scale), np.zeros(size)
        for _ in range(_MOST_DRAWS):
            units = random.multivariate_normal(zeros, normal, count, check_valid="ignore", method="eigh")
            drawn = self.numbers[:size] + scale * units
            accepted = np.concatenate([accepted, drawn[((drawn >= lower) & (drawn <= upper)).all(axis=1)]])
            if len(accepted) >= count:
                return accepted[:count]
        raise InvalidInput(f"hardly any draw is within the bounds of {', '.join(self.at_bounds) or 'the parameters'}")

    def log_posterior(self, values: Any, gradient: bool = False) -> Any:
        """Compute the logarithm of the posterior density, up to a constant that depends on the data and their errors.

        It is minus half the sum of the losses, of the squares of the priors' pulls, and of the logarithms of variances
        where a jitter is free, integrated over linear unknowns.

        Parameters
        ----------
        values : dict or array_like, (P,)
            The parameters without linear unknowns, as ``minima`` has them: by name with units, or numbers in their
            order and the units of ``values``.
        gradient : bool
            Whether to compute the derivatives with respect to the parameters too.

        Returns
        -------
        float, or (float, ndarray (P,))
            Minus infinity outside the bounds and where the setup refuses the values or a run ends with an error, with
            a gradient of zero: the density is zero there.

        Raises
        ------
        InvalidInput
            For linear unknowns under a loss that is not linear, over which the density has no integral in closed form.
        """
        objective, parameters = self._minimised(), self.parameters
        numbers = parameters.numbers(values)
        nothing = (-np.inf, np.zeros(len(numbers))) if gradient else -np.inf
        if ((numbers < parameters.lower) | (numbers > parameters.upper)).any():
            return nothing
        try:
            point = objective.problem.point(numbers)
        except Refused:
            return nothing
        density = objective.log_density(point)
        if not gradient:
            return density
        linearised = objective.linearised(point)
        return density, -linearised.matrix.T @ linearised.vector - linearised.jacobian.log_determinant

    def _minimised(self) -> Objective:
        if self._objective is None:
            raise InvalidInput("this fit is from a file, which keeps neither the setup nor the observations")
        return self._objective

    derived = derived
    sample = sample
    save = files.save

    @property
    def plot(self) -> FitPlots:
        """The plots ``fit.plot.residuals()``, ``fit.plot.sky()`` and ``fit.plot.corner()``."""
        from .pictures import FitPlots

        return FitPlots(self)

    def to_table(self) -> Any:
        """Return an astropy ``Table`` with a row for each parameter: name, value, error, unit and bounds.

        Its ``meta`` has chi2, the degrees of freedom and the correlation. If the solver stopped before it was at a
        minimum, errors are masked and the correlation is left out.
        """
        with need("observing", "a table"):
            from astropy.table import MaskedColumn
            from astropy.table import Table as AstropyTable

        parameters, errors = self.described, np.sqrt(np.diag(self.covariance))
        units = [str(unit or "") for unit in parameters.units]
        columns = {"parameter": list(self.names), "value": self.numbers, "sigma": errors, "unit": units}
        meta: dict[str, Any] = {"chi2": self.chi2, "loss": self.loss, "dof": self.dof}
        if self.message:
            columns["sigma"] = MaskedColumn(errors, mask=True)
            meta["message"] = self.message
        else:
            meta["correlation"] = self.correlation.tolist()
        return AstropyTable(columns | {"min": parameters.lower, "max": parameters.upper}, meta=meta)

    def _tables(self) -> tuple[Table, ...]:
        rows: list[Any] = []
        for k, name in enumerate(self.names):
            flags = (("at its bound", self.at_bounds), ("differenced", self.differenced))
            notes = [note for note, which in flags if name in which]
            value, error = _with_error(float(self.numbers[k]), float(np.sqrt(self.covariance[k, k])))
            if self.message:
                value, error = f"{self.numbers[k]:.8g}", "-"
            rows.append((name, value, error, str(self.described.units[k] or ""), ", ".join(notes)))
        about = [
            ("chi2", f"{self.chi2:.6g} for {self.dof} degrees of freedom"),
            ("p-value", "-" if self.p_value is None else f"{self.p_value:.3g}"),
            ("loss", f"{self.loss:.6g}"),
            ("condition", f"{self.condition:.3g}"),
            ("iterations", f"{self.iterations}, {self.runs} runs, {self.refused} proposals refused"),
            ("last refused", self.last_refusal),
            ("not constrained", self.unconstrained),
            ("ended", self.message),
            *((f"{name} differenced", reason) for name, reason in self.differenced.items()),
            *((f"{name} differenced", reason) for name, reason in self.differenced_observations.items()),
        ]
        title = "Fit, not at a minimum" if self.message else "Fit"
        tables = [
            Table(title, ("parameter", "value", "error", "unit", "note"), rows),
            Table("Quality", (), [(what, text) for what, text in about if text]),
        ]
        if len(self.minima) > 1:
            # The columns of long arrays would not fit.
            few = [k for k, name in enumerate(self.parameters.argument_of) if self.parameters.size_of(name) <= _LONG]
            names = (self.parameters.names[k] for k in few)
            lines: list[Any] = []
            for item in self.minima:
                numbers = item.loss, item.chi2, item.starts, *self.parameters.numbers(item.values)[few]
                lines.append([f"{number:.6g}" for number in numbers])
            tables.append(Table(f"Minima from {self.starts} starts", ("loss", "chi2", "starts", *names), lines))
        return tuple(tables)

    def __repr__(self) -> str:
        return to_text(self)


def fit_in(content: Any) -> Fit:
    """Return the fit in a file."""
    fit = object.__new__(Fit)
    attributes = files.contents(content)
    fit.__dict__.update(attributes, minima=tuple(Minimum(*row) for row in attributes["minima"]))
    return fit


def _with_error(value: float, error: float) -> tuple[str, str]:
    """Return a value and its error as texts, to two digits of the error."""
    if not (np.isfinite(error) and error > 0.0):
        return f"{value:.8g}", "infinite" if error else "0"
    digits = max(0, 1 - int(np.floor(np.log10(error))))
    if digits > 12 or error >= 1e6 or abs(value) >= 1e9:
        decimals = max(1, int(np.floor(np.log10(max(abs(value), error)))) - int(np.floor(np.log10(error))) + 2)
        return f"{value:.{min(decimals, 17)}g}", f"{error:.2g}"
    return f"{value:.{digits}f}", f"{error:.{digits}f}"
