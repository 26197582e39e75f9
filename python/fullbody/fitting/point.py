"""The pulls of a fit at values of its parameters, and their derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..observing.linear import LinearModel
from ..typing import Floats
from .inner import InnerSolution
from .losses import LINEAR
from .noise import design_without_jitter, log_determinant
from .setup_result import SetupResult

if TYPE_CHECKING:
    from ..motion.run import Run


@dataclass
class EvaluatedPoint:
    """Predictions at ``values`` (P,) of the parameters.

    The ``run``, of the system and state ``made`` by the setup, has samples at all times that the ``observations`` need.
    Their pulls are ``models`` of their linear unknowns, for which ``inner`` is the solution, and ``errors`` are those
    of the observations whose errors depend on parameters, by their index.
    """

    values: Floats
    made: SetupResult
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
        """The pulls of each of the observations, (K, C)."""
        parts = zip(self.inner.split(self.rows), self.models, strict=True)
        return [part.reshape(model.pulls.shape) for part, model in parts]

    def linear_values(self, i: int) -> dict[str, Any]:
        """Return the linear unknowns of one of the observations by the names that it has for them."""
        pairs = zip(self.models[i].unknowns, self.inner.values_of(i).tolist(), strict=True)
        return {unknown.name: value if unknown.unit is None else value * unknown.unit for unknown, value in pairs}

    @property
    def log_determinant(self) -> float:
        """The sum of the logarithms of the determinants of the errors' covariance and of the information about linear
        unknowns, minus the same sum without a jitter.
        """
        if not self.errors:
            return 0.0
        models = list(self.models)
        for i, errors in self.errors.items():
            model = models[i]
            models[i] = LinearModel(model.unknowns, model.pulls, design_without_jitter(errors, model.design))
        without_jitter = InnerSolution(models, LINEAR).projection.log_determinant
        by_errors = sum(map(log_determinant, self.errors.values()))
        return max(0.0, by_errors + self.inner.projection.log_determinant - without_jitter)


@dataclass
class PullJacobian:
    """Derivatives of a point with respect to P parameters.

    Attributes
    ----------
    rows : ndarray, (M, P)
        Derivatives of the pulls for constant errors, where the linear unknowns are solved for again.
    explicit : ndarray, (M, P)
        Derivatives of the pulls for constant linear unknowns.
    log_determinant : ndarray, (P,)
        Half the derivatives of the logarithm of the determinant of the information about linear unknowns.
    noise : dict of dict of ndarray, (K, C, C)
        The relative changes of the covariances of errors, by the index of the parameter and of the observations.
    differenced : dict of str
        The reasons why parameters were differenced, by their names.
    differenced_observations : dict of str
        The reasons why predictions were differenced with respect to the states, by ``"observations[i]"``.
    kinks : bool
        Whether faces are deformed by parameters: where one of them turns away, the derivatives of their light jump.
    """

    rows: Floats
    explicit: Floats
    log_determinant: Floats
    noise: dict[int, dict[int, Floats]]
    differenced: dict[str, str]
    differenced_observations: dict[str, str]
    kinks: bool
