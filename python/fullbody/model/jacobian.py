"""The derivatives of forces, torques and rates at a state."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..base.arguments import names_of
from ..base.values import ArrayFields
from ..typing import Array, Floats
from .context import SystemLike
from .failures import explaining
from .state import State, strip


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Jacobian(ArrayFields):
    """Derivatives of forces, torques and rates of change at a state.

    Rotations are small rotation vectors theta in each body's own frame: the rotation matrix R becomes R exp(theta).

    Attributes
    ----------
    force_by_position, force_by_rotation : ndarray or Quantity, (N, 3, N, 3)
        Derivatives of the forces in the inertial frame: ``force_by_position[i, :, j, :]`` is the derivative of the
        force on body i with respect to the position of body j.
    torque_by_position, torque_by_rotation : ndarray or Quantity, (N, 3, N, 3)
        Derivatives of the torques, in body frames.
    flow : ndarray, (12 N,)
        The rates of change: per body velocity, acceleration, spin and its rate, in the system's own units.
    rates : ndarray, (12 N, 12 N)
        The Jacobian of the equations of motion: the rate of change of a tangent vector is this matrix times it. The
        components are per body position, velocity, rotation vector and spin, in the system's own units. Third bodies
        stay where they are.
    by_parameter : dict of ndarray, (12 N,)
        Derivatives of the equations of motion by the requested parameters, by their names.
    """

    force_by_position: Array
    force_by_rotation: Array
    torque_by_position: Array
    torque_by_rotation: Array
    flow: Floats
    rates: Floats
    by_parameter: dict[str, Floats]

    def __repr__(self) -> str:
        bodies, parameters = len(self.flow) // 12, ", ".join(self.by_parameter)
        return f"Jacobian({bodies} bodies{', parameters ' + parameters if parameters else ''})"


def jacobian(system: SystemLike, state: State, parameters: Iterable[str] = ()) -> Jacobian:
    """Return the derivatives of forces, torques and rates of change at a state, exact to round-off.

    Parameters
    ----------
    state : State
    parameters : iterable of str
        Names from :attr:`parameters`.

    Examples
    --------
    >>> import fullbody, numpy as np
    >>> system, state = fullbody.systems.kw4()
    >>> jacobian = system.jacobian(state)
    >>> jacobian.rates.shape, bool(np.allclose(jacobian.force_by_position.sum(axis=2), 0.0))
    ((24, 24), True)
    """
    context, names = system.context, names_of(parameters, "parameters")
    core, attach, n = strip(state, context), context.units.attach, len(context)
    with explaining(context, core):
        loads, rates, forcing, flow = context.core.jacobian(core, names)
    blocks = loads.reshape(n, 2, 3, n, 2, 3)
    return Jacobian(
        attach(np.ascontiguousarray(blocks[:, 0, :, :, 0]), "force gradient"),
        attach(np.ascontiguousarray(blocks[:, 0, :, :, 1]), "force"),
        attach(np.ascontiguousarray(blocks[:, 1, :, :, 0]), "force"),
        attach(np.ascontiguousarray(blocks[:, 1, :, :, 1]), "torque"),
        flow,
        rates,
        dict(zip(names, forcing, strict=True)),
    )
