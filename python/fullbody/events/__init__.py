"""Events of a run, located on its continuous solution to the last few bits.

Bodies, such as ``body`` and ``about``, are given by their indices in the system or by their names.

Every event has a ``direction``: 1 if the condition's function must rise as time grows, -1 if it must fall, 0 for both.
The direction refers to growing time also in runs backwards. A ``terminal`` event stops the run. Functions are sampled
several times per step, so that grazing contacts are found; zeros of a function that oscillates within an eighth of a
step can be missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.arguments import directions
from ..base.kinds import Declared, Number, body_index, crossing_direction, direction, flag, function, of_kind
from ..base.limits import POSITIVE
from ..base.units import as_quantity, is_quantity, numbers, scalar
from ..errors import InvalidInput
from ..model.context import Context
from ..model.state import State, wrap
from ..typing import Scalar

__all__ = [
    "Alignment",
    "Apoapsis",
    "ClosestApproach",
    "Contact",
    "Escape",
    "Event",
    "Function",
    "Occultation",
    "Occurrence",
    "Periapsis",
    "PlaneCrossing",
    "Separation",
]


@dataclass(frozen=True, kw_only=True, eq=False)
class Event(Declared):
    """Base class of all events.

    Parameters
    ----------
    direction : {-1, 0, 1}
        1 if the condition's function must rise as time grows, -1 if it must fall, 0 for both.
    terminal : bool
        Whether the run stops there.
    """

    direction: int = field(default=0, metadata=of_kind(crossing_direction))
    terminal: bool = field(default=False, metadata=of_kind(flag))

    def _condition(self, context: Context) -> _core.Condition:
        """Return the condition that the core detects: by default that of the class's name, or of one of its bases."""
        kinds = (getattr(_core.Condition, base.__name__, None) for base in type(self).__mro__)
        if (kind := next(filter(None, kinds), None)) is None:
            raise InvalidInput(f"event is {self!r}; expected one of fullbody.events, such as Contact(0, 1)")
        condition: _core.Condition = kind(*self._unitless(context.units, context.index).values())
        return condition

    def _event_spec(self, context: Context) -> tuple[_core.Condition, int, bool]:
        """Return the condition, the direction and whether the run stops there."""
        return self._condition(context), self.direction, self.terminal


@dataclass(frozen=True, eq=False)
class _TwoBodyEvent(Event):
    body: int | str = field(default=1, metadata=of_kind(body_index))
    about: int | str = field(default=0, metadata=of_kind(body_index))


@dataclass(frozen=True, eq=False)
class Separation(_TwoBodyEvent):
    """The centres of two bodies are ``value`` apart.

    Parameters
    ----------
    body, about : int or str
    value : float or Quantity
    direction : {-1, 0, 1}
        -1 if the bodies approach each other, 1 if they recede, 0 for both.
    terminal : bool

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> run = system.integrate(state, 60.0, events=[fullbody.events.Separation(0, 1, 7.9, terminal=True)])
    >>> run.stop_reason, bool(run.events[0].time == run.time[-1])
    ('event', True)
    """

    value: Any = field(default=None, metadata=of_kind(Number("length", POSITIVE, required=True)))


@dataclass(frozen=True, eq=False)
class Contact(_TwoBodyEvent):
    """The surfaces of two bodies touch, even if they only graze each other.

    Without this event, or without ``terminal=True``, a run ends in :class:`fullbody.errors.BodiesOverlap` at the time
    of the contact if the bodies begin to interpenetrate, for however short a time.

    Parameters
    ----------
    body, about : int or str
    direction : {-1, 0, 1}
        -1 if the bodies come together, 1 if they separate, 0 for both.
    terminal : bool

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


@dataclass(frozen=True, eq=False)
class Periapsis(_TwoBodyEvent):
    """The centres of two bodies, ``body`` and ``about``, are nearest.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 40.0, output=40.0, events=[fullbody.events.Periapsis(0, 1)])
    >>> len(run.events) > 0
    True
    """


@dataclass(frozen=True, eq=False)
class Apoapsis(_TwoBodyEvent):
    """The centres of two bodies, ``body`` and ``about``, are furthest apart."""


@dataclass(frozen=True, eq=False)
class PlaneCrossing(Event):
    """The centre of a body crosses a plane.

    Parameters
    ----------
    body : int or str
    about : int, str or None
        The body whose centre lies in the plane; ``None`` for a plane through the origin.
    normal : array_like, (3,)
        The normal of the plane in the inertial frame, of any length. With the z-axis the crossings are the nodes;
        ``direction=1`` is the ascending one.
    direction : {-1, 0, 1}
    terminal : bool
    """

    body: int | str = field(default=1, metadata=of_kind(body_index))
    about: int | str | None = field(default=0, metadata=of_kind(body_index))
    normal: Any = field(default=(0.0, 0.0, 1.0), metadata=of_kind(direction))

    def _condition(self, context: Context) -> _core.Condition:
        numbers = self._unitless(context.units, context.index)
        return _core.Condition.PlaneCrossing(numbers["body"], numbers["about"], self.normal)


@dataclass(frozen=True, eq=False)
class Escape(_TwoBodyEvent):
    """Two bodies are further apart than a distance, with positive energy of their relative motion as points.

    Parameters
    ----------
    body, about : int or str
    distance : float or Quantity
    direction : {-1, 0, 1}
        1 if this becomes true, -1 if it ceases to be true, 0 for both.
    terminal : bool
    """

    distance: Any = field(default=None, metadata=of_kind(Number("length", POSITIVE, required=True)))


@dataclass(frozen=True, eq=False)
class Alignment(_TwoBodyEvent):
    """The angle between the long axis of ``body`` and the line to another body, ``about``, is smallest."""


@dataclass(frozen=True, eq=False)
class ClosestApproach(Event):
    """A third body is nearest to the system's barycentre.

    Parameters
    ----------
    force : str
        The name of a :class:`fullbody.forces.ThirdBody` of the system.
    terminal : bool

    Examples
    --------
    A planet passes on a hyperbola; its periapsis is at the time 0, and the pull moves the barycentre a little.

    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> orbit = fullbody.KeplerElements(a=-500.0, e=1.5, i=0.2, Omega=0.0, omega=0.0, M=0.0)
    >>> planet = fullbody.forces.ThirdBody(mu=1.0, orbit=orbit, of="body", name="Earth")
    >>> approach = fullbody.events.ClosestApproach("Earth")
    >>> run = system.with_forces([planet]).integrate(state.replace(time=-5.0), 5.0, events=[approach])
    >>> [bool(abs(happened.time) < 1e-3) for happened in run.events]
    [True]
    """

    force: str = ""

    def _condition(self, context: Context) -> _core.Condition:
        return _core.Condition.ClosestApproach(context.third_body(self.force, "force of ClosestApproach"))


@dataclass(frozen=True, eq=False)
class Function(Event):
    """A function of the state passes through zero.

    Parameters
    ----------
    f : callable
        A function that takes a :class:`fullbody.State` and returns a finite number or Quantity; any other result ends
        the run in :class:`fullbody.errors.InvalidInput`.
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

    f: Callable[[State], Any] = field(metadata=of_kind(partial(function, expected="a function of a State")))

    def _condition(self, context: Context) -> _core.Condition:
        name = f"value of the function {getattr(self.f, '__qualname__', type(self.f).__name__)}"

        def call(core: Any) -> float:
            state = wrap(core, context)
            value = as_quantity(self.f(state), name)
            number = scalar(numbers(getattr(value, "value", value), name), name)
            if not math.isfinite(number):
                raise InvalidInput(f"{name} is {number} at time {state.time}; expected a finite number")
            return number

        return _core.Condition.Function(call)


@dataclass(frozen=True, eq=False)
class Occultation(Event):
    """One body begins or ceases to hide another one behind it, as seen from a point.

    If the point is the observer, this is an occultation; if it is the Sun, an eclipse. The function is the gap between
    the outlines of the two bodies, or with ``total=True`` the distance by which the outline of the body behind extends
    beyond that in front. The outline of a polyhedron is the convex hull of its vertices.
    :func:`fullbody.observing.occultation` makes the event from a geometry, and :func:`fullbody.observing.mutual_events`
    finds all such events of a finished run.

    Parameters
    ----------
    body, by : int or str
        The body behind and the body in front.
    toward : array_like, (3,) or (T, 3)
        The direction to the point, of any length, or its directions at ``times``, which are interpolated by a cubic
        spline. With ``distant=False`` vectors from the barycentre to the point.
    times : array_like or Quantity, (T,), optional
        Times of the directions, at least four. A run beyond them is refused.
    distant : bool
        Whether the point counts as infinitely far. Otherwise ``toward`` has a unit, or the system's unit of length, and
        bodies are seen within cones; a run in which one of the two bodies reaches as far toward the point as it is from
        the barycentre is refused.
    slowness : float
        One over the speed of light, in the system's units. Each body is then taken when the light left it that left the
        barycentre at the time of the event. A negative number stands for light from the point, which passes the bodies.
        Zero for all bodies at one time.
    total : bool
        Whether all of the body behind must be hidden. What only several parts of the body in front hide together counts
        as visible.
    direction : {-1, 0, 1}
        -1 if it begins, 1 if it ends, 0 for both.
    terminal : bool

    Notes
    -----
    Bodies at their own times are taken from the polynomials of the step. Where these times are not within the step,
    positions follow from the acceleration at its end, with an error of a sixth of its rate of change times the cube of
    the light time, and attitudes from the spin; :func:`fullbody.observing.mutual_events` has all steps.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.didymos()
    >>> hidden = fullbody.events.Occultation("Dimorphos", "Didymos", toward=[1.0, 0.0, 0.0], terminal=True)
    >>> run = system.integrate(state, 24.0, events=[hidden])
    >>> run.stop_reason
    'event'
    """

    body: int | str = field(metadata=of_kind(body_index))
    by: int | str = field(metadata=of_kind(body_index))
    toward: Any = None
    times: Any = field(default=None, metadata=of_kind(Number("time", shape=("T",))))
    total: bool = field(default=False, metadata=of_kind(flag))
    distant: bool = field(default=True, metadata=of_kind(flag))
    slowness: float = field(default=0.0, metadata=of_kind(Number()))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.toward is None:
            raise InvalidInput("toward of Occultation is not given; expected a direction (3,), or (T, 3) with times=")
        toward = directions(self.toward, "toward of Occultation")
        times = self.times
        count = () if times is None else np.shape(times)
        if toward.ndim != (1 if times is None else 2) or toward.shape[:-1] != count:
            expected = "expected (3,) without times, or (T, 3) and (T,)"
            raise InvalidInput(f"toward of Occultation has shape {toward.shape} and times {count}; {expected}")
        # The directions are stored as tuples, which can be compared and hashed.
        has_unit = is_quantity(self.toward) and not self.distant
        object.__setattr__(self, "toward", self.toward if has_unit else _tuples(toward))
        object.__setattr__(self, "times", times if is_quantity(times) or times is None else _tuples(times))

    def _condition(self, context: Context) -> _core.Condition:
        toward, times = self.toward, self.times
        toward = toward if self.distant else context.units.strip(toward, "length", "toward of Occultation")
        vectors = np.atleast_2d(toward)
        if times is None:
            vectors, knots = np.repeat(vectors, 4, axis=0), np.arange(4.0)
        else:
            knots = context.units.numbers(times, "time", "times of Occultation")
        path = _core.Viewpoint(knots.tolist(), vectors.tolist(), self.slowness, self.distant, times is not None)
        numbers = self._unitless(context.units, context.index)
        return _core.Condition.Occultation(numbers["body"], numbers["by"], self.total, path)


def _tuples(values: Any) -> Any:
    """Return an array as nested tuples of floats."""
    array = np.asarray(values, dtype=np.float64)
    return float(array) if array.ndim == 0 else tuple(_tuples(row) for row in array)


@dataclass(frozen=True, slots=True)
class Occurrence:
    """An occurrence of an event in a run.

    Attributes
    ----------
    event : Event
        The event that was detected.
    time : float or Quantity
    state : State
    """

    event: Event
    time: Scalar
    state: State
    #: The transition matrix (12 N, 12 N), the sensitivities (P, 12 N) and the rates of change (12 N,) at the event, in
    #: runs with derivatives.
    derivatives: tuple[Any, Any, Any] | None = field(default=None, compare=False, repr=False)
