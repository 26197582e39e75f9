"""States of a system from SPICE kernels."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..base import rotations
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..model.state import State, from_numbers
from .conventions import Conventions, body_numbers, message_of, number, spiceypy


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
    named = dict(frames or {})
    for name in named:
        context.index(name, "a body in frames")
    moment = context.units.number(time, "time", "time")
    et = float(conventions.et(moment))
    position, velocity, spin = (np.zeros((len(context), 3)) for _ in range(3))
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (len(context), 1))
    with loaded(kernels):
        for k, name in enumerate(context.names):
            body = numbers[k]
            with _telling(f"the position of {name} ({body}) from {observer}", system, time):
                state_vector, _ = spice.spkgeo(body, et, "J2000", observer)
            position[k], velocity[k] = np.reshape(state_vector, (2, 3)) @ conventions.axes / conventions.km
            if name in named or any(context.bodies[k].semi_axes):
                with _telling(f"the attitude of {name} ({body})", system, time):
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
def _telling(what: str, system: SystemLike, time: Any) -> Iterator[None]:
    """Context manager that adds to an error of SPICE what the kernels lack."""
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
    added: list[str] = []
    try:
        for name in map(os.fspath, kernels):
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
