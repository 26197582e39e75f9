"""How a run depends on its start and on parameters of its system."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..errors import InvalidInput

__all__ = ["Differentiated", "departures"]

_KINDS = ("position", "velocity", "rotation", "spin")


def departures(names: tuple[str, ...]) -> list[str]:
    """What the 12 numbers of each body in a departure are."""
    return [f"{name} {kind} {axis}" for name in names for kind in _KINDS for axis in "xyz"]


class Differentiated:
    """What a run has that was integrated with ``derivatives=``.

    A departure from a run has 12 numbers a body, body after body: position and velocity in the inertial frame, a
    rotation vector theta in the body frame (R becomes R exp(theta), in rad), and spin in the body frame. All are
    numbers in the system's own units.
    """

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
