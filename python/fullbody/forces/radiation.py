"""Forces of sunlight, averaged over many rotations: YORP and BYORP."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from math import pi, sqrt
from typing import Any, Self

import numpy as np

import fullbody._core as _core

from ..base.kinds import Number, body_index, choice, direction, of_kind
from ..base.limits import POSITIVE, Limits
from ..base.tables import number
from ..base.units import UNITLESS, Units, as_quantity, need
from ..errors import InvalidInput
from ..model.context import Context
from ..model.force import Force

#: The force of BYORP for a coefficient of one, divided by the pressure and the squared radius.
_BYORP = {
    "jacobson_scheeres_2011": 1.0,
    "quillen_2022": 1.0,
    "steinberg_sari_2011": 2.0 * pi / 3.0,
    "wang_hou_2021": 2.0 * pi / 3.0,
}
#: The torque of YORP for a coefficient of one, divided by the pressure and the cubed radius.
_YORP = {"quillen_2022": 1.0, "steinberg_sari_2011": 2.0 * pi / 3.0}
#: The pressure of sunlight at 1 au, and the limits of a torque divided by this pressure and the cubed radius, from a
#: nearly round body to an irregular one near the Sun; torques outside them cause a warning.
_SOLAR_PRESSURE, _TORQUE_RANGE = "4.54e-6 Pa", (1e-6, 10.0)
#: Normalisations of YORP that are rates of the spin, either directly or through pressure times radius over mass.
_RATES = ("acceleration", "rossi_2009")


def torque_dimension(normalization: str | None) -> str:
    """Return the dimension of ``along`` and ``across`` of :class:`Yorp`; coefficients of papers are pure numbers."""
    return {None: "torque", "acceleration": "angular acceleration"}.get(normalization, "number")


def solar_pressure(semi_major_axis: Any, eccentricity: float = 0.0) -> Any:
    """Compute the mean pressure of sunlight along an orbit round the Sun, as a Quantity.

    It is the mean over time of L / (4 pi c d^2), which is L / (4 pi c a^2 sqrt(1 - e^2)): the pressure on a black plate
    that faces the Sun. L is the nominal luminosity of the IAU, with which L / (4 pi c) is 1.0161e17 N; papers round
    that to 1e17 N.

    Parameters
    ----------
    semi_major_axis : Quantity or str
        Semi-major axis of the orbit round the Sun, such as ``"0.642 au"``.
    eccentricity : float

    Examples
    --------
    >>> from fullbody.forces import solar_pressure
    >>> solar_pressure("0.642 au", 0.688)
    <Quantity 1.51794824e-05 Pa>
    """
    with need("units", "solar_pressure"):
        from astropy import constants
        from astropy import units as u

    distance = as_quantity(semi_major_axis, "semi_major_axis", "length")
    if not hasattr(distance, "unit"):
        raise InvalidInput(f"semi_major_axis is {semi_major_axis!r}; expected a Quantity or text such as '0.64 au'")
    Number("length", POSITIVE)(distance, "semi_major_axis")
    e = UNITLESS.number(eccentricity, "number", "eccentricity", Limits(least=0.0, below=1.0))
    return (constants.L_sun / (4.0 * pi * constants.c * distance**2 * sqrt(1.0 - e * e))).to(u.Pa)


@dataclass(frozen=True, eq=False, repr=False)
class Yorp(Force):
    """The mean torque of radiation on a body, averaged over its rotation and its orbit round the Sun.

    Parameters
    ----------
    on : int or str
        The body that the torque acts on.
    along, across : float, Quantity or array_like
        Components along and across the spin: torques, unless ``normalization`` says otherwise; one value, or one at
        each obliquity. A positive ``across`` raises the obliquity. The direction across is not defined for a spin along
        ``pole``, where this component is zero. A run in which an ``across`` that does not tend to zero there drives the
        spin to the pole raises :class:`fullbody.errors.ForceFailed`.
    obliquity : array_like or Quantity, optional
        Obliquities of a table, from 0 to pi, interpolated by a cubic spline.
    pole : array_like, (3,)
        Normal of the orbit round the Sun in the inertial frame, from which the obliquity is measured.
    normalization : str, optional
        ``"acceleration"``: rates of the spin, such as ``"5e-8 rad / day2"`` from light-curves; ``across`` is then the
        rate of the obliquity times the spin. ``"quillen_2022"``, ``"steinberg_sari_2011"`` and ``"rossi_2009"``: the
        dimensionless coefficients of these papers, see Notes.
    pressure, radius : float, Quantity or str, optional
        For a coefficient the pressure of sunlight, whose mean along an orbit is :func:`solar_pressure`, and the radius
        of the body, by default that of the sphere of its volume.
    name : str, optional
        Name of the force; by default ``YORP on`` the body.

    See Also
    --------
    radiation_coefficients : Computes the table of torques from a shape.

    Notes
    -----
    See Rubincam (2000). With C the largest moment of inertia the spin changes by torque ``along`` / C, and the
    obliquity by torque ``across`` / (C spin). With a coefficient f, P the pressure, R the radius and m the mass, the
    torque is f P R^3 for ``"quillen_2022"`` and (2 pi / 3) f P R^3 for ``"steinberg_sari_2011"``, and the rate of the
    spin (2/3) f P R / m for ``"rossi_2009"``, which defines ``along`` alone.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4(units=True)
    >>> yorp = fullbody.forces.Yorp("Alpha", along="1e-8 rad / day2", normalization="acceleration")
    >>> loads = system.with_forces([yorp]).loads(state)["YORP on Alpha"]
    >>> (loads.torque[0, 2] / system["Alpha"].inertia[2]).to("1 / day2")
    <Quantity 1.e-08 1 / d2>
    """

    _called = "YORP on"

    on: int | str = field(metadata=of_kind(body_index))
    along: Any
    across: Any = 0.0
    obliquity: Any = field(default=None, metadata=of_kind(Number("angle", shape=("T",))))
    pole: Any = field(default=(0.0, 0.0, 1.0), metadata=of_kind(direction))
    normalization: str | None = None
    pressure: Any = field(default=None, metadata=of_kind(Number("pressure", POSITIVE)))
    radius: Any = field(default=None, metadata=of_kind(Number("length", POSITIVE)))

    def _check(self) -> None:
        _check_normalization(self, (*_RATES, *_YORP), self.normalization not in (None, "acceleration"))
        if self.normalization == "rossi_2009" and np.any(as_quantity(self.across, f"across of {self.name}") != 0.0):
            raise InvalidInput(f"across of {self.name} is {self.across!r}; expected none, for rossi_2009 defines along")

    def _describe(self, context: Context) -> dict[str, Any]:
        units, on = context.units, self._index(context, "on")
        obliquity = [] if self.obliquity is None else self._unitless(units)["obliquity"]
        rows = max(len(obliquity), 1)
        dimension, factor = torque_dimension(self.normalization), self._factor(context, on)

        def torque(role: str) -> list[float]:
            name = self._what(role)
            array = units.numbers(getattr(self, role), dimension, name)
            if array.shape not in ((), (rows,)):
                expected = "expected a finite number, or one at each obliquity"
                raise InvalidInput(f"{name} has shape {array.shape}; {expected}")
            return [float(value) for value in factor * np.broadcast_to(array, rows)]

        described = {"kind": "Yorp", "name": self.name, "on": context.names[on], "pole": list(self.pole)}
        return described | {"obliquity": obliquity, "along": torque("along"), "across": torque("across")}

    def _factor(self, context: Context, on: int) -> float:
        """Return the factor that converts ``along`` and ``across`` in units of the system to torques."""
        if self.normalization is None:
            return 1.0
        body = context.bodies[on]
        inertia = float(np.max(body.inertia))
        if self.normalization in _RATES and inertia == 0.0:
            raise InvalidInput(f"on of {self.name} is {context.names[on]}, a point; expected a body that can rotate")
        if self.normalization == "acceleration":
            return inertia
        pressure, radius = self._unitless(context.units)["pressure"], self._radius(context, on)
        if self.normalization == "rossi_2009":
            return float(inertia * 2.0 / 3.0 * pressure * radius / body.mass)
        return float(_YORP[self.normalization] * pressure * radius**3)

    @classmethod
    def _input_warnings(cls, described: dict[str, Any], start: _core.State, context: Context) -> Iterator[str]:
        """Yield a warning of a torque that is too large for sunlight, or so small that its unit may be wrong."""
        volume = context.bodies[context.names.index(described["on"])].volume
        if not context.units.defined or volume == 0.0:
            return
        unit = context.units.number(_SOLAR_PRESSURE, "pressure", "pressure") * 0.75 * volume / pi
        size = float(np.abs([described["along"], described["across"]]).max()) / unit
        low, high = _TORQUE_RANGE
        if 0.0 < size < low or size > high:
            yield (
                f"the torque of {described['name']} is {size:.2g} times the pressure of sunlight at 1 au and the cube "
                f"of the body's radius; expected {low:g} to {high:g}: check its unit; a coefficient has a "
                "normalization, and the rate of a spin normalization='acceleration'"
            )

    def _summary(self, described: dict[str, Any], units: Units) -> str:
        if described["obliquity"]:
            return f"on {described['on']}, torques at {len(described['obliquity'])} obliquities"
        along, across = (number(units.attach(described[role][0], "torque")) for role in ("along", "across"))
        return f"on {described['on']}, {along} along and {across} across the spin"

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        table = bool(described["obliquity"])

        def torque(role: str) -> Any:
            return units.attach(np.array(described[role]) if table else described[role][0], "torque")

        obliquity = units.attach(np.array(described["obliquity"]), "angle") if table else None
        arguments = {key: described[key] for key in ("name", "on", "pole")}
        return cls(**arguments, along=torque("along"), across=torque("across"), obliquity=obliquity)


class _Components(Number):
    """Checks and converts three components along the axes of a secondary, or the middle one alone."""

    __slots__ = ()

    def unitless(self, value: Any, what: str, units: Units) -> Any:
        """Return the three components as plain numbers in a system's units."""
        array = units.numbers(value, self.dimension, what, limits=self.limits)
        if array.shape not in ((), (3,)):
            raise InvalidInput(f"{what} has shape {array.shape}; expected a finite number, or three")
        return array.tolist() if array.shape else [0.0, float(array), 0.0]

    def attached(self, value: Any, units: Units) -> Any:
        """Return the components with units: the middle one alone if the others are zero."""
        outwards, along, normal = value if isinstance(value, list) else (0.0, value, 0.0)
        return units.attach(np.array(value) if outwards or normal else along, self.dimension)


@dataclass(frozen=True, eq=False, repr=False)
class Byorp(Force):
    """The mean force and torque of radiation on a synchronous secondary, averaged over both orbits.

    Both are fixed in the secondary's body frame. Their components refer to its principal axes: the long axis, away from
    the other body; the middle axis, along the motion; and the short axis, to the side of the orbit's normal.

    They act while the secondary is locked: its short axis is within 45 degrees of the orbit's normal, and the angle psi
    of its long axis to the line to the other body is that of a pendulum which does not turn over, psi'^2 + w^2 sin^2
    psi < w^2 with w^2 = 3 (B - A)/C mu/r^3. A step ends where the lock is lost or regained, and derivatives of a run
    include the jump there. ``run.switched_off`` counts how often the lock was lost. A force so strong that the lock is
    lost whenever it acts, and regained whenever it does not, raises :class:`fullbody.errors.ForceFailed`. Where a lock
    is regained with the opposite side towards the other body, the components keep their sense along the motion.

    Parameters
    ----------
    on, about : int or str
        The secondary, and the body that it orbits.
    force : float, Quantity, str or array_like, (3,)
        The components of the force, or the one along the motion alone, which enlarges the orbit if it is positive.
        Either this or ``coefficient`` is required.
    coefficient : float or array_like, (3,)
        The components as dimensionless coefficients, which need ``normalization`` and ``pressure``.
    normalization : str
        The definition of the coefficient: ``"jacobson_scheeres_2011"``, ``"quillen_2022"``, ``"steinberg_sari_2011"``
        or ``"wang_hou_2021"``. They differ by 2 pi / 3, see Notes.
    pressure, radius : float, Quantity or str, optional
        For a coefficient the pressure of sunlight and the radius of the secondary, as for :class:`Yorp`.
    torque : Quantity or array_like, (3,), optional
        The components of the torque about the secondary's centre; zero by default.
    name : str, optional
        Name of the force; by default ``BYORP on`` the body.

    See Also
    --------
    radiation_coefficients : Computes force and torque from a shape.
    BinaryYarkovsky : The thermal force on a secondary that does not rotate synchronously.

    Notes
    -----
    According to Cuk & Burns (2005) and McMahon & Scheeres (2010), a circular orbit drifts by da/dt = 2 F / (m n), where
    F is the force along the motion, m the secondary's mass and n the mean motion. With P the pressure and R the
    secondary's radius, a coefficient f means F = f P R^2 for ``"jacobson_scheeres_2011"`` and ``"quillen_2022"``, and
    F = (2 pi / 3) f P R^2 for ``"steinberg_sari_2011"`` and ``"wang_hou_2021"``. The theory of forces in the
    documentation compares the papers' definitions.

    Examples
    --------
    The drift that McMahon & Scheeres predict for 1999 KW4 is about 7 cm a year:

    >>> import fullbody, numpy as np
    >>> from astropy import units as u
    >>> system, state = fullbody.systems.kw4(units=True)
    >>> light = {"pressure": fullbody.forces.solar_pressure("0.642 au", 0.688), "normalization": "quillen_2022"}
    >>> byorp = fullbody.forces.Byorp(on="Beta", about="Alpha", coefficient=0.02, **light)
    >>> force = system.with_forces([byorp]).loads(state)["BYORP on Beta"].force[1, 1]
    >>> (2.0 * force / system["Beta"].mass * (17.42 * u.hour / (2.0 * np.pi))).to("cm / yr")
    <Quantity 7.2090883 cm / yr>
    """

    _called = "BYORP on"

    on: int | str = field(metadata=of_kind(body_index))
    about: int | str = field(metadata=of_kind(body_index))
    force: Any = field(default=None, metadata=of_kind(_Components("force")))
    coefficient: Any = field(default=None, metadata=of_kind(_Components()))
    normalization: str | None = None
    pressure: Any = field(default=None, metadata=of_kind(Number("pressure", POSITIVE)))
    radius: Any = field(default=None, metadata=of_kind(Number("length", POSITIVE)))
    torque: Any = field(default=None, metadata=of_kind(Number("torque", shape=(3,))))

    def _check(self) -> None:
        if (self.force is None) == (self.coefficient is None):
            values = f"{self.force!r} and {self.coefficient!r}"
            raise InvalidInput(f"force and coefficient of {self.name} are {values}; expected one of the two")
        if self.coefficient is not None and self.normalization is None:
            needed = f"is not given, and coefficients differ by it; expected one of {', '.join(_BYORP)}"
            raise InvalidInput(f"normalization of {self.name} {needed}")
        _check_normalization(self, _BYORP, self.coefficient is not None)

    def _describe(self, context: Context) -> dict[str, Any]:
        arguments = super()._describe(context)
        roles = ("coefficient", "pressure", "radius", "torque")
        coefficient, pressure, _, torque = (arguments.pop(role) for role in roles)
        if self.normalization is not None:
            radius = self._radius(context, self._index(context, "on"))
            unit = _BYORP[self.normalization] * pressure * radius**2
            arguments["force"] = [unit * component for component in coefficient]
        return arguments if torque is None else arguments | {"torque": torque}

    def _summary(self, described: dict[str, Any], units: Units) -> str:
        force = number(units.attach(described["force"][1], "force"))
        return f"on {described['on']} about {described['about']}, {force} along the motion"

    @classmethod
    def _of_core(cls, described: dict[str, Any], units: Units) -> Self:
        absent = () if any(described.get("torque", ())) else ("torque",)
        return super()._of_core({name: value for name, value in described.items() if name not in absent}, units)


def _check_normalization(force: Yorp | Byorp, names: Collection[str], needs_pressure: bool) -> None:
    """Refuse an unknown normalisation, a missing pressure, and arguments of coefficients without a coefficient."""
    if force.normalization is not None:
        choice(force.normalization, f"normalization of {force.name}", names)
    if needs_pressure and force.pressure is None:
        expected = "expected that of sunlight, such as fullbody.forces.solar_pressure('0.64 au', 0.69)"
        raise InvalidInput(f"pressure of {force.name} is not given; {expected}")
    unused = ("pressure", "radius", *(("normalization",) if isinstance(force, Byorp) else ()))
    for role in () if needs_pressure else unused:
        if (value := getattr(force, role)) is not None:
            raise InvalidInput(f"{role} of {force.name} is {value!r}; expected none without a coefficient")
