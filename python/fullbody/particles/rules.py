"""Rules for particles in addition to gravity: contact response, escape, radiation."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base.arguments import positive
from ..base.values import ScalarFields
from ..errors import InvalidInput
from ..model.context import Context, SystemLike
from ..model.state import State, strip

__all__ = ["FATES", "Bounce", "Escape", "Radiation"]

#: The fates of particles, indexed by the core's numbers.
FATES = ("flying", "impact", "escape", "rest", "lost")


def _coefficient(value: Any, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= 1.0:
        raise InvalidInput(f"{what} is {value!r}; expected a number from 0 to 1")
    return float(value)


@dataclass(frozen=True, kw_only=True, eq=False)
class Bounce(ScalarFields):
    """Contact response in which particles bounce off surfaces.

    The velocity relative to the surface is multiplied along the normal by ``-normal`` and across it by ``tangential``.
    A particle that then leaves the surface more slowly than ``rest`` along the normal comes to rest, unless the forces
    push it outwards as it moves; sliding is not modelled. A particle at rest moves with the surface and lifts off when
    its acceleration relative to the surface points outwards.

    Parameters
    ----------
    normal, tangential : float
        Coefficients of restitution, from 0 to 1.
    rest : float or Quantity
        The normal speed below which particles come to rest, above zero.
    """

    normal: float
    tangential: float = 1.0
    rest: Any

    def __post_init__(self) -> None:
        for name in ("normal", "tangential"):
            object.__setattr__(self, name, _coefficient(getattr(self, name), f"{name} of Bounce"))
        object.__setattr__(self, "rest", positive(self.rest, "m/s", "rest of Bounce"))

    def _numbers(self, context: Context) -> tuple[float, float, float]:
        rest = context.units.number(self.rest, "velocity", "rest of Bounce")
        return (self.normal, self.tangential, rest)


@dataclass(frozen=True, eq=False)
class Escape(ScalarFields):
    """The condition for escape, at which a particle's flight ends.

    Parameters
    ----------
    distance : float or Quantity
        Distance from the system's nominal barycentre, where the barycentre would be without external forces.
    unbound : bool
        Whether the particle's energy relative to a point with the system's mass has to be positive as well.
    """

    distance: Any
    _: KW_ONLY
    unbound: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "distance", positive(self.distance, "km", "distance of Escape"))

    def _numbers(self, context: Context) -> tuple[float, bool]:
        return (context.units.number(self.distance, "length", "distance of Escape"), bool(self.unbound))


#: The Sun's nominal luminosity over 4 pi c, in N, and its nominal radius in km: IAU 2015 Resolution B3.
_SUN = (3.828e26 / (4.0 * math.pi * 299792458.0), 695700.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Radiation(ScalarFields):
    """Radiation pressure of a third body on particles that the bodies do not shade.

    The acceleration is ``strength * area_to_mass * visible / d**2``, directed away from the third body, with d the
    distance from it and ``visible`` the visible part of its disc. Ellipsoids hide the disc exactly, composites part by
    part, and a polyhedron as the ellipsoid with its moments of inertia.

    Parameters
    ----------
    by : str
        Name of the :class:`fullbody.forces.ThirdBody` that radiates.
    strength : float or Quantity, optional
        Luminosity divided by 4 pi c, a force. The default is the Sun's value, which needs a system with units.
    radius : float or Quantity, optional
        Radius of the third body. The default is the Sun's radius, which needs a system with units.
    """

    by: str = "Sun"
    strength: Any = None
    radius: Any = None

    def _numbers(self, context: Context) -> tuple[str, float, float]:
        context.third_body(self.by, "by of Radiation")
        units, found = context.units, []
        for name, dimension, unit, sun in zip(
            ("strength", "radius"), ("force", "length"), ("N", "km"), _SUN, strict=True
        ):
            value = getattr(self, name)
            if value is None:
                if not units.known:
                    raise InvalidInput(
                        f"{name} of Radiation is not given; expected a number, since the system has no units"
                    )
                from astropy import units as u

                value = sun * u.Unit(unit)
            found.append(units.number(value, dimension, f"{name} of Radiation"))
        return (self.by, found[0], found[1])

    def visible(self, system: SystemLike, state: State, points: Any) -> npt.NDArray[np.float64]:
        """Compute the visible part of the third body's disc at points.

        Parameters
        ----------
        system : System
        state : State
            State of the bodies, whose barycentre is taken as the nominal one.
        points : array_like or Quantity, (..., 3)
            Positions in the inertial frame, in the coordinates of the state.

        Returns
        -------
        ndarray, (...)
            Visible fraction from 0, in the umbra, to 1, in full light.
        """
        context = system.context
        places = context.units.strip(points, "length", "points")
        if places.shape[-1:] != (3,):
            raise InvalidInput(f"points has shape {places.shape}; expected (..., 3)")
        rows = np.ascontiguousarray(places.reshape(-1, 3))
        return _core.visible(context.core, strip(state, context), self._numbers(context), rows).reshape(
            places.shape[:-1]
        )
