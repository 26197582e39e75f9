"""The state of a system."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar, cast

import numpy as np

import fullbody._core as _core

from ..base import rotations
from ..base.arguments import refuse_unknown, warn_if_degrees
from ..base.attributes import Attribute
from ..base.kinds import Number, choice, instance
from ..base.limits import POSITIVE
from ..base.tables import Table, Tabled, head, number, vector
from ..base.unit_names import unit_named
from ..base.units import ANY, UNITLESS, Units, as_quantity, is_quantity, numbers, scalar, without_unit
from ..base.values import ArrayFields, block
from ..errors import InvalidInput, caution
from ..typing import Array, Floats, Scalar
from .changes import impact, kick, rotated
from .context import Context

_T = TypeVar("_T")
#: The parts of a state beside the time, in the order of the core.
PARTS = ("position", "velocity", "attitude", "spin")
#: The dimensions of the parts of a state that have one.
DIMENSIONS = {"time": "time", "position": "length", "velocity": "velocity", "spin": "spin"}


class _Part(Attribute[_T]):
    """A property of states: a part of the core's state, with its unit."""

    def __init__(self, name: str, text: str) -> None:
        def get(state: State) -> Any:
            value = getattr(state.core, name)
            if isinstance(value, np.ndarray):
                # The array is a copy of the core's numbers, so that writing to it would not change the state.
                value.flags.writeable = False
            return value << state.units[name] if name in state.units else value

        super().__init__(get, text)


class State(ArrayFields, Tabled):
    """The position, velocity, attitude and spin of every body at a time.

    A state cannot be changed and its arrays are read-only: :meth:`replace` makes another state, and
    ``state.position.copy()`` is an array that can be written to.

    Parameters
    ----------
    position, velocity : array_like or Quantity, (N, 3)
        Positions and velocities of the centres in the inertial frame, both with a unit or none; zeros need none.
    attitude : array_like, (N, 4), optional
        Quaternions ``[w, x, y, z]`` that rotate body-frame vectors into the inertial frame, no rotation by default.
        They are scaled to unit length.
    spin : array_like or Quantity, (N, 3), optional
        Angular velocities in the body frames in radians per unit time; zero by default.
    time : float or Quantity
        Time in the system's units.

    Raises
    ------
    InvalidInput
        For values that are not finite, for wrong shapes, for a quaternion of length zero, and if only some of position,
        velocity, spin and time have units.

    Warns
    -----
    InconsistentInput
        For a quaternion whose length differs from 1 by more than a thousandth.

    Examples
    --------
    >>> import fullbody
    >>> state = fullbody.State(position=[[0, 0, 0], [2.5, 0, 0]], velocity=[[0, 0, 0], [0, 0.9, 0]])
    >>> state.attitude
    array([[1., 0., 0., 0.],
           [1., 0., 0., 0.]])
    """

    #: The core's state, the names of the bodies (none for a new state), and the units of its parts that have one.
    __slots__ = ("core", "names", "units")

    kick = kick
    impact = impact
    rotated = rotated

    def __init__(self, position: Any, velocity: Any, attitude: Any = None, spin: Any = None, time: Any = 0.0) -> None:
        quaternions = None if attitude is None else numbers(attitude, "attitude")
        self._fill(_core.State, quaternions, time=time, position=position, velocity=velocity, spin=spin)
        if quaternions is not None:
            _warn_of_lengths(quaternions)

    def _fill(self, make: Callable[..., _core.State], attitude: Any, **arguments: Any) -> None:
        """Make the core's state from attitudes or angles, no rotation by default, and the other parts."""
        self.names: tuple[str, ...] = ()
        parts, self.units = _strip(**arguments)
        if attitude is None:
            attitude = np.tile([1.0, 0.0, 0.0, 0.0], (len(np.atleast_1d(parts["position"])), 1))
        self.core = make(scalar(parts["time"], "time"), parts["position"], parts["velocity"], attitude, parts["spin"])

    @classmethod
    def from_tait_bryan(cls, position: Any, velocity: Any, angles: Any, spin: Any = None, time: Any = 0.0) -> State:
        """Make a state from the paper's angles instead of quaternions.

        Parameters
        ----------
        angles : array_like or Quantity, (N, 3)
            The angles (phi, theta, psi) of R = Rz(psi) Ry(theta) Rx(phi), the paper's ``eq:RotationMatrix``; floats are
            radians.
        position, velocity, spin, time
            As for the class.

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
        state, radians = cls.__new__(cls), UNITLESS.strip(angles, "angle", "angles")
        state._fill(_core.State.from_tait_bryan, radians, time=time, position=position, velocity=velocity, spin=spin)
        warn_if_degrees(angles, "angles")
        return state

    @classmethod
    def from_scipy(cls, position: Any, velocity: Any, rotation: Any, spin: Any = None, time: Any = 0.0) -> State:
        """Make a state from rotations of scipy; the way back is ``Rotation.from_matrix(state.rotation_matrix)``.

        Parameters
        ----------
        rotation : scipy.spatial.transform.Rotation
            A Rotation that holds N rotations, or a sequence of N of them. They rotate body-frame vectors into the
            inertial frame, as :attr:`rotation_matrix` does.
        position, velocity, spin, time
            As for the class.

        Examples
        --------
        >>> import fullbody
        >>> from scipy.spatial.transform import Rotation
        >>> state = fullbody.State.from_scipy(
        ...     position=[[0, 0, 0], [2.5, 0, 0]], velocity=[[0, 0, 0], [0, 0.9, 0]],
        ...     rotation=Rotation.from_euler("z", [[0], [90]], degrees=True))
        >>> (state.rotation_matrix[1] @ [1, 0, 0]).round(12)
        array([0., 1., 0.])
        """
        rotations = [rotation] if hasattr(rotation, "as_quat") else rotation
        try:
            # The scalar is last by default in all versions of scipy.
            last = np.concatenate([np.atleast_2d(rotation.as_quat()) for rotation in rotations])
        except (TypeError, AttributeError, ValueError) as error:
            expected = "expected a scipy.spatial.transform.Rotation of one rotation a body, or a list of them"
            raise InvalidInput(f"rotation is {rotation!r}; {expected}") from error
        return cls(position, velocity, np.roll(last, 1, axis=-1), spin, time)

    @classmethod
    def rotating(
        cls,
        body: Any,
        longitude: Any,
        latitude: Any,
        period: Any,
        angle: Any = 0.0,
        *,
        axis: str = "z",
        time: Any = 0.0,
    ) -> State:
        """Make the state of a body alone, at rest in the origin, that rotates about a fixed pole.

        Parameters
        ----------
        body : Body
        longitude, latitude : float or Quantity
            The direction of the pole in the frame of the system; plain numbers are radians.
        period : float or Quantity
            The sidereal period.
        angle : float or Quantity
            The rotation angle, as in :func:`fullbody.frames.attitude`.
        axis : {"z", "principal"}
            The axis of the body along the pole: the z-axis of its working frame, or the principal axis next to that,
            about which the body does not wobble. The rotation between the two is the smallest one.
        time : float or Quantity

        Examples
        --------
        >>> import fullbody, numpy as np
        >>> body = fullbody.Body(fullbody.Ellipsoid(3.0, 2.0, 1.0), mass=1.0)
        >>> state = fullbody.State.rotating(body, 0.0, np.pi / 2, period=2 * np.pi)
        >>> state.spin, (state.rotation_matrix[0] @ [1.0, 0.0, 0.0]).round(12)
        (array([[0., 0., 1.]]), array([0., 1., 0.]))
        """
        choice(axis, "axis", ("z", "principal"))
        frame = body.working_frame
        # The axes of the working frame in the body frame.
        working = np.array([1.0, 0.0, 0.0, 0.0]) if frame is None else np.asarray(frame.attitude)
        along = rotations.matrices(working)[:, 2]
        if axis == "principal":
            nearest = int(np.argmax(np.abs(along)))
            principal = np.eye(3)[nearest] * np.copysign(1.0, along[nearest])
            working, along = rotations.product(rotations.shortest(along, principal), working), principal
        angles = {"longitude": longitude, "latitude": latitude, "angle": angle}
        lon, lat, rotation = (float(UNITLESS.strip(value, "angle", what)) for what, value in angles.items())
        equator = rotations.of_plane(lon + 0.5 * np.pi, 0.5 * np.pi - lat)
        attitude = rotations.product(equator, rotations.about_axis(2, rotation), rotations.inverse(working))
        length = Number("time", POSITIVE)(period, "period")
        radian = unit_named("rad") if is_quantity(length) else 1.0
        spin = along[None] * (2.0 * np.pi * radian / length)
        return cls(np.zeros((1, 3)), np.zeros((1, 3)), [attitude], spin, time)

    def in_units(self, units: Units) -> _core.State:
        """Return the core's state in a system's units."""
        if not self.units:
            return self.core
        if units.defined and all(self.units.get(name) is units.unit(d) for name, d in DIMENSIONS.items()):
            return self.core
        values = {name: units.strip(getattr(self, name), d, name) for name, d in DIMENSIONS.items()}
        if all(np.array_equal(values[name], getattr(self.core, name)) for name in DIMENSIONS):
            return self.core
        return _core.State(
            float(values["time"]), values["position"], values["velocity"], self.core.attitude, values["spin"]
        )

    time = _Part[Scalar]("time", "Time of the state.")
    position = _Part[Array]("position", "Positions of the centres (N, 3), inertial frame.")
    velocity = _Part[Array]("velocity", "Velocities of the centres (N, 3), inertial frame.")
    attitude = _Part[Floats]("attitude", "Unit quaternions (N, 4), ``[w, x, y, z]``, body frame to inertial.")
    spin = _Part[Array]("spin", "Angular velocities (N, 3), body frames.")
    rotation_matrix = _Part[Floats]("rotation_matrix", "Rotation matrices (N, 3, 3), body frame to inertial.")
    tait_bryan = _Part[Floats](
        "tait_bryan", "The paper's angles (N, 3): phi and psi in (-pi, pi], theta in [-pi/2, pi/2], radians."
    )

    def replace(self, **changes: Any) -> State:
        """Return a copy with some of ``position``, ``velocity``, ``attitude``, ``spin`` and ``time`` changed.

        Examples
        --------
        >>> import fullbody
        >>> state = fullbody.State(position=[[0, 0, 0]], velocity=[[0, 0, 0]])
        >>> state.replace(time=3.0).time
        3.0
        """
        names = (*PARTS, "time")
        refuse_unknown(changes, names, "State.replace")
        return _named(self.names, *(changes.get(name, getattr(self, name)) for name in names))

    def __len__(self) -> int:
        return len(self.core.position)

    def _parts(self) -> tuple[Any, ...]:
        return (*(getattr(self.core, name) for name in ("time", *PARTS)), self.units)

    def _tables(self) -> tuple[Table, ...]:
        """Return a table of position, velocity, attitude and spin, one body per row, by name or else index."""
        columns = [without_unit(getattr(self, name)) for name in PARTS]
        header = ["body", *(head(name, getattr(getattr(self, name), "unit", "")) for name in PARTS)]
        bodies = self.names or [str(k) for k in range(len(self))]
        rows = [(body, *(vector(column[k]) for column in columns)) for k, body in enumerate(bodies)]
        return (Table(f"State at time {number(self.time)}", header, list(rows)),)

    def __repr__(self) -> str:
        parts = {name: getattr(self, name) for name in PARTS}
        return block(f"State(time={self.time},", **parts)

    def __reduce__(self) -> Any:
        return _named, (self.names, *(getattr(self, name) for name in PARTS), self.time)


def wrap(core: _core.State, context: Context) -> State:
    """Return the core's state with the units and the names of a system."""
    state = State.__new__(State)
    state.core, state.names, units = core, context.names, context.units
    state.units = {name: units.unit(d) for name, d in DIMENSIONS.items()} if units.defined else {}
    return state


def sample(arrays: Mapping[str, Floats], k: int) -> _core.State:
    """Return the state of a sample, by its index in arrays of times, positions and so on, as the core takes it."""
    parts = (np.ascontiguousarray(arrays[name][k]) for name in PARTS)
    return _core.State(float(arrays["time"][k]), *parts)


def from_numbers(
    context: Context, position: Any, velocity: Any, attitude: Any = None, spin: Any = None, time: Any = 0.0
) -> State:
    """Return the state of a system from numbers in its units."""
    return wrap(State(position, velocity, attitude, spin, time).core, context)


def strip(state: State, context: Context) -> _core.State:
    """Return the core's state, in the units of a system, of a :class:`State`; other objects are refused."""
    return cast(State, instance(state, "state", State)).in_units(context.units)


def _named(names: tuple[str, ...], *arguments: Any) -> State:
    state = State(*arguments)
    state.names = names
    return state


def _warn_of_lengths(attitude: Any) -> None:
    """Warn of the first quaternion whose length differs from 1 by more than rounding to three digits can cause."""
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(attitude, axis=1)
    for body in np.flatnonzero(abs(lengths - 1.0) > 1e-3)[:1]:
        caution(
            f"attitude of body {body} is {attitude[body].tolist()}, of length {lengths[body]:.6g}, and is scaled to 1; "
            "expected a unit quaternion [w, x, y, z], its scalar first"
        )


def _strip(**values: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the numbers and the units of the dimensional parts of a state."""
    stripped: dict[str, Any] = {}
    units: dict[str, Any] = {}
    for name, value in values.items():
        if name == "spin" and value is None:
            continue
        value = as_quantity(value, name, DIMENSIONS[name])
        stripped[name] = ANY.strip(value, DIMENSIONS[name], name)
        if is_quantity(value):
            units[name] = value.unit
    first = next((name for name in ("position", "velocity", "spin", "time") if name in units), None)
    for name, value in stripped.items():
        if first is not None and name not in units and value.any():
            expected = "expected both or neither, or zeros"
            raise InvalidInput(f"{first} has the unit {units[first]}, but {name} has none; {expected}")
    if "spin" not in stripped:
        stripped["spin"] = np.zeros_like(stripped["position"])
        if "position" in units:
            units["spin"] = unit_named("rad / s")
    return stripped, units
