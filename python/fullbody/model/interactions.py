"""Forces, torques, energies and momenta of a state, with external loads and derivatives."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.arguments import names_of
from ..base.tables import Table, Tabled, head, number, vector
from ..base.units import without_unit
from ..base.values import ArrayFields, ByName, ScalarFields, block
from ..typing import Array, Floats, Scalar
from .context import SystemLike
from .failures import explaining
from .state import State, strip


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
        columns = [without_unit(value) for value in (self.force, self.torque)]
        units = [getattr(value, "unit", "") for value in (self.force, self.torque)]
        header = ("body", head("force", units[0]), head("torque, body frame", units[1]))
        rows = [(str(k), *(vector(column[k]) for column in columns)) for k in range(len(columns[0]))]
        return (Table(f"Interactions, potential energy {number(self.potential_energy)}", header, list(rows)),)

    def __repr__(self) -> str:
        names = ("force", "torque", "potential_energy", "truncation_error")
        return block("Interactions(", **{name: getattr(self, name) for name in names})


@dataclass(frozen=True, slots=True, eq=False)
class Energy(ScalarFields, Tabled):
    """The energy of a state in its parts: total, translational, rotational, potential, each a float or Quantity."""

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

    They are those of the paper's Eqs. (2) and (3), and minus Eq. (4).

    Raises
    ------
    BodiesOverlap
    NotConverged
        If the quadrature reaches its limit of nodes, as for bodies in contact with sharp rims.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> f = system.interactions(state)
    >>> f.force.shape, f.torque.shape, bool(abs(f.force.sum()) < 1e-15)
    ((2, 3), (2, 3), True)
    """
    context = system.context
    core, attach = strip(state, context), context.units.attach
    with explaining(context, core):
        force, torque, energy, truncation_error = context.core.interactions(core)
    return Interactions(attach(force, "force"), attach(torque, "torque"), attach(energy, "energy"), truncation_error)


def energy(system: SystemLike, state: State) -> Energy:
    """Return the :class:`~fullbody.model.Energy` of a state in its parts."""
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
    """Return the loads of each external force in a state, by its name.

    They are ``.force`` (N, 3), inertial, and ``.torque`` (N, 3), in body frames. The nominal barycentre, about which a
    third body's path places it, is that of the state.

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
    rows = zip(context.forces, forces, torques, strict=True)
    return ByName({name: Loads(attach(force, "force"), attach(torque, "torque")) for name, force, torque in rows})


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
    arrays = context.core.third_body(index, np.atleast_1d(times))
    position, velocity = (array.reshape(*times.shape, 3) for array in arrays)
    return context.units.attach(position, "length"), context.units.attach(velocity, "velocity")


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
