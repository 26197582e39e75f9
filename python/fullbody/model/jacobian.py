"""The derivatives of forces, torques and rates at a state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..base.values import ArrayFields
from ..typing import Array

__all__ = ["Jacobian"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Jacobian(ArrayFields):
    """Derivatives of forces, torques and rates of change at a state.

    Rotations are small rotation vectors theta in each body's own frame: the rotation matrix R becomes R exp(theta).

    Attributes
    ----------
    force_by_position, force_by_rotation : ndarray or Quantity, (N, 3, N, 3)
        Of the forces, inertial: ``force_by_position[i, :, j, :]`` is what a move of body j does to the force on body i.
    torque_by_position, torque_by_rotation : ndarray or Quantity, (N, 3, N, 3)
        Of the torques, in body frames.
    flow : ndarray, (12 N,)
        The rates of change themselves: per body velocity, acceleration, spin and its rate, in the system's own units.
    rates : ndarray, (12 N, 12 N)
        Of the equations of motion: a small departure from the motion changes at this matrix times it. Per body
        position, velocity, rotation vector and spin, in the system's own units. Third bodies stay where they are.
    by_parameter : dict of ndarray, (12 N,)
        Of the equations of motion with the parameters that were asked for, by their names.
    """

    force_by_position: Array
    force_by_rotation: Array
    torque_by_position: Array
    torque_by_rotation: Array
    flow: npt.NDArray[np.float64]
    rates: npt.NDArray[np.float64]
    by_parameter: dict[str, npt.NDArray[np.float64]]

    def __repr__(self) -> str:
        bodies, parameters = len(self.flow) // 12, ", ".join(self.by_parameter)
        return f"Jacobian({bodies} bodies{', parameters ' + parameters if parameters else ''})"
