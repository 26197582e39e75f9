"""The sum that a fit minimises, as the squares of the components of a vector, with its derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InvalidInput
from ..typing import Floats
from . import noise
from .point import EvaluatedPoint, PullJacobian
from .problem import Problem


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
