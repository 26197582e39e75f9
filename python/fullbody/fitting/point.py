"""The pulls of a fit at values of its parameters, their derivatives, and the linear unknowns of the observations.

Let z be the pulls (residuals divided by errors) with all linear unknowns zero, and A the design. The unknowns b are
those at which the sum of the losses of z - A b is least. The solver of the fit receives only the pulls z - A b, with
their exact derivatives (variable projection, Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413), so that linear
unknowns cost neither iterations nor runs.

The contracted numbers of M pulls and L unknowns are M + L + 1 numbers from whose derivatives those of z - A b follow:
the pulls for constant b, and L + 1 weighted sums over the elements of A (:meth:`LinearModel.contracted`).
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.projection import Projection
from ..errors import InvalidInput
from ..observing.linear import Held, LinearModel, LinearUnknown
from ..record.derivatives import FunctionDerivatives
from ..typing import Floats
from .losses import LINEAR, Loss
from .noise import design_without_jitter, log_determinant
from .setup_result import SetupResult

if TYPE_CHECKING:
    from ..motion.run import Run

#: The absolute and relative length of a step at which the solution for a robust loss has converged, and the largest
#: number of steps.
_ABSOLUTE, _RELATIVE, _STEPS = 1e-9, 1e-13, 200


def model_of(observation: Any, run: Any) -> LinearModel:
    """Return the pulls of observations as a function of their linear unknowns; a class of the user may have none."""
    if hasattr(observation, "linear"):
        model: LinearModel = observation.linear(run)
    else:
        pulls = np.asarray(observation.pulls(run), dtype=np.float64)
        model = LinearModel((), pulls, np.zeros((*pulls.shape, 0)))
    if not (np.isfinite(model.pulls).all() and np.isfinite(model.design).all()):
        raise InvalidInput(f"{observation!r} has predictions that are not finite")
    return model


class InnerSolution:
    """The solution of a fit's inner problem: the L linear unknowns at which the sum of the losses of M pulls is least.

    The ``values`` (L,) of the ``unknowns`` are the solution, and the ``pulls`` (M,) those of all observations at the
    solution. Shared unknowns of the same name in several observations are one unknown. The ``projection`` is the
    factorisation of the ``design`` (M, L) of all observations, and ``held`` has for each of the models the constants
    with which it is differentiated.
    """

    def __init__(self, models: Sequence[LinearModel], loss: Loss) -> None:
        self._sizes = [model.pulls.size for model in models]
        self._columns, self.unknowns = _joined(models)
        design = np.zeros((sum(self._sizes), len(self.unknowns)))
        ends = np.cumsum([0, *self._sizes])
        self._rows = [slice(first, last) for first, last in itertools.pairwise(ends)]
        for model, rows, columns in zip(models, self._rows, self._columns, strict=True):
            design[rows, columns] = model.design.reshape(model.pulls.size, len(columns))
        pulls_at_zero = np.concatenate([model.pulls.ravel() for model in models])
        self.design = design
        self.projection = Projection(design, [unknown.name for unknown in self.unknowns])
        basis = self.projection.basis
        coordinates = basis.T @ pulls_at_zero
        if not loss.linear and self.unknowns:
            coordinates = _robust(pulls_at_zero, basis, coordinates, loss)
        self.values = self.projection.unknowns(coordinates)
        self.pulls = pulls_at_zero - basis @ coordinates
        slope, self._curvature = loss.influence(self.pulls)
        # Psi is half the derivative of the loss.
        psi, inverse = slope * self.pulls, self.projection.inverse
        self.held = [
            Held(
                self.values[columns],
                psi[rows].reshape(model.pulls.shape),
                inverse[rows][:, columns].reshape(model.design.shape),
            )
            for model, rows, columns in zip(models, self._rows, self._columns, strict=True)
        ]
        self._is_linear = loss.linear

    def split(self, rows: Floats) -> list[Floats]:
        """Return the parts (M_i, ...) of an array (M, ...), one for each of the models."""
        return [rows[part] for part in self._rows]

    def values_of(self, index: int) -> Floats:
        """Return the linear unknowns of one of the models, in its order."""
        return self.values[self._columns[index]]

    def gathered(self, parts: Sequence[Floats]) -> Floats:
        """Return the contracted numbers (M + L + 1, ...) of all models from those of each of them."""
        count = len(self.pulls)
        gathered = np.zeros((count + len(self.unknowns) + 1, *parts[0].shape[1:]))
        for part, rows, columns, size in zip(parts, self._rows, self._columns, self._sizes, strict=True):
            gathered[rows] = part[:size]
            gathered[count + columns] += part[size:-1]
            gathered[-1] += part[-1]
        return gathered

    def contracted(self, models: Sequence[LinearModel]) -> Floats:
        """Return the contracted numbers (M + L + 1,) of other models with the constants of this solution."""
        return self.gathered([model.contracted(held) for model, held in zip(models, self.held, strict=True)])

    def rounding_scales(self) -> tuple[Floats, npt.NDArray[np.intp]]:
        """Return the sizes (M + L + 1,) to which rounding errors of contracted numbers are relative, and their kinds.

        The kinds are 0 for the pulls, 1 for the sums over columns of the design, and 2 for that over all of it.
        """
        rows = np.full(len(self.pulls), max(1.0, float(np.abs(self.pulls).max(initial=0.0))))
        columns = np.linalg.norm(self.design, axis=0) * max(1.0, float(np.linalg.norm(self.pulls)))
        kinds = np.repeat([0, 1, 2], [len(rows), len(columns), 1])
        return np.concatenate([rows, columns, [1.0 + len(columns)]]), kinds

    def derivative(self, contracted: Floats) -> Floats:
        """Return the derivatives (M, P) of the pulls from those of the contracted numbers, (M + L + 1, P)."""
        if not self.unknowns:
            return contracted[:-1]
        curvature = None if self._is_linear else self._curvature
        return self.projection.derivative(contracted[: len(self.pulls)], contracted[len(self.pulls) : -1], curvature)


def padded(by: FunctionDerivatives) -> FunctionDerivatives:
    """Return derivatives of pulls as those of the contracted numbers of observations without linear unknowns.

    Their one sum, over an empty design, is zero.
    """

    def with_zero(values: Floats) -> Floats:
        return np.append(values.reshape(-1, values.shape[-1]), np.zeros((1, values.shape[-1])), axis=0)

    by_parameter = {name: with_zero(values[..., None])[:, 0] for name, values in by.by_parameter.items()}
    return FunctionDerivatives(by.value, with_zero(by.start), by_parameter)


def _joined(models: Sequence[LinearModel]) -> tuple[list[Any], tuple[LinearUnknown, ...]]:
    """Return the indices of each model's unknowns among those of all models, and the latter."""
    keys = [[(-1 if entry.shared else i, entry.name) for entry in model.unknowns] for i, model in enumerate(models)]
    entries = (entry for model in models for entry in model.unknowns)
    unknowns = dict(zip(itertools.chain(*keys), entries, strict=True))
    count = Counter(name for _, name in unknowns)
    named = tuple(
        entry if entry.shared or count[name] == 1 else entry._replace(name=f"{name} of observations[{i}]")
        for (i, name), entry in unknowns.items()
    )
    indices = {key: k for k, key in enumerate(unknowns)}
    return [np.array([indices[key] for key in of_model], dtype=np.intp) for of_model in keys], named


def _robust(pulls_at_zero: Floats, basis: Floats, coordinates: Floats, loss: Loss) -> Floats:
    """Return the coordinates (L,) in an orthonormal basis (M, L) at which a sum of losses has its minimum.

    A step is Newton's unless it raises the sum, and otherwise that of reweighted least squares, which never raises the
    sum of a loss that is concave in the squares. Where both raise it, the coordinates are the minimum up to rounding.
    """
    pulls = pulls_at_zero - basis @ coordinates
    cost = loss.total(pulls)
    for _ in range(_STEPS):
        slope, curvature = loss.influence(pulls)
        gradient = basis.T @ (slope * pulls)
        for weights in (curvature, slope):
            matrix = (weights[:, None] * basis).T @ basis
            if np.linalg.eigvalsh(matrix)[0] <= 0.0:
                continue
            step = np.linalg.solve(matrix, gradient)
            trial = pulls - basis @ step
            if (trial_cost := loss.total(trial)) <= cost:
                break
        else:
            return coordinates
        coordinates, pulls, cost = coordinates + step, trial, trial_cost
        if np.linalg.norm(step) <= _ABSOLUTE + _RELATIVE * np.linalg.norm(coordinates):
            return coordinates
    raise InvalidInput(f"the linear unknowns have no minimum of the loss {loss.argument!r} within {_STEPS} steps")


@dataclass
class EvaluatedPoint:
    """Predictions at ``values`` (P,) of the parameters.

    The ``run``, of the system and state in ``setup_result``, has samples at all times that the ``observations`` need.
    The ``models`` are the pulls of each of the observations as functions of the linear unknowns, of which ``inner`` is
    the solution. The ``errors``, by the index of the observations, are those that depend on parameters.
    """

    values: Floats
    setup_result: SetupResult
    run: Run
    observations: list[Any]
    models: list[LinearModel]
    inner: InnerSolution
    errors: dict[int, Any]

    @property
    def rows(self) -> Floats:
        """The pulls of all observations as one array (M,)."""
        return self.inner.pulls

    @property
    def pulls(self) -> list[Floats]:
        """The pulls of each of the observations, in its own shape (K, C)."""
        parts = zip(self.inner.split(self.rows), self.models, strict=True)
        return [part.reshape(model.pulls.shape) for part, model in parts]

    def linear_values(self, i: int) -> dict[str, Any]:
        """Return the linear unknowns of observations ``i`` by the names that these have for them."""
        pairs = zip(self.models[i].unknowns, self.inner.values_of(i).tolist(), strict=True)
        return {unknown.name: value if unknown.unit is None else value * unknown.unit for unknown, value in pairs}

    @property
    def log_determinant(self) -> float:
        """The sum of the logarithms of the determinants of the errors' covariance and of the information matrix of the
        linear unknowns, minus the same sum without a jitter. It is not negative but for rounding, which is cut off.
        """
        if not self.errors:
            return 0.0
        models = list(self.models)
        for i, errors in self.errors.items():
            models[i] = models[i]._replace(design=design_without_jitter(errors, models[i].design))
        without_jitter = InnerSolution(models, LINEAR).projection.log_determinant
        by_errors = sum(map(log_determinant, self.errors.values()))
        return max(0.0, by_errors + self.inner.projection.log_determinant - without_jitter)


@dataclass
class PullJacobian:
    """Derivatives of a point with respect to P parameters.

    Attributes
    ----------
    rows : ndarray, (M, P)
        Derivatives of the pulls for constant errors, while the linear unknowns follow as the solution.
    explicit : ndarray, (M, P)
        Derivatives of the pulls for constant linear unknowns.
    log_determinant : ndarray, (P,)
        Half the derivatives of the logarithm of the determinant of the information matrix of the linear unknowns.
    noise : dict of dict of ndarray, (K, C, C)
        The relative changes of the covariances of errors, by the index of the parameter and of the observations.
    differenced : dict of str
        The reasons why parameters were differenced, by their names.
    differenced_observations : dict of str
        The reasons why predictions were differenced with respect to the states, by ``"observations[i]"``.
    kinks : bool
        Whether parameters deform faces: where a face turns out of view, the derivatives of the light jump.
    """

    rows: Floats
    explicit: Floats
    log_determinant: Floats
    noise: dict[int, dict[int, Floats]]
    differenced: dict[str, str]
    differenced_observations: dict[str, str]
    kinks: bool
