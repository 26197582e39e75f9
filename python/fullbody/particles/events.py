"""Events of particles: functions whose zeros are found during a flight."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ..base.kinds import Declared, Number, body_index, choice, crossing_direction, function, of_kind
from ..base.limits import Limits
from ..base.values import UnstoredFunction
from ..errors import InvalidInput
from ..model.context import Context


@dataclass(frozen=True, kw_only=True, eq=False)
class ParticleEvent(Declared):
    """Base class of particle events, which are zeros of a function found in each step as in a run's event detection.

    Parameters
    ----------
    direction : {-1, 0, 1}
        1 detects zeros where the function rises along the flight, -1 zeros where it falls, and 0 both.
    """

    direction: int = field(default=0, metadata=of_kind(crossing_direction))

    def _describe(self, context: Context) -> dict[str, Any]:
        """Return the description of the event for files."""
        numbers = self._unitless(context.units, context.index)
        return {"kind": type(self).__name__.removeprefix("Particle"), "direction": self.direction, **numbers}

    def _event_spec(self, context: Context) -> tuple[Any, ...]:
        """Return the event in the form that the core takes."""
        if type(self) is ParticleEvent:
            raise InvalidInput(f"event is {self!r}; expected one of fullbody.particles, such as Shadow()")
        kind = next(base.__name__ for base in type(self).__mro__ if ParticleEvent in base.__bases__)
        numbers = self._unitless(context.units, context.index).values()
        return (kind.removeprefix("Particle").lower(), *numbers, self.direction)


@dataclass(frozen=True, eq=False)
class Shadow(ParticleEvent):
    """Entry of a particle into the bodies' shadow, or exit from it: a change of the visible part of the source's disc.

    Parameters
    ----------
    visible : float
        The visible part of the disc below which the particle counts as in the shadow, between 0 and 1: nearly 1 for the
        edge of the penumbra, nearly 0 for the edge of the umbra.
    direction : {-1, 0, 1}
        -1 detects only entries, 1 only exits, and 0 both.
    """

    visible: float = field(default=0.5, metadata=of_kind(Number(limits=Limits(above=0.0, below=1.0))))


@dataclass(frozen=True, eq=False)
class ParticlePeriapsis(ParticleEvent):
    """The least distance of a particle from the centre of a body, given by its index or its name."""

    body: int | str = field(default=0, metadata=of_kind(body_index))
    direction: int = field(default=1, kw_only=True, metadata=of_kind(crossing_direction))


@dataclass(frozen=True, eq=False)
class ParticleFunction(ParticleEvent):
    """Zeros of a user's function of a particle, which is slow: it is called about eleven times per step and particle.

    Parameters
    ----------
    f : callable
        ``f(time, position, velocity)`` returns a float; the arguments are numbers in the system's units, position and
        velocity lists of three. Several threads may call it at once.
    direction : {-1, 0, 1}
    """

    f: Callable[[float, list[float], list[float]], float] = field(
        metadata=of_kind(partial(function, expected="a function of time, position and velocity"))
    )

    def _describe(self, context: Context) -> dict[str, Any]:
        return {**super()._describe(context), "name": getattr(self.f, "__name__", "function")}

    def _event_spec(self, context: Context) -> tuple[Any, ...]:
        call: Any = self.f
        return ("function", lambda time, x, v: float(np.asarray(call(time, x, v))), self.direction)


def rebuild(described: dict[str, Any]) -> ParticleEvent:
    """Rebuild an event from its description; a function, which files do not store, raises an error when called."""
    options = dict(described)
    kind = options.pop("kind")
    if kind == "Function":
        function = UnstoredFunction(str(options.pop("name")), "give it in events= of another flight")
        return ParticleFunction(function, **options)
    kinds = {"Shadow": Shadow, "Periapsis": ParticlePeriapsis}
    return kinds[choice(kind, "event", kinds)](**options)
