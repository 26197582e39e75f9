"""The sum that a fit minimises, with its derivatives, and its solver: steps of a trust region from one start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidInput
from ..typing import Floats
from . import noise
from .point import EvaluatedPoint, PullJacobian
from .problem import Problem, Refused

#: The distance from the minimum, in errors, at which the solver stops, and the relative changes of chi2 and of the
#: parameters at which it stops if rounding errors prevent that.
_CLOSE, _FTOL, _XTOL = 1e-4, 1e-12, 1e-13
#: The distance from the minimum above which a solver that no longer advances has not converged, and the change of chi2,
#: relative to it, that rounding errors hide.
_NOT_CONVERGED, _CHI2_ROUNDING = 0.03, 1e-11
#: The changes of chi2 over how many iterations at which a solver has converged whose derivatives have kinks, and the
#: largest distance from the minimum there.
_STALLED, _ITERATIONS, _KINKED = 0.01, 3, 1.0


@dataclass
class Linearised:
    """The objective near values of the parameters.

    The squares of the ``vector`` (R,) are minimised. The ``matrix`` J (R, P) has the gradient J^T ``vector`` of half
    the sum, and the expected information J^T J for a linear loss; ``rows`` (2 P, P) are those of its rows that hold
    priors and the information about parameters of errors. ``norms`` (P,) are the inverse of each parameter's natural
    length: of its error if it alone were free, as far as it has one.
    """

    point: EvaluatedPoint
    jacobian: PullJacobian
    vector: Floats
    matrix: Floats
    rows: Floats
    norms: Floats

    @property
    def cost(self) -> float:
        """Half the sum that is minimised."""
        return 0.5 * float(self.vector @ self.vector)


class Objective:
    """The sum of the losses of pulls, of the squares of priors' pulls, and of the logarithms of determinants of
    errors.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem, self.loss, self.parameters = problem, problem.loss, problem.parameters
        self._weights = np.diag(np.where(np.isfinite(self.parameters.sigma), 1.0 / self.parameters.sigma, 0.0))

    def vector(self, point: EvaluatedPoint) -> Floats:
        """Return the components (R,): of pulls, errors and priors, and P zeros in the rows of the information."""
        prior = self._weights @ (point.values - self.parameters.mean)
        parts = [self.loss.roots(point.rows)[0], np.sqrt([point.log_determinant]), prior, np.zeros(len(prior))]
        return np.concatenate(parts)

    def linearised(self, point: EvaluatedPoint) -> Linearised:
        """Return the derivatives at a point.

        Parameters of errors have no part in the derivatives of pulls. Their gradient is put along the vector, whose
        components are small in comparison at a minimum, and their expected information, in rows where the vector is
        zero (Fisher's scoring).
        """
        jacobian = self.problem.jacobian(point)
        vector, (roots, weights) = self.vector(point), self.loss.roots(point.rows)
        parts = map(point.inner.split, (point.inner.projection.basis, point.rows, roots * weights))
        gradient, information, widths = noise.derivatives(point.values, jacobian.noise, *parts)
        values, vectors = np.linalg.eigh(information)
        rows = np.concatenate([self._weights, np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T])
        determinant = np.zeros((1, len(gradient)))
        matrix = np.concatenate([weights[:, None] * jacobian.rows, determinant, rows])
        norms = np.sqrt(np.maximum(np.sum(matrix**2, axis=0), widths))
        matrix += np.outer(vector, gradient) / max(float(vector @ vector), 1e-300)
        return Linearised(point, jacobian, vector, matrix, rows, norms)

    def log_density(self, point: EvaluatedPoint) -> float:
        """Return the logarithm of the posterior density, integrated over the linear unknowns, up to a constant.

        The integral of a normal density over L unknowns of design A is (2 pi)^(L/2) det(A^T A)^(-1/2) times its
        largest value.
        """
        if not self.loss.linear and point.inner.unknowns:
            raise InvalidInput(
                f"loss is {self.loss.argument!r}, for which the integral over linear unknowns such as "
                f"{point.inner.unknowns[0].name} has no closed form; expected loss='linear'"
            )
        prior = self._weights @ (point.values - self.parameters.mean)
        losses = float(np.sum(self.loss.roots(point.rows)[0] ** 2) + prior @ prior)
        widened = sum(map(noise.log_determinant, point.errors.values()))
        volume = len(point.inner.unknowns) * np.log(2.0 * np.pi) - point.inner.projection.log_determinant
        return 0.5 * (volume - losses - widened)


class _Converged(Exception):
    """The solver is at a minimum."""


class Solver:
    """The residuals of a problem in the form that scipy's solver takes.

    Of the lowest values so far, ``best`` has the derivatives; ``message`` is the reason why the solver stopped before
    it was at a minimum, and empty otherwise.
    """

    def __init__(self, objective: Objective, report: Any, proposals: int | None = None) -> None:
        self._objective, self._report, self._proposals = objective, report, proposals
        self._problem, self._parameters = objective.problem, objective.parameters
        self._last: EvaluatedPoint | None = None
        self.best: Linearised | None = None
        self.message, self.iterations, self.interrupted = "", 0, False
        self._distance, self._accepted = np.inf, False
        self._costs: list[float] = []

    def solve(self, start: Floats) -> None:
        """Find the minimum next to a start; after an early interrupt ``best`` may still be ``None``."""
        from scipy.optimize import least_squares

        try:
            self._last = self._problem.point(start)
            _check_count(self._problem, self._last)
            first = [self._linearised(start)]
            lengths = self._problem.step_lengths(start)
            # The first trust region allows changes by all of the parameters' sizes.
            scale = np.divide(1.0, first[0].norms, out=lengths.copy(), where=first[0].norms > 0.0)
            scaled_start = lengths / scale

            def residuals(x: Floats) -> Floats:
                return self._residuals(start + scale * (x - scaled_start))

            def jacobian(x: Floats) -> Floats:
                return (first.pop() if first else self._linearised(start + scale * (x - scaled_start))).matrix * scale

            bounds = tuple(
                (item - start) / scale + scaled_start for item in (self._parameters.lower, self._parameters.upper)
            )
            options = {"ftol": _FTOL, "xtol": _XTOL, "gtol": 1e-15, "max_nfev": self._proposals}
            # The solver's squares overflow if the start is 1e50 errors away from a prior. Whether the fit reached a
            # minimum is judged below by the distance that is left, not by these warnings.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                solution = least_squares(residuals, scaled_start, jacobian, bounds, **options)
            refusal = self._problem.reason and f"; the last proposal refused: {self._problem.reason}"
            if refusal and self.best is not None:
                refusal += self._problem.limits(self.best.point.values)
            if solution.status <= 0:
                self.message = f"stopped after {solution.nfev} proposals, the limit{refusal}"
            elif self._distance > _NOT_CONVERGED and self._distance**2 > _CHI2_ROUNDING * 2.0 * solution.cost:
                self.message = f"stopped {self._distance:.2g} errors away from where the derivatives lead{refusal}"
        except _Converged:
            pass
        except KeyboardInterrupt:
            self.interrupted = True
            self.message = "interrupted: the values are the best so far, not those of a minimum"

    def _residuals(self, values: Floats) -> Floats:
        if self._last is None or not np.array_equal(self._last.values, values):
            try:
                # After an accepted step the next one is probably accepted too, and its derivatives are then needed.
                self._last = self._problem.point(values, differentiated=self._accepted)
            except Refused:
                if self.best is None:
                    raise
                return np.full(len(self.best.vector), np.nan)
            finally:
                self._accepted = False
                self._show()
        return self._objective.vector(self._last)

    def _linearised(self, values: Floats) -> Linearised:
        if self._last is None or not np.array_equal(self._last.values, values):
            self._last = self._problem.point(values)
        linearised = self._objective.linearised(self._last)
        if self.best is None or linearised.cost <= self.best.cost:
            self.best = linearised
        self.iterations += 1
        self._accepted = True
        self._show()
        self._distance = self._step(linearised)
        if self._distance < _CLOSE or (linearised.jacobian.kinks and self._is_stalled(linearised.cost)):
            raise _Converged
        return linearised

    def _is_stalled(self, cost: float) -> bool:
        """Return whether chi2 has settled close to a minimum that derivatives with kinks do not reach."""
        self._costs.append(cost)
        recent = self._costs[-1 - _ITERATIONS :]
        settled = len(recent) > _ITERATIONS and 2.0 * (recent[0] - recent[-1]) < _STALLED
        return settled and self._distance < _KINKED

    def _step(self, linearised: Linearised) -> float:
        """Return the length of the step to the bounded minimum of the linearised problem, in units of errors."""
        norms = np.linalg.norm(linearised.matrix, axis=0)
        free = norms > 0.0
        scaled = linearised.matrix / np.where(free, norms, 1.0)
        low, high = self._parameters.at_bounds(linearised.point.values, norms)
        for _ in range(len(norms)):
            step = np.zeros(len(norms))
            step[free] = np.linalg.lstsq(scaled[:, free], -linearised.vector, rcond=1e-12)[0]
            out = free & (((step < 0.0) & low) | ((step > 0.0) & high))
            if not out.any():
                break
            free = free & ~out
        return float(np.linalg.norm(scaled @ step))

    def _show(self) -> None:
        if self._report is not None and self.best is not None:
            runs = self._problem.runs + self._problem.differentiated
            self._report(runs, None, f"chi2 {2.0 * self.best.cost:.8g}")


def _check_count(problem: Problem, point: EvaluatedPoint) -> None:
    """Raise an error for more parameters than data."""
    data = len(point.rows) + int(np.isfinite(problem.parameters.sigma).sum())
    solved = len(point.inner.unknowns)
    if data < len(problem.parameters) + solved:
        also = f" and {solved} linear unknowns" if solved else ""
        raise InvalidInput(
            f"parameters has {len(problem.parameters)} parameters{also}, and there are {data} numbers of data and "
            "priors; expected no more parameters than data"
        )
