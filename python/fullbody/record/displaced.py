"""Derivatives of functions of a run, from the run displaced along its own tangent vectors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from .. import _core
from ..base import rotations
from ..base.differences import difference
from ..base.units import is_quantity
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..events import Occurrence

if TYPE_CHECKING:
    from ..motion.run import Run

__all__ = ["FunctionDerivatives", "derivatives_of"]

_Array = npt.NDArray[np.float64]

#: The largest displacement in natural sizes; the error of the differences, relative to their scale, is its square.
_STEP = 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class FunctionDerivatives(ArrayFields):
    """The value of a function of a run and its derivatives.

    Attributes
    ----------
    value : float, ndarray or Quantity
        Value of the function for the run itself.
    start : ndarray, (..., 12 N)
        Derivatives with respect to the start: per body position, velocity, rotation vector (body frame) and spin, in
        the value's own unit divided by the system's.
    by_parameter : dict of float or ndarray
        Derivatives with respect to the parameters by which the run was differentiated.
    """

    value: Any
    start: Any
    by_parameter: dict[str, Any]

    def __repr__(self) -> str:
        parameters = ", ".join(self.by_parameter)
        value = f"value of shape {np.shape(self.value)}" if np.ndim(self.value) else repr(self.value)
        return f"FunctionDerivatives({value}{', parameters ' + parameters if parameters else ''})"


def derivatives_of(run: Run, function: Callable[[Any], Any], start: bool) -> FunctionDerivatives:
    """Compute the derivatives of a function of a run; see :meth:`fullbody.Run.derivative_of`."""
    if not callable(function):
        raise InvalidInput(f"function is {function!r}; expected a function of a Run")
    value = function(run)
    unit = value.unit if is_quantity(value) else None
    events = _EventsByColumn(run)
    size = run.transition.shape[-1]

    plain = np.asarray(value if unit is None else value.value, dtype=np.float64)

    def by(name: str | int) -> _Array:
        columns = run.transition[:, :, name] if isinstance(name, int) else run.sensitivity[name]
        step = _STEP / max(float(np.abs(columns / _sizes(run)).max(initial=0.0)), 1e-300)
        if isinstance(name, str):
            step = min(step, _STEP * run.system._changed(name, 0.0)[1])

        def change(shift: float) -> _Array:
            displaced = function(_displaced(run, name, columns, shift, events))
            numbers = np.asarray(displaced if unit is None else displaced.to_value(unit), dtype=np.float64)
            if numbers.shape != plain.shape:
                raise InvalidInput(
                    f"the function gives values of shapes {plain.shape} and {numbers.shape}; expected the same shape "
                    "for runs that differ little"
                )
            return np.asarray(numbers - plain)

        return difference(change, step)

    by_start = np.stack([by(column) for column in range(size)], axis=-1) if start else None
    found = {name: by(name) for name in run._parameters}
    return FunctionDerivatives(value, by_start, {name: _scalar(numbers) for name, numbers in found.items()})


def _scalar(numbers: _Array) -> Any:
    return float(numbers) if numbers.ndim == 0 else numbers


def _sizes(run: Run) -> _Array:
    """Return natural sizes of the 12 N components of a tangent vector, over the whole run."""
    record = run._record

    def largest(vectors: _Array) -> float:
        return float(np.linalg.norm(vectors, axis=-1).max(initial=0.0))

    length = largest(record["position"] - record["position"].mean(axis=1, keepdims=True)) or 1.0
    speed = largest(record["velocity"] - record["velocity"].mean(axis=1, keepdims=True)) or length
    spin = largest(record["spin"]) or speed / length
    return np.tile(np.repeat([length, speed, 1.0, spin], 3), record["position"].shape[1])


def _displaced(run: Run, name: str | int, columns: _Array, by: float, events: _EventsByColumn) -> Run:
    """Return a run whose samples and events are displaced."""
    system = run.system._changed(name, by)[0] if isinstance(name, str) else run.system
    record = _Record(system, _moved(run._record, columns, by))
    start = run._start
    if len(run):
        first = record.state(0)
        start = np.concatenate([[first.time], system._core.energy(first), system._core.angular_momentum(first)])
    displaced = type(run)(
        system,
        run.integrator,
        record,
        start,
        run.statistics,
        stop_reason=run.stop_reason,
        switched_off=run.switched_off,
    )
    displaced.events = _Events(run, name, by, events)  # type: ignore[assignment]
    return displaced


def _moved(record: Any, columns: _Array, by: float) -> dict[str, _Array]:
    """Return the numbers of states (K,) displaced by tangent vectors (K, 12 N)."""
    samples, bodies = record["position"].shape[:2]
    moved = (by * columns).reshape(samples, bodies, 4, 3)
    return {
        "time": record["time"].copy(),
        "position": record["position"] + moved[:, :, 0],
        "velocity": record["velocity"] + moved[:, :, 1],
        "attitude": rotations.products(record["attitude"], rotations.of_vectors(moved[:, :, 2])),
        "spin": record["spin"] + moved[:, :, 3],
    }


class _Record(dict[str, _Array]):
    """The arrays of a displaced run; energies and angular momenta are computed on demand."""

    def __init__(self, system: Any, arrays: dict[str, _Array]) -> None:
        super().__init__(arrays)
        self._system = system

    def __missing__(self, name: str) -> _Array:
        if name not in ("energy", "angular_momentum"):
            raise InvalidInput(
                f"a function of a displaced run asks for its {name.replace('_', ' ')}; expected one of samples and "
                "events, energies and angular momenta"
            )
        quantity = getattr(self._system._core, name)
        self[name] = np.array([quantity(self.state(k)) for k in range(len(self["time"]))])
        return self[name]

    def state(self, k: int) -> _core.State:
        """Return the state of a sample in the form that the core takes."""
        arrays = (np.ascontiguousarray(self[key][k]) for key in ("position", "velocity", "attitude", "spin"))
        return _core.State(float(self["time"][k]), *arrays)


class _EventsByColumn:
    """The derivatives of the events of a run, computed once for all columns."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._known: dict[int, Any] = {}

    def __getitem__(self, k: int) -> Any:
        if k not in self._known:
            self._known[k] = self._run.at_event(k)
        return self._known[k]


class _Events(Sequence[Occurrence]):
    """The events of a displaced run, each displaced on demand."""

    def __init__(self, run: Run, name: str | int, by: float, known: _EventsByColumn) -> None:
        self._run, self._name, self._by, self._known = run, name, by, known

    def __len__(self) -> int:
        return len(self._run.events)

    def __iter__(self) -> Iterator[Occurrence]:
        return (self._one(k) for k in range(len(self)))

    @overload
    def __getitem__(self, k: int) -> Occurrence: ...
    @overload
    def __getitem__(self, k: slice) -> list[Occurrence]: ...
    def __getitem__(self, k: int | slice) -> Occurrence | list[Occurrence]:
        places = range(len(self))[k]
        return [self._one(place) for place in places] if isinstance(places, range) else self._one(places)

    def _one(self, k: int) -> Occurrence:
        happened, found, name = self._run.events[k], self._known[k], self._name
        system = self._run.system
        if isinstance(name, int):
            time, columns = found.time[name], found.transition[:, name]
        else:
            time, columns = found.time_sensitivity[name], found.sensitivity[name]
        core = system._strip(happened.state)
        record = {key: getattr(core, key)[np.newaxis] for key in ("position", "velocity", "attitude", "spin")}
        moved = _moved(record | {"time": np.array([core.time + self._by * time])}, columns[np.newaxis], self._by)
        arrays = (np.ascontiguousarray(moved[key][0]) for key in ("position", "velocity", "attitude", "spin"))
        state = system._state(_core.State(float(moved["time"][0]), *arrays))
        return Occurrence(happened.event, state.time, state)
