"""Sudden changes of a state: kicks, impacts and rotations of one body."""

from __future__ import annotations

from typing import Any, Literal, Protocol, Self, TypeVar

import numpy as np

import fullbody._core as _core

from ..base import rotations
from ..base.arguments import directions, index_of, warn_if_degrees
from ..base.kinds import Number, choice
from ..base.limits import LATITUDE, POSITIVE
from ..base.units import UNITLESS, Units, is_quantity, strip_to
from ..errors import InvalidInput
from ..typing import Floats
from .context import SystemLike


class StateLike(Protocol):
    """The numbers, units and names of a state, which is a :class:`fullbody.State`: that class uses these functions."""

    core: _core.State
    units: dict[str, Any]
    names: tuple[str, ...]

    def in_units(self, units: Units) -> _core.State:
        """Return the core's state in a system's units."""

    def replace(self, **changes: Any) -> Self:
        """Return a copy with some arrays changed."""


_State = TypeVar("_State", bound=StateLike)


def kick(
    state: _State,
    body: int | str,
    dv: Any,
    *,
    along: Literal["inertial", "body", "orbit"] = "inertial",
    about: int | str | None = None,
) -> _State:
    """Return the state after a sudden change of one body's velocity.

    Parameters
    ----------
    body : int or str
        The index of the body, or its name if the state comes from a run, a system or a ready-made start.
    dv : array_like or Quantity, (3,)
        The change of its velocity, with a unit if the state has units.
    along : {"inertial", "body", "orbit"}
        The axes of the components of ``dv``: the inertial ones, the body's own, or those of its orbit, which are radial
        (from the other body to this one), transverse (in the orbit's plane, along the motion) and normal to the plane.
    about : int or str, optional
        The other body of the orbit for ``along="orbit"``; needed only if there are more than two bodies.

    Raises
    ------
    InvalidInput
        If there is no such body; if there are several other bodies and ``about`` is not given; and if the body moves
        along the line to the other one, which defines no plane.

    Notes
    -----
    Spin and all positions stay the same. An impact that transfers the momentum p gives dv = p / m; for a spacecraft of
    momentum p_0 that is beta p_0, where beta is the factor by which ejecta enhance it. :meth:`impact` computes dv from
    the projectile, with the change of the spin.

    Examples
    --------
    DART changed the velocity of Dimorphos by 2.70 mm/s against its motion (Cheng et al. 2023, Nature 616, 457):

    >>> import fullbody
    >>> from astropy import units as u
    >>> system, before = fullbody.systems.didymos(units=True)
    >>> after = before.kick("Dimorphos", [0, -2.70, 0] * u.mm / u.s, along="orbit")
    >>> run = system.integrate(after, "20 day", output="0.5 hour")
    >>> print(f"{fullbody.observables.mutual_period(run).mean:.2f}")
    11.37 h
    """
    index = _index(state, body, "body of kick")
    dv = Number("velocity", shape=(3,))(dv, "dv")
    axes = _axes(state, index, along, about, "kick")
    if is_quantity(dv) and not state.units:
        raise InvalidInput(f"dv has the unit {dv.unit}, but the state has none; expected both or neither")
    if not is_quantity(dv) and state.units and np.any(dv):
        unit = next(iter(state.units.values()))
        raise InvalidInput(f"the state has units such as {unit}, but dv has none; expected both or neither")
    # Velocities of zero may have been given without a unit.
    unit, velocity = state.units.get("velocity", getattr(dv, "unit", None)), state.core.velocity
    velocity[index] += axes @ (strip_to(dv, unit, "dv") if is_quantity(dv) else dv)
    return state.replace(velocity=velocity if unit is None else velocity << unit)


def impact(
    state: _State,
    system: SystemLike,
    body: int | str,
    *,
    mass: Any,
    velocity: Any,
    longitude: Any,
    latitude: Any,
    beta: Any = 1.0,
    ejecta: Any = None,
    along: Literal["inertial", "body", "orbit"] = "inertial",
    about: int | str | None = None,
) -> _State:
    """Return the state after a projectile has struck a body's surface, which changes the body's velocity and spin.

    Parameters
    ----------
    system : System
        The system, which gives masses, moments of inertia and surfaces.
    mass : float or Quantity
        Mass of the projectile. The body keeps its own mass, shape and centre of mass.
    velocity : array_like or Quantity, (3,)
        Velocity of the projectile relative to the body's centre.
    longitude, latitude : float, Quantity or text
        Direction from the body's centre in its frame, in which the outermost point of the surface is struck.
    beta : float
        The factor by which ejecta enhance the momentum along their direction: 1 without ejecta.
    ejecta : array_like, (3,), optional
        The direction of the net momentum of the ejecta, of any length; by default the surface's outward normal.
    body, along, about
        The body that is struck, and the axes of ``velocity`` and ``ejecta``, as for :meth:`kick`.

    Raises
    ------
    InvalidInput
        For a body without a surface, for a velocity that points away from the surface, and as for :meth:`kick`.

    Notes
    -----
    Let U be the velocity of the projectile relative to the surface where it strikes, and E the direction of the ejecta.
    The body receives the momentum p = m U + m (beta - 1) (E.U) E (Cheng et al. 2023, Nature 616, 457), and the angular
    momentum r x p about its centre, where r is the point that is struck.

    Examples
    --------
    A projectile with the mass, the speed and the beta of DART (Cheng et al. 2023) comes from straight ahead:

    >>> import fullbody, numpy as np
    >>> system, before = fullbody.systems.didymos(units=True)
    >>> options = {"velocity": ["0 km/s", "-6.14 km/s", "0 km/s"], "along": "orbit", "beta": 3.61}
    >>> after = before.impact(
    ...     system, "Dimorphos", mass="579.4 kg", longitude="-90 deg", latitude=0.0, **options)
    >>> dv = (after.velocity - before.velocity)[1].to("mm/s")
    >>> float(np.linalg.norm(dv.value).round(1))
    2.6
    """
    index = _index(state, body, "body of impact")
    axes = _axes(state, index, along, about, "impact")
    context = system.context
    units, core = context.units, state.in_units(context.units)
    amount = units.number(mass, "mass", "mass of the projectile", POSITIVE)
    coming = units.numbers(velocity, "velocity", "velocity of the projectile", (3,))
    enhanced = units.number(beta, "angle", "beta")
    lon, lat = units.number(longitude, "angle", "longitude"), units.number(latitude, "angle", "latitude", LATITUDE)
    warn_if_degrees(longitude, "longitude")
    (point,), (normal,) = _core.surface(context.core, index, rotations.unit_vectors(lon, lat)[None])
    rotation, velocities, spins = core.rotation_matrix[index], core.velocity, core.spin
    # This is the velocity in the body frame, relative to the surface at the point that is struck.
    relative = rotation.T @ (axes @ coming) - np.cross(spins[index], point)
    if relative @ normal >= 0.0:
        speed = units.text(relative @ normal, "velocity", 4)
        raise InvalidInput(
            f"velocity of the projectile is {velocity!r}, by which it leaves the surface there at {speed} along the "
            "normal; expected one that comes from outside, relative to the body's centre"
        )
    out = normal if ejecta is None else rotation.T @ (axes @ directions(ejecta, "ejecta", single=True))
    out = out / np.linalg.norm(out)
    momentum = amount * (relative + (enhanced - 1.0) * (out @ relative) * out)
    velocities[index] += rotation @ momentum / context.bodies[index].mass
    spins[index] += np.cross(point, momentum) / context.bodies[index].inertia
    return state.replace(
        time=units.attach(core.time, "time"),
        position=units.attach(core.position, "length"),
        velocity=units.attach(velocities, "velocity"),
        spin=units.attach(spins, "spin"),
    )


def rotated(
    state: _State,
    body: int | str,
    axis: Any,
    angle: Any,
    *,
    along: Literal["inertial", "body", "orbit"] = "body",
    about: int | str | None = None,
) -> _State:
    """Return the state with one body rotated about an axis through its centre.

    The body rotates together with its spin: the components of the spin in the body frame do not change.

    Parameters
    ----------
    axis : array_like, (3,)
        The axis, of any length.
    angle : float or Quantity
        The angle of the rotation, right-handed about the axis; floats are radians.
    body, along, about
        The body, and the axes of the components of ``axis``, as for :meth:`kick`.

    Raises
    ------
    InvalidInput
        As for :meth:`kick`, and for an axis of length zero.

    Warns
    -----
    InconsistentInput
        For angles that look like degrees: plain numbers beyond two turns with six decimals at most.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> system, state = fullbody.systems.didymos()
    >>> rotated = state.rotated("Dimorphos", [0, 0, 1], np.radians(10))
    >>> run = system.integrate(rotated, 1.0)
    >>> round(float(np.degrees(fullbody.observables.roll_pitch_yaw(run)[0, 2])), 6)
    10.0
    """
    index = _index(state, body, "body of rotated")
    direction = _axes(state, index, along, about, "rotated") @ directions(axis, "axis", single=True)
    attitude = state.core.attitude
    rotation = rotations.about(direction, UNITLESS.number(angle, "angle", "angle"))
    # No rotation is larger than a full one, or in a state with units larger than half of one.
    warn_if_degrees(angle, "angle", 0.5 if state.units else 1.0)
    attitude[index] = rotations.product(rotation, attitude[index])
    return state.replace(attitude=attitude)


def _index(state: StateLike, body: object, what: str) -> int:
    """Return the index of a body from its index or name."""
    if isinstance(body, str) and not state.names:
        raise InvalidInput(
            f"{what} is {body!r}, and this state does not know the names of its bodies (states of runs and of "
            f"ready-made systems do); expected an index, 0 to {len(state.core.position) - 1}"
        )
    return index_of(body, state.names or [f"body {k}" for k in range(len(state.core.position))], what)


def _axes(state: StateLike, index: int, along: str, about: int | str | None, what: str) -> Floats:
    """Return the axes ``along`` which vectors of a body have their components, as columns (3, 3)."""
    if choice(along, f"along of {what}", ("inertial", "body", "orbit")) != "orbit":
        if about is not None:
            raise InvalidInput(f"about of {what} is {about!r}, along is {along!r}; expected about with 'orbit' only")
        return np.eye(3) if along == "inertial" else state.core.rotation_matrix[index]
    if about is None:
        count = len(state.core.position) - 1
        if count != 1:
            raise InvalidInput(
                f"about of {what} is not given, and there are {count} other bodies; expected one of them"
            )
        about = 1 - index
    other = _index(state, about, f"about of {what}")
    if other == index:
        raise InvalidInput(f"about of {what} is {about!r}, the body itself; expected another one")
    r = state.core.position[index] - state.core.position[other]
    v = state.core.velocity[index] - state.core.velocity[other]
    normal = np.cross(r, v)
    size = np.linalg.norm(normal)
    if size <= 1e-14 * np.linalg.norm(r) * np.linalg.norm(v):
        raise InvalidInput(
            f"body {index} moves along its line to body {other}, or not at all; along='orbit' of {what} needs the "
            "plane of an orbit"
        )
    radial, normal = r / np.linalg.norm(r), normal / size
    return np.stack([radial, np.cross(normal, radial), normal], axis=1)
