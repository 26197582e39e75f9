"""Integrators and their settings."""

from __future__ import annotations

from dataclasses import dataclass

from .errors import InvalidInput

__all__ = ["Verner98"]


@dataclass(frozen=True, slots=True)
class Verner98:
    """Verner's Runge-Kutta pair of orders 9 and 8, with dense output of order 9.

    The error of a step is held below ``rtol`` times the present scale of each quantity plus ``atol`` times its scale
    at the start: positions against the nearest separation, velocities against their own size or that of a circular
    orbit there, attitudes against one, spins against their own size or that orbit's rate. Both tolerances are pure
    numbers.

    Parameters
    ----------
    rtol, atol : float
        From 0 to below 1, not both zero.

    References
    ----------
    J. H. Verner (2010), Numer. Algor. 53, 383.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Verner98(rtol=1e-12)
    Verner98(rtol=1e-12, atol=1e-13)
    """

    rtol: float = 1e-13
    atol: float = 1e-13

    def __post_init__(self) -> None:
        for name in ("rtol", "atol"):
            value = getattr(self, name)
            if not isinstance(value, int | float) or not 0.0 <= value < 1.0:
                raise InvalidInput(f"{name} is {value!r}; expected a number from 0 to below 1")
        if self.rtol == 0.0 and self.atol == 0.0:
            raise InvalidInput("rtol and atol are both 0; expected at least one above zero")
