"""The state of a system."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import rotations
from ..base.arguments import directions, place, refuse_unknown, vectors, warn_if_degrees
from ..base.tables import Table, Tabled, head, number, vector
from ..base.units import Units, gathered, is_quantity, numbers, refuse_cycles, scalar, strip_to, unit_named
from ..base.values import block
from ..errors import InvalidInput, caution
from ..typing import Array, Scalar
from .context import Context, SystemLike

__all__ = ["State", "strip", "wrap"]

_FIELDS = {"time": "time", "position": "length", "velocity": "velocity", "spin": "spin"}


class State(Tabled):
    """The position, velocity, attitude and spin of every body at a time.

    A state cannot be changed and its arrays are read-only: :meth:`replace` makes another state, and
    ``state.position.copy()`` is an array that can be written to.

    Parameters
    ----------
    position : array_like or Quantity, (N, 3)
        Positions of the centres in the inertial frame.
    velocity : array_like or Quantity, (N, 3)
        Velocities of the centres in the inertial frame, with a unit if the positions have one; zeros need none.
    attitude : array_like, (N, 4), optional
        Quaternions ``[w, x, y, z]`` that turn body-frame vectors into the inertial frame. They are scaled to unit
        length, with a warning if this changes them by more than a thousandth. By default the body frames are parallel
        to the inertial one.
    spin : array_like or Quantity, (N, 3), optional
        Angular velocities in the body frames in radians per unit time (also if the unit is 1/time); zero by default.
    time : float or Quantity
        Time in the system's units.

    Raises
    ------
    InvalidInput
        For values that are not finite, for wrong shapes, for a quaternion of length zero, and if only some of position,
        velocity, spin and time have units; zeros need none.

    Warns
    -----
    InconsistentInput
        For a quaternion whose length is not 1.

    Examples
    --------
    >>> import fullbody
    >>> state = fullbody.State(position=[[0, 0, 0], [2.5, 0, 0]], velocity=[[0, 0, 0], [0, 0.9, 0]])
    >>> state.attitude
    array([[1., 0., 0., 0.],
           [1., 0., 0., 0.]])
    """

    __slots__ = ("_core", "_names", "_units")

    def __init__(
        self,
        position: Any,
        velocity: Any,
        attitude: Any = None,
        spin: Any = None,
        time: Any = 0.0,
    ) -> None:
        self._names: tuple[str, ...] = ()
        values, self._units = _strip(time=time, position=position, velocity=velocity, spin=spin)
        if attitude is None:
            attitude = np.tile([1.0, 0.0, 0.0, 0.0], (len(np.atleast_1d(values["position"])), 1))
        attitude = numbers(attitude, "attitude")
        self._core = _core.State(
            scalar(values["time"], "time"), values["position"], values["velocity"], attitude, values["spin"]
        )
        _warn_of_lengths(attitude)

    @classmethod
    def from_tait_bryan(
        cls,
        position: Any,
        velocity: Any,
        angles: Any,
        spin: Any = None,
        time: Any = 0.0,
    ) -> State:
        """Make a state from the paper's angles instead of quaternions.

        Parameters
        ----------
        position, velocity, spin, time
            Arguments of :class:`State`.
        angles : array_like or Quantity, (N, 3)
            The angles (phi, theta, psi) of R = Rz(psi) Ry(theta) Rx(phi), the paper's ``eq:RotationMatrix``; floats are
            radians.

        Returns
        -------
        State

        Warns
        -----
        InconsistentInput
            For angles that look like degrees: plain numbers beyond two turns with six decimals at most.

        Examples
        --------
        >>> import fullbody, numpy as np
        >>> state = fullbody.State.from_tait_bryan(
        ...     position=[[0, 0, 0]], velocity=[[0, 0, 0]], angles=[[0, 0, np.pi / 2]])
        >>> (state.rotation_matrix[0] @ [1, 0, 0]).round(12)
        array([0., 1., 0.])
        """
        state = cls.__new__(cls)
        state._names = ()
        values, state._units = _strip(time=time, position=position, velocity=velocity, spin=spin)
        state._core = _core.State.from_tait_bryan(
            scalar(values["time"], "time"),
            values["position"],
            values["velocity"],
            Units().strip(angles, "angle", "angles"),
            values["spin"],
        )
        warn_if_degrees(angles, "angles")
        return state

    @classmethod
    def from_scipy(cls, position: Any, velocity: Any, rotation: Any, spin: Any = None, time: Any = 0.0) -> State:
        """Make a state from rotations of scipy, whose quaternions have the scalar last.

        Parameters
        ----------
        position, velocity, spin, time
            Arguments of :class:`State`.
        rotation : scipy.spatial.transform.Rotation
            A Rotation that holds N rotations, or a sequence of N of them. They turn body-frame vectors into the
            inertial frame, as :attr:`rotation_matrix` does.

        Returns
        -------
        State

        Examples
        --------
        >>> import fullbody
        >>> from scipy.spatial.transform import Rotation
        >>> state = fullbody.State.from_scipy(
        ...     position=[[0, 0, 0], [2.5, 0, 0]], velocity=[[0, 0, 0], [0, 0.9, 0]],
        ...     rotation=Rotation.from_euler("z", [[0], [90]], degrees=True))
        >>> (state.rotation_matrix[1] @ [1, 0, 0]).round(12)
        array([0., 1., 0.])

        The way back is ``Rotation.from_matrix(state.rotation_matrix)``.
        """
        rotations = [rotation] if hasattr(rotation, "as_quat") else rotation
        try:
            # The scalar is last by default in all versions of scipy.
            last = np.concatenate([np.atleast_2d(one.as_quat()) for one in rotations])
        except (TypeError, AttributeError, ValueError) as error:
            raise InvalidInput(
                f"rotation is {rotation!r}; expected a scipy.spatial.transform.Rotation of one rotation a body, or a "
                "list of them"
            ) from error
        return cls(position, velocity, np.roll(last, 1, axis=-1), spin, time)

    @classmethod
    def _wrap(cls, core: _core.State, units: Units, names: tuple[str, ...]) -> State:
        state = cls.__new__(cls)
        state._core = core
        state._units = {name: units.unit(d) for name, d in _FIELDS.items()} if units.known else {}
        state._names = names
        return state

    def _named(self, names: tuple[str, ...]) -> State:
        """Return the state with the names of its bodies."""
        return self._with(self._core, names)

    def _with(self, core: _core.State, names: tuple[str, ...]) -> State:
        """Return a state of other numbers or names, in the units of this one."""
        state = State.__new__(State)
        state._core, state._units, state._names = core, self._units, names
        return state

    def _in(self, units: Units) -> _core.State:
        """Return the core's state in a system's units."""
        if not self._units:
            return self._core
        if units.known and all(self._units.get(name) is units.unit(d) for name, d in _FIELDS.items()):
            return self._core
        values = {name: units.strip(getattr(self, name), d, name) for name, d in _FIELDS.items()}
        if all(np.array_equal(values[name], getattr(self._core, name)) for name in _FIELDS):
            return self._core
        return _core.State(
            float(values["time"]), values["position"], values["velocity"], self._core.attitude, values["spin"]
        )

    def _get(self, name: str) -> Any:
        value = getattr(self._core, name)
        if isinstance(value, np.ndarray):
            # The array is a copy of the core's numbers, so that writing to it would not change the state.
            value.flags.writeable = False
        return value << self._units[name] if name in self._units else value

    def _array(self, name: str) -> Array:
        array: Array = self._get(name)
        return array

    @property
    def time(self) -> Scalar:
        """Time of the state."""
        time: Scalar = self._get("time")
        return time

    @property
    def position(self) -> Array:
        """Positions of the centres (N, 3), inertial frame."""
        return self._array("position")

    @property
    def velocity(self) -> Array:
        """Velocities of the centres (N, 3), inertial frame."""
        return self._array("velocity")

    @property
    def attitude(self) -> npt.NDArray[np.float64]:
        """Unit quaternions (N, 4), ``[w, x, y, z]``, body frame to inertial."""
        return self._array("attitude")

    @property
    def spin(self) -> Array:
        """Angular velocities (N, 3), body frames."""
        return self._array("spin")

    @property
    def rotation_matrix(self) -> npt.NDArray[np.float64]:
        """Rotation matrices (N, 3, 3), body frame to inertial."""
        return self._array("rotation_matrix")

    @property
    def tait_bryan(self) -> npt.NDArray[np.float64]:
        """The paper's angles (N, 3): phi and psi in (-pi, pi], theta in [-pi/2, pi/2], radians."""
        return self._array("tait_bryan")

    def replace(self, **changes: Any) -> State:
        """Return a copy with some of ``position``, ``velocity``, ``attitude``, ``spin`` and ``time`` changed.

        Examples
        --------
        >>> import fullbody
        >>> state = fullbody.State(position=[[0, 0, 0]], velocity=[[0, 0, 0]])
        >>> state.replace(time=3.0).time
        3.0
        """
        names = ("position", "velocity", "attitude", "spin", "time")
        refuse_unknown(changes, names, "State.replace")
        return State(**{name: changes.get(name, getattr(self, name)) for name in names})._named(self._names)

    def kick(
        self,
        body: int | str,
        dv: Any,
        *,
        along: Literal["inertial", "body", "orbit"] = "inertial",
        about: int | str | None = None,
    ) -> State:
        """Return the state after a sudden change of one body's velocity.

        Parameters
        ----------
        body : int or str
            The place of the body, or its name if the state comes from a run, a system or a ready-made start.
        dv : array_like or Quantity, (3,)
            The change of its velocity, with a unit if the state has units.
        along : {"inertial", "body", "orbit"}
            The axes of the components of ``dv``: the inertial ones, the body's own, or those of its orbit, which are
            radial (from the other body to this one), transverse (in the orbit's plane, along the motion) and normal to
            the plane.
        about : int or str, optional
            The other body of the orbit for ``along="orbit"``; needed only if there are more than two bodies.

        Returns
        -------
        State

        Raises
        ------
        InvalidInput
            If there is no such body; if there are several other bodies and ``about`` is not given; and if the body
            moves along the line to the other one, which defines no plane.

        Notes
        -----
        Only this body is pushed, through its centre: its spin and all positions stay the same. The total momentum grows
        by its mass times ``dv``, so that the velocity of the barycentre changes by ``dv`` times the body's share of the
        total mass, and the body's velocity relative to each other body changes by ``dv``. An impact that transfers the
        momentum p gives dv = p / m; for a spacecraft of momentum p_0 the transferred momentum is beta p_0, where beta
        is the factor by which ejecta enhance it. :meth:`impact` computes dv from the projectile, with the change of the
        spin.

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
        index = self._place(body, "body of kick")
        dv = vectors(dv, "dv", one=True)
        axes = self._axes(index, along, about, "kick")
        velocity = self._core.velocity
        if not is_quantity(dv):
            if self._units and dv.any():
                unit = next(iter(self._units.values()))
                raise InvalidInput(f"the state has units such as {unit}, but dv has none; expected both or neither")
            velocity[index] += axes @ dv
            return self.replace(velocity=velocity << self._units["velocity"] if "velocity" in self._units else velocity)
        if not self._units:
            raise InvalidInput(f"dv has the unit {dv.unit}, but the state has none; expected both or neither")
        # Velocities of zero may have been given without a unit.
        unit = self._units.get("velocity", dv.unit)
        velocity[index] += axes @ strip_to(dv, unit, "dv")
        return self.replace(velocity=velocity << unit)

    def impact(
        self,
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
    ) -> State:
        """Return the state after a projectile has struck a body's surface, which changes the body's velocity and spin.

        Parameters
        ----------
        system : System
            The system, which gives masses, moments of inertia and surfaces.
        body : int or str
            The place of the body that is struck, or its name.
        mass : float or Quantity
            Mass of the projectile. The body keeps its own mass, shape and centre of mass.
        velocity : array_like or Quantity, (3,)
            Velocity of the projectile relative to the body's centre.
        longitude, latitude : float, Quantity or text
            Direction from the body's centre in its frame, in which the outermost point of the surface is struck.
        beta : float
            The factor by which ejecta enhance the momentum along their direction: 1 without ejecta.
        ejecta : array_like, (3,), optional
            The direction of the net momentum of the ejecta, of any length; by default the outward normal of the
            surface.
        along : {"inertial", "body", "orbit"}
            The axes of the components of ``velocity`` and ``ejecta``, as for :meth:`kick`.
        about : int or str, optional
            The other body of the orbit for ``along="orbit"``; needed only if there are more than two bodies.

        Returns
        -------
        State

        Raises
        ------
        InvalidInput
            For a body without a surface, for a velocity that points away from the surface, and for the same reasons as
            :meth:`kick`.

        Notes
        -----
        Let U be the velocity of the projectile relative to the surface where it strikes, and E the direction of the
        ejecta. The body receives the momentum p = m U + m (beta - 1) (E.U) E (Cheng et al. 2023, Nature 616, 457), and
        the angular momentum r x p about its centre, where r is the point that is struck.

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
        from .impact import impulse

        index = self._place(body, "body of impact")
        axes = self._axes(index, along, about, "impact")
        core = strip(self, system.context)
        dv, spin_up = impulse(system, core, index, axes, mass, velocity, longitude, latitude, beta, ejecta)
        velocities, spins = core.velocity, core.spin
        velocities[index] += dv
        spins[index] += spin_up
        changed = _core.State(core.time, core.position, velocities, core.attitude, spins)
        return State._wrap(changed, system.context.units, self._names)

    def rotated(
        self,
        body: int | str,
        axis: Any,
        angle: Any,
        *,
        along: Literal["inertial", "body", "orbit"] = "body",
        about: int | str | None = None,
    ) -> State:
        """Return the state with one body turned about an axis through its centre.

        The body turns together with its spin: the components of the spin in the body frame do not change.

        Parameters
        ----------
        body : int or str
            The place of the body, or its name; see :meth:`kick`.
        axis : array_like, (3,)
            The axis, of any length.
        angle : float or Quantity
            The angle of the turn, right-handed about the axis; floats are radians.
        along : {"body", "inertial", "orbit"}
            The axes of the components of ``axis``: the body's own, the inertial ones, or radial, transverse and normal;
            see :meth:`kick`.
        about : int or str, optional
            The other body of the orbit for ``along="orbit"``; see :meth:`kick`.

        Returns
        -------
        State

        Raises
        ------
        InvalidInput
            For the same reasons as :meth:`kick`, and for an axis of length zero.

        Warns
        -----
        InconsistentInput
            For angles that look like degrees: plain numbers beyond two turns with six decimals at most.

        Examples
        --------
        Dimorphos is turned by ten degrees about its pole:

        >>> import fullbody, numpy as np
        >>> system, state = fullbody.systems.didymos()
        >>> turned = state.rotated("Dimorphos", [0, 0, 1], np.radians(10))
        >>> run = system.integrate(turned, 1.0)
        >>> round(float(np.degrees(fullbody.observables.roll_pitch_yaw(run)[0, 2])), 6)
        10.0
        """
        index = self._place(body, "body of rotated")
        way = self._axes(index, along, about, "rotated") @ directions(axis, "axis", one=True)
        attitude = self._core.attitude
        turn = rotations.about(way, Units().number(angle, "angle", "angle"))
        # No body is turned by more than a turn, or in a state with units by more than half of one.
        warn_if_degrees(angle, "angle", 0.5 if self._units else 1.0)
        attitude[index] = rotations.product(turn, attitude[index])
        core = self._core
        turned = _core.State(core.time, core.position, core.velocity, attitude, core.spin)
        return self._with(turned, self._names)

    def _place(self, body: object, what: str) -> int:
        """Return the place of a body from its place or name."""
        if isinstance(body, str) and not self._names:
            raise InvalidInput(
                f"{what} is {body!r}, and this state does not know the names of its bodies (states of runs and of "
                f"ready-made systems do); expected a place, 0 to {len(self) - 1}"
            )
        return place(body, self._names or [f"body {k}" for k in range(len(self))], what)

    def _axes(self, index: int, along: str, about: int | str | None, what: str) -> Any:
        """Return as columns (3, 3) the axes in which vectors of a body are given."""
        if not isinstance(along, str) or along not in ("inertial", "body", "orbit"):
            raise InvalidInput(f"along of {what} is {along!r}; expected 'inertial', 'body' or 'orbit'")
        if along != "orbit":
            if about is not None:
                raise InvalidInput(
                    f"about of {what} is {about!r}, along is {along!r}; expected about with 'orbit' only"
                )
            return np.eye(3) if along == "inertial" else self._core.rotation_matrix[index]
        if about is None:
            others = [k for k in range(len(self)) if k != index]
            if len(others) != 1:
                raise InvalidInput(
                    f"about of {what} is not given, and there are {len(others)} other bodies; expected one of them"
                )
            about = others[0]
        other = self._place(about, f"about of {what}")
        if other == index:
            raise InvalidInput(f"about of {what} is {about!r}, the body itself; expected another one")
        r = self._core.position[index] - self._core.position[other]
        v = self._core.velocity[index] - self._core.velocity[other]
        normal = np.cross(r, v)
        size = np.linalg.norm(normal)
        if size <= 1e-14 * np.linalg.norm(r) * np.linalg.norm(v):
            raise InvalidInput(
                f"body {index} moves along its line to body {other}, or not at all; along='orbit' of {what} needs the "
                "plane of an orbit"
            )
        radial, normal = r / np.linalg.norm(r), normal / size
        return np.stack([radial, np.cross(normal, radial), normal], axis=1)

    def __len__(self) -> int:
        return len(self._core.position)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, State):
            return NotImplemented
        names = ("time", "position", "velocity", "attitude", "spin")
        same = all(np.array_equal(getattr(self._core, n), getattr(other._core, n)) for n in names)
        return same and self._units == other._units

    __hash__ = None  # type: ignore[assignment]

    def _tables(self) -> tuple[Table, ...]:
        """Return a table of position, velocity, attitude and spin, one body per row, by name or else index."""
        names = ("position", "velocity", "attitude", "spin")
        columns = [np.asarray(getattr(getattr(self, name), "value", getattr(self, name))) for name in names]
        header = ["body", *(head(name, getattr(getattr(self, name), "unit", "")) for name in names)]
        bodies = self._names or [str(k) for k in range(len(self))]
        rows = [(body, *(vector(column[k]) for column in columns)) for k, body in enumerate(bodies)]
        return (Table(f"State at time {number(self.time)}", header, list(rows)),)

    def __repr__(self) -> str:
        parts = {name: getattr(self, name) for name in ("position", "velocity", "attitude", "spin")}
        return block(f"State(time={self.time},", **parts)

    def __reduce__(self) -> Any:
        arguments = (self.position, self.velocity, self.attitude, self.spin, self.time)
        return (_rebuild, (self._names, *arguments))


def wrap(core: _core.State, context: Context) -> State:
    """Return the core's state with the units and the names of a system."""
    return State._wrap(core, context.units, context.names)


def strip(state: State, context: Context) -> _core.State:
    """Return a state as the core takes it, in the units of a system, or raise an error for what is not a state."""
    if not isinstance(state, State):
        raise InvalidInput(f"state is {state!r}; expected a State")
    return state._in(context.units)


def _rebuild(names: tuple[str, ...], *arguments: Any) -> State:
    return State(*arguments)._named(names)


#: A unit that each part of a state can be converted to.
_EXPECTED = {"time": "s", "position": "m", "velocity": "m / s", "spin": "rad / s"}


@lru_cache(maxsize=1024)
def _with_angle(unit: Any) -> Any:
    """Return the unit of a spin; a rate without an angle is taken as radians per time."""
    from astropy import units as u

    return u.rad * unit if unit.is_equivalent(u.s**-1) else unit


def _strip(**values: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the numbers and the units of the dimensional parts of a state."""
    stripped: dict[str, Any] = {}
    units: dict[str, Any] = {}
    for name, value in values.items():
        if name == "spin" and value is None:
            continue
        value = gathered(value, name, _FIELDS[name])
        if not is_quantity(value):
            stripped[name] = numbers(value, name)
            continue
        unit = value.unit
        if name == "spin":
            refuse_cycles(unit, name)
            unit = _with_angle(unit)
        strip_to(value, unit_named(_EXPECTED[name]), name)
        stripped[name] = strip_to(value, unit, name)
        units[name] = unit
    _refuse_mixture(stripped, units)
    if "spin" not in stripped:
        stripped["spin"] = np.zeros_like(stripped["position"])
        if "position" in units:
            from astropy import units as u

            units["spin"] = u.rad / u.s
    return stripped, units


def _warn_of_lengths(attitude: Any) -> None:
    """Warn of the first quaternion whose length differs from 1 by more than rounding to three digits can cause."""
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(attitude, axis=1)
    for body in np.flatnonzero(abs(lengths - 1.0) > 1e-3)[:1]:
        caution(
            f"attitude of body {body} is {attitude[body].tolist()}, of length {lengths[body]:.6g}, and is scaled to 1; "
            "expected a unit quaternion [w, x, y, z], its scalar first"
        )


def _refuse_mixture(stripped: dict[str, Any], units: dict[str, Any]) -> None:
    """Raise an error if some parts have a unit and others do not; zeros need none."""
    united = next((name for name in ("position", "velocity", "spin", "time") if name in units), None)
    for name, value in stripped.items():
        if united is not None and name not in units and value.any():
            raise InvalidInput(
                f"{united} has the unit {units[united]}, but {name} has none; expected both or neither, or zeros"
            )
