"""The gravity of bodies at points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..base.units import Units
from ..base.values import ArrayFields, brief
from ..errors import InvalidInput
from ..typing import Array, Floats
from .context import SystemLike
from .state import State, strip


class Gravity(ArrayFields):
    """Potential, field and gravity gradient at points of any shape (...).

    Attributes
    ----------
    potential : ndarray or Quantity, (...)
        The potential Phi, positive: a unit mass at rest has the potential energy -Phi.
    field : ndarray or Quantity, (..., 3)
        The field g = grad Phi, the acceleration of a particle.
    gradient : ndarray or Quantity, (..., 3, 3)
        The gravity gradient dg/dx, symmetric, computed at its first use. Its trace is zero outside and -4 pi G rho
        inside matter.
    """

    __slots__ = ("_gradient", "field", "potential")

    def __init__(self, potential: Array, field: Array, gradient: Array | Callable[[], Array]) -> None:
        self.potential, self.field, self._gradient = potential, field, gradient

    @property
    def gradient(self) -> Array:
        """The gravity gradient (..., 3, 3)."""
        if callable(self._gradient):
            self._gradient = self._gradient()
        return self._gradient

    def _parts(self) -> tuple[Any, ...]:
        return self.potential, self.field, self.gradient

    def __reduce__(self) -> Any:
        return Gravity, self._parts()

    def __repr__(self) -> str:
        return f"Gravity(potential={brief(self.potential)}, field={brief(self.field)})"


def points_in(points: Any, units: Units) -> Floats:
    """Return points (..., 3) as numbers in a system's units."""
    array = units.strip(points, "length", "points")
    if array.shape[-1:] != (3,):
        raise InvalidInput(f"points has shape {array.shape}; expected (..., 3)")
    return array


def gravity_at(
    attraction: _core.Attraction,
    positions: Floats,
    attitudes: Floats,
    points: Floats,
    units: Units,
    body: int | None = None,
    states: npt.NDArray[np.int64] | None = None,
) -> Gravity:
    """Return the gravity at points (..., 3) of bodies at K epochs, with positions and attitudes (K, N, ...).

    ``states`` (...) has for each point the index of its epoch; by default that is the first.
    """
    shape = points.shape[:-1]
    flat = np.ascontiguousarray(points.reshape(-1, 3))
    state_of_point = None if states is None else np.ascontiguousarray(states.reshape(-1))

    def evaluate(*shapes: tuple[int, ...]) -> list[Floats]:
        arrays = [np.empty((len(flat), *numbers)) for numbers in shapes]
        attraction.gravity(
            positions.reshape(-1, 3), attitudes.reshape(-1, 4), state_of_point, flat, list(shape), body, arrays
        )
        return [array.reshape(shape + array.shape[1:]) for array in arrays]

    potential, field = evaluate((), (3,))
    return Gravity(
        units.attach(potential, "potential"),
        units.attach(field, "acceleration"),
        lambda: units.attach(evaluate((3, 3))[0], "gravity gradient"),
    )


def gravity(system: SystemLike, state: State, points: Any, body: int | str | None = None) -> Gravity:
    """Return potential, field and gravity gradient of the bodies at points of the inertial frame, outside or inside.

    The sum is over the bodies only and does not include external forces such as the pull of a third body;
    :meth:`fullbody.Body.gravity` is that of one body in its own frame.

    Parameters
    ----------
    state : State
    points : array_like or Quantity, (..., 3)
        Inertial.
    body : int or str, optional
        The body whose gravity is computed, by its name or index; by default all bodies.

    Returns
    -------
    Gravity
        ``.potential`` (...), ``.field`` (..., 3) and ``.gradient`` (..., 3, 3), inertial.

    Raises
    ------
    InvalidInput
        For a point at a point mass or with coordinates that are not finite, which the message gives by its index; for
        the gradient on a polyhedron's surface.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> gravity = system.gravity(state, [[0.0, 0.0, 5.0], [0.0, 0.0, 6.0]])
    >>> gravity.field.shape, gravity.gradient.shape
    ((2, 3), (2, 3, 3))
    """
    context = system.context
    core = strip(state, context)
    if len(core.position) != len(context):
        raise InvalidInput(f"state has {len(core.position)} bodies; expected {len(context)}, as in the system")
    index = None if body is None else context.index(body)
    pose = core.position[None], core.attitude[None]
    return gravity_at(context.attraction, *pose, points_in(points, context.units), context.units, index)
