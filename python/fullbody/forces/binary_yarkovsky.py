"""The binary Yarkovsky effect: the mean thermal force on a secondary that does not rotate synchronously."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt
from typing import Any, Self

from ..base.kinds import Number, body_index, direction, of_kind
from ..base.limits import POSITIVE, Limits
from ..base.tables import number
from ..base.unit_names import unit_named
from ..base.units import ANY, UNITLESS, Units, as_quantity, is_quantity, strip_to
from ..errors import InvalidInput
from ..model.context import Context
from ..model.force import Force

_FRACTION = Limits(least=0.0, most=1.0)
#: The SI unit of thermal inertia, which a plain number has.
_INERTIA = "J / (m2 K s(1/2))"


def _thermal_inertia(value: Any, what: str) -> Any:
    """Return a thermal inertia as a number in its SI unit."""
    value = as_quantity(value, what, expected=f"a thermal inertia in {_INERTIA}")
    if is_quantity(value):
        value = float(strip_to(value, unit_named(_INERTIA), what))
    return UNITLESS.number(value, "number", what, POSITIVE)


@dataclass(frozen=True, eq=False, repr=False)
class BinaryYarkovsky(Force):
    """The mean thermal force on a secondary that does not rotate synchronously, along its motion.

    The primary's shadow darkens the secondary once in each revolution, and the primary's light and heat warm the side
    that faces it. The surface radiates this heat with a delay, in which it rotates, so that the mean recoil has a
    component along the motion. The effect of the shadow is the larger one: a secondary that rotates faster than it
    revolves drifts inwards, and a slower or a retrograde one outwards.

    Parameters
    ----------
    on, about : int or str
        The secondary, and the body that it orbits.
    pressure : float, Quantity or str
        Mean pressure of sunlight, see :func:`solar_pressure`.
    thermal_inertia : float, Quantity or str, optional
        Thermal inertia of the surface; a plain number is in J m^-2 K^-1 s^-1/2. It needs a system with units. Either
        this or ``lag`` is required.
    lag : float, Quantity or str, optional
        Lag angle of the radiated heat, above 0 and below 45 degrees and independent of the spin.
    albedo, emissivity : float
        Bond albedo and emissivity of both bodies, from 0 to 1.
    radius, primary_radius : float, Quantity or str, optional
        Radii of the secondary and of the body that it orbits; by default those of the spheres of their volumes.
    pole : array_like, (3,)
        Normal of the orbit round the Sun in the inertial frame.
    name : str, optional
        Name of the force; by default ``binary Yarkovsky on`` the body.

    Raises
    ------
    ForceFailed
        In a run, for a motion out of the range of the formula: an eccentricity above 0.1; an angle between the mutual
        orbit and the one round the Sun whose sine is above half of the primary's radius over the distance; a spin that
        is inclined to the orbit's normal by more than 30 degrees, or that differs from the mean motion by less than a
        tenth of it.
    InvalidInput
        For a secondary larger than the primary, and for none or both of ``thermal_inertia`` and ``lag``.

    Notes
    -----
    The effect is that of Zhou et al. (2024), ApJL 968, L3. We could read their abstract, not their formula: the formula
    here follows from the linear theory of heat conduction in a sphere (Vokrouhlicky 1998), as the theory of forces in
    the documentation derives it. The thermal skin depth must be small relative to the radius.

    Examples
    --------
    The force on Dimorphos if it turned twice in each revolution:

    >>> import fullbody
    >>> system, state = fullbody.systems.didymos_after_dart(units=True)
    >>> pressure, pole = fullbody.forces.solar_pressure("1.644 au", 0.384), (0.0569, -0.0172, 0.9982)
    >>> effect = fullbody.forces.BinaryYarkovsky(
    ...     "Dimorphos", "Didymos", pressure=pressure, thermal_inertia=320.0, pole=pole, name="thermal"
    ... )
    >>> state = state.replace(spin=state.spin * [[1.0], [2.0]])
    >>> force = system.with_force(effect).loads(state)["thermal"].force[1]
    >>> ((force @ force) ** 0.5).to("mN").round(3)
    <Quantity 0.158 mN>
    """

    _called = "binary Yarkovsky on"

    on: int | str = field(metadata=of_kind(body_index))
    about: int | str = field(metadata=of_kind(body_index))
    pressure: Any = field(kw_only=True, metadata=of_kind(Number("pressure", POSITIVE)))
    thermal_inertia: Any = field(default=None, kw_only=True, metadata=of_kind(_thermal_inertia))
    lag: Any = field(default=None, kw_only=True, metadata=of_kind(Number("angle")))
    albedo: float = field(default=0.1, kw_only=True, metadata=of_kind(Number(limits=_FRACTION)))
    emissivity: float = field(default=0.9, kw_only=True, metadata=of_kind(Number(limits=_FRACTION)))
    radius: Any = field(default=None, kw_only=True, metadata=of_kind(Number("length", POSITIVE)))
    primary_radius: Any = field(default=None, kw_only=True, metadata=of_kind(Number("length", POSITIVE)))
    pole: Any = field(default=(0.0, 0.0, 1.0), kw_only=True, metadata=of_kind(direction))

    def _check(self) -> None:
        if (self.thermal_inertia is None) == (self.lag is None):
            values = f"{self.thermal_inertia!r} and {self.lag!r}"
            raise InvalidInput(f"thermal_inertia and lag of {self.name} are {values}; expected one of the two")
        if self.thermal_inertia is not None and (self.albedo == 1.0 or self.emissivity == 0.0):
            values = f"albedo and emissivity of {self.name} are {self.albedo} and {self.emissivity}"
            raise InvalidInput(f"{values}; expected a surface that sunlight warms and that radiates")

    def _describe(self, context: Context) -> dict[str, Any]:
        arguments = super()._describe(context)
        arguments["radius"] = self._radius(context, self._index(context, "on"))
        arguments["primary_radius"] = self._radius(context, self._index(context, "about"), "primary_radius")
        arguments["pole"] = list(self.pole)
        if (inertia := self.thermal_inertia) is not None:
            arguments["thermal_time"] = self._thermal_time(inertia, arguments["pressure"], context.units)
        return {role: value for role, value in arguments.items() if value is not None}

    def _thermal_time(self, inertia: float, pressure: float, units: Units) -> float:
        """Return (thermal inertia / (emissivity sigma T^3))^2, T the subsolar temperature, in the unit of time."""
        if units is ANY:
            # For a force that does not belong to a system yet, any time will do.
            return 1.0
        if not units.defined:
            expected = "expected a system with units, or a lag"
            raise InvalidInput(f"thermal_inertia of {self.name} is {inertia}, but the system has no units; {expected}")
        seconds = (inertia / _emission(pressure, self.albedo, self.emissivity, units)) ** 2
        return units.number(f"{seconds!r} s", "time", "thermal time")

    def _summary(self, described: dict[str, Any], units: Units) -> str:
        role, dimension = ("lag", "angle") if described.get("lag") is not None else ("thermal_time", "time")
        value = number(units.attach(described[role], dimension))
        return f"on {described['on']} about {described['about']}, {role.replace('_', ' ')} {value}"

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        arguments = {role: value for role, value in described.items() if value is not None}
        if (time := arguments.pop("thermal_time", None)) is not None:
            seconds = float(strip_to(units.attach(time, "time"), unit_named("s"), "thermal time"))
            pressure, albedo, emissivity = (described[role] for role in ("pressure", "albedo", "emissivity"))
            arguments["thermal_inertia"] = sqrt(seconds) * _emission(pressure, albedo, emissivity, units)
        return super()._of_core(arguments, units)


def _emission(pressure: float, albedo: float, emissivity: float, units: Units) -> float:
    """Return emissivity sigma T^3, T the subsolar temperature, in SI units."""
    from astropy import constants

    flux = float(strip_to(units.attach(pressure, "pressure"), unit_named("Pa"), "pressure")) * constants.c.value
    power, emitted = (1.0 - albedo) * flux, emissivity * constants.sigma_sb.value
    return float(emitted * (power / emitted) ** 0.75)
