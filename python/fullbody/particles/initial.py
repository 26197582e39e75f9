"""Particles at the start of a flight."""

from __future__ import annotations

from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.arguments import generator, warn_if_degrees
from ..base.attributes import Attribute
from ..base.kinds import whole_number
from ..base.limits import FINITE, LATITUDE, NOT_NEGATIVE, Limits
from ..base.rotations import unit_vectors
from ..base.units import UNITLESS, AnyUnits, Units, as_quantity, has_shape
from ..base.values import same
from ..errors import InvalidInput
from ..model.context import Context, SystemLike
from ..model.state import State, strip
from ..typing import Floats

_DIMENSIONS = {"position": "length", "velocity": "velocity", "area_to_mass": "area to mass", "time": "time"}


class Particles:
    """Massless particles at one time, the start of a flight.

    Parameters
    ----------
    position, velocity : array_like or Quantity, (P, 3)
        Initial values in the inertial frame, in the coordinates of the states.
    area_to_mass : float, Quantity or array_like, () or (P,)
        Cross-section divided by mass, for :class:`fullbody.particles.Radiation`. A coefficient of reflectivity is to be
        multiplied in: 1 for a particle that absorbs all light, up to 2 for a mirror.
    time : float or Quantity, optional
        The time of the positions and velocities. A flight starts at that time and is refused if it would start at
        another one. Particles of :meth:`from_surface` and :meth:`ejecta` have the time of their state; particles
        without a time start with the flight.

    Raises
    ------
    InvalidInput
        For wrong shapes, and for numbers that are not finite or above 1e60 in size; the message has the particle's
        index.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> particles = fullbody.Particles([[4.0, 0.0, 0.0]], [[0.0, 0.0, 0.7]])
    >>> flight = system.fly(state, particles, 10.0, output=5.0)
    >>> flight.position.shape, flight.fate.tolist()
    ((3, 1, 3), ['flying'])
    """

    def __init__(self, position: Any, velocity: Any, *, area_to_mass: Any = 0.0, time: Any = None) -> None:
        values = {"position": position, "velocity": velocity, "area_to_mass": area_to_mass}
        values |= {} if time is None else {"time": time}
        self._values = {name: as_quantity(value, name, _DIMENSIONS[name]) for name, value in values.items()}
        # Numbers that are invalid in every system are refused when the particles are made.
        self._numbers(AnyUnits())
        self._time(AnyUnits())

    def _numbers(self, units: Units) -> tuple[Floats, Floats, Floats]:
        """Return positions, velocities and area-to-mass ratios as numbers in the units of a system."""
        names = ("position", "velocity", "area_to_mass")
        numbers = {name: units.strip(self._values[name], _DIMENSIONS[name], name) for name in names}
        position, velocity = numbers["position"], numbers["velocity"]
        for name in ("position", "velocity"):
            if not has_shape(numbers[name], ("P", 3)):
                raise InvalidInput(f"{name} of particles has shape {numbers[name].shape}; expected (P, 3)")
        if position.shape != velocity.shape:
            expected = f"expected {position.shape}, as position has"
            raise InvalidInput(f"velocity of particles has shape {velocity.shape}; {expected}")
        if not len(position):
            raise InvalidInput("position of particles has no rows; expected at least one particle")
        ratio = numbers["area_to_mass"]
        if ratio.ndim and ratio.shape != (len(position),):
            raise InvalidInput(f"area_to_mass has shape {ratio.shape}; expected one number, or ({len(position)},)")
        numbers["area_to_mass"] = np.ascontiguousarray(np.broadcast_to(ratio, len(position)))
        limit = _core.LARGEST_OF_PARTICLE
        for name, values in numbers.items():
            # A comparison with nan is false, so that nan is refused too.
            valid = (np.abs(values.reshape(len(values), -1)) <= limit).all(axis=1)
            if not valid.all():
                index = int(np.argmin(valid))
                expected = f"expected finite numbers of at most {limit:g} in size, in units that keep them in range"
                raise InvalidInput(f"{name} of particle {index} is {values[index]}; {expected}")
        negative = np.flatnonzero(numbers["area_to_mass"] < 0.0)
        if len(negative):
            value = numbers["area_to_mass"][negative[0]]
            raise InvalidInput(f"area_to_mass of particle {negative[0]} is {value}; expected zero or more")
        return position, velocity, numbers["area_to_mass"]

    def _time(self, units: Any) -> float | None:
        """Return the time as a number in the units of a system."""
        return units.number(self._values["time"], "time", "time of particles") if "time" in self._values else None

    position = Attribute[Any](lambda self: self._values["position"], "Inertial positions (P, 3), as given.")
    velocity = Attribute[Any](lambda self: self._values["velocity"], "Inertial velocities (P, 3), as given.")
    area_to_mass = Attribute[Any](lambda self: self._values["area_to_mass"], "Area-to-mass ratios, as given.")
    time = Attribute[Any](lambda self: self._values.get("time"), "The time of both, as given; ``None`` if none was.")

    def __len__(self) -> int:
        return len(self._values["position"])

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Particles):
            return NotImplemented
        return same(self._values, other._values)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        when = f" at time {self.time}" if "time" in self._values else ""
        return f"Particles({len(self)} particle{'s' if len(self) != 1 else ''}{when})"

    @classmethod
    def from_surface(
        cls,
        system: SystemLike,
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
        """Make particles that leave the surface of a body, as many as the arguments broadcast to.

        Parameters
        ----------
        system : System
        state : State
            The state with the body's position, attitude and velocities; its time becomes that of the particles.
        body : int or str
        longitude, latitude : float, Quantity or array_like
            The direction from the body's centre in the body frame; if it meets the surface more than once, the
            outermost point is taken. The notes say which side of a body leads.
        speed : float, Quantity or array_like
            Speed relative to the rotating surface.
        azimuth, elevation : float, Quantity or array_like
            Direction in the horizontal plane, from north towards east, and the angle above this plane.
        area_to_mass : float, Quantity or array_like

        Warns
        -----
        InconsistentInput
            For angles that look like degrees: plain numbers beyond two turns with at most six decimals.

        Notes
        -----
        Longitude zero is at the body's x-axis, its long axis, and the z-axis is along the spin. If +x points away from
        the other body, as for Beta in :func:`fullbody.systems.kw4`, the leading side of an orbit along the spin is at
        longitude 90 degrees; if +x points towards the other body, as for Dimorphos and Selam in
        :func:`~fullbody.systems.didymos` and :func:`~fullbody.systems.dinkinesh`, it is at 270 degrees. In any state,
        ``state.rotation_matrix[k, :, 0]`` is the direction of +x.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> up = fullbody.Particles.from_surface(system, state, "Beta", longitude=[0.0, 1.0], latitude=0.0, speed=0.2)
        >>> len(up)
        2
        """
        angles = {"longitude": longitude, "latitude": latitude, "azimuth": azimuth, "elevation": elevation}
        numbers = {name: system.context.units.strip(value, "angle", name) for name, value in angles.items()}
        for name, value in angles.items():
            warn_if_degrees(value, name)
        numbers["speed"] = system.context.units.strip(speed, "velocity", "speed")
        motion = _launch(system.context, state, system.context.index(body, "body"), numbers)
        return cls(*motion, area_to_mass=area_to_mass, time=state.time)

    @classmethod
    def ejecta(
        cls,
        system: SystemLike,
        state: State,
        body: int | str,
        *,
        longitude: Any,
        latitude: Any,
        speed: Any,
        n: int,
        opening_angle: Any = np.pi / 2,
        filled: bool = False,
        rng: int | np.random.Generator = 0,
        area_to_mass: Any = 0.0,
    ) -> Particles:
        """Make particles that leave one point of a surface in a cone about its normal.

        Parameters
        ----------
        system, state, body, area_to_mass
            As for :meth:`from_surface`.
        longitude, latitude : float or Quantity
            Direction of the crater, as in :meth:`from_surface`, which says which side leads, and with the same warning.
        speed : float, Quantity or array_like, () or (n,)
            Speed relative to the rotating surface.
        n : int
            Number of particles.
        opening_angle : float or Quantity
            Full opening angle of the cone: twice the angle between its mantle and the normal.
        filled : bool
            Whether directions are uniform in the solid angle of the cone; otherwise they lie on its mantle.
        rng : int or numpy.random.Generator
            The generator of random numbers, or its seed: equal seeds give equal particles.
        """
        count, units, random = whole_number(n, "n"), system.context.units, generator(rng)
        cones = Limits(least=0.0, most=np.pi, text="an angle from 0 to pi")
        half = 0.5 * units.number(opening_angle, "angle", "opening_angle", cones)
        site = {"longitude": longitude, "latitude": latitude}
        for name, value in site.items():
            units.number(value, "angle", name)
        shape = units.strip(speed, "velocity", "speed").shape
        if shape not in ((), (count,)):
            raise InvalidInput(f"speed has shape {shape}; expected one number, or ({count},)")
        azimuth = random.uniform(0.0, 2.0 * np.pi, count)
        elevation = np.arcsin(random.uniform(np.cos(half), 1.0, count)) if filled else np.full(count, np.pi / 2 - half)
        directions = {"azimuth": azimuth, "elevation": elevation}
        return cls.from_surface(system, state, body, **site, speed=speed, **directions, area_to_mass=area_to_mass)


def _launch(context: Context, state: State, index: int, numbers: dict[str, Floats]) -> tuple[Any, Any]:
    """Return inertial positions and velocities, with units, of particles that leave the surface of a body."""
    core = strip(state, context)
    if len(core.position) != len(context):
        raise InvalidInput(f"state has {len(core.position)} bodies; expected {len(context)}, as the system has")
    limits = {"latitude": LATITUDE, "speed": NOT_NEGATIVE}
    for name, values in numbers.items():
        UNITLESS.numbers(values, "number", name, None, limits.get(name, FINITE))
    try:
        arrays = np.broadcast_arrays(*numbers.values())
    except ValueError as error:
        shapes = ", ".join(f"{name} {np.shape(values)}" for name, values in numbers.items())
        raise InvalidInput(f"the shapes {shapes} do not match; expected shapes that broadcast") from error
    lon, lat, az, el, speed = (np.ravel(values).astype(np.float64) for values in arrays)
    point, normal = _core.surface(context.core, index, np.ascontiguousarray(unit_vectors(lon, lat)))
    east = np.cross([0.0, 0.0, 1.0], normal)
    length = np.linalg.norm(east, axis=1, keepdims=True)
    # At a pole, the longitude defines the direction of east.
    towards_east = np.stack([-np.sin(lon), np.cos(lon), np.zeros_like(lon)], axis=1)
    east = np.where(length > 1e-12, east / np.maximum(length, 1e-300), towards_east)
    north = np.cross(normal, east)
    horizontal = np.sin(az)[:, None] * east + np.cos(az)[:, None] * north
    velocity = speed[:, None] * (np.cos(el)[:, None] * horizontal + np.sin(el)[:, None] * normal)
    matrix, velocity = core.rotation_matrix[index], velocity + np.cross(core.spin[index], point)
    return (
        context.units.attach(core.position[index] + point @ matrix.T, "length"),
        context.units.attach(core.velocity[index] + velocity @ matrix.T, "velocity"),
    )
