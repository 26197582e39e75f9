"""How a run depends on its start and on parameters of its system."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput
from ..typing import Array

__all__ = ["Differentiated", "departures"]

_KINDS = ("position", "velocity", "rotation", "spin")


def departures(names: tuple[str, ...]) -> list[str]:
    """What the 12 numbers of each body in a departure are."""
    return [f"{name} {kind} {axis}" for name in names for kind in _KINDS for axis in "xyz"]


class Differentiated:
    """What a run has that was integrated with ``derivatives=`` or ``chaos=True``.

    A departure from a run has 12 numbers a body, body after body: position and velocity in the inertial frame, a
    rotation vector theta in the body frame (R becomes R exp(theta), in rad), and spin in the body frame. All are
    numbers in the system's own units.
    """

    system: Any
    _record: dict[str, npt.NDArray[np.float64]]
    #: Names of the parameters that the run was differentiated by.
    _parameters: tuple[str, ...] = ()

    @property
    def transition(self) -> npt.NDArray[np.float64]:
        """Transition matrices (K, 12 N, 12 N): a departure from the start of the run times them is that from a sample.

        In the system's own units, per body position, velocity, rotation vector in the body frame and spin.

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
        """
        if "transition" not in self._record:
            raise InvalidInput("this run keeps no transition matrices; integrate with derivatives=True")
        return self._record["transition"]

    @property
    def sensitivity(self) -> dict[str, npt.NDArray[np.float64]]:
        """Derivatives (K, 12 N) of the samples by parameters of the system, by their names; the start stays as it is.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 10.0, output="ends", derivatives=["G", "mass of Alpha"])
        >>> run.sensitivity["mass of Alpha"].shape
        (2, 24)
        """
        if "transition" not in self._record:
            raise InvalidInput("this run keeps no sensitivities; integrate with derivatives=['mass of ...', ...]")
        values = self._record.get("sensitivity")
        return {} if values is None else {name: values[:, k] for k, name in enumerate(self._parameters)}

    @property
    def megno(self) -> npt.NDArray[np.float64]:
        """Mean of MEGNO since the start of the run (K,): tends to 2 for regular motion, and grows with chaotic motion.

        Of a run with ``chaos=True``; zero at its start. See Cincotta & Simo (2000), Astron. Astrophys. Suppl. 147, 205.

        Examples
        --------
        >>> import fullbody
        >>> system, state = fullbody.systems.kw4()
        >>> run = system.integrate(state, 3000.0, output="ends", chaos=True)
        >>> bool(abs(run.megno[-1] - 2.0) < 0.1)
        True
        """
        return self._chaos(0)

    @property
    def lyapunov(self) -> Array:
        """Growth ln(|delta|/|delta_0|) of a departure over the time since the start (K,), in 1/time.

        Tends to the largest Lyapunov exponent; its inverse is the Lyapunov time. Of a run with ``chaos=True``; departures
        are measured in the natural sizes of their numbers at the start: separation, orbital speed or the body's own,
        rad, and the spin.
        """
        rate: Array = self.system._units.attach(self._chaos(1), "rate")
        return rate

    @property
    def fast_lyapunov(self) -> npt.NDArray[np.float64]:
        """The largest ln(|delta|/|delta_0|) so far (K,): the fast Lyapunov indicator. Of a run with ``chaos=True``."""
        return self._chaos(2)

    def _chaos(self, which: int) -> npt.NDArray[np.float64]:
        if "chaos" not in self._record:
            raise InvalidInput("this run keeps no indicators of chaos; integrate with chaos=True")
        return self._record["chaos"][:, which]
