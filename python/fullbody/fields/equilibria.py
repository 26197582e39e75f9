"""Equilibrium points of the rotating frame of a pair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..base.units import need
from ..base.values import ArrayFields
from ..typing import Array, Scalar
from .frame import Frame

__all__ = ["Equilibrium", "equilibria", "inner_point"]

_Numbers = npt.NDArray[np.float64]
#: Real parts of eigenvalues, in units of the rate, that count as zero.
_NEUTRAL = 1e-6
#: Points that are nearer than this, in separations, are the same one.
_SAME = 1e-6


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Equilibrium(ArrayFields):
    """A point where a particle can rest in the rotating frame.

    Attributes
    ----------
    name : str
        ``"L1"`` to ``"L5"``: between the bodies, behind the lighter one, behind the heavier one, 60 degrees before and
        behind the lighter one. Others, which two points do not have, are ``"E6"`` and so on.
    position : ndarray or Quantity, (3,)
        In the rotating frame.
    jacobi : float or Quantity
        Jacobi's constant there.
    eigenvalues : ndarray or Quantity, (6,)
        Of the linear motion about the point, complex, by time.
    stable : bool
        Whether none of them has a real part above zero.
    """

    name: str
    position: Array
    jacobi: Scalar
    eigenvalues: Any
    stable: bool


def equilibria(frame: Frame) -> list[Equilibrium]:
    """As :meth:`fullbody.fields.Synodic.equilibria`."""
    found: list[tuple[str, _Numbers]] = []
    for name, seed in [*_of_points(frame), *(("", seed) for seed in _grid())]:
        x = _root(frame, seed)
        if x is None or any(np.linalg.norm(x - other) < _SAME for _, other in found):
            continue
        # Where the bodies' extent leaves none of the classical points there, the next one is another.
        classical = name and np.linalg.norm(x - seed) < 0.3
        found.append((name if classical else f"E{6 + sum(other[0] == 'E' for other, _ in found)}", x))
    return [_described(frame, name, x * frame._distance) for name, x in found]


def inner_point(frame: Frame) -> Equilibrium | None:
    """The point between the bodies, if there is one."""
    x = _root(frame, _of_points(frame)[0][1])
    return None if x is None else _described(frame, "L1", x * frame._distance)


def _of_points(frame: Frame) -> list[tuple[str, _Numbers]]:
    """The equilibrium points of two masses without extent, in separations."""
    with need("analysis", "an equilibrium point"):
        from scipy.optimize import brentq

    light = float(frame._masses[1 - frame.primary] / frame._masses.sum())

    def pull(x: float) -> float:
        heavy, near = x + light, x - 1.0 + light
        return x - (1.0 - light) * heavy / abs(heavy) ** 3 - light * near / abs(near) ** 3

    gap = 1e-9
    spans = ((gap - light, 1.0 - light - gap), (1.0 - light + gap, 2.5), (-2.5, -light - gap))
    roots = [np.array([brentq(pull, *span, xtol=1e-15), 0.0, 0.0]) for span in spans]
    third = [np.array([0.5 - light, sign * np.sqrt(0.75), 0.0]) for sign in (1.0, -1.0)]
    return list(zip(("L1", "L2", "L3", "L4", "L5"), [*roots, *third], strict=True))


def _grid() -> list[_Numbers]:
    """Places about both bodies, in separations."""
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    return [r * np.array([np.cos(a), np.sin(a), 0.0]) for r in (0.4, 0.7, 1.1) for a in angles]


def _root(frame: Frame, seed: _Numbers) -> _Numbers | None:
    """The point of rest, in separations, to which Newton's method leads, if it does, outside of the bodies."""
    with need("analysis", "an equilibrium point"):
        from scipy.optimize import root

    scale = frame._rate**2

    def pull(x: _Numbers) -> tuple[_Numbers, _Numbers]:
        acceleration, slopes = frame._slope(x * frame._distance)
        return acceleration / (scale * frame._distance), slopes / scale

    answer = root(pull, seed, jac=True, options={"xtol": 1e-14})
    x: _Numbers = answer.x
    # What is left is round-off of the pull of the nearest body.
    value, slopes = pull(x)
    x = x - np.linalg.solve(slopes, value)
    if not np.abs(pull(x)[0]).max() < 1e-11 * np.abs(slopes).max() or np.abs(x).max() > 3.0:
        return None
    return None if frame._is_inside(x * frame._distance) else x


def _described(frame: Frame, name: str, x: _Numbers) -> Equilibrium:
    """The linear motion about a point: x'' = W x + 2 Omega (y', -x', 0) with W the derivatives of the acceleration."""
    coriolis = 2.0 * frame._rate * np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    eigenvalues: Any = np.linalg.eigvals(np.block([[np.zeros((3, 3)), np.eye(3)], [frame._slope(x)[1], coriolis]]))
    return Equilibrium(
        name,
        frame._units.attach(x, "length"),
        frame._units.attach(frame._jacobi(x)[()], "potential"),
        frame._units.attach(eigenvalues, "spin"),
        bool(eigenvalues.real.max() < _NEUTRAL * frame._rate),
    )
