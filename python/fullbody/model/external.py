"""External forces on the bodies in a state, and where third bodies are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.values import ArrayFields, ByName, block
from ..typing import Array
from .context import SystemLike
from .failures import explaining
from .state import State, strip


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Loads(ArrayFields):
    """The loads of one external force in a state.

    Attributes
    ----------
    force : ndarray or Quantity, (N, 3)
        Forces in the inertial frame. For a third body they are the part that moves the bodies relative to the nominal
        barycentre.
    torque : ndarray or Quantity, (N, 3)
        Torques about each body's centre, in its body frame.
    """

    force: Array
    torque: Array

    def __repr__(self) -> str:
        return block("Loads(", force=self.force, torque=self.torque)


def loads(system: SystemLike, state: State) -> dict[str, Loads]:
    """Return the :class:`~fullbody.model.Loads` of each external force in a state, by its name.

    The nominal barycentre, about which a third body's path places it, is that of the state.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> tide = fullbody.forces.Tide(on="Alpha", by="Beta", k2=1e-5, lag=0.01)
    >>> system.with_forces([tide]).loads(state)["tide on Alpha"].force.shape
    (2, 3)
    """
    context = system.context
    core, attach = strip(state, context), context.units.attach
    with explaining(context, core):
        forces, torques = context.core.external_loads(core)
    both = zip(context.forces, forces, torques, strict=True)
    return ByName({name: Loads(attach(force, "force"), attach(torque, "torque")) for name, force, torque in both})


def third_body(system: SystemLike, name: str, time: Any) -> tuple[Array, Array]:
    """Return the position and velocity of a third body relative to the system's nominal barycentre.

    Parameters
    ----------
    name : str
        Name of a :class:`fullbody.forces.ThirdBody` of the system.
    time : float, Quantity or array_like, () or (K,)

    Returns
    -------
    position, velocity : ndarray or Quantity, (3,) or (K, 3)
    """
    context = system.context
    index, times = context.third_body(name, "name"), context.units.strip(time, "time", "time")
    both = context.core.third_body(index, np.atleast_1d(times))
    position, velocity = (array.reshape(*times.shape, 3) for array in both)
    return context.units.attach(position, "length"), context.units.attach(velocity, "velocity")
