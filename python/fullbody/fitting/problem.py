"""The residuals of a fit and their derivatives at given values of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.differences import REFUSALS, Differences
from ..errors import InvalidInput
from ..model.description import with_deformations
from ..observing.linear import Held
from ..record.derivatives import FunctionDerivatives
from ..record.record import Record, joined
from ..typing import Floats
from .free import Parameters
from .inputs import Entries, Setup, refuse_unused
from .losses import LINEAR, Loss
from .noise import relative_change
from .point import EvaluatedPoint, InnerSolution, PullJacobian, model_of, padded
from .setup_result import ROUNDING, SetupDerivatives, SetupDifferences, SetupResult

if TYPE_CHECKING:
    from ..motion.run import Run
    from ..record.integrators import Integrator


#: The rounding errors of the pulls between different runs, relative to the largest pull; and those of covariances.
_NOISE, _ROUNDING_OF_ERRORS = 1e-8, 1e-14


class Refused(Exception):
    """Values of parameters at which there is no prediction; the text gives the reason."""


class Problem:
    """The setup, the parameters and the observations of a fit.

    It counts the ``runs`` without and with derivatives, and the proposals that were ``refused``; ``reason`` is why the
    last of them was.
    """

    def __init__(
        self,
        setup: Callable[..., Any],
        parameters: Parameters,
        observations: Any,
        integrator: Integrator | None,
        loss: Loss = LINEAR,
    ) -> None:
        self.setup, self._entries = Setup(setup, parameters), Entries(observations, parameters)
        refuse_unused(parameters, self.setup, self._entries)
        self.parameters, self.integrator, self.loss = parameters, integrator, loss
        self._setup_differences = SetupDifferences(self.setup, self.setup.parameters)
        #: The parameters of the system by which the last runs were differentiated.
        self._needed: tuple[str, ...] | None = None
        self._differences = [Differences() for _ in parameters.names]
        #: The number of pulls, which parameters must not change.
        self._count: int | None = None
        self.runs = self.differentiated = self.refused = 0
        self.reason = ""
        #: The values that were refused last.
        self._refused = parameters.start

    def make(self, values: Floats) -> SetupResult:
        """Call the setup, and return its system and state."""
        return self.setup(values[self.setup.indices])

    def point(self, values: Floats, differentiated: bool = False) -> EvaluatedPoint:
        """Integrate a run and compute the predictions at values (P,).

        If it is to be ``differentiated``, the run includes the derivatives that the last Jacobian needed, so that
        :meth:`jacobian` needs no other run. :class:`Refused` is raised if the setup refuses the values, the run ends
        with an error, or a prediction is not finite.
        """
        try:
            return self._point(values, self._needed if differentiated else None)
        except REFUSALS as error:
            self.refused += 1
            self.reason, self._refused = f"{type(error).__name__}: {error}", values.copy()
            raise Refused(self.reason) from error

    def _point(self, values: Floats, derivatives: Sequence[str] | None = None) -> EvaluatedPoint:
        setup_result, observations = self.make(values), self._entries.at(values)
        run = self.run(setup_result, observations, derivatives)
        models = [model_of(observation, _part(run, observation)) for observation in observations]
        count = sum(model.pulls.size for model in models)
        if self._count is None:
            self._count = count
        if count != self._count:
            raise InvalidInput(
                f"the observations have {count} numbers here and had {self._count} at the start of the fit; expected "
                "the same number for all values of the parameters"
            )
        errors = {
            i: observation.errors(setup_result.system)
            for i, observation in enumerate(observations)
            if self._entries.arguments[i] and hasattr(observation, "errors")
        }
        return EvaluatedPoint(
            values.copy(), setup_result, run, observations, models, InnerSolution(models, self.loss), errors
        )

    def run(self, setup_result: SetupResult, observations: list[Any], derivatives: Sequence[str] | None = None) -> Run:
        """Run forward and backward from the epoch of the state over all observations, with samples at their times."""
        times = np.unique(np.concatenate([_emission(observation, setup_result.system) for observation in observations]))
        epoch, options = setup_result.core.time, dict[str, Any](integrator=self.integrator)
        if derivatives is None:
            self.runs += 1
        else:
            self.differentiated += 1
            options["derivatives"] = list(derivatives) or True
        following, previous = times[times >= epoch], times[times < epoch][::-1]
        integrate, state = setup_result.system.integrate, setup_result.state
        forward = integrate(state, following[-1] if following.size else epoch, output=following, **options)
        if not previous.size:
            return forward
        return joined(forward, integrate(state, previous[-1], output=previous, **options))

    def residuals(self, point: EvaluatedPoint) -> list[Any]:
        """Return the residuals of each of the observations, in their units, or their pulls if it has no others."""
        residuals = []
        for i, (observation, pulls) in enumerate(zip(point.observations, point.pulls, strict=True)):
            linear = (point.linear_values(i),) if hasattr(observation, "linear") else ()
            if linear or hasattr(observation, "residuals"):
                residuals.append(observation.residuals(_part(point.run, observation), *linear))
            else:
                residuals.append(pulls)
        return residuals

    def jacobian(self, point: EvaluatedPoint) -> PullJacobian:
        """Return the derivatives of a point: those of the motion are exact, those of the setup are differences."""
        names, inner = self.parameters.names, point.inner
        rows = np.zeros((len(point.rows) + len(inner.unknowns) + 1, len(names)))
        noise: dict[int, dict[int, Floats]] = {}
        differenced: dict[str, str] = {}
        observations: dict[str, str] = {}
        columns, kinks = self.setup.indices, False
        if columns:
            setup_derivatives = self._setup_differences.at(point.setup_result, point.values[columns])
            kinks = bool(setup_derivatives.deformations)
            differenced |= {
                name: f"it changes {path}, by which motions are not differentiated"
                for name, path in setup_derivatives.undifferentiable.items()
            }
            exact = [column for column, k in enumerate(columns) if names[k] not in differenced]
            if exact:
                try:
                    by_motion, observations = self._by_motion(point, setup_derivatives)
                    rows[:, np.array(columns)[exact]] = by_motion[:, exact]
                except InvalidInput as error:
                    differenced |= {names[columns[k]]: f"derivatives are refused: {error}" for k in exact}
        for k, name in enumerate(names):
            if name in differenced:
                rows[:, k] = self._by_runs(point, k)
            else:
                change, by_observations = self._by_observations(point, k)
                rows[:, k] += change
                if by_observations:
                    noise[k] = by_observations
        explicit = rows[: len(inner.pulls)]
        return PullJacobian(inner.derivative(rows), explicit, rows[-1], noise, differenced, observations, kinks)

    def _by_motion(self, point: EvaluatedPoint, setup_derivatives: SetupDerivatives) -> tuple[Floats, dict[str, str]]:
        """Return the derivatives (M + L + 1, P) of the contracted pulls by the parameters of the setup.

        The motion is differentiated exactly; beside them are the reasons why observations are not, by their index as
        text.
        """
        run, shared = point.run, [name for name in setup_derivatives.system if name in point.setup_result.parameters]
        # Coefficients by which only the equivalent system moves need a run of it.
        is_shared = len(shared) == len(setup_derivatives.system)
        self._needed = tuple(shared) if is_shared else None
        if not is_shared:
            run = self.run(setup_derivatives.equivalent, point.observations, tuple(setup_derivatives.system))
        elif not run.is_differentiated or not {*shared} <= {*run.sensitivity}:
            run = self.run(point.setup_result, point.observations, self._needed)
        if setup_derivatives.deformations:
            run = self._deforming(point.run, run, setup_derivatives, shared)
        parts = []
        differenced: dict[str, str] = {}
        for i, (observation, held) in enumerate(zip(point.observations, point.inner.held, strict=True)):
            by, reason = _derivatives(observation, held, _part(run, observation))
            if reason:
                differenced[f"observations[{i}]"] = reason
            part = by.start @ setup_derivatives.start
            for name in shared:
                part += np.outer(by.by_parameter[name], setup_derivatives.system[name])
            for name in setup_derivatives.deformations:
                part[:, self.setup.parameters.names.index(name)] += by.by_parameter[name]
            parts.append(part)
        return point.inner.gathered(parts), differenced

    def _deforming(self, run: Run, differentiated: Run, setup_derivatives: SetupDerivatives, shared: list[str]) -> Run:
        """Return a run with the derivatives of another one of the same motion, also with respect to deformations."""
        sensitivity = [differentiated.sensitivity[name] for name in shared]
        for name in setup_derivatives.deformations:
            k = self.setup.parameters.names.index(name)
            parts = (
                row[k] * differentiated.sensitivity[by]
                for by, row in setup_derivatives.system.items()
                if by not in shared
            )
            sensitivity.append(sum(parts, np.zeros((len(run), run.system.context.core.masses.size * 12))))
        arrays = {"transition": differentiated.transition, "sensitivity": np.stack(sensitivity, axis=1)}
        deforming = run._with({**run.arrays, **arrays})
        deforming.system = with_deformations(run.system, setup_derivatives.deformations)
        deforming.parameters = (*shared, *setup_derivatives.deformations)
        return deforming

    def _by_observations(self, point: EvaluatedPoint, k: int) -> tuple[Floats, dict[int, Floats]]:
        """Return the derivatives with respect to a parameter that observations take, of the same run.

        They are those of the contracted pulls (M + L + 1,), and the relative changes (K, C, C) of covariances by the
        index of the observations.
        """
        name, system = self.parameters.names[k], point.setup_result.system
        argument = self.parameters.argument_of[k]
        changing = [i for i, names in enumerate(self._entries.arguments) if argument in names]
        if not changing:
            return np.zeros(len(point.rows) + len(point.inner.unknowns) + 1), {}
        base = point.inner.contracted(point.models)

        def shifted(by: float) -> Floats:
            moved, models = self._entries.at(self.parameters.shifted(point.values, k, by)), list(point.models)
            parts = []
            for i in changing:
                observation, errors = moved[i], point.errors.get(i)
                observation = observation if errors is None else observation.with_errors_of(point.observations[i])
                models[i] = model_of(observation, _part(point.run, observation))
                if errors is not None:
                    shifted_errors = moved[i].errors(system)
                    parts.append(relative_change(errors.covariance, shifted_errors.covariance).ravel())
                    parts.append(relative_change(errors.without_jitter, shifted_errors.without_jitter).ravel())
            return np.concatenate([point.inner.contracted(models) - base, *parts])

        scale, kinds = point.inner.rounding_scales()
        sizes = [point.errors[i].covariance.size for i in changing if i in point.errors for _ in range(2)]
        noise = np.concatenate([ROUNDING * scale, np.full(sum(sizes), _ROUNDING_OF_ERRORS)])
        groups = np.concatenate([kinds, 3 + np.repeat(np.arange(len(sizes)), sizes)])
        derivative = self._derivative(shifted, point, k, noise, groups)
        parts = iter(np.split(derivative[len(base) :], np.cumsum(sizes)[:-1]))
        changes: dict[int, Floats] = {}
        for i in changing:
            if i in point.errors:
                change, stated = next(parts), next(parts)
                if stated.any():
                    raise InvalidInput(
                        f"the stated errors of {point.observations[i]!r} change with {name}, which has no part in the "
                        "likelihood; expected errors that with_jitter() widens"
                    )
                if change.any():
                    changes[i] = change.reshape(point.errors[i].covariance.shape)
        return derivative[: len(base)], changes

    def _by_runs(self, point: EvaluatedPoint, k: int) -> Floats:
        """Return derivatives (M + L + 1,) of the contracted pulls with respect to a parameter, from complete runs."""
        base = point.inner.contracted(point.models)

        def shifted(by: float) -> Floats:
            return point.inner.contracted(self._point(self.parameters.shifted(point.values, k, by)).models) - base

        scale, kinds = point.inner.rounding_scales()
        return self._derivative(shifted, point, k, _NOISE * scale, kinds)

    def _derivative(
        self,
        shifted: Callable[[float], Floats],
        point: EvaluatedPoint,
        k: int,
        noise: Floats,
        groups: npt.NDArray[np.intp],
    ) -> Floats:
        at = f"{self.parameters.names[k]} near {point.values[k]:.9g}"
        size = self.parameters.size(k, point.values[k])
        try:
            derivative = self._differences[k].derivative(shifted, size, noise, groups, 0.1 * max(size, 1.0))
        except InvalidInput as error:
            raise InvalidInput(f"the predictions cannot be differentiated with respect to {at}: {error}") from error
        if derivative is None:
            raise InvalidInput(f"the predictions do not change evenly with {at}")
        return derivative

    def step_lengths(self, values: Floats) -> Floats:
        """Return the lengths (P,) over which parameters may change in the first step.

        A value is as good as zero if nothing changed over steps of its size in the last derivatives.
        """
        sizes = np.array([self.parameters.size(k, value) for k, value in enumerate(values)])
        steps = np.array([differences.length for differences in self._differences])
        for k, differences in zip(self.setup.indices, self._setup_differences.differences, strict=True):
            steps[k] = max(steps[k], differences.length)
        widths = np.array([self.parameters.width(k) for k in range(len(values))])
        return np.where(steps > 2e-3 * sizes, widths, sizes)

    def unchanged(self, values: Floats, shifted: Floats) -> bool:
        """Return whether the setup returns the same system and state for two values (P,), up to rounding errors."""
        try:
            setup_result, other = self.make(values), self.make(shifted)
        except REFUSALS:
            return False
        changes, unexplained = setup_result.changes(other)
        if unexplained is not None:
            return False
        difference = np.append(setup_result.displacement(other), changes)
        sizes = np.append(setup_result.sizes(), np.abs(list(setup_result.parameters.values())))
        return bool((np.abs(difference) <= 1e-9 * sizes).all())

    def limits(self, values: Floats) -> str:
        """Return, as text, the bounds that would exclude the values refused last from a fit at values (P,)."""
        sides = []
        for k, (name, refused) in enumerate(zip(self.parameters.names, self._refused, strict=True)):
            moved = values.copy()
            moved[k] = refused
            try:
                self.make(moved)
            except REFUSALS:
                sides.append(f"{'min' if refused < values[k] else 'max'} of {name}")
        return f"; give Free the bound {' or '.join(sides)}" if sides else ""


def _emission(observation: Any, system: Any) -> Floats:
    """Return the times at which observations need samples, in numbers of the system's units."""
    return system.context.units.strip(observation.emission(system), "time", f"times of {observation!r}")


def _part(run: Record, observation: Any) -> Any:
    """Return the samples of a run at the times of observations, several rows of which may share a time."""
    return run[np.unique(run.indices(_emission(observation, run.system)))]


def _derivatives(observation: Any, held: Held, part: Any) -> tuple[FunctionDerivatives, str]:
    """Return the derivatives of the contracted numbers of observations, and the reason if they are differences."""
    reason = "the observations have no derivatives of their own"
    for name, *arguments in (("linear_derivatives", held), ("derivatives",)):
        if hasattr(observation, name):
            try:
                by = getattr(observation, name)(part, *arguments)
            except InvalidInput as error:
                reason = str(error)
                break
            return (by if arguments else padded(by)), ""
    return part.derivative_of(lambda run: model_of(observation, run).contracted(held)), reason
