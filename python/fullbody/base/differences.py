"""Derivatives by differences: over a given step, and over a step that is searched for."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput
from ..typing import Floats

#: The errors of a function at an argument for which it has no value.
REFUSALS = (ValueError, ArithmeticError, RuntimeError)
#: Steps relative to the size of the argument, in the order in which they are tried. They are no decimal numbers, to
#: which functions might round.
_RELATIVE_STEPS = tuple(2.0**-k for k in range(10, 32, 3))
#: The step of later differences, relative to the step that was searched for.
_SHORTER = 0.1234
#: Arguments in units of the step, from both sides or from one, whose ratios are irrational: a function that rounds is
#: not linear at them by chance.
_CENTRAL = np.array([-(3.0**0.5), -1.0, -_SHORTER, _SHORTER, 1.0, 3.0**0.5])
_FORWARD = np.array([_SHORTER, _SHORTER * 3.0**0.5, 1.0, 3.0**0.5, 7.0**0.5, 13.0**0.5])
#: The arguments of the formulas of fourth order, of second order, and of second order over the shorter step.
_FORMULAS = (([0, 1, 4, 5], [1, 4], [2, 3]), ([2, 3, 4, 5], [2, 3], [0, 1]))
#: The largest difference of the three formulas, relative to the derivative, and in units of noise over the step.
_AGREE, _ROUNDED = 1e-4, 30.0
#: The changes over a step, in units of noise, below which nothing has changed, and from which they are precise.
_CHANGED, _PRECISE = 30.0, 1e4


def _weights(arguments: Floats, formulas: tuple[list[int], ...]) -> Floats:
    """Return the weights (3, 6) of the derivative at zero of a polynomial that is zero there."""
    weights = np.zeros((len(formulas), len(arguments)))
    for row, which in zip(weights, formulas, strict=True):
        powers = arguments[which] ** np.arange(1, len(which) + 1)[:, None]
        row[which] = np.linalg.solve(powers, np.eye(len(which))[0])
    return weights


_SIDES = [
    (sign * arguments, sign * _weights(arguments, formulas))
    for sign, arguments, formulas in (
        (1.0, _CENTRAL, _FORMULAS[0]),
        (1.0, _FORWARD, _FORMULAS[1]),
        (-1.0, _FORWARD, _FORMULAS[1]),
    )
]


def difference(function: Callable[[float], Floats], step: float) -> Floats:
    """Return the derivative of a function that is zero at zero: second order, one-sided if it refuses ``-step``."""
    try:
        below = function(-step)
    except REFUSALS:
        return np.asarray((4.0 * function(step) - function(2.0 * step)) / (2.0 * step))
    return np.asarray((function(step) - below) / (2.0 * step))


class Differences:
    """Derivatives of a function of one argument at its values, of six values each, or of two with an earlier step."""

    def __init__(self) -> None:
        #: The step of the last derivative, zero if there is none, and the size of its argument.
        self.length = self._size = 0.0

    def derivative(
        self,
        function: Callable[[float], Floats],
        size: float,
        noise: Floats,
        groups: npt.NDArray[np.intp],
        longest: float,
    ) -> Floats | None:
        """Return the derivative (M,) of a function of a shift, or ``None`` where the function is not smooth.

        An error of ``REFUSALS`` means that the function has no value; if it has none next to zero, InvalidInput is
        raised. It is smooth over the length ``size``, or a shorter one. The step is shortened until differences of
        fourth and of second order agree, and those over an eighth of it too, which later calls use. A function that is
        not smooth, since it rounds or takes values from a table, changes over a long step and not over a short one, or
        its derivative over a short step differs from that over a long one by more than the formulas do there. If the
        changes are not far above the noise, the step is lengthened as long as the formulas agree, up to ``longest``, so
        that an argument that is zero up to rounding has the step of zero. What does not change at all has a derivative
        of zero, of which no step is kept. A step holds for arguments of the same size to a factor of two. The ``noise``
        is the rounding errors of the values, and ``groups`` are equal for components of one quantity, whose derivative
        is as precise as its largest.
        """
        if 0.5 * self._size <= size <= 2.0 * self._size:
            step = _SHORTER * self.length
            with suppress(*REFUSALS):
                change = np.asarray(function(step) - function(-step))
                if _signal(change, noise) > 0.01 * _PRECISE:
                    return np.asarray(change / (2.0 * step))
        self.length = self._size = 0.0
        longer: _Trial | None = None
        refused: Exception | None = None
        for relative_step in _RELATIVE_STEPS:
            try:
                trial = _Trial(function, relative_step * size, noise, groups)
            except REFUSALS as error:
                refused = error
                continue
            if longer is not None and (longer.changed > trial.changed or not trial.follows(longer)):
                return None
            if trial.smooth:
                break
            longer = trial
        else:
            if refused is not None and longer is None:
                raise InvalidInput(f"no value near it is accepted: {refused}") from refused
            return None
        while trial.signal < _PRECISE and trial.length < longest:
            length = min(longest, trial.length * 10.0 * _PRECISE / max(trial.signal, 1.0))
            with suppress(*REFUSALS):
                further = _Trial(function, length, noise, groups)
                if further.smooth:
                    trial = further
                    continue
            break
        if trial.signal < _CHANGED:
            return np.zeros(len(noise))
        self.length, self._size = trial.length, size
        return trial.derivative


class _Trial:
    """Differences over a step, from both sides or from the one that the function accepts.

    Beside the ``derivative`` (M,) there are ``error`` (M,), the largest difference of the formulas for any component of
    the same quantity, ``smooth``, whether the formulas agree, ``signal``, the largest change over the step that is
    linear in it, in units of noise, and ``changed``, whether anything changes.
    """

    def __init__(
        self, function: Callable[[float], Floats], length: float, noise: Floats, groups: npt.NDArray[np.intp]
    ) -> None:
        self.length = length
        refused: Exception | None = None
        for arguments, formulas in _SIDES:
            try:
                values = np.array([function(argument * length) for argument in arguments])
                weights = formulas
                break
            except REFUSALS as error:
                refused = error
        else:
            assert refused is not None
            raise refused
        fine, coarse, short = weights @ values / length
        self.derivative: Floats = fine
        self.error = _largest(np.maximum(np.abs(fine - coarse), np.abs(fine - short)), groups)
        self._rounding = _ROUNDED * noise / length
        sizes = _largest(np.maximum(np.abs(fine), np.abs(short)), groups)
        self.smooth = bool((self.error <= _AGREE * sizes + _largest(self._rounding, groups)).all())
        self.signal = _signal(fine * length, noise)
        self.changed = _signal(np.abs(values).max(axis=0), noise) > _CHANGED

    def follows(self, longer: _Trial) -> bool:
        """Return whether the derivative differs from that over a longer step by no more than the formulas do there."""
        difference = np.abs(self.derivative - longer.derivative)
        return bool((difference <= 10.0 * longer.error + self.error + self._rounding).all())


def _largest(values: Floats, groups: npt.NDArray[np.intp]) -> Floats:
    """Return for each of the values (M,) the largest one of its group."""
    largest = np.zeros(int(groups.max(initial=-1)) + 1)
    np.maximum.at(largest, groups, values)
    return np.asarray(largest[groups])


def _signal(changes: Floats, noise: Floats) -> float:
    """Return the largest of changes (M,) in units of noise (M,); one without noise is infinite."""
    sizes = np.abs(changes)
    return float(np.divide(sizes, noise, out=np.where(sizes > 0.0, np.inf, 0.0), where=noise > 0.0).max(initial=0.0))
