"""Arrays of a record as its attributes, with units: samples, derivatives and indicators of chaos."""

from __future__ import annotations

from typing import Any

from ..base.attributes import Attribute, WithUnit
from ..base.values import ByName
from ..errors import InvalidInput
from ..typing import Array, Floats

#: The data that a run has for an option, by the name of the array.
_OPTIONS = {
    "transition": "derivatives; integrate with derivatives=True",
    "chaos": "indicators of chaos; integrate with chaos=True",
}


def array(record: Any, name: str, part: int | None = None) -> Floats:
    """Return an array of a record or a column of it, or raise an error that says with which option a run keeps it."""
    if name in _OPTIONS and name not in record.arrays:
        raise InvalidInput(f"this run keeps no {_OPTIONS[name]}")
    values: Floats = record.arrays[name]
    return values if part is None else values[:, part]


class Numbers(Attribute[Floats]):
    """A property of a record: pure numbers, an array of the record or one of its columns, the ``part``."""

    def __init__(self, text: str, name: str, part: int | None = None) -> None:
        super().__init__(lambda record: array(record, name, part), text)


class Column(WithUnit[Array]):
    """A property of a record: an array of the record, or one of its columns, with the unit of a dimension."""

    def __init__(self, text: str, name: str, dimension: str, part: int | None = None) -> None:
        super().__init__(text, lambda record: array(record, name, part), dimension)


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
