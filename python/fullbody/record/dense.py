"""The continuous solution of a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..model.context import Context
from ..model.state import DIMENSIONS, State, wrap
from ..typing import Array, Floats, Scalar


class Dense:
    """The continuous solution of a run, a function of time.

    Copies share the steps of which it consists. It cannot be pickled; pickle samples of it instead, ``dense(times)``.
    """

    def __init__(self, context: Context, core: _core.Dense) -> None:
        self.context, self.core = context, core

    @property
    def range(self) -> tuple[Scalar, Scalar]:
        """The first and the last time, in the direction of the run."""
        start, end = self.core.range
        return (self.context.units.attach(start, "time"), self.context.units.attach(end, "time"))

    @overload
    def __call__(self, time: float | str) -> State: ...
    @overload
    def __call__(self, time: Sequence[float] | npt.NDArray[Any]) -> Samples: ...
    def __call__(self, time: Any) -> State | Samples:
        """Return the state at a time of the run, or :class:`~fullbody.record.Samples` at times (K,) in any order."""
        units = self.context.units
        values = units.strip(time, "time", "time")
        if values.ndim > 1:
            raise InvalidInput(f"time has shape {values.shape}; expected a number or (K,)")
        if values.ndim == 0:
            self._check(values)
            return wrap(self.core.state(float(values)), self.context)
        arrays = {"time": values} | self.states(values)
        fields = {name: units.attach(arrays[name], dimension) for name, dimension in DIMENSIONS.items()}
        return Samples(**fields, attitude=arrays["attitude"])

    def states(self, times: Floats, what: str = "time") -> dict[str, Floats]:
        """Return the states at times (K,), all in numbers of the system's units; see :meth:`fullbody.Run.states`."""
        self._check(times, what)
        arrays = self.core.states(np.ascontiguousarray(times))
        # Without any times the core does not know the number of bodies.
        if len(times):
            return arrays
        return {name: values.reshape(0, len(self.context), values.shape[-1]) for name, values in arrays.items()}

    def covers(self, times: Floats) -> npt.NDArray[np.bool_]:
        """Return which of some times, in the system's units, are within the run."""
        low, high = sorted(self.core.range)
        return np.asarray((times >= low) & (times <= high))

    def _check(self, times: Floats, what: str = "time") -> None:
        outside = times[~self.covers(times)]
        if outside.size:
            attach = self.context.units.attach
            first, last = (attach(end, "time") for end in sorted(self.core.range))
            expected = f"expected one from {first} to {last}, since the run does not cover others"
            raise InvalidInput(f"{what} is {attach(outside[0], 'time')}; {expected}")

    def __copy__(self) -> Dense:
        return self

    def __deepcopy__(self, memo: Any) -> Dense:
        return self

    def __reduce__(self) -> Any:
        raise TypeError("a continuous solution does not pickle; pickle samples of it, dense(times)")

    def __repr__(self) -> str:
        start, end = self.range
        return f"Dense(from {start} to {end}, {self.core.bytes / 1e6:.1f} MB)"


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
    attitude: Floats
    spin: Array
