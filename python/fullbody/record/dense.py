"""The continuous solution of a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..model.state import State
from ..typing import Array, Scalar

if TYPE_CHECKING:
    from ..motion.system import System

__all__ = ["Dense", "Samples"]


class Dense:
    """The continuous solution of a run, a function of time.

    Copies share the steps of which it consists. It cannot be pickled; pickle samples of it instead, ``dense(times)``.

    Attributes
    ----------
    range : tuple
        The first and the last time, in the direction of the run.
    """

    def __init__(self, system: System, core: _core.Dense) -> None:
        self._system = system
        self._core = core

    @property
    def range(self) -> tuple[Scalar, Scalar]:
        """The first and the last time, in the direction of the run."""
        start, end = self._core.range
        return (self._system._units.attach(start, "time"), self._system._units.attach(end, "time"))

    @overload
    def __call__(self, time: float | str) -> State: ...
    @overload
    def __call__(self, time: Sequence[float] | npt.NDArray[Any]) -> Samples: ...
    def __call__(self, time: Any) -> State | Samples:
        """Return the state at a time of the run, or the states at many times.

        Parameters
        ----------
        time : float, Quantity or array_like, (K,)
            Times within the run, in any order.

        Returns
        -------
        State or Samples
        """
        units = self._system._units
        values = units.strip(time, "time", "time")
        low, high = sorted(self._core.range)
        outside = values[~((values >= low) & (values <= high))]
        if outside.size:
            first, last = units.attach(low, "time"), units.attach(high, "time")
            raise InvalidInput(
                f"time is {units.attach(outside[0], 'time')}; expected one from {first} to {last}, which the run covers"
            )
        if values.ndim == 0:
            return self._system._state(self._core.state(float(values)))
        if values.ndim != 1:
            raise InvalidInput(f"time has shape {values.shape}; expected a number or (K,)")
        arrays = self._core.states(values)
        return Samples(
            units.attach(values, "time"),
            units.attach(arrays["position"], "length"),
            units.attach(arrays["velocity"], "velocity"),
            arrays["attitude"],
            units.attach(arrays["spin"], "spin"),
        )

    def __copy__(self) -> Dense:
        return self

    def __deepcopy__(self, memo: Any) -> Dense:
        return self

    def __reduce__(self) -> Any:
        raise TypeError("a continuous solution does not pickle; pickle samples of it, dense(times)")

    def __repr__(self) -> str:
        start, end = self.range
        return f"Dense(from {start} to {end}, {self._core.bytes / 1e6:.1f} MB)"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Samples(ArrayFields):
    """States of a run at given times.

    Attributes
    ----------
    time : ndarray or Quantity, (K,)
    position, velocity, spin : ndarray or Quantity, (K, N, 3)
    attitude : ndarray, (K, N, 4)
    """

    time: Array
    position: Array
    velocity: Array
    attitude: npt.NDArray[np.float64]
    spin: Array
