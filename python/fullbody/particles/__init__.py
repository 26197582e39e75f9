"""Massless particles among moving bodies: spacecraft, ejecta, dust.

The bodies do not feel them. :meth:`fullbody.System.fly` and :meth:`fullbody.Run.fly` push
:class:`fullbody.Particles` along the bodies' motion; what comes of it is a :class:`fullbody.Flight`.
"""

from .events import Function, ParticleEvent, Periapsis, Shadow
from .flight import Flight, Happened
from .given import Particles
from .rules import Bounce, Escape, Radiation

__all__ = [
    "Bounce",
    "Escape",
    "Flight",
    "Function",
    "Happened",
    "ParticleEvent",
    "Particles",
    "Periapsis",
    "Radiation",
    "Shadow",
]


def __dir__() -> list[str]:
    return __all__
