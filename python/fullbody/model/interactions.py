"""Forces, torques and energy of a state, and the quantities that the motion conserves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.tables import Table, Tabled, head, number, vector
from ..base.values import ArrayFields, ScalarFields, block
from ..typing import Array, Scalar
from .context import SystemLike
from .failures import explaining
from .state import State, strip

__all__ = ["Energy", "Interactions", "Invariants", "angular_momentum", "energy", "interactions", "momentum"]


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
        estimates the error of a series that converges. For two polyhedra near each other, whose interaction is a sum
        over their fragments, it is a bound of the error in the same measure. It is zero for the other rules.
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


def interactions(system: SystemLike, state: State) -> Interactions:
    """Return the forces and torques on the bodies and the potential energy in a state.

    Parameters
    ----------
    state : State

    Returns
    -------
    Interactions

    Raises
    ------
    BodiesOverlap
    NotConverged
        If the quadrature reaches its limit of nodes, as for bodies in contact with sharp rims.

    Notes
    -----
    The results are those of the paper's Eqs. (2) and (3), and for the potential energy minus Eq. (4).

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> f = system.interactions(state)
    >>> f.force.shape, f.torque.shape
    ((2, 3), (2, 3))
    >>> bool(abs(f.force.sum()) < 1e-15)
    True
    """
    context = system.context
    core, attach = strip(state, context), context.units.attach
    with explaining(context, core):
        force, torque, energy, truncation_error = context.core.interactions(core)
    return Interactions(attach(force, "force"), attach(torque, "torque"), attach(energy, "energy"), truncation_error)


def energy(system: SystemLike, state: State) -> Energy:
    """Return the energy of a state in its parts.

    Parameters
    ----------
    state : State

    Returns
    -------
    Energy
    """
    context = system.context
    core = strip(state, context)
    with explaining(context, core):
        parts = context.core.energy(core)
    return Energy(*(context.units.attach(part, "energy") for part in parts))


def momentum(system: SystemLike, state: State) -> Array:
    """Return the total momentum (3,) of a state in the inertial frame."""
    context = system.context
    return context.units.attach(context.core.momentum(strip(state, context)), "momentum")


def angular_momentum(system: SystemLike, state: State) -> Array:
    """Return the total angular momentum (3,) about the origin, inertial frame: the paper's ``eq:Total_angmom``."""
    context = system.context
    return context.units.attach(context.core.angular_momentum(strip(state, context)), "angular momentum")
