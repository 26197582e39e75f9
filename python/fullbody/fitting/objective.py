"""The sum that a fit minimises, as the squares of the components of a vector, with its derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..typing import Floats
from . import noise
from .losses import Loss
from .problem import EvaluatedPoint, Problem, PullJacobian

__all__ = ["Linearised", "Objective"]


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

    def __init__(self, problem: Problem, loss: Loss) -> None:
        self.problem, self.loss, self.parameters = problem, loss, problem.parameters
        self._weights = np.diag(np.where(np.isfinite(self.parameters.sigma), 1.0 / self.parameters.sigma, 0.0))

    def vector(self, point: EvaluatedPoint) -> Floats:
        """Return the components (R,): of pulls, errors and priors, and P zeros in the rows of the information."""
        prior = self._weights @ (point.values - self.parameters.mean)
        parts = [self.loss.roots(point.rows)[0], np.sqrt(point.log_determinants), prior, np.zeros(len(prior))]
        return np.concatenate(parts)

    def linearised(self, point: EvaluatedPoint, jacobian: PullJacobian) -> Linearised:
        """Return the derivatives at a point.

        Parameters of errors have no part in the derivatives of pulls. Their gradient is put along the vector, whose
        components are small in comparison at a minimum, and their expected information, in rows where the vector is
        zero (Fisher's scoring).
        """
        vector, (roots, weights) = self.vector(point), self.loss.roots(point.rows)
        gradient, information, widths = self._noise(point, jacobian, roots * weights)
        values, vectors = np.linalg.eigh(information)
        own = np.concatenate([self._weights, np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T])
        determinants = np.zeros((len(point.errors), len(gradient)))
        matrix = np.concatenate([weights[:, None] * jacobian.rows, determinants, own])
        norms = np.sqrt(np.maximum(np.sum(matrix**2, axis=0), widths))
        matrix += np.outer(vector, gradient) / max(float(vector @ vector), 1e-300)
        return Linearised(point, jacobian, vector, matrix, own, norms)

    def _noise(self, point: EvaluatedPoint, jacobian: PullJacobian, by_pulls: Floats) -> tuple[Floats, Floats, Floats]:
        """Return gradient (P,), information (P, P) and inverse squared lengths (P,) of the parameters of errors."""
        gradient, information, widths = (
            np.zeros_like(point.values),
            np.zeros((len(point.values),) * 2),
            0.0 * point.values,
        )
        parts = np.split(by_pulls, np.cumsum([part.size for part in point.pulls])[:-1])
        for i, errors in point.errors.items():
            which = [k for k, changes in jacobian.noise.items() if i in changes]
            if which:
                changes = np.array([jacobian.noise[k][i] for k in which])
                found = noise.derivatives(errors, point.pulls[i].reshape(errors.covariance.shape[:2]), changes)
                gradient[which] += found.pulls.reshape(len(which), -1) @ parts[i] + 0.5 * found.log_determinant
                information[np.ix_(which, which)] += found.information
                # The information about a jitter vanishes with it, but not the length over which it changes the errors.
                size = np.maximum(np.abs(point.values[which]), 1e-300)
                widths[which] += 0.5 * np.abs(found.log_determinant) / size
        return gradient, information, widths
