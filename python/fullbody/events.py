"""Things to watch for in a run, located on its continuous solution to the last few bits.

Bodies are given by their places in the system or by their names.

Every event has a ``direction`` (1: the condition's function rises as time grows, -1: it falls, 0: both; that of growing
time also where a run goes backwards) and may be ``terminal``: the run then stops there. Functions are sampled several
times a step, so that contacts that only graze are found; a function that oscillates within an eighth of a step can
still be missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ._arguments import directions, integer, named_options, place
from ._records import Alike
from ._units import gathered, numbers, scalar
from .errors import InvalidInput
from .state import State
from .typing import Scalar

if TYPE_CHECKING:
    from .system import System

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


@named_options
@dataclass(frozen=True, kw_only=True, eq=False)
class Event(Alike):
    """Base of all events.

    Parameters
    ----------
    direction : {-1, 0, 1}
        1: where the condition's function rises as time grows; -1: where it falls; 0: both.
    terminal : bool
        Whether the run stops there.
    """

    direction: int = 0
    terminal: bool = False

    def __post_init__(self) -> None:
        if integer(self.direction) not in (-1, 0, 1):
            raise InvalidInput(f"direction is {self.direction!r}; expected -1, 0 or 1")

    def _place(self, system: System, name: str) -> int:
        return place(getattr(self, name), system.names, f"{name} of {type(self).__name__}")

    def _describe(self, system: System) -> dict[str, Any]:
        """What the core is told."""
        return {
            "kind": type(self).__name__,
            "first": 0,
            "second": None,
            "value": 0.0,
            "normal": (0.0, 0.0, 1.0),
            "function": None,
            "direction": integer(self.direction),
            "terminal": bool(self.terminal),
        }


@dataclass(frozen=True, eq=False)
class _OfPair(Event):
    i: int | str = 0
    j: int | str = 1

    def _describe(self, system: System) -> dict[str, Any]:
        first, second = (self._place(system, name) for name in ("i", "j"))
        return {**super()._describe(system), "first": first, "second": second}


@named_options
@dataclass(frozen=True, eq=False)
class Separation(_OfPair):
    """The centres of bodies i and j are ``value`` apart.

    Parameters
    ----------
    i, j : int or str
        Places in the system, or names.
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

    def _describe(self, system: System) -> dict[str, Any]:
        value = _length(self.value, system, "value of Separation")
        return {**super()._describe(system), "value": value}


@named_options
@dataclass(frozen=True, eq=False)
class Contact(_OfPair):
    """The surfaces of bodies i and j touch, also where they only graze.

    Without it, or without ``terminal=True``, a run ends in :class:`fullbody.BodiesOverlap` when bodies interpenetrate.

    Parameters
    ----------
    i, j : int or str
        Places in the system, or names.
    direction : {-1, 0, 1}
        -1: the bodies come together; 1: they part; 0: both.
    terminal : bool
        Whether the run stops there.

    Examples
    --------
    Two spheres fall towards each other until they touch.

    >>> import fullbody
    >>> bodies = [fullbody.Body(fullbody.Sphere(1.0), mass=1.0) for _ in range(2)]
    >>> system = fullbody.System(bodies, G=1.0)
    >>> state = fullbody.State(position=[[0, 0, 0], [6, 0, 0]], velocity=[[0, 0, 0], [0, 0, 0]])
    >>> run = system.integrate(state, 50.0, events=[fullbody.events.Contact(0, 1, direction=-1, terminal=True)])
    >>> run.stop_reason, round(float(run.position[-1, 1, 0] - run.position[-1, 0, 0]), 12)
    ('event', 2.0)
    """


@named_options
@dataclass(frozen=True, eq=False)
class Periapsis(_OfPair):
    """The centres of bodies i and j are nearest.

    Parameters
    ----------
    i, j : int or str
    terminal : bool

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 40.0, output=40.0, events=[fullbody.events.Periapsis(0, 1)])
    >>> len(run.events) > 0
    True
    """


@named_options
@dataclass(frozen=True, eq=False)
class Apoapsis(_OfPair):
    """The centres of bodies i and j are furthest apart.

    Parameters
    ----------
    i, j : int or str
    terminal : bool
    """


@named_options
@dataclass(frozen=True, eq=False)
class PlaneCrossing(Event):
    """The centre of body i goes through a plane.

    Parameters
    ----------
    i : int or str
    j : int, str or None
        The body whose centre the plane holds; ``None``: the origin.
    normal : array_like, (3,)
        Inertial, of any length. With the z-axis the crossings are the nodes; ``direction=1`` is the ascending one.
    direction : {-1, 0, 1}
    terminal : bool
    """

    i: int | str = 1
    j: int | str | None = 0
    normal: Any = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        normal = directions(self.normal, "normal of PlaneCrossing", one=True)
        object.__setattr__(self, "normal", tuple(float(component) for component in normal))

    def _describe(self, system: System) -> dict[str, Any]:
        first = self._place(system, "i")
        second = None if self.j is None else self._place(system, "j")
        return {**super()._describe(system), "first": first, "second": second, "normal": self.normal}


@named_options
@dataclass(frozen=True, eq=False)
class Escape(_OfPair):
    """Bodies i and j are further apart than a distance, with positive energy of their relative motion as points.

    Parameters
    ----------
    i, j : int or str
    distance : float or Quantity
    direction : {-1, 0, 1}
        1: the pair comes to be so; -1: it ceases to.
    terminal : bool
    """

    distance: Any = None

    def _describe(self, system: System) -> dict[str, Any]:
        value = _length(self.distance, system, "distance of Escape")
        return {**super()._describe(system), "value": value}


@named_options
@dataclass(frozen=True, eq=False)
class Alignment(_OfPair):
    """The angle between body i's long axis and the line to body j is smallest.

    Parameters
    ----------
    i, j : int or str
    terminal : bool
    """


@named_options
@dataclass(frozen=True, eq=False)
class Function(Event):
    """A function of the state goes through zero.

    Parameters
    ----------
    f : callable
        Takes a :class:`fullbody.State`, gives a finite number or Quantity; anything else ends the run in
        :class:`fullbody.InvalidInput`.
    direction : {-1, 0, 1}
        1: it rises through zero as time grows; -1: it falls.
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

    def _describe(self, system: System) -> dict[str, Any]:
        if not callable(self.f):
            raise InvalidInput(f"f is {self.f!r}; expected a function of a State")

        what = f"value of the function {getattr(self.f, '__qualname__', type(self.f).__name__)}"

        def call(core: Any) -> float:
            state = State._wrap(core, system._units)
            value = gathered(self.f(state), what)
            number = scalar(numbers(getattr(value, "value", value), what), what)
            if not math.isfinite(number):
                raise InvalidInput(f"{what} is {number} at time {state.time}; expected a finite number")
            return number

        return {**super()._describe(system), "function": call}


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
    time: Scalar
    state: State


def __dir__() -> list[str]:
    return __all__


def _length(value: Any, system: System, what: str) -> float:
    if value is None:
        raise InvalidInput(f"{what} is not given; expected a length")
    return system._units.number(value, "length", what)
