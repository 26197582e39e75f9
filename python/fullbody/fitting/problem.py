"""The residuals of a fit and their derivatives at given values of its parameters."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from ..base.arguments import suggestion
from ..errors import InvalidInput
from ..model.state import State
from ..motion.samples import chosen, joined
from ..motion.system import System
from .chain import Chain, SetupResult
from .differences import REFUSALS, derivative
from .free import Parameters

if TYPE_CHECKING:
    from ..motion.run import Run
    from ..record.integrators import Integrator

__all__ = ["Jacobian", "Observed", "Point", "Problem", "Refused"]

_Array = npt.NDArray[np.float64]

#: The rounding errors of the pulls of one run, and between different runs, relative to the largest pull.
_ROUNDING, _NOISE = 1e-13, 1e-8


class Observed(Protocol):
    """The methods that a fit calls on observations; any class that has them can be fitted.
    A class may also have the method ``derivatives(run)``, with the result of ``run.derivative_of(observed.pulls)``, and
    ``widening(system)``, which returns the logarithms of the factors by which parameters widen the variances.
    """

    def emission(self, system: System) -> Any:
        """Return the times (K,) of a system's clock at which the predictions need samples, in their order."""

    def pulls(self, run: Run) -> _Array:
        """Return the residuals of a run with samples at these times, made independent and divided by their errors."""


class Refused(Exception):
    """Values of parameters at which there is no prediction; the text gives the reason."""


@dataclass
class Point:
    """Predictions at values (P,) of the parameters.

    Attributes
    ----------
    values : ndarray, (P,)
    made : SetupResult
    run : Run
        The samples at all times that the observations need.
    observations : list of Observed
    pulls : list of ndarray
        The pulls of each of the observations.
    widening : list of ndarray
        Roots of the logarithms of the factors by which jitter widens variances, if observations are functions.
    """

    values: _Array
    made: SetupResult
    run: Run
    observations: list[Any]
    pulls: list[_Array]
    widening: list[_Array]

    @property
    def rows(self) -> _Array:
        """Return all pulls and widenings as one array."""
        return np.concatenate([np.ravel(part) for part in (*self.pulls, *self.widening)])


@dataclass
class Jacobian:
    """Derivatives of the rows of a point with respect to the parameters, (M, P), and the parameters that were
    differenced.
    """

    rows: _Array
    differenced: dict[str, str] = field(default_factory=dict)


class Problem:
    """The setup, the parameters and the observations of a fit.

    Attributes
    ----------
    runs, differentiated : int
        The number of runs without and with derivatives.
    refused : int
        The number of proposals that were refused; ``reason`` is why the last of them was.
    """

    def __init__(
        self, setup: Callable[..., Any], parameters: Parameters, observations: Any, integrator: Integrator | None
    ) -> None:
        if not callable(setup):
            raise InvalidInput(f"setup is {setup!r}; expected a function")
        given = [observations] if hasattr(observations, "pulls") or callable(observations) else observations
        try:
            entries = iter(given)
        except TypeError:
            entries = iter(())
        if not (listed := list(entries)):
            raise InvalidInput(f"observations is {observations!r}; expected observations, or a list of them")
        for one in listed:
            if not callable(one) and not _is_observed(one):
                raise InvalidInput(
                    f"observations has {one!r}; expected those of fullbody.observing, or a function of parameters that "
                    "returns some"
                )
        self.setup, self.parameters, self.integrator = setup, parameters, integrator
        self.given = listed
        names = parameters.names
        self.of_setup = _taken(setup, names)
        #: The parameters of each of those observations that are functions.
        self.of_observations = [_taken(one, names) if callable(one) else () for one in listed]
        used = {*self.of_setup, *(name for taken in self.of_observations for name in taken)}
        if unused := [name for name in names if name not in used]:
            arguments = sorted(name for name, one in _arguments(setup).items() if one.kind is not one.VAR_POSITIONAL)
            raise InvalidInput(
                f"parameters has {unused[0]!r}, which neither the setup nor observations take; "
                f"{suggestion(unused[0], arguments, 'some')}"
            )
        own = parameters.only(self.of_setup)
        self._chain = Chain(lambda values: self._make(own.named(values)), self.of_setup)
        #: The parameters of the system by which the last runs were differentiated.
        self._needed: tuple[str, ...] | None = None
        self._steps: list[dict[str, float]] = [{} for _ in names]
        #: The number of pulls, which parameters must not change.
        self._count: int | None = None
        self.runs = self.differentiated = self.refused = 0
        self.reason = ""

    def make(self, values: _Array) -> SetupResult:
        """Call the setup, and return its system and state."""
        return self._make(self.parameters.named(values))

    def _make(self, named: dict[str, Any]) -> SetupResult:
        found = self.setup(**{name: named[name] for name in self.of_setup})
        try:
            system, state = found
        except (TypeError, ValueError) as error:
            raise TypeError(f"setup returned {found!r}; expected (system, state)") from error
        if not isinstance(system, System) or not isinstance(state, State):
            raise TypeError(f"setup returned {found!r}; expected (system, state)")
        return SetupResult(system, state)

    def observations(self, values: _Array) -> list[Any]:
        """Return the observations; those that are functions are called with these values of their parameters."""
        named = self.parameters.named(values)
        both = zip(self.given, self.of_observations, strict=True)
        found = [one(**{name: named[name] for name in names}) if callable(one) else one for one, names in both]
        for one, given in zip(found, self.given, strict=True):
            if not _is_observed(one):
                raise TypeError(f"{given!r} of observations returned {one!r}; expected those of fullbody.observing")
        return found

    def point(self, values: _Array, differentiated: bool = False) -> Point:
        """Integrate a run and compute the predictions.

        Parameters
        ----------
        values : ndarray, (P,)
        differentiated : bool
            Whether the run includes the derivatives that the last Jacobian needed, so that :meth:`jacobian` needs no
            other run.

        Raises
        ------
        Refused
            If the setup refuses the values, the run ends with an error, or a prediction is not finite.
        """
        try:
            return self._point(values, self._needed if differentiated else None)
        except REFUSALS as error:
            self.refused += 1
            self.reason = f"{type(error).__name__}: {error}"
            raise Refused(self.reason) from error

    def _point(self, values: _Array, derivatives: Sequence[str] | None = None) -> Point:
        made = self.make(values)
        observations = self.observations(values)
        run = self._run(made, observations, derivatives)
        pulls = [_finite(self.of(one, run, "pulls"), one) for one in observations]
        count = sum(part.size for part in pulls)
        if self._count is None:
            self._count = count
        if count != self._count:
            raise InvalidInput(
                f"the observations have {count} numbers here and had {self._count} at the start of the fit; expected "
                "the same number for all values of the parameters"
            )
        return Point(values.copy(), made, run, observations, pulls, self._widening(made.system, observations))

    def _widening(self, system: System, observations: list[Any]) -> list[_Array]:
        both = zip(self.given, observations, strict=True)
        return [np.sqrt(one.widening(system)) for given, one in both if callable(given) and hasattr(one, "widening")]

    def times(self, made: SetupResult, observations: list[Any]) -> _Array:
        """Return all times at which the observations need samples, in numbers of the system's units."""
        parts = [self._emission(one, made.system) for one in observations]
        return np.unique(np.concatenate(parts))

    def _emission(self, one: Any, system: System) -> _Array:
        return system._units.strip(one.emission(system), "time", f"times of {one!r}")

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
            return integrate(state, later[-1] if later.size else epoch, later, **options)
        back = integrate(state, earlier[-1], earlier, **options)
        ahead = integrate(state, later[-1] if later.size else epoch, later, **options)
        return joined(ahead, back)

    def of(self, one: Any, run: Run, what: str) -> Any:
        """Call a method of observations with the samples of a run at the times of these observations."""
        return getattr(one, what)(chosen(run, self._emission(one, run.system)))

    def jacobian(self, point: Point) -> Jacobian:
        """Return the derivatives of the rows of a point: the motion's are exact, those of the setup are differences."""
        values, names = point.values, self.parameters.names
        sizes = np.array([self.parameters.size(k, value) for k, value in enumerate(values)])
        found = np.zeros((len(point.rows), len(values)))
        mine = [k for k, name in enumerate(names) if name in self.of_setup]
        differenced: dict[str, str] = {}
        if mine:
            made = self._chain.at(point.made, values[mine], sizes[mine])
            differenced |= {
                name: f"it changes {place}, by which motions are not differentiated"
                for name, place in made.undifferentiable.items()
            }
            exact = [(column, k) for column, k in enumerate(mine) if names[k] not in differenced]
            if exact:
                try:
                    self._needed, run = tuple(made.system), point.run
                    if not run.is_differentiated or not {*self._needed} <= {*run.sensitivity}:
                        run = self._run(point.made, point.observations, self._needed)
                    start = 0
                    for one in point.observations:
                        by = self._derivatives(one, run)
                        size = by.value.size
                        for column, k in exact:
                            part = by.start.reshape(size, -1) @ made.start[:, column]
                            for name, changes in made.system.items():
                                part = part + changes[column] * np.reshape(by.by_parameter[name], size)
                            found[start : start + size, k] = part
                        start += size
                except InvalidInput as error:
                    differenced |= {names[k]: f"derivatives are refused: {error}" for _, k in exact}
        for k, name in enumerate(names):
            if name in differenced:
                found[:, k] = self._by_runs(point, k, sizes[k])
            else:
                found[:, k] += self._by_observations(point, k, sizes[k])
        return Jacobian(found, differenced)

    def _derivatives(self, one: Any, run: Run) -> Any:
        part = chosen(run, self._emission(one, run.system))
        if hasattr(one, "derivatives"):
            try:
                return one.derivatives(part)
            except InvalidInput:
                # This is so for the light of polyhedra, which is not differentiated.
                pass
        return part.derivative_of(one.pulls)

    def _by_observations(self, point: Point, k: int, size: float) -> _Array:
        """Return derivatives (M,) of rows with respect to a parameter that observations take, with the same run."""
        if all(self.parameters.names[k] not in taken for taken in self.of_observations):
            return np.zeros(len(point.rows))

        def shifted(by: float) -> _Array:
            values = point.values.copy()
            values[k] += by
            observations = self.observations(values)
            pulls = [_finite(self.of(one, point.run, "pulls"), one) for one in observations]
            widening = self._widening(point.made.system, observations)
            return np.concatenate([np.ravel(part) for part in (*pulls, *widening)]) - point.rows

        return self._derivative(shifted, point, k, size, _ROUNDING, 0.01)

    def _by_runs(self, point: Point, k: int, size: float) -> _Array:
        """Return derivatives (M,) of rows with respect to a parameter, from complete runs."""

        def shifted(by: float) -> _Array:
            values = point.values.copy()
            values[k] += by
            return self._point(values).rows - point.rows

        return self._derivative(shifted, point, k, size, _NOISE, 0.1)

    def _derivative(
        self, shifted: Callable[[float], _Array], point: Point, k: int, size: float, noise: float, shorter: float
    ) -> _Array:
        """Return differences of the rows; ``noise`` is their rounding error."""
        scale = noise * max(1.0, float(np.abs(point.rows).max(initial=0.0))) * np.ones(len(point.rows))
        where = f"{self.parameters.names[k]} near {point.values[k]:.9g}"
        try:
            found = derivative(shifted, size, scale, np.zeros(len(scale), dtype=int), self._steps[k], shorter)
        except InvalidInput as error:
            raise InvalidInput(f"the predictions cannot be differentiated with respect to {where}: {error}") from error
        if found is None:
            raise InvalidInput(f"the predictions do not change evenly with {where}")
        return found


def _is_observed(one: Any) -> bool:
    return hasattr(one, "pulls") and hasattr(one, "emission")


def _finite(pulls: Any, one: Any) -> _Array:
    found = np.asarray(pulls, dtype=np.float64)
    if not np.isfinite(found).all():
        raise InvalidInput(f"{one!r} has predictions that are not finite")
    return found


def _arguments(function: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError) as error:
        raise InvalidInput(
            f"{function!r} has arguments that Python cannot list; expected a function of Python"
        ) from error


def _taken(function: Callable[..., Any], names: Sequence[str]) -> tuple[str, ...]:
    """Return the parameters that a function takes, after checking that it needs no others."""
    arguments = _arguments(function)
    if any(one.kind is one.VAR_KEYWORD for one in arguments.values()):
        return tuple(names)
    for name, one in arguments.items():
        if one.kind is one.POSITIONAL_ONLY:
            raise InvalidInput(f"{function!r} takes {name} by its place alone; expected arguments that have names")
        if one.default is one.empty and one.kind is not one.VAR_POSITIONAL and name not in names:
            raise InvalidInput(f"parameters has no {name!r}, which {function!r} needs; it has {', '.join(names)}")
    return tuple(
        name for name in names if name in arguments and arguments[name].kind is not inspect.Parameter.VAR_POSITIONAL
    )
