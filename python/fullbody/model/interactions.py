"""What acts in a state, and what the motion conserves of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..base.values import Alike, Record, block

__all__ = ["Energy", "Interactions", "Invariants"]


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

    force: Any
    torque: Any
    potential_energy: Any

    def _repr_html_(self) -> str:
        from ..base import tables

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

    total: Any
    translational: Any
    rotational: Any
    potential: Any

    def _repr_html_(self) -> str:
        from ..base import tables

        return tables.to_html(tables.of_energy(self))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Invariants(Record):
    """What a motion conserves, at a time.

    Attributes
    ----------
    time : float or Quantity
    energy : Energy
    angular_momentum : ndarray or Quantity, (3,)
        Total, about the origin, inertial.
    """

    time: Any
    energy: Energy
    angular_momentum: Any
