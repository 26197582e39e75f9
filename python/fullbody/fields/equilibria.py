"""Equilibrium points of the rotating frame of a pair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.units import need
from ..base.values import ArrayFields
from ..typing import Array, Floats, Scalar
from .frame import Frame

#: Real parts of eigenvalues that count as zero, in units of the rate.
_NEUTRAL = 1e-6
#: The distance, in separations, below which two points are the same.
_SAME = 1e-6


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Equilibrium(ArrayFields):
    """A point where a particle can rest in the rotating frame.

    Attributes
    ----------
    name : str
        ``"L1"`` to ``"L5"``: between the bodies, behind the lighter one, behind the heavier one, 60 degrees before and
        behind the lighter one. Further points, which two point masses do not have, are ``"E6"`` and so on.
    position : ndarray or Quantity, (3,)
        Position in the rotating frame.
    jacobi : float or Quantity
        Jacobi's constant at the point.
    eigenvalues : ndarray or Quantity, (6,)
        Complex eigenvalues of the linear motion about the point, per unit of time.
    stable : bool
        Whether no eigenvalue has a positive real part.
    """

    name: str
    position: Array
    jacobi: Scalar
    eigenvalues: Any
    stable: bool


def equilibria(pair: Any) -> list[Equilibrium]:
    """Find the points outside of the bodies where a particle can rest, and the linear motion about them.

    Newton's method starts from the points of two point masses and from a grid about the bodies. It needs scipy.

    Returns
    -------
    list of Equilibrium
    """
    frame = pair.frame
    found: list[tuple[str, Floats]] = []
    for name, seed in [*_of_points(frame), *(("", seed) for seed in _grid())]:
        x = _root(frame, seed)
        if x is None or any(np.linalg.norm(x - other) < _SAME for _, other in found):
            continue
        # The extent of the bodies may remove a classical point; the search then finds another point.
        classical = name and np.linalg.norm(x - seed) < 0.3
        found.append((name if classical else f"E{6 + sum(other[0] == 'E' for other, _ in found)}", x))
    return [_described(frame, name, x * frame.distance) for name, x in found]


def inner_point(frame: Frame) -> Equilibrium | None:
    """Return the point between the bodies, or ``None`` if there is none."""
    x = _root(frame, _of_points(frame)[0][1])
    return None if x is None else _described(frame, "L1", x * frame.distance)


def _of_points(frame: Frame) -> list[tuple[str, Floats]]:
    """Return the equilibrium points of two point masses, in units of the separation."""
    with need("analysis", "an equilibrium point"):
        from scipy.optimize import brentq

    light = float(frame.context.masses[1 - frame.primary] / frame.context.masses.sum())

    def pull(x: float) -> float:
        heavy, near = x + light, x - 1.0 + light
        return x - (1.0 - light) * heavy / abs(heavy) ** 3 - light * near / abs(near) ** 3

    gap = 1e-9
    spans = ((gap - light, 1.0 - light - gap), (1.0 - light + gap, 2.5), (-2.5, -light - gap))
    roots = [np.array([brentq(pull, *span, xtol=1e-15), 0.0, 0.0]) for span in spans]
    third = [np.array([0.5 - light, sign * np.sqrt(0.75), 0.0]) for sign in (1.0, -1.0)]
    return list(zip(("L1", "L2", "L3", "L4", "L5"), [*roots, *third], strict=True))


def _grid() -> list[Floats]:
    """Return a grid of points about both bodies, in separations."""
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    return [r * np.array([np.cos(a), np.sin(a), 0.0]) for r in (0.4, 0.7, 1.1) for a in angles]


def _root(frame: Frame, seed: Floats) -> Floats | None:
    """Return the equilibrium point, in separations, that Newton's method finds outside of the bodies, or ``None``."""
    with need("analysis", "an equilibrium point"):
        from scipy.optimize import root

    scale = frame.rate**2

    def pull(x: Floats) -> tuple[Floats, Floats]:
        acceleration, jacobian = frame.acceleration_and_gradient(x * frame.distance)
        return acceleration / (scale * frame.distance), jacobian / scale

    answer = root(pull, seed, jac=True, options={"xtol": 1e-14})
    x: Floats = answer.x
    # The remaining acceleration is round-off of the gravity of the nearest body.
    value, jacobian = pull(x)
    x = x - np.linalg.solve(jacobian, value)
    if not np.abs(pull(x)[0]).max() < 1e-11 * np.abs(jacobian).max() or np.abs(x).max() > 3.0:
        return None
    return None if frame.is_inside(x * frame.distance) else x


def _described(frame: Frame, name: str, x: Floats) -> Equilibrium:
    """Describe a point by its eigenvalues: x'' = W x + 2 Omega (y', -x', 0), W the derivatives of the acceleration."""
    coriolis = 2.0 * frame.rate * np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    _, gradient = frame.acceleration_and_gradient(x)
    eigenvalues: Any = np.linalg.eigvals(np.block([[np.zeros((3, 3)), np.eye(3)], [gradient, coriolis]]))
    return Equilibrium(
        name,
        frame.context.units.attach(x, "length"),
        frame.context.units.attach(frame.jacobi(x)[()], "potential"),
        frame.context.units.attach(eigenvalues, "spin"),
        bool(eigenvalues.real.max() < _NEUTRAL * frame.rate),
    )
