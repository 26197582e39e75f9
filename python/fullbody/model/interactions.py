"""Forces, torques and energy of a state, and the quantities that the motion conserves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.tables import Table, Tabled, head, number, vector
from ..base.values import ArrayFields, ScalarFields, block
from ..typing import Array, Scalar

__all__ = ["Energy", "Interactions", "Invariants", "Loads"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Interactions(ArrayFields, Tabled):
    """Forces, torques and the potential energy of a state.

    Attributes
    ----------
    force : ndarray or Quantity, (N, 3)
        Forces in the inertial frame.
    torque : ndarray or Quantity, (N, 3)
        Torques about each body's centre, in its body frame.
    potential_energy : float or Quantity
        The potential energy, negative: minus the paper's U.
    truncation_error : float
        For ``gravity="multipole:N"`` the contribution of the next two degrees to the force, or to the torques divided
        by the bodies' radii, relative to the force between two bodies, for the pair for which it is largest. It
        estimates the error of a series that converges. It is zero for the other methods, which have no series.
    """

    force: Array
    torque: Array
    potential_energy: Scalar
    truncation_error: float = 0.0

    def _tables(self) -> tuple[Table, ...]:
        """Return a table of force and torque, one body per row."""
        columns = [np.asarray(getattr(value, "value", value)) for value in (self.force, self.torque)]
        units = [getattr(value, "unit", "") for value in (self.force, self.torque)]
        header = ("body", head("force", units[0]), head("torque, body frame", units[1]))
        rows = [(str(k), *(vector(column[k]) for column in columns)) for k in range(len(columns[0]))]
        return (Table(f"Interactions, potential energy {number(self.potential_energy)}", header, list(rows)),)

    def __repr__(self) -> str:
        names = ("force", "torque", "potential_energy", "truncation_error")
        return block("Interactions(", **{name: getattr(self, name) for name in names})


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


@dataclass(frozen=True, slots=True, eq=False)
class Energy(ScalarFields, Tabled):
    """The energy of a state in its parts.

    Attributes
    ----------
    total, translational, rotational, potential : float or Quantity
    """

    total: Scalar
    translational: Scalar
    rotational: Scalar
    potential: Scalar

    def _tables(self) -> tuple[Table, ...]:
        """Return a table of the parts of the energy."""
        names = ("translational", "rotational", "potential", "total")
        return (Table("Energy", (), [(name, number(getattr(self, name))) for name in names]),)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Invariants(ArrayFields):
    """The conserved quantities of a motion at a time.

    Attributes
    ----------
    time : float or Quantity
    energy : Energy
    angular_momentum : ndarray or Quantity, (3,)
        Total angular momentum about the origin, inertial frame.
    """

    time: Any
    energy: Energy
    angular_momentum: Any
