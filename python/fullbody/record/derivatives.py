"""Derivatives of a run at its events, and of functions of it, from the run displaced along its tangent vectors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from ..base import rotations
from ..base.arguments import integer
from ..base.differences import difference
from ..base.kinds import function as check_function
from ..base.units import is_quantity
from ..base.values import ArrayFields
from ..errors import InvalidInput
from ..events import Occurrence
from ..model.state import PARTS, sample, strip, wrap
from ..typing import Floats
from .record import Record


@dataclass(frozen=True, slots=True, eq=False)
class EventDerivatives(ArrayFields):
    """Derivatives of the time and the state of an event with respect to the start of a run and to parameters.

    Those of the state include the change of the event's time. Parameters are those of the run and of the event itself.

    Attributes
    ----------
    time : ndarray, (12 N,)
        Derivatives of the event's time with respect to the start of the run.
    transition : ndarray, (12 N, 12 N)
        Derivatives of the state at the event with respect to the start of the run.
    time_sensitivity : dict of float
        Derivatives of the event's time with respect to the parameters.
    sensitivity : dict of ndarray, (12 N,)
        Derivatives of the state at the event with respect to the parameters.
    """

    time: Floats
    transition: Floats
    time_sensitivity: dict[str, float]
    sensitivity: dict[str, Floats]

    def __repr__(self) -> str:
        bodies, parameters = len(self.time) // 12, ", ".join(self.sensitivity)
        return f"EventDerivatives({bodies} bodies{', parameters ' + parameters if parameters else ''})"


def at_event(run: Record, k: int = -1) -> EventDerivatives:
    """Return the derivatives of the time and the state of an event.

    At a zero of the event's function g the time changes by dt = -(grad g . dx + dg/dp dp) / (dg/dt), and the state by
    dx + f dt, with dx the tangent vector at a fixed time and f the rates of change there. The derivatives of g itself
    are differences of eighth order. A :class:`fullbody.events.Function` depends only on the state and has no dg/dp; for
    a closest approach, the third body keeps its position relative to the barycentre at the event.

    Parameters
    ----------
    k : int
        Index of the event in :attr:`events`; by default the last one.

    Returns
    -------
    EventDerivatives
        Its dictionaries have the parameters of the run and those of the event, such as ``"value of Separation"``.

    Raises
    ------
    InvalidInput
        For a run without ``derivatives=``, for an event that the run does not have, and for one whose function is
        constant along the run.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> apsis = fullbody.events.Periapsis(0, 1)
    >>> run = system.integrate(state, 40.0, output="ends", events=[apsis], derivatives=True)
    >>> run.at_event(0).time.shape
    (24,)
    """
    index = integer(k)
    if index is None or not -len(run.events) <= index < len(run.events):
        raise InvalidInput(f"k is {k!r}; expected the index of one of the {len(run.events)} events of the run")
    happened = run.events[index]
    if happened.derivatives is None:
        raise InvalidInput("the events of this run keep no derivatives; integrate with derivatives=True")
    transition, sensitivity, flow = happened.derivatives
    condition, names = happened.event._condition(run.context), list(run.parameters)
    core = strip(happened.state, run.context)
    gradient, by_time, direct, by_condition = condition.derivatives(run.context.core, core, names)
    rate = gradient @ flow + by_time
    if rate == 0.0:
        raise InvalidInput(f"the function of {happened.event!r} does not change along the run; expected one that does")
    time = -(gradient @ transition) / rate
    fixed = dict(zip(names, sensitivity, strict=True)) | {name: np.zeros_like(flow) for name, _ in by_condition}
    by_parameter = dict(zip(names, direct, strict=True)) | dict(by_condition)
    times = {name: float(-(gradient @ values + by_parameter[name]) / rate) for name, values in fixed.items()}
    states = {name: values + flow * times[name] for name, values in fixed.items()}
    return EventDerivatives(time, transition + np.outer(flow, time), times, states)


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


def derivative_of(run: Any, function: Callable[[Any], Any], *, start: bool = True) -> FunctionDerivatives:
    """Compute the derivatives of a function of the run with respect to its start and its parameters.

    The function is evaluated on the run displaced along its own tangent vectors, twice for each of the 12 N components
    of the start and for each parameter; nothing is integrated. The function may use samples, events, elements, energies
    and angular momenta; a displaced run has no continuous solution, and no work of forces.

    Parameters
    ----------
    function : callable
        A function that takes a :class:`Run` and returns a number, a Quantity or an array. It has to be smooth, as a
        mean is; the largest of the samples is smooth as long as it stays the same sample.
    start : bool
        Whether to compute the derivatives with respect to the start.

    Returns
    -------
    FunctionDerivatives

    Raises
    ------
    InvalidInput
        For a run without ``derivatives=``, and for a function that uses what a displaced run does not have.

    Notes
    -----
    The derivatives are differences of second order over a hundred-thousandth of the natural sizes of the components;
    they are one-sided for a parameter at the end of its range, such as an eccentricity of zero. Their error is about
    1e-9 of the scale of the derivative.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> run = system.integrate(state, 40.0, output=1.0, derivatives=["mass of Alpha"])
    >>> found = run.derivative_of(lambda run: run.elements().e.mean())
    >>> found.start.shape, list(found.by_parameter)
    ((24,), ['mass of Alpha'])
    """
    value = check_function(function, "function", "a function of a Run")(run)
    unit = value.unit if is_quantity(value) else None
    events = cache(run.at_event)
    size = run.transition.shape[-1]
    values = np.asarray(value if unit is None else value.value, dtype=np.float64)

    def derivative(name: str | int) -> Floats:
        columns = run.transition[:, :, name] if isinstance(name, int) else run.sensitivity[name]
        step = _STEP / max(float(np.abs(columns / _sizes(run)).max(initial=0.0)), 1e-300)
        if isinstance(name, str):
            step = min(step, _STEP * run.context.natural_size(name))

        def change(step: float) -> Floats:
            result = function(_displaced(run, name, columns, step, events))
            numbers = np.asarray(result if unit is None else result.to_value(unit), dtype=np.float64)
            if numbers.shape != values.shape:
                raise InvalidInput(
                    f"the function gives values of shapes {values.shape} and {numbers.shape}; expected the same shape "
                    "for runs that differ little"
                )
            return np.asarray(numbers - values)

        return difference(change, step)

    by_start = np.stack([derivative(column) for column in range(size)], axis=-1) if start else None
    derivatives = {name: derivative(name) for name in run.parameters}
    by_parameter = {name: numbers if numbers.ndim else float(numbers) for name, numbers in derivatives.items()}
    return FunctionDerivatives(value, by_start, by_parameter)


def _sizes(run: Any) -> Floats:
    """Return natural sizes of the 12 N components of a tangent vector, over the whole run."""
    record = run.arrays

    def largest(vectors: Floats) -> float:
        return float(np.linalg.norm(vectors, axis=-1).max(initial=0.0))

    length = largest(record["position"] - record["position"].mean(axis=1, keepdims=True)) or 1.0
    speed = largest(record["velocity"] - record["velocity"].mean(axis=1, keepdims=True)) or length
    spin = largest(record["spin"]) or speed / length
    return np.tile(np.repeat([length, speed, 1.0, spin], 3), record["position"].shape[1])


def _displaced(run: Any, name: str | int, columns: Floats, step: float, events: Callable[[int], Any]) -> Any:
    """Return a run whose samples and events are displaced."""
    system = run.system.changed(name, step) if isinstance(name, str) else run.system
    record = _Record(system, _displaced_arrays(run.arrays, columns, step))
    start = run.invariants
    if len(run):
        first = sample(record, 0)
        core = system.context.core
        start = np.concatenate([[first.time], core.energy(first), core.angular_momentum(first)])
    options = {"stop_reason": run.stop_reason, "switched_off": run.switched_off}
    displaced = type(run)(system, run.integrator, record, start, run.statistics, **options)
    displaced.events = _Events(run, name, step, events)
    return displaced


def _displaced_arrays(record: Any, columns: Floats, step: float) -> dict[str, Floats]:
    """Return the arrays of states (K,) displaced along tangent vectors (K, 12 N)."""
    samples, bodies = record["position"].shape[:2]
    position, velocity, rotation, spin = np.moveaxis((step * columns).reshape(samples, bodies, 4, 3), 2, 0)
    return {
        "time": record["time"].copy(),
        "position": record["position"] + position,
        "velocity": record["velocity"] + velocity,
        "attitude": rotations.products(record["attitude"], rotations.of_vectors(np.ascontiguousarray(rotation))),
        "spin": record["spin"] + spin,
    }


class _Record(dict[str, Floats]):
    """The arrays of a displaced run; energies and angular momenta are computed on demand."""

    def __init__(self, system: Any, arrays: dict[str, Floats]) -> None:
        super().__init__(arrays)
        self._system = system

    def __missing__(self, name: str) -> Floats:
        if name not in ("energy", "angular_momentum"):
            expected = "expected one of samples and events, energies and angular momenta"
            raise InvalidInput(f"a function of a displaced run uses its {name.replace('_', ' ')}; {expected}")
        quantity = getattr(self._system.context.core, name)
        self[name] = np.array([quantity(sample(self, k)) for k in range(len(self["time"]))])
        return self[name]


class _Events(Sequence[Occurrence]):
    """The events of a displaced run, each displaced on demand."""

    def __init__(self, run: Any, name: str | int, step: float, derivatives: Callable[[int], EventDerivatives]) -> None:
        self._run, self._name, self._step, self._derivatives = run, name, step, derivatives

    def __len__(self) -> int:
        return len(self._run.events)

    def __getitem__(self, k: Any) -> Any:
        indices = range(len(self))[k]
        return [*map(self._occurrence, indices)] if isinstance(indices, range) else self._occurrence(indices)

    def _occurrence(self, k: int) -> Occurrence:
        happened, derivatives, name = self._run.events[k], self._derivatives(k), self._name
        context = self._run.context
        if isinstance(name, int):
            time, columns = derivatives.time[name], derivatives.transition[:, name]
        else:
            time, columns = derivatives.time_sensitivity[name], derivatives.sensitivity[name]
        core = strip(happened.state, context)
        record = {key: getattr(core, key)[np.newaxis] for key in PARTS}
        record["time"] = np.array([core.time + self._step * time])
        state = wrap(sample(_displaced_arrays(record, columns[np.newaxis], self._step), 0), context)
        return Occurrence(happened.event, state.time, state)
