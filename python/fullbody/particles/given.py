"""Particles at the start of a flight."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import doubt_radians, integer, named_options
from ..base.units import Units, gathered, is_quantity
from ..base.values import same
from ..errors import InvalidInput
from ..model.state import State
from .launch import Ground, cone, thrown

if TYPE_CHECKING:
    from ..model.system import BaseSystem

__all__ = ["Particles"]

#: As in the core, whose search for contact takes fourth powers.
_LARGEST = 1e60


@named_options
class Particles:
    """Massless particles at one time.

    Parameters
    ----------
    position, velocity : array_like or Quantity, (P, 3)
        Inertial, in the coordinates of the states.
    area_to_mass : float, Quantity or array_like, () or (P,)
        Cross-section over mass, for :class:`fullbody.particles.Radiation`. A coefficient of reflectivity belongs in it:
        1 for a particle that absorbs all light, up to 2 for a mirror.

    Raises
    ------
    InvalidInput
        For wrong shapes, and numbers that are not finite or above 1e60 in size, by the particle's place.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> particles = fullbody.Particles([[4.0, 0.0, 0.0]], [[0.0, 0.0, 0.7]])
    >>> flight = system.fly(state, particles, 10.0, output=5.0)
    >>> flight.position.shape, flight.fate.tolist()
    ((3, 1, 3), ['flying'])
    """

    def __init__(self, position: Any, velocity: Any, area_to_mass: Any = 0.0) -> None:
        self._given = {
            "position": gathered(position, "position"),
            "velocity": gathered(velocity, "velocity", "velocity"),
            "area_to_mass": gathered(area_to_mass, "area_to_mass", "area to mass"),
        }
        # Numbers that are wrong in any system are wrong now.
        self._numbers(_Any())

    def _numbers(self, units: Any) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Positions, velocities and area-to-mass ratios in the units of a system."""
        dimensions = {"position": "length", "velocity": "velocity", "area_to_mass": "area to mass"}
        found = {name: units.strip(self._given[name], of, name) for name, of in dimensions.items()}
        position, velocity = found["position"], found["velocity"]
        for name in ("position", "velocity"):
            if found[name].ndim != 2 or found[name].shape[1] != 3:
                raise InvalidInput(f"{name} of particles has shape {found[name].shape}; expected (P, 3)")
        if position.shape != velocity.shape:
            raise InvalidInput(
                f"velocity of particles has shape {velocity.shape}; expected {position.shape}, as position has"
            )
        if not len(position):
            raise InvalidInput("position of particles has no rows; expected at least one particle")
        ratio = found["area_to_mass"]
        if ratio.ndim and ratio.shape != (len(position),):
            raise InvalidInput(f"area_to_mass has shape {ratio.shape}; expected one number, or ({len(position)},)")
        found["area_to_mass"] = np.ascontiguousarray(np.broadcast_to(ratio, len(position)))
        for name, values in found.items():
            # A comparison with nan is false.
            bad = ~(np.abs(values.reshape(len(values), -1)) <= _LARGEST).all(axis=1)
            if bad.any():
                index = int(np.argmax(bad))
                expected = f"expected finite numbers of at most {_LARGEST:g} in size, in units that keep them in range"
                raise InvalidInput(f"{name} of particle {index} is {values[index]}; {expected}")
        negative = found["area_to_mass"] < 0.0
        if negative.any():
            index = int(np.argmax(negative))
            value = found["area_to_mass"][index]
            raise InvalidInput(f"area_to_mass of particle {index} is {value}; expected zero or more")
        return position, velocity, found["area_to_mass"]

    @property
    def position(self) -> Any:
        """Positions (P, 3), as given."""
        return self._given["position"]

    @property
    def velocity(self) -> Any:
        """Velocities (P, 3), as given."""
        return self._given["velocity"]

    @property
    def area_to_mass(self) -> Any:
        """Area-to-mass ratios, as given."""
        return self._given["area_to_mass"]

    def __len__(self) -> int:
        return len(self._given["position"])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Particles):
            return NotImplemented
        return all(same(value, other._given[name]) for name, value in self._given.items())

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Particles({len(self)} particle{'s' if len(self) != 1 else ''})"

    @classmethod
    def from_surface(
        cls,
        system: BaseSystem,
        state: State,
        body: int | str,
        *,
        longitude: Any,
        latitude: Any,
        speed: Any,
        azimuth: Any = 0.0,
        elevation: Any = np.pi / 2,
        area_to_mass: Any = 0.0,
    ) -> Particles:
        """Particles that leave the surface of a body.

        Parameters
        ----------
        system : System
        state : State
            Where the body is, how it turns and moves.
        body : int or str
        longitude, latitude : float, Quantity or array_like
            Of the direction from the body's centre, in its frame; on a surface that this meets more than once the
            outermost place is taken.
        speed : float, Quantity or array_like
            Relative to the turning surface.
        azimuth : float, Quantity or array_like
            From north towards east, across the outward normal.
        elevation : float, Quantity or array_like
            Above the plane across the normal.
        area_to_mass : float, Quantity or array_like

        Returns
        -------
        Particles
            As many as the arguments have when they are broadcast to one shape.

        Warns
        -----
        InconsistentInput
            For angles that look like degrees: plain numbers beyond two turns with six decimals at most.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> up = fullbody.Particles.from_surface(system, state, "Beta", longitude=[0.0, 1.0], latitude=0.0, speed=0.2)
        >>> len(up)
        2
        """
        ground = Ground(system, state, body)
        angles = {"longitude": longitude, "latitude": latitude, "azimuth": azimuth, "elevation": elevation}
        numbers = {name: system._units.strip(value, "angle", name) for name, value in angles.items()}
        for name, value in angles.items():
            doubt_radians(value, name)
        numbers["speed"] = system._units.strip(speed, "velocity", "speed")
        return cls(*thrown(ground, **numbers), area_to_mass)

    @classmethod
    def ejecta(
        cls,
        system: BaseSystem,
        state: State,
        body: int | str,
        *,
        longitude: Any,
        latitude: Any,
        speed: Any,
        number: int,
        opening_angle: Any = np.pi / 2,
        filled: bool = False,
        seed: int = 0,
        area_to_mass: Any = 0.0,
    ) -> Particles:
        """Particles that leave one place of a surface in a cone about its normal.

        Parameters
        ----------
        system : System
        state : State
        body : int or str
        longitude, latitude : float or Quantity
            Of the crater, as in :meth:`from_surface`.
        speed : float, Quantity or array_like, () or (number,)
            Relative to the turning surface.
        number : int
            Of particles.
        opening_angle : float or Quantity
            Of the whole cone: twice the angle between its mantle and the normal.
        filled : bool
            Whether directions are even in the solid angle of the cone; else they are on its mantle.
        seed : int
            Of the generator of random numbers: the same one gives the same particles.
        area_to_mass : float, Quantity or array_like

        Returns
        -------
        Particles

        Warns
        -----
        InconsistentInput
            For angles that look like degrees: plain numbers beyond two turns with six decimals at most.
        """
        count = integer(number)
        if count is None or count < 1:
            raise InvalidInput(f"number is {number!r}; expected a whole number above zero")
        ground, units = Ground(system, state, body), system._units
        opening = units.number(opening_angle, "angle", "opening_angle")
        if not 0.0 <= opening <= np.pi:
            raise InvalidInput(f"opening_angle is {opening_angle!r}; expected an angle from 0 to pi")
        azimuth, elevation = cone(count, opening, bool(filled), seed)
        place = {"longitude": longitude, "latitude": latitude}
        numbers = {name: units.number(value, "angle", name) for name, value in place.items()}
        doubt_radians(longitude, "longitude")
        speeds = units.strip(speed, "velocity", "speed")
        if speeds.ndim and speeds.shape != (count,):
            raise InvalidInput(f"speed has shape {speeds.shape}; expected one number, or ({count},)")
        return cls(*thrown(ground, **numbers, azimuth=azimuth, elevation=elevation, speed=speeds), area_to_mass)


class _Any:
    """The units of any system: numbers as they are."""

    def strip(self, value: Any, dimension: str, what: str) -> npt.NDArray[np.float64]:
        plain = value.value if is_quantity(value) else value
        return Units().strip(plain, dimension, what)
