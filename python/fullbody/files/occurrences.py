"""Conversion of a run's events to variables of a dataset and back."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from typing import Any

import numpy as np

from .. import events
from ..base.units import is_quantity
from ..base.values import UnstoredFunction
from ..errors import InvalidInput
from ..events import Event, Occurrence
from ..model.context import Context
from ..model.state import sample, strip, wrap
from ..record.record import Record
from .reading import Content, check_order, check_unit

#: Variables of states, of runs and of events: further dimensions, dimension of the unit, meaning.
STATES: dict[str, tuple[tuple[str, ...], str | None, str]] = {
    "position": (("body", "axis"), "length", "centres, inertial frame"),
    "velocity": (("body", "axis"), "velocity", "velocities of the centres, inertial frame"),
    "attitude": (("body", "quaternion"), None, "unit quaternions, body frame to inertial"),
    "spin": (("body", "axis"), "spin", "angular velocities, body frames"),
}
_VARIABLES: dict[str, tuple[tuple[str, ...], str | None, str]] = {"time": ((), "time", "times"), **STATES}
#: Variables of derivatives of events, in runs that have them.
_DERIVATIVES: dict[str, tuple[tuple[str, ...], str]] = {
    "transition": (("tangent", "start_tangent"), "transition matrices from the start of the run to the events"),
    "sensitivity": (("parameter", "tangent"), "derivatives of the states at the events by parameters of the system"),
    "flow": (("tangent",), "rates of change of the states at the events"),
}
_KINDS = [name for name in events.__all__ if name not in ("Event", "Occurrence")]


def to_dataset(
    run: Record, attributes: Callable[[str | None, str], dict[str, str]]
) -> tuple[dict[str, Any], dict[str, Any], str]:
    """Return variables, coordinates, and the events as JSON; without an occurrence there are no variables.

    ``attributes`` returns a variable's attributes from the dimension of its unit and its meaning.
    """
    watched: list[Event] = []
    indices = []
    for happened in run.events:
        # Events are found by identity: comparing them would compare arrays and functions in them.
        matches = [k for k, event in enumerate(watched) if event is happened.event]
        indices.append(matches[0] if matches else len(watched))
        watched += [] if matches else [happened.event]
    text = json.dumps([_describe(event) for event in watched])
    if not watched:
        return {}, {}, text
    states = [strip(happened.state, run.context) for happened in run.events]
    variables: dict[str, Any] = {"event_index": ("event", indices, {"long_name": "index in fullbody_events"})}
    for name, (dims, dimension, meaning) in _VARIABLES.items():
        values = np.array([getattr(state, name) for state in states])
        variables[f"event_{name}"] = (("event", *dims), values, attributes(dimension, f"{meaning}, at the events"))
    derivatives_of_events = [happened.derivatives for happened in run.events]
    for k, (name, (dims, meaning)) in enumerate(_DERIVATIVES.items()):
        if all(entry is not None and entry[k].size for entry in derivatives_of_events):
            values = np.array([entry[k] for entry in derivatives_of_events if entry is not None])
            variables[f"event_{name}"] = (("event", *dims), values, attributes(None, meaning))
    labels = [type(happened.event).__name__ for happened in run.events]
    event = ("event", labels, {"long_name": "what happened"})
    return variables, {"event": event, "event_time": variables.pop("event_time")}, text


def from_file(content: Content, context: Context, parameters: int) -> list[Occurrence]:
    """Read the events of a run's file, with derivatives, if present, by the start and so many parameters."""
    watched = content.parsed("fullbody_events", lambda described: _event_spec(described, context))
    if not watched:
        return []
    indices = content.numbers("event_index", {"event": None}, integers=True)
    sizes = {"event": len(indices), "body": len(context), "axis": 3, "quaternion": 4}
    sizes |= {"tangent": 12 * len(context), "start_tangent": 12 * len(context), "parameter": parameters}

    def numbers(name: str, dims: tuple[str, ...]) -> Any:
        return content.numbers(f"event_{name}", {dim: sizes[dim] for dim in ("event", *dims)})

    record = {name: numbers(name, dims) for name, (dims, _, _) in _VARIABLES.items()}
    derivatives: list[Any] = [None] * len(indices)
    if "event_transition" in content:
        stored = [name for name in _DERIVATIVES if parameters or name != "sensitivity"]
        values = {name: numbers(name, _DERIVATIVES[name][0]) for name in stored}
        none = np.zeros((len(indices), 0, sizes["tangent"]))
        derivatives = list(zip(values["transition"], values.get("sensitivity", none), values["flow"], strict=True))
    check_order(record["time"], "event_time", repeated=True)
    check_unit(record["attitude"], "event_attitude")
    happened = []
    for k, index in enumerate(indices):
        if not 0 <= index < len(watched):
            expected = f"expected 0 to {len(watched) - 1}, an index in fullbody_events"
            raise InvalidInput(f"event_index has {index}; {expected}")
        state = wrap(sample(record, k), context)
        happened.append(Occurrence(watched[int(index)], state.time, state, derivatives[k]))
    return happened


def _event_spec(described: list[dict[str, Any]], context: Context) -> list[Event]:
    """Rebuild the events that were detected."""
    watched = [_rebuild(event) for event in described]
    for event in watched:
        # This raises an error if the system lacks bodies or units of the event, as a run would.
        event._condition(context)
    return watched


def _describe(event: Event) -> dict[str, Any]:
    """Return the kind and the parameters of an event for JSON."""

    def described(value: Any) -> Any:
        if is_quantity(value):
            return {"value": np.asarray(value.value).tolist(), "unit": str(value.unit)}
        if isinstance(value, UnstoredFunction):
            return {"function": value.name}
        if callable(value):
            return {"function": getattr(value, "__qualname__", type(value).__name__)}
        return np.asarray(value).tolist()

    parameters = {entry.name: described(getattr(event, entry.name)) for entry in dataclasses.fields(event)}
    return {"kind": type(event).__name__, **parameters}


def _rebuild(described: dict[str, Any]) -> Event:
    """Rebuild an event from such a description."""

    def full(value: Any) -> Any:
        if isinstance(value, list):
            return tuple(value)
        if not isinstance(value, dict):
            return value
        if "function" in value:
            return UnstoredFunction(value["function"], "give it in events= of another run")
        from astropy import units as u

        return u.Quantity(value["value"], value["unit"])

    parameters = {name: full(value) for name, value in described.items()}
    kind = parameters.pop("kind")
    if kind not in _KINDS:
        raise InvalidInput(f"event is {kind!r}; expected one of {', '.join(_KINDS)}")
    return getattr(events, kind)(**parameters)
