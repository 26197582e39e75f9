"""Errors and warnings: the classes of errors have one base class, and say what went wrong and when."""

from __future__ import annotations

import functools
import re
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from typing import Any

__all__ = [
    "BodiesOverlap",
    "ChartSingularity",
    "ForceFailed",
    "FullbodyError",
    "InconsistentInput",
    "Interrupted",
    "InvalidInput",
    "NotConverged",
    "PrecisionWarning",
    "StepSizeTooSmall",
    "UncheckedFile",
]


class FullbodyError(Exception):
    """Base of all errors of this package.

    Attributes
    ----------
    run : Run or None
        The run until the error, if an integration was cut short.
    dataset : xarray.Dataset or None
        The map until the error, if a sweep was cut short.
    """

    run: Any = None
    dataset: Any = None

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class InvalidInput(FullbodyError, ValueError):
    """An argument describes nothing physical, or has the wrong shape or the wrong unit."""


class InconsistentInput(UserWarning):
    """A warning: the input can be computed with, but is probably a mistake.

    Examples are two values of one quantity that differ a little, such as a period beside a semi-major axis and masses;
    a density that no asteroid has; a body whose rotation is not stated; quaternions that are not of length one; angles
    that look like degrees; a start whose bodies are far apart, or much too fast to be bound; a tide with too long
    a lag.
    """


class BodiesOverlap(FullbodyError, RuntimeError):
    """Two bodies share interior points.

    Bodies count as touching, and not as overlapping, where their gap or depth is below 4e-15 times the sum of their
    longest semi-axes, about as far as rounding moves their surfaces. Where that is more than a thousandth of their
    thickness (c/a below about 1e-12), bodies that nearly touch are refused with :class:`InvalidInput`.

    Attributes
    ----------
    bodies : tuple of str
        The names of the bodies.
    time : float
        Time in the system's units: the time of the state, or in a run the time of the contact, after the run's last
        sample.
    """

    def __init__(self, message: str, bodies: tuple[str, str] = ("", ""), time: float = float("nan")) -> None:
        super().__init__(message, bodies, time)
        self.bodies = bodies
        self.time = time


class StepSizeTooSmall(FullbodyError, RuntimeError):
    """The error control asks for steps that no longer advance the time: a singularity.

    Attributes
    ----------
    time, step : float
        The time, and the step that the error control asked for, in the system's units.
    """

    def __init__(self, message: str, time: float = float("nan"), step: float = float("nan")) -> None:
        super().__init__(message, time, step)
        self.time = time
        self.step = step


class NotConverged(FullbodyError, RuntimeError):
    """A quadrature or an iteration reached its stated limit."""


class ChartSingularity(FullbodyError, RuntimeError):
    """A body came too near the pole of the Tait-Bryan angles (theta = 90 degrees).

    Attributes
    ----------
    body : str
        Name of the body.
    time : float
        Time of the error, in the system's units.
    """

    def __init__(self, message: str, body: str = "", time: float = float("nan")) -> None:
        super().__init__(message, body, time)
        self.body = body
        self.time = time


class ForceFailed(FullbodyError, RuntimeError):
    """An external force cannot be evaluated, or its function failed.

    Attributes
    ----------
    force : str
        Name of the force.
    time : float
        Time of the error, in the system's units.
    answer : int or None
        The status that the force's compiled function returned, if it was not success.
    """

    def __init__(self, message: str, force: str = "", time: float = float("nan"), answer: int | None = None) -> None:
        super().__init__(message, force, time, answer)
        self.force = force
        self.time = time
        self.answer = answer


class PrecisionWarning(UserWarning):
    """A warning: a tolerance is below what double precision permits, and is raised to that."""


#: The kinds of warnings that were given since the outermost of :func:`once` began.
_warned: ContextVar[set[tuple[type[Warning], str]] | None] = ContextVar("warned", default=None)


@contextmanager
def once() -> Iterator[None]:
    """Context manager in which warnings that differ in numbers alone, as of many calls of a setup, are issued once."""
    token = _warned.set(set()) if _warned.get() is None else None
    try:
        yield
    finally:
        if token is not None:
            _warned.reset(token)


class WarnedOnce:
    """A function whose warnings are shown once for each kind: texts that differ in numbers alone are of one kind.

    Parameters
    ----------
    function : callable
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        functools.update_wrapper(self, function)
        self._function = function
        self._shown: set[tuple[type[Warning], str]] = set()

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Call the function."""
        try:
            with warnings.catch_warnings(record=True) as caught:
                return self._function(*arguments, **options)
        finally:
            for warning in caught:
                kind = _kind(warning.category, str(warning.message))
                if kind not in self._shown:
                    self._shown.add(kind)
                    warnings.showwarning(warning.message, warning.category, warning.filename, warning.lineno)


def _kind(category: type[Warning], message: str) -> tuple[type[Warning], str]:
    return category, re.sub(r"[-+]?\d[\d.]*(e[-+]?\d+)?", "0", message)


def caution(message: str, category: type[Warning] = InconsistentInput) -> None:
    """Issue a warning that refers to the line outside of this package from which it follows; see :func:`once`."""
    if (warned := _warned.get()) is not None:
        kind = _kind(category, message)
        if kind in warned:
            return
        warned.add(kind)
    # Functions of the package may be called by the decorator of a context manager.
    passed = (__name__.partition(".")[0], "contextlib")
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] in passed:
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level)


class UncheckedFile(UserWarning):
    """A warning: a file has no checksum of its whole content, so that damage may go unseen.

    An earlier version or another program wrote it. A run that is loaded from it and saved again has the checksum.
    """


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a long computation.

    Attributes
    ----------
    run : Run or None
        The run as recorded until the interrupt.
    runs : list or None
        The results of many integrations until the interrupt, as :func:`fullbody.integrate_many` describes them.
    dataset : xarray.Dataset or None
        The map of a sweep until the interrupt.
    """

    run: Any = None
    runs: Any = None
    dataset: Any = None


def keep_result(error: BaseException, name: str, result: Any) -> None:
    """Give an error the result until it in an attribute, and the result a copy of the error.

    With the error itself, the two would refer to each other and stay in memory until Python's search for cycles.
    """
    if isinstance(error, FullbodyError):
        result.error = type(error)(*error.args)
    with suppress(AttributeError):
        setattr(error, name, result)


@contextmanager
def interruptible(what: str) -> Iterator[None]:
    """Raise :class:`Interrupted`, with the name of a computation, for a Ctrl-C in it; also a decorator."""
    try:
        yield
    except KeyboardInterrupt as error:
        raise Interrupted(f"interrupted in {what}") from error
