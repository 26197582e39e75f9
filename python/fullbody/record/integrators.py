"""Integrators and their settings."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any, ClassVar, Literal, get_args

import fullbody._core as _core

from ..base.kinds import Declared, Number, choice, of_kind
from ..base.limits import POSITIVE, Limits
from ..base.units import Units
from ..errors import InvalidInput, PrecisionWarning, caution
from ..model.context import SystemLike
from ..model.state import State, strip
from .step_size import longest_step

__all__ = [
    "DormandPrince54",
    "LieGroupVariational",
    "SymplecticSplitting",
    "Verner65",
    "Verner76",
    "Verner87",
    "Verner98",
]

_Scheme = Literal["ABA864", "ABA1064", "leapfrog"]


class Integrator(Declared):
    """Base class of all integrators."""

    __slots__ = ()

    def _what(self, name: str, of: str = "") -> str:
        return name

    @property
    def _tolerance(self) -> float | None:
        """The tolerance of a step relative to the distance of the nearest body; ``None`` with fixed steps."""
        return None

    def _describe(self, units: Units) -> dict[str, Any]:
        """Return name and settings, in numbers of a system's units."""
        settings = {field.name: getattr(self, field.name) for field in fields(self)}  # type: ignore[arg-type]
        return {"name": type(self).__name__, **settings, **self._unitless(units)}


def rebuild(described: dict[str, Any]) -> Integrator:
    """Rebuild an integrator from its description."""
    settings = dict(described)
    name = settings.pop("name")
    if name == _TO_ROUNDOFF:
        return Verner98.to_roundoff()
    if name not in __all__:
        raise InvalidInput(f"integrator is {name!r}; expected one of {', '.join(__all__)}")
    return globals()[name](**settings)


@dataclass(frozen=True, slots=True, eq=False)
class _Adaptive(Integrator):
    """A Runge-Kutta pair with step control; :class:`Verner98` describes its tolerances."""

    #: Whether tolerances of zero mean the tightest useful steps.
    _to_roundoff: ClassVar[bool] = False

    rtol: float = field(default=1e-13, metadata=of_kind(Number(limits=Limits(least=0.0, below=1.0))))
    atol: float = field(default=1e-13, metadata=of_kind(Number(limits=Limits(least=0.0, below=1.0))))

    def __post_init__(self) -> None:
        self._check_fields()
        if self._to_roundoff and self.rtol == 0.0 and self.atol == 0.0:
            return
        rtol, _ = _core.tolerance(self.rtol, self.atol)
        if rtol > self.rtol:
            text = f"rtol + atol is {self.rtol + self.atol:g}, below what doubles can do; rtol is raised to {rtol:g}"
            if self._to_roundoff:
                text += "; Verner98.to_roundoff() takes shorter steps"
            caution(text, PrecisionWarning)
            object.__setattr__(self, "rtol", rtol)

    @property
    def _tolerance(self) -> float | None:
        return self.rtol + self.atol


#: The core's name of the integrator from :meth:`Verner98.to_roundoff`.
_TO_ROUNDOFF = "Verner98ToRoundoff"


@dataclass(frozen=True, slots=True, eq=False)
class Verner98(_Adaptive):
    """Verner's Runge-Kutta pair of orders 9 and 8 (2010, Numer. Algor. 53, 383), with dense output of order 9: the
    default.

    The error of a step is held below ``rtol`` times the present scale of each quantity plus ``atol`` times its scale at
    the start: positions against the nearest separation, velocities against their own size or that of a circular orbit
    there, attitudes against one, spins against their own size or that orbit's rate.

    Parameters
    ----------
    rtol, atol : float
        Numbers from 0 to below 1. If their sum is below the accuracy of double precision, rtol is raised, with a
        warning. If both are zero, this is the integrator of :meth:`to_roundoff`.

    Notes
    -----
    The errors of successive steps add up in the same direction at every tolerance: the energy drifts in proportion to
    the time. At the default that is 5e-17 per step on a Kepler orbit of eccentricity 0.1, 8e-16 at 0.5, and 1e-19 of
    the orbital energy in 1999 KW4. A tenth of the tolerance gives a tenth of the drift. For runs of a million steps and
    more that should conserve the energy as well as double precision permits, take :meth:`to_roundoff`, or
    :class:`SymplecticSplitting`.

    Examples
    --------
    >>> import fullbody
    >>> fullbody.Verner98(rtol=1e-12)
    Verner98(rtol=1e-12, atol=1e-13)
    """

    _to_roundoff: ClassVar[bool] = True

    @classmethod
    def to_roundoff(cls) -> Verner98:
        """Make an integrator with steps so short that only round-off remains, whatever the eccentricity.

        Both its tolerances are zero. The error of the energy is a random walk that grows as the root of the number of
        steps (Brouwer 1937, Astron. J. 46, 149; Rein & Spiegel 2015, Mon. Not. R. Astron. Soc. 446, 1424), with a small
        drift of round-off, for two points of masses 7 to 3 about 2e-20 of the energy per step. The cost is three times
        the evaluations of the default. The steps are controlled by a formula of order 6 instead of 8, whose estimate
        is itself round-off with such short steps.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.case1()
        >>> run = system.integrate(state, 100.0, integrator=fullbody.Verner98.to_roundoff())
        >>> bool(abs(run.energy_drift).max() < 1e-14)
        True
        """
        return cls(0.0, 0.0)

    def _describe(self, units: Units) -> dict[str, Any]:
        tightest = self.rtol == 0.0 and self.atol == 0.0
        return {"name": _TO_ROUNDOFF} if tightest else _Adaptive._describe(self, units)

    def __repr__(self) -> str:
        tightest = self.rtol == 0.0 and self.atol == 0.0
        return "Verner98.to_roundoff()" if tightest else f"Verner98(rtol={self.rtol!r}, atol={self.atol!r})"


@dataclass(frozen=True, slots=True, eq=False)
class Verner87(_Adaptive):
    """Verner's pair of orders 8 and 7; ``rtol`` and ``atol`` as in :class:`Verner98`."""


@dataclass(frozen=True, slots=True, eq=False)
class Verner76(_Adaptive):
    """Verner's pair of orders 7 and 6; ``rtol`` and ``atol`` as in :class:`Verner98`."""


@dataclass(frozen=True, slots=True, eq=False)
class Verner65(_Adaptive):
    """Verner's pair of orders 6 and 5; ``rtol`` and ``atol`` as in :class:`Verner98`."""


@dataclass(frozen=True, slots=True, eq=False)
class DormandPrince54(_Adaptive):
    """The pair of Dormand & Prince (1980, J. Comput. Appl. Math. 6, 19), orders 5 and 4; see :class:`Verner98`."""


@dataclass(frozen=True, slots=True, eq=False)
class LieGroupVariational(Integrator):
    """The Lie group variational integrator on SE(3): second order, symplectic, one evaluation per step.

    See Lee, Leok & McClamroch (2007), Comput. Methods Appl. Mech. Engrg. 196, 2907.

    Parameters
    ----------
    step : float or Quantity
        Size of the steps, a time in the system's units. A step in which a body turns by a rad or more may have no
        solution; a run then ends with a :class:`fullbody.errors.NotConverged` that names the body and a step that has
        one.
    """

    step: Any = field(metadata=of_kind(Number("time", POSITIVE)))


@dataclass(frozen=True, slots=True, eq=False)
class SymplecticSplitting(Integrator):
    """A symplectic splitting: Kepler motion and free rotation solved exactly, the rest of the interaction as kicks.

    The method is symplectic and time-reversible. N bodies are described in Jacobi coordinates, and the first two bodies
    should be the closest pair. The steps have to resolve the rotation as well as the orbit: for a triaxial body about
    ten steps per turn. :meth:`suggest` finds a step.

    Parameters
    ----------
    step : float or Quantity
        Size of the steps, a time in the system's units. A step in which a triaxial body turns by more than 1024 rad is
        refused with :class:`fullbody.errors.NotConverged`, which names a step that is accepted.
    scheme : {"ABA864", "ABA1064", "leapfrog"}
        The near-integrable compositions (8,6,4) and (10,6,4) of Blanes et al. (2013, Appl. Numer. Math. 68, 58), or the
        leapfrog.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4_ho2021("spheroid")
    >>> run = system.integrate(state, 73.0, integrator=fullbody.SymplecticSplitting(step=0.73), output=[73.0])
    >>> run.statistics.steps
    100
    """

    step: Any = field(metadata=of_kind(Number("time", POSITIVE)))
    scheme: _Scheme = field(default="ABA864", metadata=of_kind(partial(choice, words=get_args(_Scheme))))

    @classmethod
    def suggest(
        cls,
        system: SystemLike,
        state: State,
        *,
        energy_error: float = 1e-9,
        scheme: _Scheme = "ABA864",
        trial: Any = None,
    ) -> SymplecticSplitting:
        """Find by short trial runs the longest step that keeps the energy's error below a bound.

        Steps from an eighth of the shortest orbit downwards, each 0.84 times the last one, or less if the error is far
        too large, are tried for 64 such orbits. The result is the first step that keeps the energy's error below the
        bound, without growth from the first half to the second, and whose neighbours, 2 per cent shorter and longer,
        stay below twice the bound. Steps within 3 per cent of resonances of a triaxial body are skipped, in which it
        turns relative to another body by a multiple of a half turn in one, two or three steps. The method's own error
        is periodic; the trials do not cover round-off and chaos.

        Parameters
        ----------
        system : System
        state : State
        energy_error : float
            Largest error of the energy in a trial, relative to that of the orbits: abs(potential + translational). A
            run that is much longer may exceed it; a long run of 1999 KW4 with spheroids does so by a half.
        scheme : {"ABA864", "ABA1064", "leapfrog"}
        trial : float or Quantity, optional
            Length of a trial, a time in the system's units, for an energy that varies slowly, as that of an eccentric
            orbit about other bodies.

        Raises
        ------
        NotConverged
            If no step suffices, as for bodies that come close to each other or turn too fast. The message gives the
            least error found.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4_ho2021("spheroid")
        >>> fullbody.SymplecticSplitting.suggest(system, state, energy_error=1e-9).step  # doctest: +SKIP
        1.15
        """
        context = system.context

        def describe(step: float) -> dict[str, Any]:
            return cls(step=step, scheme=scheme)._describe(context.units)

        step = longest_step(describe, context, strip(state, context), energy_error, trial)
        return cls(step=context.units.attach(step, "time"), scheme=scheme)
