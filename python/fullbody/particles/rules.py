"""Rules for particles in addition to gravity: contact response, escape, radiation."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass, field
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.kinds import Declared, Number, flag, of_kind
from ..base.limits import FRACTION, NOT_NEGATIVE, POSITIVE
from ..errors import InvalidInput
from ..model.context import Context, SystemLike
from ..model.state import State, strip
from ..typing import Floats

#: The fates of particles, indexed by the core's numbers.
FATES = ("flying", "impact", "escape", "rest", "lost")


@dataclass(frozen=True, kw_only=True, eq=False)
class Bounce(Declared):
    """Contact response in which particles bounce off surfaces.

    The velocity relative to the surface is multiplied along the normal by ``-normal`` and tangentially by
    ``tangential``. A particle that then leaves the surface more slowly than ``rest_speed`` along the normal comes to
    rest, unless the forces push it outwards as it moves; sliding is not modelled. A particle at rest moves with the
    surface and lifts off when its acceleration relative to the surface points outwards.

    Parameters
    ----------
    normal, tangential : float
        Coefficients of restitution, from 0 to 1.
    rest_speed : float or Quantity
        The normal speed below which particles come to rest, above zero.
    """

    normal: float = field(metadata=of_kind(Number(limits=FRACTION)))
    tangential: float = field(default=1.0, metadata=of_kind(Number(limits=FRACTION)))
    rest_speed: Any = field(metadata=of_kind(Number("velocity", POSITIVE)))

    def _describe(self, context: Context) -> tuple[float, float, float]:
        normal, tangential, rest_speed = self._unitless(context.units).values()
        return normal, tangential, rest_speed


@dataclass(frozen=True, eq=False)
class EscapeDistance(Declared):
    """The condition for escape, at which a particle's flight ends.

    Parameters
    ----------
    distance : float or Quantity
        Distance from the system's nominal barycentre, where the barycentre would be without external forces.
    unbound : bool
        Whether the particle's energy relative to a point with the system's mass has to be positive as well.
    """

    distance: Any = field(metadata=of_kind(Number("length", POSITIVE)))
    _: KW_ONLY
    unbound: bool = field(default=False, metadata=of_kind(flag))

    def _describe(self, context: Context) -> tuple[float, bool]:
        return self._unitless(context.units)["distance"], self.unbound


#: The Sun's nominal luminosity over 4 pi c, and its nominal radius: IAU 2015 Resolution B3.
_SUN = {"strength": (f"{3.828e26 / (4.0 * math.pi * 299792458.0)!r} N", "force"), "radius": ("695700 km", "length")}


@dataclass(frozen=True, kw_only=True, eq=False)
class Radiation(Declared):
    """Radiation pressure of a third body on particles that the bodies do not shade.

    The acceleration is ``strength * area_to_mass * visible / d**2``, directed away from the third body, with d the
    distance from it and ``visible`` the visible part of its disc. Ellipsoids hide the disc exactly, composites part by
    part, and a polyhedron as the ellipsoid with its moments of inertia.

    Parameters
    ----------
    by : str
        Name of the :class:`fullbody.forces.ThirdBody` that radiates.
    strength, radius : float or Quantity, optional
        Its luminosity divided by 4 pi c, a force, and its radius. The defaults are the Sun's, which need a system with
        units.
    """

    by: str = "Sun"
    strength: Any = field(default=None, metadata=of_kind(Number("force", NOT_NEGATIVE)))
    radius: Any = field(default=None, metadata=of_kind(Number("length", POSITIVE)))

    def _describe(self, context: Context) -> tuple[str, float, float]:
        context.third_body(self.by, "by of Radiation")
        numbers = self._unitless(context.units)
        for name, value in numbers.items():
            if value is None and not context.units.defined:
                expected = "expected a number, since the system has no units"
                raise InvalidInput(f"{name} of Radiation is not given; {expected}")
            if value is None:
                numbers[name] = context.units.number(*_SUN[name], name)
        return self.by, numbers["strength"], numbers["radius"]

    def visible(self, system: SystemLike, state: State, points: Any) -> Floats:
        """Return the visible part (...) of the third body's disc at points, from 0, in the umbra, to 1, in full light.

        Parameters
        ----------
        system : System
        state : State
            State of the bodies, whose barycentre is taken as the nominal one.
        points : array_like or Quantity, (..., 3)
            Positions in the inertial frame, in the coordinates of the state.
        """
        context = system.context
        coordinates = context.units.numbers(points, "length", "points", ("...", 3))
        rows = np.ascontiguousarray(coordinates.reshape(-1, 3))
        visible = _core.visible(context.core, strip(state, context), self._describe(context), rows)
        return visible.reshape(coordinates.shape[:-1])
