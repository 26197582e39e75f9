"""The residuals of a fit and their derivatives at given values of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from ..base.arguments import suggestion
from ..base.differences import REFUSALS, Differences
from ..base.kinds import function
from ..errors import InvalidInput, WarnedOnce
from ..model.description import with_deformations
from ..model.state import State
from ..motion.system import System
from ..observing.linear import Held, LinearModel
from ..record.derivatives import FunctionDerivatives
from ..record.record import Record, joined
from ..typing import Floats
from .chain import Chain, SetupDerivatives, SetupResult
from .free import Parameters
from .inner import InnerSolution, model_of, padded
from .losses import LINEAR, Loss
from .noise import relative_change
from .point import EvaluatedPoint, PullJacobian
from .signature import arguments_of, parameters_taken

if TYPE_CHECKING:
    from ..motion.run import Run
    from ..record.integrators import Integrator


#: The rounding errors of the pulls of one run, and between different runs, relative to the largest pull; and those of
#: covariances.
_ROUNDING, _NOISE, _ROUNDING_OF_ERRORS = 1e-13, 1e-8, 1e-14


class Observed(Protocol):
    """The methods that a fit calls on observations; any class that has them can be fitted.
    A class may also have the method ``derivatives(run)``, with the result of ``run.derivative_of(observed.pulls)``, the
    methods ``linear(run)`` and ``linear_derivatives(run, held)``, which give the pulls as a function of unknowns that
    are solved for, and the methods ``errors(system)`` and ``with_errors_of(observed)``, by which a fit takes parameters
    of errors into account.
    """

    def emission(self, system: System) -> Any:
        """Return the times (K,) of a system's clock at which the predictions need samples, in their order."""

    def pulls(self, run: Record) -> Floats:
        """Return the residuals of a run with samples at these times, made independent and divided by their errors."""


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
        function(setup, "setup")
        entry = [observations] if hasattr(observations, "pulls") or callable(observations) else observations
        try:
            entries = iter(entry)
        except TypeError:
            entries = iter(())
        if not (listed := list(entries)):
            raise InvalidInput(f"observations is {observations!r}; expected observations, or a list of them")
        for observation in listed:
            if not callable(observation) and not _is_observed(observation):
                raise InvalidInput(
                    f"observations has {observation!r}; expected those of fullbody.observing, or a "
                    "function of parameters that returns some"
                )
        #: The setup shows each of its warnings once, in the fit and in what is computed from it later.
        self.setup = setup if isinstance(setup, WarnedOnce) else WarnedOnce(setup)
        self.parameters, self.integrator, self.loss = parameters, integrator, loss
        self.entries = listed
        names = parameters.arguments
        #: The arguments of the setup.
        self.of_setup = parameters_taken(setup, names)
        #: The arguments of each of those observations that are functions.
        self.of_observations = [parameters_taken(item, names) if callable(item) else () for item in listed]
        used = {*self.of_setup, *(name for names_taken in self.of_observations for name in names_taken)}
        if unused := [name for name in names if name not in used]:
            arguments = sorted(
                name for name, item in arguments_of(setup).items() if item.kind is not item.VAR_POSITIONAL
            )
            raise InvalidInput(
                f"parameters has {unused[0]!r}, which neither the setup nor observations take; "
                f"{suggestion(unused[0], arguments, 'some')}"
            )
        self._setup_parameters = parameters.only(self.of_setup)
        #: The indices of the parameters of the setup.
        self.places = parameters.places(self.of_setup)
        self._chain = Chain(self._make, self._setup_parameters)
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
        return self._make(values[self.places])

    def _make(self, values: Floats) -> SetupResult:
        made = self.setup(**self._setup_parameters.named(values))
        try:
            system, state = made
        except (TypeError, ValueError) as error:
            raise TypeError(f"setup returned {made!r}; expected (system, state)") from error
        if not isinstance(system, System) or not isinstance(state, State):
            raise TypeError(f"setup returned {made!r}; expected (system, state)")
        return SetupResult(system, state)

    def observations(self, values: Floats) -> list[Any]:
        """Return the observations; those that are functions are called with these values of their parameters."""
        named = self.parameters.named(values)
        both = zip(self.entries, self.of_observations, strict=True)
        made = [item(**{name: named[name] for name in names}) if callable(item) else item for item, names in both]
        for observation, entry in zip(made, self.entries, strict=True):
            if not _is_observed(observation):
                raise TypeError(
                    f"{entry!r} of observations returned {observation!r}; expected those of fullbody.observing"
                )
        return made

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
        made = self.make(values)
        observations = self.observations(values)
        run = self._run(made, observations, derivatives)
        models = self._models(run, observations)
        count = sum(model.pulls.size for model in models)
        if self._count is None:
            self._count = count
        if count != self._count:
            raise InvalidInput(
                f"the observations have {count} numbers here and had {self._count} at the start of the fit; expected "
                "the same number for all values of the parameters"
            )
        errors = {
            i: observation.errors(made.system)
            for i, observation in enumerate(observations)
            if self.of_observations[i] and hasattr(observation, "errors")
        }
        return EvaluatedPoint(values.copy(), made, run, observations, models, InnerSolution(models, self.loss), errors)

    def _models(self, run: Run, observations: list[Any]) -> list[LinearModel]:
        return [model_of(observation, self._part(run, observation)) for observation in observations]

    def times(self, made: SetupResult, observations: list[Any]) -> Floats:
        """Return all times at which the observations need samples, in numbers of the system's units."""
        parts = [self._emission(observation, made.system) for observation in observations]
        return np.unique(np.concatenate(parts))

    def _emission(self, observation: Any, system: System) -> Floats:
        return system.context.units.strip(observation.emission(system), "time", f"times of {observation!r}")

    def _run(self, made: SetupResult, observations: list[Any], derivatives: Sequence[str] | None) -> Run:
        """Run forward and backward from the epoch of the state over all observations, with samples at their times."""
        times, epoch = self.times(made, observations), made.core.time
        options: dict[str, Any] = {"integrator": self.integrator}
        if derivatives is None:
            self.runs += 1
        else:
            self.differentiated += 1
            options["derivatives"] = list(derivatives) or True
        later, earlier = times[times >= epoch], times[times < epoch][::-1]
        integrate, state = made.system.integrate, made.state
        if not earlier.size:
            return integrate(state, later[-1] if later.size else epoch, output=later, **options)
        back = integrate(state, earlier[-1], output=earlier, **options)
        ahead = integrate(state, later[-1] if later.size else epoch, output=later, **options)
        return joined(ahead, back)

    def sampled(self, made: SetupResult, observations: list[Any]) -> Run:
        """Return a run with samples at the times of observations."""
        return self._run(made, observations, None)

    def residuals(self, point: EvaluatedPoint) -> list[Any]:
        """Return the residuals of each of the observations, in their units, or their pulls if it has no others."""
        found = []
        for i, (observation, pulls) in enumerate(zip(point.observations, point.pulls, strict=True)):
            if hasattr(observation, "linear"):
                linear = self.linear_values(point, i)
                found.append(observation.residuals(self._part(point.run, observation), linear))
            elif hasattr(observation, "residuals"):
                found.append(observation.residuals(self._part(point.run, observation)))
            else:
                found.append(pulls)
        return found

    def linear_values(self, point: EvaluatedPoint, i: int) -> dict[str, Any]:
        """Return the linear unknowns of one of the observations by the names that it has for them."""
        both = zip(point.models[i].unknowns, point.inner.values_of(i).tolist(), strict=True)
        return {one.name: value if one.unit is None else value * one.unit for one, value in both}

    def _part(self, run: Record, observation: Any) -> Any:
        """Return the samples of a run at the times of observations."""
        # Several rows may have one time.
        return run[np.unique(run.indices(self._emission(observation, run.system)))]

    def jacobian(self, point: EvaluatedPoint) -> PullJacobian:
        """Return the derivatives of a point: those of the motion are exact, those of the setup are differences."""
        names = self.parameters.names
        rows = np.zeros((len(point.rows) + len(point.inner.unknowns) + 1, len(names)))
        noise: dict[int, dict[int, Floats]] = {}
        differenced: dict[str, str] = {}
        columns, kinks = self.places, False
        if columns:
            made = self._chain.at(point.made, point.values[columns])
            kinks = bool(made.deformations)
            differenced |= {
                name: f"it changes {path}, by which motions are not differentiated"
                for name, path in made.undifferentiable.items()
            }
            exact = [column for column, k in enumerate(columns) if names[k] not in differenced]
            if exact:
                try:
                    rows[:, np.array(columns)[exact]] = self._by_motion(point, made)[:, exact]
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
        inner = point.inner
        return PullJacobian(inner.derivative(rows), rows[: len(inner.pulls)], rows[-1], noise, differenced, kinks)

    def _by_motion(self, point: EvaluatedPoint, made: SetupDerivatives) -> Floats:
        """Return the exact derivatives (M + L + 1, P) of the contracted pulls by the parameters of the setup."""
        run, own = point.run, [name for name in made.system if name in point.made.parameters]
        # Coefficients by which only the equivalent system moves need a run of it.
        is_own = len(own) == len(made.system)
        self._needed = tuple(own) if is_own else None
        if not is_own:
            run = self._run(made.equivalent, point.observations, tuple(made.system))
        elif not run.is_differentiated or not {*own} <= {*run.sensitivity}:
            run = self._run(point.made, point.observations, self._needed)
        run = self._deforming(point.run, run, made, own)
        parts = []
        for observation, held in zip(point.observations, point.inner.held, strict=True):
            by = self._derivatives(observation, held, run)
            part = by.start @ made.start
            for name in own:
                part += np.outer(by.by_parameter[name], made.system[name])
            for name in made.deformations:
                part[:, self._setup_parameters.names.index(name)] += by.by_parameter[name]
            parts.append(part)
        return point.inner.gathered(parts)

    def _deforming(self, run: Run, differentiated: Run, made: SetupDerivatives, own: list[str]) -> Run:
        """Return a run with the derivatives of another one of the same motion, also with respect to deformations."""
        if not made.deformations:
            return differentiated
        sensitivity = [differentiated.sensitivity[name] for name in own]
        for name in made.deformations:
            k = self._setup_parameters.names.index(name)
            parts = (row[k] * differentiated.sensitivity[what] for what, row in made.system.items() if what not in own)
            sensitivity.append(sum(parts, np.zeros((len(run), run.system.context.core.masses.size * 12))))
        arrays = {"transition": differentiated.transition, "sensitivity": np.stack(sensitivity, axis=1)}
        found = run._with({**run.arrays, **arrays})
        found.system = with_deformations(run.system, made.deformations)
        found.parameters = (*own, *made.deformations)
        return found

    def _derivatives(self, observation: Any, held: Held, run: Run) -> FunctionDerivatives:
        """Return the derivatives of what the model of observations contracts."""
        part = self._part(run, observation)
        for name, *arguments in (("linear_derivatives", held), ("derivatives",)):
            if hasattr(observation, name):
                try:
                    by = getattr(observation, name)(part, *arguments)
                except InvalidInput:
                    # This is so for the light of polyhedra, which is not differentiated.
                    break
                if arguments:
                    return by
                return padded(by)
        return part.derivative_of(lambda run: model_of(observation, run).contracted(held))

    def _by_observations(self, point: EvaluatedPoint, k: int) -> tuple[Floats, dict[int, Floats]]:
        """Return the derivatives with respect to a parameter that observations take, of the same run.

        They are those of the contracted pulls (M + L + 1,), and the relative changes (K, C, C) of covariances by the
        index of the observations.
        """
        name, system = self.parameters.names[k], point.made.system
        changing = [i for i, names in enumerate(self.of_observations) if self.parameters.argument_of[k] in names]
        if not changing:
            return np.zeros(len(point.rows) + len(point.inner.unknowns) + 1), {}
        base = point.inner.contracted(point.models)

        def shifted(by: float) -> Floats:
            moved, models = self.observations(self.parameters.shifted(point.values, k, by)), list(point.models)
            parts = []
            for i in changing:
                observation, errors = moved[i], point.errors.get(i)
                observation = observation if errors is None else observation.with_errors_of(point.observations[i])
                models[i] = model_of(observation, self._part(point.run, observation))
                if errors is not None:
                    now = moved[i].errors(system)
                    parts.append(relative_change(errors.covariance, now.covariance).ravel())
                    parts.append(relative_change(errors.without_jitter, now.without_jitter).ravel())
            return np.concatenate([point.inner.contracted(models) - base, *parts])

        scale, kinds = point.inner.sizes()
        sizes = [point.errors[i].covariance.size for i in changing if i in point.errors for _ in range(2)]
        noise = np.concatenate([_ROUNDING * scale, np.full(sum(sizes), _ROUNDING_OF_ERRORS)])
        groups = np.concatenate([kinds, 3 + np.repeat(np.arange(len(sizes)), sizes)])
        found = self._derivative(shifted, point, k, noise, groups)
        parts = iter(np.split(found[len(base) :], np.cumsum(sizes)[:-1]))
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
        return found[: len(base)], changes

    def _by_runs(self, point: EvaluatedPoint, k: int) -> Floats:
        """Return derivatives (M + L + 1,) of the contracted pulls with respect to a parameter, from complete runs."""
        base = point.inner.contracted(point.models)

        def shifted(by: float) -> Floats:
            return point.inner.contracted(self._point(self.parameters.shifted(point.values, k, by)).models) - base

        scale, kinds = point.inner.sizes()
        return self._derivative(shifted, point, k, _NOISE * scale, kinds)

    def _derivative(
        self,
        shifted: Callable[[float], Floats],
        point: EvaluatedPoint,
        k: int,
        noise: Floats,
        groups: npt.NDArray[np.intp],
    ) -> Floats:
        where = f"{self.parameters.names[k]} near {point.values[k]:.9g}"
        size = self.parameters.size(k, point.values[k])
        try:
            made = self._differences[k].derivative(shifted, size, noise, groups, 0.1 * max(size, 1.0))
        except InvalidInput as error:
            raise InvalidInput(f"the predictions cannot be differentiated with respect to {where}: {error}") from error
        if made is None:
            raise InvalidInput(f"the predictions do not change evenly with {where}")
        return made

    def reach(self, values: Floats) -> Floats:
        """Return the lengths (P,) over which parameters may change at first.

        A value is as good as zero if nothing changed over steps of its size in the last derivatives.
        """
        reach = np.array([self.parameters.size(k, value) for k, value in enumerate(values)])
        steps = np.array([differences.length for differences in self._differences])
        for k, differences in zip(self.places, self._chain.differences, strict=True):
            steps[k] = max(steps[k], differences.length)
        widths = np.array([self.parameters.width(k) for k in range(len(values))])
        return np.where(steps > 2e-3 * reach, widths, reach)

    def unchanged(self, values: Floats, others: Floats) -> bool:
        """Return whether the setup returns the same system and state for two values (P,), up to rounding errors."""
        try:
            observation, other = self.make(values), self.make(others)
        except REFUSALS:
            return False
        changes, unexplained = observation.changes(other)
        if unexplained is not None:
            return False
        apart = np.append(observation.moved(other), changes)
        sizes = np.append(observation.sizes(), np.abs(list(observation.parameters.values())))
        return bool((np.abs(apart) <= 1e-9 * sizes).all())

    def limits(self, values: Floats) -> str:
        """Return the bounds, as text, that would keep a fit at values (P,) from those that were refused last."""
        sides = []
        for k, (name, refused) in enumerate(zip(self.parameters.names, self._refused, strict=True)):
            moved = values.copy()
            moved[k] = refused
            try:
                self.make(moved)
            except REFUSALS:
                sides.append(f"{'min' if refused < values[k] else 'max'} of {name}")
        return f"; give Free the bound {' or '.join(sides)}" if sides else ""


def _is_observed(observation: Any) -> bool:
    return hasattr(observation, "pulls") and hasattr(observation, "emission")
