"""Derivatives and indicators of chaos of a record as its attributes."""

from __future__ import annotations

from typing import Any

from ..base.attributes import Attribute
from ..base.values import ByName
from ..typing import Floats
from .columns import Column, Numbers, array

_KINDS = ("position", "velocity", "rotation", "spin")


def tangent_labels(names: tuple[str, ...]) -> list[str]:
    """Return the labels of the components of a tangent vector, 12 for each body."""
    return [f"{name} {kind} {axis}" for name in names for kind in _KINDS for axis in "xyz"]


@Attribute
def tangent_units(record: Any) -> tuple[Any, ...] | None:
    """The units of the 12 N components of a tangent vector, or ``None`` for a system without units.

    The element (i, j) of a transition matrix has the unit ``tangent_units[i] / tangent_units[j]``. The element
    i of a sensitivity has the unit ``tangent_units[i]`` divided by that of the parameter, which is the system's
    own.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4(units=True)
    >>> units = system.integrate(state, "1 hour", derivatives=True).tangent_units
    >>> [str(unit) for unit in units[:12:3]]
    ['km', 'km / h', 'rad', 'rad / h']
    """
    units = record.context.units
    if not units.defined:
        return None
    kinds = [units.unit(dimension) for dimension in ("length", "velocity", "angle", "spin")]
    return tuple(unit for _ in record.context.names for unit in kinds for _ in range(3))


transition = Numbers(
    """Transition matrices (K, 12 N, 12 N), which map a tangent vector at the start of the run to that at a sample.

    A tangent vector has 12 components per body, body after body: changes of position and velocity in the inertial
    frame, a rotation vector theta in the body frame (R becomes R exp(theta), in rad), and the change of spin in the
    body frame. All are numbers in the system's own units (:attr:`tangent_units`). The nominal barycentre moves with
    the start, and the paths of third bodies with it.

    Raises
    ------
    InvalidInput
        For a run that was not integrated with ``derivatives=``.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 10.0, output="ends", derivatives=True)
    >>> run.transition.shape
    (2, 24, 24)
    """,
    "transition",
)


@Attribute
def sensitivity(record: Any) -> dict[str, Floats]:
    """Derivatives (K, 12 N) of the samples with respect to parameters of the system, by their names, at a fixed
    start.

    They are numbers in the system's own units: :attr:`tangent_units` divided by the unit of the parameter.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 10.0, output="ends", derivatives=["G", "mass of Alpha"])
    >>> run.sensitivity["mass of Alpha"].shape
    (2, 24)
    """
    array(record, "transition")
    values = record.arrays.get("sensitivity")
    return ByName({} if values is None else {name: values[:, k] for k, name in enumerate(record.parameters)})


megno = Numbers(
    """Mean MEGNO since the start of the run (K,): it tends to 2 for regular motion, and grows with chaotic motion.

    It needs a run with ``chaos=True``, and is zero at the start. See Cincotta & Simo (2000), Astron. Astrophys.
    Suppl. 147, 205.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 3000.0, output="ends", chaos=True)
    >>> bool(abs(run.megno[-1] - 2.0) < 0.1)
    True
    """,
    "chaos",
    0,
)
lyapunov = Column(
    """Tangent growth ``ln(|delta|/|delta_0|)`` divided by the time since the start (K,), in 1/time.

    It tends to the largest Lyapunov exponent, whose inverse is the Lyapunov time, and needs a run with
    ``chaos=True``. Components of tangent vectors are measured in their natural sizes at the start: separation,
    orbital speed or the body's own, rad, and the spin.
    """,
    "chaos",
    "rate",
    1,
)
fast_lyapunov = Numbers(
    "The fast Lyapunov indicator (K,): the largest ``ln(|delta|/|delta_0|)`` so far. It needs ``chaos=True``.",
    "chaos",
    2,
)
