"""Loss functions, which reduce the weight of residuals that are too large for their errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.limits import Limits
from ..base.units import UNITLESS
from ..errors import InvalidInput
from ..typing import Floats


@dataclass(frozen=True)
class Outliers:
    """A loss for data with outliers: minus the logarithm of a mixture of two normal distributions.

    With z a residual divided by its error, the likelihood is proportional to
    (1 - f) exp(-z^2 / 2) + f / w exp(-z^2 / 2 w^2).

    Parameters
    ----------
    fraction : float
        The fraction f of the observations that is wrong, above 0 and below 1.
    width : float
        The factor w by which the errors of these are larger, above 1.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.fitting.Outliers(fraction=0.05, width=10.0)
    Outliers(fraction=0.05, width=10.0)
    """

    fraction: float = 0.05
    width: float = 10.0

    def __post_init__(self) -> None:
        UNITLESS.number(self.fraction, "number", "fraction", Limits(above=0.0, below=1.0))
        UNITLESS.number(self.width, "number", "width", Limits(above=1.0))

    def __call__(self, z: Floats) -> Floats:
        """Return the loss (3, ...) of squares z (...) of residuals, with its first and second derivatives."""
        w2 = self.width**-2
        heights = np.log(1.0 - self.fraction), np.log(self.fraction / self.width)
        total = np.logaddexp(heights[0] - 0.5 * z, heights[1] - 0.5 * z * w2)
        correct = np.exp(heights[0] - 0.5 * z - total)
        first = correct + (1.0 - correct) * w2
        second = -0.5 * correct * (1.0 - correct) * (1.0 - w2) ** 2
        return np.stack([2.0 * (np.logaddexp(*heights) - total), first, second])


def _huber(z: Floats) -> Floats:
    root = np.sqrt(np.maximum(z, 1.0))
    return np.stack([np.where(z <= 1.0, z, 2.0 * root - 1.0), 1.0 / root, np.where(z <= 1.0, 0.0, -0.5 * root**-3)])


#: The losses of scipy's ``least_squares`` with their derivatives.
_NAMED: dict[str, Callable[[Floats], Floats]] = {
    "linear": lambda z: np.stack([z, np.ones_like(z), np.zeros_like(z)]),
    "soft_l1": lambda z: np.stack([2.0 * z / (1.0 + np.sqrt(1.0 + z)), (1.0 + z) ** -0.5, -0.5 * (1.0 + z) ** -1.5]),
    "huber": _huber,
    "cauchy": lambda z: np.stack([np.log1p(z), 1.0 / (1.0 + z), -((1.0 + z) ** -2)]),
    "arctan": lambda z: np.stack([np.arctan(z), 1.0 / (1.0 + z * z), -2.0 * z / (1.0 + z * z) ** 2]),
}


class Loss:
    """A loss function of pulls, each of which is replaced by the signed root of its loss.

    The sum of the squares of these roots is the sum of the losses, so that a solver of least squares takes them.
    """

    def __init__(self, argument: Any, function: Callable[[Floats], Any]) -> None:
        self.argument = argument
        self._function = function
        #: Whether pulls stay as they are, in a linear loss.
        self.linear = argument == "linear"

    def __reduce__(self) -> Any:
        return (loss_of, (self.argument,))

    def _of(self, pulls: Floats) -> Floats:
        rho = np.asarray(self._function(pulls**2), dtype=np.float64)
        if rho.shape != (3, *pulls.shape) or not np.isfinite(rho).all() or (rho[0] < 0.0).any():
            raise InvalidInput(
                f"loss is {self.argument!r}, which gives {rho!r}; expected rho >= 0 and its first and second "
                "derivatives (3, ...), finite, for squares (...) of residuals"
            )
        return rho

    def roots(self, pulls: Floats) -> tuple[Floats, Floats]:
        """Return the signed roots (M,) of the losses of pulls (M,), and their derivatives with respect to the pulls."""
        if self.linear:
            return pulls, np.ones_like(pulls)
        rho, slope, _ = self._of(pulls)
        root = np.sqrt(rho)
        small = np.abs(pulls) < 1e-8
        safe = np.where(small, 1.0, root)
        return np.sign(pulls) * root, np.where(small, np.sqrt(slope), slope * np.abs(pulls) / safe)

    def total(self, pulls: Floats) -> float:
        """Return the sum of the losses of pulls (M,)."""
        return float(np.sum(self._of(pulls)[0]))

    def influence(self, pulls: Floats) -> tuple[Floats, Floats]:
        """Return the weights (M,) of pulls (M,), psi over the pulls, and the derivatives (M,) of psi, half the
        derivative of the loss.
        """
        if self.linear:
            return np.ones_like(pulls), np.ones_like(pulls)
        _, slope, curvature = self._of(pulls)
        return slope, slope + 2.0 * curvature * pulls**2

    def inflation(self, pulls: Floats, free: int) -> float:
        """Return the factor from the covariance of weighted least squares to that of an M-estimator.

        With psi half the derivative of the loss, it is the mean of psi^2 over the square of the mean of psi', where the
        information is that of the unweighted residuals (Huber & Ronchetti 2009, Robust Statistics, Eq. 7.82).
        """
        slope, change = self.influence(pulls)
        psi = slope * pulls
        steep = float(change.mean())
        if not steep > 0.0 or len(pulls) <= free:
            raise InvalidInput(
                f"loss is {self.argument!r}, which takes most residuals for outliers; expected larger errors or "
                "another loss"
            )
        return float((psi**2).sum() / (len(pulls) - free) / steep**2)


def loss_of(argument: Any) -> Loss:
    """Return the loss of a name, of :class:`Outliers`, or of a function as scipy's ``least_squares`` takes it."""
    if callable(argument):
        return Loss(argument, argument)
    if not isinstance(argument, str) or argument not in _NAMED:
        raise InvalidInput(
            f"loss is {argument!r}; expected one of {', '.join(_NAMED)}, fullbody.fitting.Outliers(...), or a function"
        )
    return Loss(argument, _NAMED[argument])


#: The loss of least squares.
LINEAR = loss_of("linear")
