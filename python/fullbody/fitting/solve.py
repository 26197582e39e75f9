"""Least squares: steps of a trust region, from one start or from many."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import integer, seed_of
from ..base.progress import Progress
from ..base.units import need
from ..errors import InconsistentInput, Interrupted, InvalidInput, caution
from .free import Parameters
from .losses import Loss, Outliers, loss_of
from .problem import Jacobian, Observed, Point, Problem, Refused
from .result import Fit, Minimum

if TYPE_CHECKING:
    from ..record.integrators import Integrator

__all__ = ["fit"]

_Array = npt.NDArray[np.float64]

#: The distance from the minimum, in errors, at which the solver stops, and the relative changes of chi2 and of the
#: parameters at which it stops if rounding errors prevent that.
_CLOSE, _FTOL, _XTOL = 1e-4, 1e-9, 1e-13
#: The distance from the minimum above which a solver that no longer advances has not converged.
_FAR = 0.03
#: The largest difference, in units of each parameter's error, between two fits at the same minimum.
_SAME = 0.1


def fit(
    setup: Callable[..., Any],
    parameters: Mapping[str, Any],
    observations: Observed | Callable[..., Observed] | Sequence[Observed | Callable[..., Observed]],
    *,
    integrator: Integrator | None = None,
    loss: str | Outliers | Callable[[Any], Any] = "linear",
    starts: int | Sequence[Mapping[str, Any]] = 1,
    seed: int | None = None,
    progress: bool | str | Callable[..., Any] = False,
) -> Fit:
    """Fit the parameters of a setup to observations by least squares.

    Each iteration integrates the motion once alone and once with its exact derivatives, forward and backward from the
    epoch of the state over all observations, whatever the number of parameters.

    Parameters
    ----------
    setup : callable
        ``setup(**parameters)`` returns ``(system, state)``, as for :func:`fullbody.sweep`.
    parameters : dict
        Names to initial values, numbers or Quantities, or to :class:`fullbody.fitting.Free` with bounds and priors. The
        setup is differentiated by differences over a thousandth of the initial value or less.
    observations : Astrometry, Photometry, Radar, Measured, or a list of them
        Observations may also be a function of parameters that returns them: ``lambda jitter: data.with_jitter(jitter)``
        frees a jitter, ``lambda albedo: observing.Photometry(..., albedo={"Alpha": 1.0, "Beta": albedo})`` an albedo.
    integrator : Integrator, optional
        :class:`fullbody.Verner98` unless given.
    loss : {"linear", "soft_l1", "huber", "cauchy", "arctan"}, Outliers or callable
        The weight of pulls, as in ``scipy.optimize.least_squares`` with scale one; priors always count linearly. A
        function takes squares (...) and returns the loss with two derivatives (3, ...).
    starts : int or list of dict
        The starts themselves, or their number: the first has the given values, the others are spread by Latin hypercube
        between the bounds of each parameter, or over its prior if it has no bounds.
    seed : int, optional
        The seed of random starts, needed if ``starts`` is above one.
        Needed by more than one start.
    progress : bool, str or callable
        Whether to show the number of runs and chi2, or a title; or a function of (done, total, description): the number
        of runs, ``None``, and a text with chi2.

    Returns
    -------
    Fit
        The best minimum; ``Fit.minima`` lists all. Ctrl-C returns the best values so far, with the
        ``Fit.message`` that says so.

    Raises
    ------
    InvalidInput
        For invalid arguments, more parameters than data, a setup that jumps, and starts that are all refused.
    Interrupted
        On Ctrl-C before there is anything to return.

    Warns
    -----
    InconsistentInput
        If the data leave a combination of parameters unconstrained, and if the solver reaches its limit of steps.

    Notes
    -----
    The solver is scipy's ``least_squares`` ("trf"), in units of the errors that parameters have at the start. A step to
    values that the setup refuses, or to a collision, is shortened to a quarter and tried again; ``Fit.refused``
    counts these.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> from fullbody import observing
    >>> def setup(mass):
    ...     system, state = fullbody.systems.case1()
    ...     return system.with_body(1, system[1].shape, mass=mass), state
    >>> system, state = setup(2.0)
    >>> times, far = np.linspace(1.0, 20.0, 40), [1e6, 0.0, 0.0]
    >>> view = observing.Geometry([0.0, 30.0], to_observer=far, light_time=False)
    >>> options = {"sigma": 0.01, "body": 1, "about": 0, "geometry": view}
    >>> run = system.integrate(state, 20.0, dense=True)
    >>> ranges = observing.Radar(times, range=0 * times, **options).predict(run).range
    >>> data = observing.Radar(times, range=ranges, **options)
    >>> found = fullbody.fit(setup, {"mass": 2.01}, data)
    >>> round(found.values["mass"], 6), found.dof
    (2.0, 39)
    """
    with need("fit", "a fit"):
        from scipy.optimize import least_squares  # noqa: F401
    known = Parameters(parameters)
    problem = Problem(setup, known, observations, integrator)
    wanted = loss_of(loss)
    if seed is not None:
        seed = seed_of(seed)
    places = _starts(known, starts, seed)
    done: list[_Solution] = []
    with Progress(progress) as report:
        for place in places:
            solver = _Solver(problem, wanted, report)
            try:
                solution = solver.solve(place)
            except Refused as error:
                if len(places) == 1:
                    raise InvalidInput(f"the start of the fit is refused: {error}") from error
                continue
            if solution is not None:
                done.append(solution)
            if solver.interrupted:
                break
    if not done:
        if problem.differentiated or not problem.refused:
            raise Interrupted("interrupted before the first derivatives of the fit; there is nothing to return")
        raise InvalidInput(f"all {len(places)} starts of the fit are refused; the last: {problem.reason}")
    return _result(problem, wanted, done, len(places))


@dataclass
class _Solution:
    """The last values of a solver."""

    point: Point
    jacobian: Jacobian
    cost: float
    message: str
    iterations: int


class _Converged(Exception):
    """The solver is at a minimum."""


class _Solver:
    """The residuals of a problem in the form that scipy's solver takes, with the best values so far."""

    def __init__(self, problem: Problem, loss: Loss, report: Any) -> None:
        self._problem, self._loss, self._report = problem, loss, report
        self._parameters = problem.parameters
        self._priors = np.isfinite(self._parameters.sigma)
        self._last: Point | None = None
        self._best: _Solution | None = None
        self._iterations = 0
        self._distance = np.inf
        self._taken = False
        self.interrupted = False

    def solve(self, start: _Array) -> _Solution | None:
        """Find the minimum next to a start; ``None`` after an interrupt that came before any derivatives."""
        from scipy.optimize import least_squares

        try:
            first = self._problem.point(start)
            check_count(self._problem, first)
            self._last = first
            jacobian = self._jacobian(start)
            norms = np.linalg.norm(jacobian, axis=0)
            sizes = np.array([self._parameters.size(k, value) for k, value in enumerate(start)])
            scale = np.where(norms > 0.0, 1.0 / np.where(norms > 0.0, norms, 1.0), sizes)
            # The first trust region allows changes by all of the parameters' sizes.
            begin = sizes / scale
            first_jacobian: list[_Array] = [jacobian]

            def residuals(x: _Array) -> _Array:
                return self._residuals(start + scale * (x - begin))

            def jacobian_at(x: _Array) -> _Array:
                found = first_jacobian.pop() if first_jacobian else self._jacobian(start + scale * (x - begin))
                return np.asarray(found * scale)

            bounds = tuple((one - start) / scale + begin for one in (self._parameters.lower, self._parameters.upper))
            options = {"ftol": _FTOL, "xtol": _XTOL, "gtol": 1e-15, "x_scale": "jac"}
            # The solver's squares overflow if the start is 1e50 errors away from a prior. Whether the fit reached a
            # minimum is judged below by the distance that is left, not by these warnings.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                found = least_squares(residuals, begin, jacobian_at, bounds, **options)
            why = f"; the last proposal refused: {self._problem.reason}" if self._problem.refused else ""
            message = "" if found.status > 0 else f"stopped after {found.nfev} proposals, the limit{why}"
            if found.status > 0 and self._distance > _FAR:
                message = f"stopped {self._distance:.2g} errors away from where the derivatives lead{why}"
        except _Converged:
            message = ""
        except KeyboardInterrupt:
            self.interrupted = True
            message = "interrupted: the values are the best so far, not those of a minimum"
        if self._best is None:
            return None
        self._best.message = message
        self._best.iterations = self._iterations
        return self._best

    def _vector(self, point: Point) -> _Array:
        pulls = np.concatenate([np.ravel(part) for part in point.pulls])
        parts = [self._loss.roots(pulls)[0], point.rows[len(pulls) :], self._prior(point.values)]
        return np.concatenate(parts)

    def _prior(self, values: _Array) -> _Array:
        on, known = self._priors, self._parameters
        return np.asarray((values[on] - known.mean[on]) / known.sigma[on])

    def _residuals(self, values: _Array) -> _Array:
        if self._last is not None and np.array_equal(self._last.values, values):
            return self._vector(self._last)
        try:
            # After an accepted step the next one is probably accepted too, and its derivatives are then needed.
            point = self._problem.point(values, differentiated=self._taken)
        except Refused:
            if self._best is None:
                raise
            return np.full(len(self._vector(self._best.point)), np.nan)
        finally:
            self._taken = False
            self._show()
        self._last = point
        return self._vector(point)

    def _jacobian(self, values: _Array) -> _Array:
        if self._last is None or not np.array_equal(self._last.values, values):
            self._last = self._problem.point(values)
        point = self._last
        jacobian = self._problem.jacobian(point)
        vector = self._vector(point)
        cost = 0.5 * float(np.sum(vector**2))
        if self._best is None or cost <= self._best.cost:
            self._best = _Solution(point, jacobian, cost, "", 0)
        self._iterations += 1
        self._taken = True
        self._show()
        pulls = np.concatenate([np.ravel(part) for part in point.pulls])
        weights = self._loss.roots(pulls)[1]
        rows = jacobian.rows.copy()
        rows[: len(pulls)] *= weights[:, None]
        prior = np.diag(1.0 / self._parameters.sigma)[self._priors]
        matrix = np.concatenate([rows, prior])
        self._distance = self._step(values, matrix, vector)
        if self._distance < _CLOSE:
            raise _Converged
        return matrix

    def _step(self, values: _Array, matrix: _Array, vector: _Array) -> float:
        """Return the length of the step to the bounded minimum of the linearised problem, in units of errors."""
        known, norms = self._parameters, np.linalg.norm(matrix, axis=0)
        free = norms > 0.0
        scaled = matrix / np.where(free, norms, 1.0)
        near = 0.05 / np.where(free, norms, 1.0)
        for _ in range(len(values)):
            step = np.zeros(len(values))
            step[free] = np.linalg.lstsq(scaled[:, free], -vector, rcond=1e-12)[0]
            out = ((step < 0.0) & (values - known.lower < near)) | ((step > 0.0) & (known.upper - values < near))
            if not (out & free).any():
                break
            free = free & ~out
        return float(np.linalg.norm(scaled @ step))

    def _show(self) -> None:
        if self._report is not None and self._best is not None:
            runs = self._problem.runs + self._problem.differentiated
            self._report(runs, None, f"{runs} runs, chi2 {2.0 * self._best.cost:.8g}")


def check_count(problem: Problem, point: Point) -> None:
    """Raise an error for more parameters than data."""
    data = sum(part.size for part in point.pulls) + int(np.isfinite(problem.parameters.sigma).sum())
    solved = sum(getattr(one, "free_zeros", 0) for one in point.observations)
    if data < len(problem.parameters) + solved:
        also = f" and {solved} zero points" if solved else ""
        raise InvalidInput(
            f"parameters has {len(problem.parameters)} parameters{also}, and there are {data} numbers of data and "
            "priors; expected no more parameters than data"
        )


def _starts(known: Parameters, starts: Any, seed: Any) -> list[_Array]:
    """Return the places from which the solver starts."""
    if isinstance(starts, list | tuple):
        if not starts:
            raise InvalidInput("starts is empty; expected a number, or one start or more")
        found = [known.numbers(one) for one in starts]
        for place in found:
            if ((place < known.lower) | (place > known.upper)).any():
                raise InvalidInput(f"starts has {known.named(place)}, which is not within the bounds")
        return found
    count = integer(starts)
    if count is None or count < 1:
        raise InvalidInput(f"starts is {starts!r}; expected a whole number above zero, or a list of starts")
    if count == 1:
        return [known.start]
    if seed is None:
        raise InvalidInput(f"seed is None, but {count - 1} starts are drawn; expected a whole number")
    from scipy.stats import norm, qmc

    width = known.upper - known.lower
    bounded, prior = np.isfinite(width), np.isfinite(known.sigma)
    if not (bounded | prior).any():
        raise InvalidInput(f"starts is {count}, but no parameter has two bounds or a prior over which to spread them")
    parts = qmc.LatinHypercube(len(known), seed=np.random.default_rng(seed_of(seed))).random(count - 1)
    places = [known.start]
    for part in parts:
        inside = known.lower + np.where(bounded, width, 0.0) * part
        drawn = known.mean + np.where(prior, known.sigma, 0.0) * norm.ppf(np.clip(part, 1e-6, 1.0 - 1e-6))
        place = np.where(bounded, inside, np.where(prior, drawn, known.start))
        places.append(np.clip(place, known.lower, known.upper))
    return places


def _result(problem: Problem, loss: Loss, done: list[_Solution], starts: int) -> Fit:
    """Return the best of the solutions as a fit that lists all different ones."""
    best = min(range(len(done)), key=lambda place: done[place].cost)
    fits = [Fit(problem, loss, one.point, one.jacobian, one.message, one.iterations) for one in done]
    minima: list[tuple[Fit, int]] = []
    for one in sorted(fits, key=lambda each: each.chi2 if loss.linear else each.loss):
        for place, (other, count) in enumerate(minima):
            if _same(one, other):
                minima[place] = (other, count + 1)
                break
        else:
            minima.append((one, 1))
    found = fits[best]
    found.minima = tuple(Minimum(each.values, each.chi2, count, each.message) for each, count in minima)
    found.starts = starts
    if found.message:
        caution(f"the fit was {found.message}", InconsistentInput)
    elif found.unconstrained is not None:
        caution(f"the data do not constrain {found.unconstrained}", InconsistentInput)
    return found


def _same(one: Fit, other: Fit) -> bool:
    """Return whether two fits have the same values within their errors; angles with units are taken modulo a turn."""
    apart = np.empty(len(one.names))
    for k, name in enumerate(one.names):
        difference = one.values[name] - other.values[name]
        unit = getattr(difference, "unit", None)
        if unit is not None and unit.physical_type == "angle":
            turn = 360.0 * (1.0 * unit).to_value("deg") ** -1
            apart[k] = (difference.value + 0.5 * turn) % turn - 0.5 * turn
        else:
            apart[k] = getattr(difference, "value", difference)
    errors = np.sqrt(np.diag(other.covariance))
    return bool((np.abs(apart) <= _SAME * errors).all())
