"""The parameters of a fit that a function takes, by the names of its arguments."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..errors import InvalidInput


def arguments_of(function: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    """Return the arguments of a function by name."""
    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError) as error:
        raise InvalidInput(
            f"{function!r} has arguments that Python cannot list; expected a function of Python"
        ) from error


def parameters_taken(function: Callable[..., Any], names: Sequence[str]) -> tuple[str, ...]:
    """Return those names of parameters that a function takes, after checking that it needs no others."""
    arguments = arguments_of(function)
    if any(argument.kind is argument.VAR_KEYWORD for argument in arguments.values()):
        return tuple(names)
    for name, argument in arguments.items():
        if argument.kind is argument.POSITIONAL_ONLY:
            raise InvalidInput(f"{function!r} takes {name} by its position alone; expected arguments that have names")
        if argument.default is argument.empty and argument.kind is not argument.VAR_POSITIONAL and name not in names:
            raise InvalidInput(f"parameters has no {name!r}, which {function!r} needs; it has {', '.join(names)}")
    return tuple(
        name for name in names if name in arguments and arguments[name].kind is not inspect.Parameter.VAR_POSITIONAL
    )
