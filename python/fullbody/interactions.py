"""What acts in a state: forces, torques and energies."""

from __future__ import annotations

from dataclasses import dataclass

from ._records import Alike, Record, block
from .typing import Array, Scalar

__all__ = ["Energy", "Interactions"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Interactions(Record):
    """Forces, torques and the potential energy of a state.

    Attributes
    ----------
    force : ndarray or Quantity, (N, 3)
        Inertial frame.
    torque : ndarray or Quantity, (N, 3)
        About each body's centre, in its body frame.
    potential_energy : float or Quantity
        Negative: minus the paper's U.
    """

    force: Array
    torque: Array
    potential_energy: Scalar

    def _repr_html_(self) -> str:
        from . import tables

        return tables.to_html(tables.of_interactions(self))

    def __repr__(self) -> str:
        return block("Interactions(", force=self.force, torque=self.torque, potential_energy=self.potential_energy)


@dataclass(frozen=True, slots=True, eq=False)
class Energy(Alike):
    """Energy in its parts.

    Attributes
    ----------
    total, translational, rotational, potential : float or Quantity
    """

    total: Scalar
    translational: Scalar
    rotational: Scalar
    potential: Scalar

    def _repr_html_(self) -> str:
        from . import tables

        return tables.to_html(tables.of_energy(self))
