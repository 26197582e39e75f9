"""Integrators and their settings."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any, Literal

from . import _core
from ._records import Alike
from ._units import gathered, is_quantity, numbers, scalar, strip_to
from .errors import InvalidInput, PrecisionWarning

__all__ = [
    "DormandPrince54",
    "LieGroupVariational",
    "SymplecticSplitting",
    "Verner65",
    "Verner76",
    "Verner87",
    "Verner98",
]


class Integrator(Alike):
    """Base of all integrators."""

    __slots__ = ()

    def _arguments(self, strip: Any) -> tuple[str, float, float, float, str]:
        """Name, rtol, atol, step, scheme for the core; ``strip`` turns a time into the system's units."""
        raise NotImplementedError

    def _describe(self, strip: Any) -> dict[str, Any]:
        """Name and settings in numbers."""
        name, rtol, atol, step, scheme = self._arguments(strip)
        if isinstance(self, _Adaptive):
            return {"name": name, "rtol": rtol, "atol": atol}
        return {"name": name, "step": step, **({"scheme": scheme} if scheme else {})}


def rebuild(described: dict[str, Any]) -> Integrator:
    """The integrator of a description."""
    settings = dict(described)
    name = settings.pop("name")
    if name not in __all__:
        raise InvalidInput(f"integrator is {name!r}; expected one of {', '.join(__all__)}")
    integrator: Integrator = globals()[name](**settings)
    return integrator


@dataclass(frozen=True, slots=True, eq=False)
class _Adaptive(Integrator):
    """A Runge-Kutta pair with step control.

    The error of a step is held below ``rtol`` times the present scale of each quantity plus ``atol`` times its scale at
    the start: positions against the nearest separation, velocities against their own size or that of a circular orbit
    there, attitudes against one, spins against their own size or that orbit's rate. Both tolerances are pure numbers.

    Parameters
    ----------
    rtol, atol : float
        From 0 to below 1, not both zero. Where their sum is below what doubles can do, rtol is raised to that, with a
        warning.
    """

    rtol: float = 1e-13
    atol: float = 1e-13

    def __post_init__(self) -> None:
        for name in ("rtol", "atol"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value < 1.0:
                raise InvalidInput(f"{name} is {value!r}; expected a number from 0 to below 1")
        if self.rtol == 0.0 and self.atol == 0.0:
            raise InvalidInput("rtol and atol are both 0; expected at least one above zero")
        floor = _core.tolerance_floor()
        if self.rtol + self.atol < floor:
            text = f"rtol + atol is {self.rtol + self.atol:g}, below what doubles can do; rtol is raised to {floor:g}"
            warnings.warn(text, PrecisionWarning, stacklevel=3)
            rtol = floor - self.atol
            # Rounded up, lest the settings warn again when they are read from a file.
            object.__setattr__(self, "rtol", rtol if rtol + self.atol >= floor else math.nextafter(rtol, 1.0))

    def _arguments(self, strip: Any) -> tuple[str, float, float, float, str]:
        return (type(self).__name__, self.rtol, self.atol, 0.0, "")


@dataclass(frozen=True, slots=True, eq=False)
class Verner98(_Adaptive):
    """Verner's Runge-Kutta pair of orders 9 and 8, with dense output of order 9: the default.

    The error of a step is held below ``rtol`` times the present scale of each quantity plus ``atol`` times its scale at
    the start: positions against the nearest separation, velocities against their own size or that of a circular orbit
    there, attitudes against one, spins against their own size or that orbit's rate. Both tolerances are pure numbers.

    Parameters
    ----------
    rtol, atol : float
        From 0 to below 1, not both zero. Where their sum is below what doubles can do, rtol is raised to that, with a
        warning.

    References
    ----------
    J. H. Verner (2010), Numer. Algor. 53, 383.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Verner98(rtol=1e-12)
    Verner98(rtol=1e-12, atol=1e-13)
    """


@dataclass(frozen=True, slots=True, eq=False)
class Verner87(_Adaptive):
    """Verner's pair of orders 8 and 7; tolerances as in :class:`Verner98`.

    Parameters
    ----------
    rtol, atol : float
    """


@dataclass(frozen=True, slots=True, eq=False)
class Verner76(_Adaptive):
    """Verner's pair of orders 7 and 6; tolerances as in :class:`Verner98`.

    Parameters
    ----------
    rtol, atol : float
    """


@dataclass(frozen=True, slots=True, eq=False)
class Verner65(_Adaptive):
    """Verner's pair of orders 6 and 5; tolerances as in :class:`Verner98`.

    Parameters
    ----------
    rtol, atol : float
    """


@dataclass(frozen=True, slots=True, eq=False)
class DormandPrince54(_Adaptive):
    """The pair of Dormand and Prince of orders 5 and 4; tolerances as in :class:`Verner98`.

    Parameters
    ----------
    rtol, atol : float

    References
    ----------
    J. R. Dormand & P. J. Prince (1980), J. Comput. Appl. Math. 6, 19.
    """


def _time(step: Any) -> Any:
    """A step that is a finite time above zero; its unit is the system's to judge."""
    step = gathered(step, "step")
    if is_quantity(step):
        from astropy import units as u

        strip_to(step, u.s, "step")
    value = scalar(numbers(getattr(step, "value", step), "step"), "step")
    if not (math.isfinite(value) and value > 0.0):
        raise InvalidInput(f"step is {step!r}; expected a finite time above zero")
    return step


@dataclass(frozen=True, slots=True, eq=False)
class LieGroupVariational(Integrator):
    """The Lie group variational integrator on SE(3): second order, symplectic, one evaluation a step.

    Parameters
    ----------
    step : float or Quantity
        Size of the steps, a time in the system's units.

    References
    ----------
    T. Lee, M. Leok & N. H. McClamroch (2007), Comput. Methods Appl. Mech. Engrg. 196, 2907.
    """

    step: Any

    def __post_init__(self) -> None:
        object.__setattr__(self, "step", _time(self.step))

    def _arguments(self, strip: Any) -> tuple[str, float, float, float, str]:
        return (type(self).__name__, 0.0, 0.0, strip(self.step), "")


@dataclass(frozen=True, slots=True, eq=False)
class SymplecticSplitting(Integrator):
    """Kepler motion and free rotation solved exactly, the rest of the interaction as kicks.

    Symplectic and time-reversible. N bodies are taken in Jacobi's coordinates: let the first two be the closest pair.
    The steps have to resolve the rotation as well as the orbit: for a triaxial body some ten steps a turn.

    Parameters
    ----------
    step : float or Quantity
        Size of the steps, a time in the system's units.
    scheme : {"ABA864", "ABA1064", "leapfrog"}
        The near-integrable compositions (8,6,4) and (10,6,4), or the leapfrog.

    References
    ----------
    S. Blanes et al. (2013), Appl. Numer. Math. 68, 58.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4_ho2021("spheroid")
    >>> run = system.integrate(state, 73.0, integrator=fullbody.SymplecticSplitting(step=0.73), output=[73.0])
    >>> run.statistics.steps
    100
    """

    step: Any
    scheme: Literal["ABA864", "ABA1064", "leapfrog"] = "ABA864"

    def __post_init__(self) -> None:
        object.__setattr__(self, "step", _time(self.step))
        schemes = ("ABA864", "ABA1064", "leapfrog")
        if not (isinstance(self.scheme, str) and self.scheme in schemes):
            raise InvalidInput(f"scheme is {self.scheme!r}; expected one of {schemes}")

    def _arguments(self, strip: Any) -> tuple[str, float, float, float, str]:
        return (type(self).__name__, 0.0, 0.0, strip(self.step), self.scheme)
