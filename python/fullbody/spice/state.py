"""SPICE's conventions of time, length, axes and numbers of bodies, and states of a system from its kernels."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..base import epochs, rotations
from ..base.arguments import integer, sequence, suggestion
from ..base.kinds import instance
from ..base.units import need
from ..errors import InvalidInput
from ..frames import rotation
from ..model.context import SystemLike
from ..model.state import State, from_numbers


def state(
    system: SystemLike,
    ids: dict[str, int],
    barycentre: int,
    *,
    time: Any = 0.0,
    kernels: Sequence[Any] = (),
    frames: dict[str, str] | None = None,
) -> State:
    """Read the state of a system at a time from SPICE kernels.

    Parameters
    ----------
    system : System
        A system with units, an epoch and a frame.
    ids : dict of int
        NAIF's numbers of all bodies, by their names.
    barycentre : int
        NAIF's number of the point to which positions refer.
    time : float or Quantity
        Time of the state, since the system's epoch.
    kernels : sequence of paths
        Kernels to load for the call, in addition to those already loaded, which may suffice.
    frames : dict of str, optional
        The frame along the principal axes of each body, by its name; by default the frame that SPICE takes as fixed to
        the body. A point needs none.

    Returns
    -------
    State
        Geometric state, in the system's axes and units, relative to the barycentre.

    Raises
    ------
    InvalidInput
        For a system without units, epoch or frame, and if the kernels lack a body's position or attitude.

    Notes
    -----
    Astropy converts the epoch to TDB, so that no kernel of leap seconds is needed.

    Examples
    --------
    >>> import fullbody, tempfile
    >>> system, start = fullbody.systems.didymos(units=True)
    >>> run = system.integrate(start, 12.0, dense=True)
    >>> ids = {"Didymos": 920065803, "Dimorphos": 120065803}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     kernels = [run.to_spk(f"{folder}/run.bsp", ids, barycentre=20065803), *run.to_ck(f"{folder}/run.bc", ids)]
    ...     found = fullbody.spice.state(system, ids, barycentre=20065803, time=6.0, kernels=kernels)
    >>> float(abs(found.spin - run(6.0).spin).max().value) < 1e-11
    True
    """
    conventions = Conventions(system, "a state from SPICE")
    context, spice = system.context, spiceypy()
    numbers, observer = body_numbers(ids, context.names), number(barycentre, "barycentre")
    if missing := [name for k, name in enumerate(context.names) if k not in numbers]:
        raise InvalidInput(f"ids has no number of {missing[0]}; expected those of {', '.join(context.names)}")
    named = dict(instance(frames or {}, "frames", Mapping, "names of frames by those of bodies"))
    for name, frame in named.items():
        context.index(name, "a body in frames")
        instance(frame, f"frame of {name}", str, "the name of a frame")
    moment = context.units.number(time, "time", "time")
    et = float(conventions.et(moment))
    position, velocity, spin = (np.zeros((len(context), 3)) for _ in range(3))
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (len(context), 1))
    with loaded(kernels):
        for k, name in enumerate(context.names):
            body = numbers[k]
            with _explaining(f"the position of {name} ({body}) from {observer}", system, time):
                state_vector, _ = spice.spkgeo(body, et, "J2000", observer)
            position[k], velocity[k] = np.reshape(state_vector, (2, 3)) @ conventions.axes / conventions.km
            if name in named or any(context.bodies[k].semi_axes):
                with _explaining(f"the attitude of {name} ({body})", system, time):
                    frame = named.get(name) or spice.cidfrm(body)[1]
                    transformation = spice.sxform(frame, "J2000", et)
                matrix = transformation[:3, :3]
                attitude[k] = rotations.quaternion(conventions.axes.T @ matrix)
                # The rate of the matrix is the matrix times the vector product with the spin.
                cross = matrix.T @ transformation[3:, :3]
                spin[k] = cross[2, 1], cross[0, 2], cross[1, 0]
    second = conventions.second
    return from_numbers(context, position, velocity * second, attitude, spin * second, moment)


@contextmanager
def _explaining(what: str, system: SystemLike, time: Any) -> Iterator[None]:
    """Context manager that raises errors of SPICE as errors that name the missing data."""
    errors = spiceypy().utils.exceptions
    try:
        yield
    except (errors.SpiceyError, errors.NotFoundError) as error:
        date = f"{time} after {system.context.epoch}"
        raise InvalidInput(f"the kernels do not contain {what} at {date}: {message_of(error)}") from error


@contextmanager
def loaded(kernels: Sequence[Any]) -> Iterator[None]:
    """Context manager with these kernels loaded."""
    spice = spiceypy()
    if isinstance(kernels, str | bytes | os.PathLike):
        raise InvalidInput(f"kernels is {kernels!r}; expected a sequence of paths")
    kind: Any = str | bytes | os.PathLike
    added: list[str] = []
    try:
        for name in map(os.fspath, sequence(kernels, kind, "kernels", "a sequence of paths", "paths")):
            try:
                spice.furnsh(name)
            except spice.utils.exceptions.SpiceyError as error:
                raise InvalidInput(f"{name} is not a kernel that SPICE can load: {message_of(error)}") from error
            added.append(name)
        yield
    finally:
        # A kernel that was loaded twice stays loaded once.
        for name in reversed(added):
            spice.unload(name)


def spiceypy() -> Any:
    """Import the package spiceypy, or raise an error that says how to install it."""
    with need("spice", "a SPICE kernel"):
        import spiceypy
    return spiceypy


def message_of(error: Exception) -> str:
    """Return the message of an error of SPICE in one line."""
    return str(getattr(error, "long", "") or getattr(error, "explain", "") or error).strip()


class Conventions:
    """The conversions of a system's times and vectors to SPICE's.

    The system's units of length in km and of time in s are ``km`` and ``second``, ``axes`` (3, 3) is the matrix from
    the system's axes to those of J2000, and ``epoch`` is time zero in seconds of TDB past J2000.
    """

    def __init__(self, system: SystemLike, what: str) -> None:
        spiceypy()
        missing = {
            "units": (system.context.units.names, "units=('km', 'hour', 'kg')"),
            "epoch": (system.context.epoch, "epoch='2022-09-26T00:00:00 TDB'"),
            "frame": (system.context.frame, "frame='ecliptic'"),
        }
        for name, (value, example) in missing.items():
            if value is None:
                raise InvalidInput(f"{what} needs the system's {name}; give fullbody.System(..., {example})")
        self.km = float(system.context.units.unit("length").to("km"))
        self.second = float(system.context.units.unit("time").to("s"))
        self.axes = rotation(system.context.frame, "equatorial")
        date = epochs.to_time(str(system.context.epoch)).tdb
        # The fraction of the day has digits that would be lost in the number of days.
        self.epoch = float((date.jd1 - 2451545.0) * 86400.0 + date.jd2 * 86400.0)

    def et(self, time: Any) -> Any:
        """Convert times of the system to seconds of TDB past J2000, which doubles today resolve to 1e-7 s."""
        return self.epoch + np.asarray(time) * self.second

    def time(self, et: Any) -> Any:
        """Convert seconds of TDB past J2000 to times of the system."""
        return (np.asarray(et) - self.epoch) / self.second


def number(value: object, what: str) -> int:
    """Check a body's number with NAIF."""
    numbers = integer(value)
    if numbers is None or numbers == 0 or not abs(numbers) < 2**31:
        raise InvalidInput(f"{what} is {value!r}; expected the number that NAIF gives it, such as 120065803")
    return numbers


def body_numbers(values: Any, names: tuple[str, ...]) -> dict[int, int]:
    """Return NAIF's number of each named body by its index in the system."""
    try:
        pairs = dict(values).items()
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"ids is {values!r}; expected NAIF's numbers by name, such as {_example(names)}") from error
    numbers: dict[int, int] = {}
    for name, value in pairs:
        if name not in names:
            raise InvalidInput(f"ids has {name!r}; {suggestion(str(name), names, 'names of bodies:')}")
        index, code = names.index(name), number(value, f"the id of {name}")
        if code in numbers.values():
            raise InvalidInput(f"the id of {name} is {code}, that of another body; expected distinct numbers")
        numbers[index] = code
    if not numbers:
        raise InvalidInput(f"ids names no body; expected such as {_example(names)}")
    return numbers


def _example(names: tuple[str, ...]) -> dict[str, int]:
    return {name: 20000000 + 100000000 * (9 if k == 0 else k) + 65803 for k, name in enumerate(names[:3])}
