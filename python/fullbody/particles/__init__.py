"""Massless particles among moving bodies: spacecraft, ejecta, dust.

Particles do not act on the bodies. :meth:`fullbody.System.fly` and :meth:`fullbody.Run.fly` integrate
:class:`fullbody.Particles` along the motion of the bodies and return a :class:`fullbody.Flight`.
"""

from .events import Function, ParticleEvent, Periapsis, Shadow
from .flight import Flight, ParticleOccurrence
from .initial import Particles
from .rules import Bounce, Escape, Radiation

__all__ = [
    "Bounce",
    "Escape",
    "Flight",
    "Function",
    "ParticleEvent",
    "ParticleOccurrence",
    "Particles",
    "Periapsis",
    "Radiation",
    "Shadow",
]
