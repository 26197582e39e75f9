"""Things to watch for in a run, located on its continuous solution to the last few bits.

Every event has a ``direction`` (1: the condition's function rises as time grows, -1: it falls, 0: both) and may be
``terminal``: the run then stops there. Functions are sampled several times a step, so that contacts that only graze are
found; a function that oscillates within an eighth of a step can still be missed.
"""

from __future__ import annotations

import operator
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from ._units import Units, is_quantity, numbers, scalar
from .errors import InvalidInput
from .state import State

__all__ = [
    "Alignment",
    "Apoapsis",
    "Contact",
    "Escape",
    "Event",
    "Function",
    "Occurrence",
    "Periapsis",
    "PlaneCrossing",
    "Separation",
]


@dataclass(frozen=True, kw_only=True)
class Event:
    """Base of all events.

    Parameters
    ----------
    direction : {-1, 0, 1}
    terminal : bool
    """

    direction: int = 0
    terminal: bool = False

    def __post_init__(self) -> None:
        if _integer(self.direction) not in (-1, 0, 1):
            raise InvalidInput(f"direction is {self.direction!r}; expected -1, 0 or 1")

    def _describe(self, units: Units) -> dict[str, Any]:
        """What the core is told."""
        return {
            "kind": type(self).__name__,
            "first": 0,
            "second": None,
            "value": 0.0,
            "normal": (0.0, 0.0, 1.0),
            "function": None,
            "direction": _integer(self.direction),
            "terminal": bool(self.terminal),
        }


@dataclass(frozen=True)
class _OfPair(Event):
    i: int = 0
    j: int = 1

    def _describe(self, units: Units) -> dict[str, Any]:
        return {**super()._describe(units), "first": _place(self.i, "i"), "second": _place(self.j, "j")}


@dataclass(frozen=True)
class Separation(_OfPair):
    """The centres of bodies i and j are ``value`` apart.

    Parameters
    ----------
    i, j : int
        Places in the system.
    value : float or Quantity
    direction : {-1, 0, 1}
        -1 approaching, 1 receding.
    terminal : bool

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> run = system.integrate(state, 60.0, events=[fullbody.events.Separation(0, 1, 7.9, terminal=True)])
    >>> run.stop_reason, bool(run.events[0].time == run.time[-1])
    ('event', True)
    """

    value: Any = None

    def _describe(self, units: Units) -> dict[str, Any]:
        value = scalar(units.strip(self.value, "length", "value of Separation"), "value of Separation")
        return {**super()._describe(units), "value": value}


@dataclass(frozen=True)
class Contact(_OfPair):
    """The surfaces of bodies i and j touch, also where they only graze.

    Parameters
    ----------
    i, j : int
    direction : {-1, 0, 1}
        -1 coming together.
    terminal : bool
    """


@dataclass(frozen=True)
class Periapsis(_OfPair):
    """The centres of bodies i and j are nearest.

    Parameters
    ----------
    i, j : int
    terminal : bool

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 40.0, output=40.0, events=[fullbody.events.Periapsis(0, 1)])
    >>> len(run.events) > 0
    True
    """


@dataclass(frozen=True)
class Apoapsis(_OfPair):
    """The centres of bodies i and j are furthest apart.

    Parameters
    ----------
    i, j : int
    terminal : bool
    """


@dataclass(frozen=True)
class PlaneCrossing(Event):
    """The centre of body i goes through a plane.

    Parameters
    ----------
    i : int
    j : int or None
        The body whose centre the plane holds; ``None``: the origin.
    normal : array_like, (3,)
        Inertial, of any length. With the z-axis the crossings are the nodes; ``direction=1`` is the ascending one.
    direction : {-1, 0, 1}
    terminal : bool
    """

    i: int = 1
    j: int | None = 0
    normal: Any = (0.0, 0.0, 1.0)

    def _describe(self, units: Units) -> dict[str, Any]:
        normal = numbers(self.normal, "normal")
        if normal.shape != (3,):
            raise InvalidInput(f"normal has shape {normal.shape}; expected (3,)")
        j = None if self.j is None else _place(self.j, "j")
        return {**super()._describe(units), "first": _place(self.i, "i"), "second": j, "normal": tuple(normal)}


@dataclass(frozen=True)
class Escape(_OfPair):
    """Bodies i and j are further apart than a distance, with positive energy of their relative motion as points.

    Parameters
    ----------
    i, j : int
    distance : float or Quantity
    terminal : bool
    """

    distance: Any = None

    def _describe(self, units: Units) -> dict[str, Any]:
        value = scalar(units.strip(self.distance, "length", "distance of Escape"), "distance of Escape")
        return {**super()._describe(units), "value": value}


@dataclass(frozen=True)
class Alignment(_OfPair):
    """The angle between body i's long axis and the line to body j is smallest.

    Parameters
    ----------
    i, j : int
    terminal : bool
    """


@dataclass(frozen=True)
class Function(Event):
    """A function of the state goes through zero.

    Parameters
    ----------
    f : callable
        Takes a :class:`fullbody.State`, gives a number or a Quantity.
    direction : {-1, 0, 1}
    terminal : bool

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> crossing = fullbody.events.Function(lambda s: s.position[0, 0], terminal=True)
    >>> run = system.integrate(state, 200.0, events=[crossing])
    >>> bool(abs(run[-1].position[0, 0]) < 1e-12)
    True
    """

    f: Callable[[State], Any] = field(default=lambda state: 1.0)

    def _describe(self, units: Units) -> dict[str, Any]:
        if not callable(self.f):
            raise InvalidInput(f"f is {self.f!r}; expected a function of a State")

        def call(core: Any) -> float:
            value = self.f(State._wrap(core, units))
            return float(value.value if is_quantity(value) else value)

        return {**super()._describe(units), "function": call}


@dataclass(frozen=True, slots=True)
class Occurrence:
    """An event that happened.

    Attributes
    ----------
    event : Event
        The one that was asked for.
    time : float or Quantity
    state : State
    """

    event: Event
    time: Any
    state: State


def _integer(value: Any) -> int | None:
    """A whole number of Python or numpy, or ``None``."""
    try:
        return None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        return None


def _place(index: object, name: str) -> int:
    place = _integer(index)
    if place is None or not 0 <= place < sys.maxsize:
        raise InvalidInput(f"{name} is {index!r}; expected the place of a body, 0 or above")
    return place
