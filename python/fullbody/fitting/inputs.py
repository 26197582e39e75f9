"""The setup and the observations of a fit as functions of its parameters."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from ..base.arguments import suggestion
from ..base.kinds import function
from ..errors import InvalidInput, WarnedOnce
from ..model.state import State
from ..motion.system import System
from ..record.record import Record
from ..typing import Floats
from .free import Parameters
from .setup_result import SetupResult


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


class Setup:
    """A function that returns a system and a state, with those parameters of a fit that it takes.

    The ``arguments`` are their names, and ``indices`` those of their numbers among all parameters.
    """

    def __init__(self, setup: Callable[..., Any], parameters: Parameters) -> None:
        function(setup, "setup")
        #: The setup shows each of its warnings once, in the fit and in what is computed from it later.
        self.function = setup if isinstance(setup, WarnedOnce) else WarnedOnce(setup)
        self.arguments = parameters_taken(setup, parameters.arguments)
        self.parameters, self.indices = parameters.only(self.arguments), parameters.indices(self.arguments)

    def __call__(self, values: Floats) -> SetupResult:
        """Return the system and the state for values (P,) of the setup's own parameters."""
        returned = self.function(**self.parameters.named(values))
        match returned:
            case (System() as system, State() as state):
                return SetupResult(system, state)
        raise TypeError(f"setup returned {returned!r}; expected (system, state)")


class Entries:
    """The observations of a fit, of which some are functions of parameters that return them.

    The ``arguments`` are the names of the parameters that each of them takes, none for observations themselves.
    """

    def __init__(self, observations: Any, parameters: Parameters) -> None:
        single = hasattr(observations, "pulls") or callable(observations)
        try:
            self._entries = [observations] if single else list(observations)
        except TypeError:
            self._entries = []
        if not self._entries:
            raise InvalidInput(f"observations is {observations!r}; expected observations, or a list of them")
        for entry in self._entries:
            if not callable(entry) and not _is_observed(entry):
                raise InvalidInput(
                    f"observations has {entry!r}; expected those of fullbody.observing, or a function of parameters "
                    "that returns some"
                )
        self._parameters, names = parameters, parameters.arguments
        self.arguments = [parameters_taken(item, names) if callable(item) else () for item in self._entries]

    def at(self, values: Floats) -> list[Any]:
        """Return the observations for values (P,) of all parameters."""
        named, observations = self._parameters.named(values), []
        for entry, names in zip(self._entries, self.arguments, strict=True):
            observation = entry(**{name: named[name] for name in names}) if callable(entry) else entry
            if not _is_observed(observation):
                raise TypeError(
                    f"{entry!r} of observations returned {observation!r}; expected those of fullbody.observing"
                )
            observations.append(observation)
        return observations


def refuse_unused(parameters: Parameters, setup: Setup, entries: Entries) -> None:
    """Raise an error for a parameter that neither the setup nor observations take."""
    used = {*setup.arguments, *(name for names in entries.arguments for name in names)}
    for name in parameters.arguments:
        if name not in used:
            arguments = _arguments(setup.function).items()
            names = sorted(other for other, item in arguments if item.kind is not item.VAR_POSITIONAL)
            raise InvalidInput(
                f"parameters has {name!r}, which neither the setup nor observations take; "
                f"{suggestion(name, names, 'some')}"
            )


def parameters_taken(function: Callable[..., Any], names: Sequence[str]) -> tuple[str, ...]:
    """Return those names of parameters that a function takes, after checking that it needs no others."""
    arguments = _arguments(function)
    if any(argument.kind is argument.VAR_KEYWORD for argument in arguments.values()):
        return tuple(names)
    for name, argument in arguments.items():
        if argument.kind is argument.POSITIONAL_ONLY:
            raise InvalidInput(f"{function!r} takes {name} by its position alone; expected arguments that have names")
        if argument.default is argument.empty and argument.kind is not argument.VAR_POSITIONAL and name not in names:
            raise InvalidInput(f"parameters has no {name!r}, which {function!r} needs; it has {', '.join(names)}")
    positional = inspect.Parameter.VAR_POSITIONAL
    return tuple(name for name in names if name in arguments and arguments[name].kind is not positional)


def _arguments(function: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    """Return the arguments of a function by name."""
    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError) as error:
        raise InvalidInput(
            f"{function!r} has arguments that Python cannot list; expected a function of Python"
        ) from error


def _is_observed(observation: Any) -> bool:
    return hasattr(observation, "pulls") and hasattr(observation, "emission")
