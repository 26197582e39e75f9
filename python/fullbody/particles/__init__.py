"""Massless particles among moving bodies: spacecraft, ejecta, dust.

Particles do not act on the bodies. :meth:`fullbody.System.fly` and :meth:`fullbody.Run.fly` integrate
:class:`fullbody.Particles` along the motion of the bodies and return a :class:`fullbody.Flight`.
"""

from .events import ParticleEvent, ParticleFunction, ParticlePeriapsis, Shadow
from .flight import Flight, ParticleOccurrence
from .initial import Particles
from .rules import Bounce, EscapeDistance, Radiation

__all__ = [
    "Bounce",
    "EscapeDistance",
    "Flight",
    "ParticleEvent",
    "ParticleFunction",
    "ParticleOccurrence",
    "ParticlePeriapsis",
    "Particles",
    "Radiation",
    "Shadow",
]
