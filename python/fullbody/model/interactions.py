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
        Inertial frame.
    torque : ndarray or Quantity, (N, 3)
        About each body's centre, in its body frame.
    potential_energy : float or Quantity
        Negative: minus the paper's U.
    truncation_error : float
        For ``gravity="multipole:N"`` the size of the two degrees after the last one, of the force, and of the torques
        divided by the bodies' radii, relative to the force between the two bodies for which that is largest. It
        estimates the error of a series that converges. It is zero for the other methods, which have no series.
    """

    force: Array
    torque: Array
    potential_energy: Scalar
    truncation_error: float = 0.0

    def _tables(self) -> tuple[Table, ...]:
        """Force and torque, a body a row, by its place."""
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
        Inertial frame. Of a third body the part that moves the bodies relative to the nominal barycentre.
    torque : ndarray or Quantity, (N, 3)
        About each body's centre, in its body frame.
    """

    force: Array
    torque: Array

    def __repr__(self) -> str:
        return block("Loads(", force=self.force, torque=self.torque)


@dataclass(frozen=True, slots=True, eq=False)
class Energy(ScalarFields, Tabled):
    """Energy in its parts.

    Attributes
    ----------
    total, translational, rotational, potential : float or Quantity
    """

    total: Scalar
    translational: Scalar
    rotational: Scalar
    potential: Scalar

    def _tables(self) -> tuple[Table, ...]:
        """The parts of an energy."""
        names = ("translational", "rotational", "potential", "total")
        return (Table("Energy", (), [(name, number(getattr(self, name))) for name in names]),)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Invariants(ArrayFields):
    """The quantities that a motion conserves, at a time.

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
