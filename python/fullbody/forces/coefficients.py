"""Radiation coefficients: the recoil of sunlight on a shape, as Fourier series over its rotation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import pi
from typing import Any, Literal

import numpy as np

import fullbody._core as _core

from ..base.arguments import directions, refuse_mixture, warn_if_degrees
from ..base.kinds import Number, instance, whole_number
from ..base.limits import POSITIVE, Limits
from ..base.tables import Table, Tabled, number
from ..base.units import UNITLESS, is_quantity, without_unit
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..model.bodies import Body
from ..model.force import radius_of
from ..model.shapes import inferred_units
from ..typing import Array, Floats
from .radiation import Byorp, Yorp

#: Number of true anomalies in a mean over the orbit round the Sun.
_ANOMALIES = 360
#: Obliquities of the table of a body's coefficients, in degrees.
_OBLIQUITIES = (0.0, 30.0, 60.0, 90.0)
_OBLIQUITY = Limits(least=0.0, most=pi + 1e-12, text="an obliquity from 0 to pi")


@dataclass(frozen=True, eq=False, repr=False)
class RadiationCoefficients(ArrayFields, Tabled):
    """Fourier coefficients of the force and the torque of sunlight on a rotating body, from its shape.

    At the latitude delta and the longitude lambda of the Sun the force on the body is, with P the pressure of sunlight,

    ``F = P [A_0(delta) + sum_n A_n(delta) cos(n lambda) + B_n(delta) sin(n lambda)]``,

    and the torque about its centre of mass is a series of the same form with C_n and D_n: the definition of McMahon &
    Scheeres (2010). All vectors have the components along the body's long, middle and short principal axes, the axes of
    its smallest, middle and largest moments of inertia. The latitude is measured from the plane of the first two and
    the longitude from the long axis. The body rotates about the short axis in the positive sense.

    Attributes
    ----------
    on : str or None
        Name of the body.
    radius : float or Quantity
        Radius of the sphere of the body's volume.
    latitude : ndarray, (K,)
        Evenly spaced latitudes of the Sun from -pi/2 to pi/2, in radians.
    force_cosine, force_sine : ndarray or Quantity, (K, N + 1, 3)
        A_n and B_n: areas.
    torque_cosine, torque_sine : ndarray or Quantity, (K, N + 1, 3)
        C_n and D_n: volumes.
    outwards : int
        Whether the positive long axis points away from the other body, 1, or to it, -1.

    See Also
    --------
    radiation_coefficients : Computes them for a body.
    """

    on: str | None
    radius: Any
    latitude: Floats
    force_cosine: Array
    force_sine: Array
    torque_cosine: Array
    torque_sine: Array
    outwards: int = field(default=1)

    def __repr__(self) -> str:
        rows, orders = self.force_cosine.shape[:2]
        radius = number(self.radius, 6)
        return f"RadiationCoefficients(on={self.on!r}, radius={radius}, order {orders - 1} at {rows} latitudes)"

    def spin_torques(self, obliquity: Any = 0.0) -> tuple[Any, Any]:
        """Compute the mean torques along and across the spin for unit pressure, over the rotation and the orbit.

        Parameters
        ----------
        obliquity : float, array_like or Quantity
            Angles from the normal of the orbit round the Sun to the spin.

        Returns
        -------
        along, across : ndarray or Quantity
            Volumes, of the shape of ``obliquity``. A positive ``across`` raises the obliquity.

        Examples
        --------
        >>> import fullbody
        >>> beta = fullbody.systems.kw4(shape="radar")[0]["Beta"]
        >>> along, across = fullbody.forces.radiation_coefficients(beta).spin_torques([0.0, 1.0])
        >>> (along / beta.shape.volume).round(7), abs(across / beta.shape.volume).round(7)
        (array([8.06e-05, 4.68e-05]), array([0.00e+00, 9.09e-05]))
        """
        angle = _obliquities(obliquity)
        cosine, sine = without_unit(self.torque_cosine), without_unit(self.torque_sine)
        # The mean over a fast rotation of the torque towards the meridian of the Sun. That across it is a function of
        # the latitude times cos(nu), whose mean over the orbit is zero.
        meridian = 0.5 * (cosine[:, 1, 0] + sine[:, 1, 1])
        along = _orbit_mean(cosine[:, 0, 2], angle)
        # The longitude of the Sun has the sine cos(obliquity) sin(nu) / cos(latitude).
        across = np.cos(angle) * _orbit_mean(meridian, angle, by_sine=True)
        return self._with_unit(along, self.torque_cosine), self._with_unit(across, self.torque_cosine)

    def synchronous_force(self, obliquity: Any = 0.0) -> Any:
        """Compute the mean force (..., 3) on a synchronous body for unit pressure, an area.

        The mean is over the rotation, which is the orbit round the other body, and over the orbit round the Sun.

        Parameters
        ----------
        obliquity : float, array_like or Quantity
            Angles from the normal of the orbit round the Sun to that of the mutual orbit.

        Examples
        --------
        >>> import fullbody
        >>> beta = fullbody.systems.kw4(shape="radar")[0]["Beta"]
        >>> coefficients = fullbody.forces.radiation_coefficients(beta)
        >>> (coefficients.synchronous_force() / coefficients.radius**2).round(4)
        array([ 0.0182, -0.0202,  0.0186])
        """
        return self._synchronous(self.force_cosine, obliquity)

    def synchronous_torque(self, obliquity: Any = 0.0) -> Any:
        """Compute the mean torque (..., 3) about the centre of mass of a synchronous body for unit pressure, a volume.

        Examples
        --------
        >>> import fullbody
        >>> ball = fullbody.Body(fullbody.Sphere(1.0), mass=1.0)
        >>> bool(abs(fullbody.forces.radiation_coefficients(ball).synchronous_torque()).max() < 1e-13)
        True
        """
        return self._synchronous(self.torque_cosine, obliquity)

    def yorp(self, pressure: Any, *, on: int | str | None = None, pole: Any = (0.0, 0.0, 1.0), rows: int = 37) -> Yorp:
        """Return the torque of YORP on the body, as a table at obliquities from 0 to pi.

        Parameters
        ----------
        pressure : float, Quantity or str
            Mean pressure of sunlight, see :func:`solar_pressure`.
        on : int or str, optional
            The body in its system; by default that of the body's name.
        pole : array_like, (3,)
            Normal of the orbit round the Sun.
        rows : int
            Number of obliquities.

        Examples
        --------
        >>> import fullbody
        >>> beta = fullbody.systems.kw4(shape="radar", units=True)[0]["Beta"]
        >>> yorp = fullbody.forces.radiation_coefficients(beta).yorp("1e-5 Pa", rows=5)
        >>> yorp.along.to("N m").round(3)
        <Quantity [ 0.039,  0.04 , -0.055,  0.04 ,  0.039] N m>
        """
        pressure, on = self._pressure(pressure), self._body(on)
        obliquity = np.linspace(0.0, pi, whole_number(rows, "rows", 4))
        along, across = self.spin_torques(obliquity)
        return Yorp(on, pressure * along, pressure * across, obliquity=obliquity, pole=pole)

    def byorp(self, about: int | str, pressure: Any, *, on: int | str | None = None, obliquity: Any = 0.0) -> Byorp:
        """Return the force and torque of BYORP on the body as a synchronous secondary.

        Parameters
        ----------
        about : int or str
            The body about which it moves.
        pressure, on
            As for :meth:`yorp`.
        obliquity : float or Quantity
            Angle from the normal of the orbit round the Sun to that of the mutual orbit.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4(shape="radar", units=True)
        >>> coefficients = fullbody.forces.radiation_coefficients(system["Beta"], towards=(1, 0, 0))
        >>> byorp = coefficients.byorp("Alpha", fullbody.forces.solar_pressure("0.642 au", 0.688))
        >>> byorp.force.to("N").round(4)
        <Quantity [-0.0141,  0.0156,  0.0144] N>
        """
        pressure, on = self._pressure(pressure), self._body(on)
        angle = UNITLESS.number(obliquity, "angle", "obliquity", _OBLIQUITY)
        senses = np.array([self.outwards, self.outwards, 1.0])
        force, torque = (pressure * senses * mean(angle) for mean in (self.synchronous_force, self.synchronous_torque))
        return Byorp(on, about, force, torque=torque)

    def _synchronous(self, coefficients: Any, obliquity: Any) -> Any:
        angle = _obliquities(obliquity)
        means = [_orbit_mean(without_unit(coefficients)[:, 0, k], angle) for k in range(3)]
        return self._with_unit(np.stack(means, axis=-1), coefficients)

    @staticmethod
    def _with_unit(value: Any, coefficients: Any) -> Any:
        return value << coefficients.unit if is_quantity(coefficients) else value

    def _body(self, on: int | str | None) -> int | str:
        if (body := self.on if on is None else on) is None:
            raise InvalidInput("on is not given, and the body has no name; expected the index or the name of a body")
        return body

    def _pressure(self, pressure: Any) -> Any:
        pressure = Number("pressure", POSITIVE)(pressure, "pressure")
        refuse_mixture({"pressure": pressure, f"radius of {self.on or 'the body'}": self.radius})
        return pressure

    def _tables(self) -> tuple[Table, ...]:
        """Return a table of the dimensionless coefficients at a few obliquities."""
        angle = np.radians(_OBLIQUITIES)
        radius = float(without_unit(self.radius))
        along, across = (without_unit(torque) / radius**3 for torque in self.spin_torques(angle))
        byorp = self.outwards * without_unit(self.synchronous_force(angle))[:, 1] / radius**2
        columns = zip(_OBLIQUITIES, along, across, byorp, strict=True)
        head = ("obliquity [deg]", "YORP along", "YORP across", "BYORP")
        # Values that are zero by symmetry have no digits.
        rows: list[Sequence[str]] = [[number(round(float(value), 12) + 0.0, 4) for value in row] for row in columns]
        return (Table(f"Radiation coefficients of {self.on or 'a body'} (quillen_2022)", head, rows),)


def radiation_coefficients(
    body: Body,
    *,
    other: Body | None = None,
    position: Any = None,
    towards: Any = None,
    order: int = 4,
    latitudes: int = 91,
    longitudes: int = 180,
) -> RadiationCoefficients:
    """Compute the radiation coefficients of a body from its shape, as :class:`RadiationCoefficients` defines them.

    The surface reflects and radiates by Lambert's law and has no thermal inertia: a lit area A with the normal n takes
    the force ``-P A (n.s) (s + 2/3 n)`` in sunlight of the pressure P from the direction s, whatever its albedo. The
    body's own facets cast shadows, and so does another body at a fixed place in its frame, as the primary of a
    synchronous secondary is. Light from one facet to another is neglected.

    Parameters
    ----------
    body : Body
        A polyhedron with its own faces; an ellipsoid, which has 5,120 facets of its area; or a composite of both, whose
        parts hide each other and count as far as they are outside of each other. Parts of negative mass count like any
        other. A point and Stokes coefficients have no surface.
    other : Body, optional
        A body that casts its shadow on the first one. It keeps its place in the body frame, and its axes are parallel.
    position : array_like or Quantity, (3,)
        The place of the centre of ``other`` in the body frame.
    towards : array_like, (3,), optional
        The direction in the body frame to the body about which a synchronous secondary moves, for
        :meth:`RadiationCoefficients.byorp`; by default that of ``position``, or else of the negative long axis.
    order : int
        The highest order N of the series, at least one.
    latitudes, longitudes : int
        The numbers of latitudes of the Sun, which has to be odd, and of longitudes, which has to be even.

    Raises
    ------
    InvalidInput
        For a body without a surface, for one of ``other`` and ``position`` without the other one, and for numbers of
        latitudes and longitudes that do not fit.
    BodiesOverlap
        If the other body overlaps the first one at its place.

    Notes
    -----
    Coefficients are exact for polyhedra up to the rule of equal longitudes, whose error falls at least with the square
    of their number. For a body with the symmetry of an ellipsoid all secular effects are zero up to round-off. The
    definition is that of McMahon & Scheeres (2010), Icarus 209, 494, as the program YORPLib of the first author has it.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4(shape="radar", units=True)
    >>> fullbody.forces.radiation_coefficients(system["Beta"], towards=(1, 0, 0))
    RadiationCoefficients(on='Beta', radius=0.225504 km, order 4 at 91 latitudes)
    """
    instance(body, "body", Body)
    if (other is None) != (position is None):
        raise InvalidInput(f"other and position are {other!r} and {position!r}; expected both or neither")
    bodies = [body] if other is None else [body, instance(other, "other", Body)]
    numbers = ((k, *entry) for k, item in enumerate(bodies) for entry in item._numbers().items())
    units = inferred_units({f"{k} {label}": number for k, label, number in numbers})
    core, *shading = (item._core(units, k) for k, item in enumerate(bodies))
    positions = np.zeros((0, 3)) if other is None else units.numbers(position, "length", "position", (3,))[None]
    axes = _principal_axes(core)
    line = -axes[:, 0] if towards is None else directions(towards, "towards", single=True)
    if towards is None and other is not None:
        line = positions[0]
    if not (projection := float(line @ axes[:, 0])):
        raise InvalidInput(f"towards is {line}; expected a direction that is not normal to the body's long axis")
    order = whole_number(order, "order")
    latitude = np.linspace(-0.5 * pi, 0.5 * pi, _count(latitudes, "latitudes", 5, "odd"))
    count = _count(longitudes, "longitudes", 2 * order + 2, "even")
    to_sun = _directions(latitude, count) @ axes.T
    loads = _core.recoil(core, shading, positions, np.ascontiguousarray(to_sun.reshape(-1, 3)))
    series = [_series(load.reshape(*to_sun.shape) @ axes, order) for load in loads]
    length = units.attach(1.0, "length")
    powers = length**2, length**3
    force, torque = ((cosine * power, sine * power) for (cosine, sine), power in zip(series, powers, strict=True))
    radius = units.attach(radius_of(core.volume), "length")
    return RadiationCoefficients(body.name, radius, latitude, *force, *torque, outwards=-1 if projection > 0.0 else 1)


def _count(value: object, name: str, least: int, parity: Literal["odd", "even"]) -> int:
    """Return a whole number that is odd or even."""
    number = whole_number(value, name, least)
    if number % 2 != (parity == "odd"):
        raise InvalidInput(f"{name} is {number}; expected an {parity} number, {least} or more")
    return number


def _principal_axes(core: _core.Body) -> Floats:
    """Return the long, the middle and the short principal axis of a body as columns, a right-handed frame."""
    axes = np.eye(3)[:, np.argsort(core.inertia, kind="stable")]
    axes[:, 1] *= np.linalg.det(axes)
    return axes


def _directions(latitude: Floats, count: int) -> Floats:
    """Return unit vectors (K, count, 3) to the Sun at latitudes and at evenly spaced longitudes."""
    longitude = 2.0 * pi * np.arange(count) / count
    cosine = np.cos(latitude)[:, None]
    z = np.broadcast_to(np.sin(latitude)[:, None], (len(latitude), count))
    return np.stack([cosine * np.cos(longitude), cosine * np.sin(longitude), z], axis=-1)


def _series(values: Floats, order: int) -> tuple[Floats, Floats]:
    """Return the coefficients of cosines and sines of functions (K, count, 3) at evenly spaced longitudes."""
    series = np.fft.rfft(values, axis=1)[:, : order + 1] / values.shape[1]
    series[:, 1:] *= 2.0
    return series.real, -series.imag


def _obliquities(obliquity: Any) -> Floats:
    warn_if_degrees(obliquity, "obliquity")
    return UNITLESS.numbers(obliquity, "angle", "obliquity", None, _OBLIQUITY)


def _orbit_mean(values: Floats, obliquity: Floats, by_sine: bool = False) -> Floats:
    """Return means over the orbit round the Sun of a function of its latitude, one for each obliquity.

    The mean over time of the pressure times a function is the mean pressure times the mean of the function over the
    true anomaly, whatever the eccentricity. The function is given at evenly spaced latitudes, and is taken for a series
    of cosines of the polar distance. With ``by_sine`` it vanishes at the poles, is a series of sines, and is multiplied
    by the sine of the angle nu from the node over the cosine of the latitude.
    """
    nu = 2.0 * pi * (np.arange(_ANOMALIES) + 0.5) / _ANOMALIES
    polar_distance = np.arccos(np.clip(np.sin(obliquity)[..., None] * np.sin(nu), -1.0, 1.0))
    values, order = values[::-1], len(values) - 1
    sign = -1.0 if by_sine else 1.0
    extended = np.fft.rfft(np.concatenate([values, sign * values[-2:0:-1]])) / order
    orders = np.arange(order + 1)
    if by_sine:
        # The ratio sin(k x) / sin(x) is finite at the poles, which the angles nu, being between the nodes, do not meet.
        ratios = np.sin(polar_distance[..., None] * orders) / np.sin(polar_distance)[..., None]
        return (ratios @ -extended.imag * np.sin(nu)).mean(axis=-1)
    coefficients = extended.real
    coefficients[[0, -1]] *= 0.5
    return (np.cos(polar_distance[..., None] * orders) @ coefficients).mean(axis=-1)
