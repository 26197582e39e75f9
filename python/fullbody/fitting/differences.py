"""Cheap differences of smooth functions, with a step that is found by comparing two orders."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput

__all__ = ["REFUSALS", "derivative"]

_Array = npt.NDArray[np.float64]

#: Steps relative to the size of the argument, in the order in which they are tried.
_STEPS = (1e-3, 1e-5, 1e-7, 1e-9)
#: Positions in units of the step, and the weights of the formulas of fourth and of second order there.
_CENTRAL = ((-2, -1, 1, 2), (1 / 12, -2 / 3, 2 / 3, -1 / 12), (0.0, -1 / 2, 1 / 2, 0.0))
_FORWARD = ((0, 1, 2, 3, 4), (-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4), (-3 / 2, 2.0, -1 / 2, 0.0, 0.0))
#: The largest difference of the two orders, relative to the derivative.
_AGREE = 1e-4
#: The errors of a function at an argument for which it has no value.
REFUSALS = (ValueError, ArithmeticError, RuntimeError)


def derivative(
    function: Callable[[float], _Array],
    size: float,
    noise: _Array,
    groups: npt.NDArray[np.intp],
    known: dict[str, float],
    shorter: float = 0.01,
) -> _Array | None:
    """Return the derivative (M,) of a function at zero, or ``None`` where no step gives one.

    Parameters
    ----------
    function : callable
        A function that takes a shift of the argument and returns values (M,), or raises an error if it has none.
    size : float
        The length over which the function is smooth, or longer.
    noise : ndarray, (M,)
        The rounding errors of the values.
    groups : ndarray of int, (M,)
        Values with the same number are components of one quantity, whose derivative is as precise as its largest.
    known : dict
        Receives the step that was found and keeps it for later calls at the same argument, which take two values.
    shorter : float
        The fraction of a known step that is taken.

    Notes
    -----
    Differences are of fourth order, from both sides or from one. The step is shortened until those of second order
    agree. With a known step, differences are of second order from both sides, over a fraction of it.
    """
    if "step" in known:
        step = shorter * known["step"]
        with suppress(*REFUSALS):
            apart = np.asarray(function(step) - function(-step))
            # Where nothing changes any more, the function may have steps that are longer than this one.
            if apart.any() or not known["changes"]:
                return apart / (2.0 * step)
    refused: Exception | None = None
    found = changed = False
    for share in _STEPS:
        for sign, (places, fourth, second) in ((1, _CENTRAL), (1, _FORWARD), (-1, _FORWARD)):
            step = sign * share * size
            try:
                values = np.array([function(place * step) for place in places])
            except REFUSALS as error:
                refused = error
                continue
            found = True
            if changed and not values.any():
                # A function that changes over a long step and not at all over a short one has steps itself.
                return None
            changed = changed or bool(values.any())
            fine, coarse = (np.array(weights) @ values / step for weights in (fourth, second))
            largest = np.zeros(int(groups.max(initial=-1)) + 1)
            np.maximum.at(largest, groups, np.abs(fine))
            allowed = _AGREE * largest[groups] + noise / abs(step)
            if (np.abs(fine - coarse) <= allowed).all():
                known |= {"step": abs(step), "changes": float(fine.any())}
                return np.asarray(fine)
            break
    if not found and refused is not None:
        raise InvalidInput(f"no value near it is accepted: {refused}") from refused
    return None
