"""Flights as files: NetCDF through xarray."""

from __future__ import annotations

import json
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.atomic import check_suffix
from ..base.units import need
from ..base.version import version
from ..errors import InvalidInput
from ..files.netcdf import SUFFIXES, described, write
from ..files.reading import Content, netcdf
from ..model.context import Context
from .events import rebuild
from .rules import FATES

if TYPE_CHECKING:
    import xarray

#: The attribute that marks a file as a flight, and the number of the format, the only one that is read.
FORMAT = ("fullbody_flight", 1)

#: The variables of samples and of particles: their dimensions, the dimension of their unit, their meaning.
_NUMBERS: dict[str, tuple[tuple[str, ...], str, str]] = {
    "position": (("time", "particle", "axis"), "length", "positions, inertial"),
    "velocity": (("time", "particle", "axis"), "velocity", "velocities, inertial"),
    "last_position": (("particle", "axis"), "length", "last positions, inertial"),
    "last_velocity": (("particle", "axis"), "velocity", "last velocities, inertial"),
    "fate_time": (("particle",), "time", "when the flight ended"),
    "longitude": (("particle",), "angle", "longitude of the impact, body frame"),
    "latitude": (("particle",), "angle", "latitude of the impact, body frame"),
    "speed": (("particle",), "velocity", "speed of the impact relative to the surface"),
    "incidence": (("particle",), "angle", "angle between path and normal at the impact"),
    "last_time": (("particle",), "time", "time to which the particle was integrated"),
}
_INTEGERS = {"fate": "fate of the particle", "fate_body": "index of the body, -1 without one", "strikes": "impacts"}
_OF_EVENTS = {
    "event_time": ((), "time"),
    "event_position": (("axis",), "length"),
    "event_velocity": (("axis",), "velocity"),
}
_EVENT_INTEGERS = ("event_index", "event_particle", "event_rising")
#: Names of the arrays in the core.
_CORE = {"event_index": "event"}


def to_xarray(flight: Any) -> xarray.Dataset:
    """Convert the flight to an ``xarray.Dataset``, with units, and the system in its attributes.

    The dimensions are ``time``, ``particle``, ``axis`` and ``event``; numbers of ``fate`` are indices of its attribute
    ``flag_meanings``.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.kw4()
    >>> flight = system.fly(state, fullbody.Particles([[3.0, 0.0, 0.0]], [[0.0, 0.8, 0.0]]), 2.0, output=1.0)
    >>> dict(flight.to_xarray().sizes)
    {'time': 3, 'particle': 1, 'axis': 3, 'event': 0}
    """
    with need("data", "a flight as a dataset"):
        import xarray as xr

    arrays, attributes = flight.arrays, partial(described, flight.context.units)
    variables: dict[str, Any] = {
        name: (dims, arrays[name], attributes(dimension, text)) for name, (dims, dimension, text) in _NUMBERS.items()
    }
    for name, text in _INTEGERS.items():
        variables[name] = ("particle", arrays[name].astype(np.int64), {"long_name": text})
    variables["fate"][2]["flag_values"] = list(range(len(FATES)))
    variables["fate"][2]["flag_meanings"] = " ".join(FATES)
    for name, (dims, dimension) in _OF_EVENTS.items():
        variables[name] = (("event", *dims), arrays[name], attributes(dimension, f"{dimension} of each event"))
    for name in _EVENT_INTEGERS:
        variables[name] = ("event", arrays[_CORE.get(name, name)].astype(np.int64))
    return xr.Dataset(
        variables,
        {"time": ("time", arrays["time"], attributes("time", "time")), "axis": ("axis", ["x", "y", "z"])},
        {
            "title": "fullbody flight",
            "fullbody_version": version(),
            FORMAT[0]: FORMAT[1],
            "fullbody_system": json.dumps(flight.context.describe()),
            "fullbody_events": json.dumps([event._describe(flight.context) for event in flight.watched]),
        },
    )


def save(flight: Any, path: Any) -> None:
    """Write a NetCDF file as :meth:`fullbody.Run.save` does; :func:`fullbody.load_flight` reads it."""
    check_suffix(path, SUFFIXES)
    netcdf()
    write(to_xarray(flight), path)


def contents(content: Content, context: Context) -> dict[str, Any]:
    """Return the arguments of ``Flight``, except its system, by name."""
    watched = content.parsed("fullbody_events", lambda described: [rebuild(event) for event in described])
    time = content.numbers("time", {"time": None})
    fate = content.numbers("fate", {"particle": None}, integers=True)
    k, p = len(time), len(fate)
    sizes: dict[str, int | None] = {"time": k, "particle": p, "axis": 3}

    def numbers(name: str, *dims: str) -> Any:
        return content.numbers(name, {dim: sizes[dim] for dim in dims}, missing=True)

    arrays: dict[str, Any] = {"time": time} | {name: numbers(name, *dims) for name, (dims, _, _) in _NUMBERS.items()}
    for name, kind, low, high in (
        ("fate", np.int8, 0, len(FATES) - 1),
        ("fate_body", np.int32, -1, len(context) - 1),
        ("strikes", np.uint32, 0, 2**32 - 1),
    ):
        values = content.numbers(name, {"particle": p}, integers=True)
        if p and not low <= values.min() <= values.max() <= high:
            raise InvalidInput(f"{name} has other values than whole numbers from {low} to {high}")
        arrays[name] = values.astype(kind)
    arrays["event"] = index = content.numbers("event_index", {"event": None}, integers=True)
    sizes["event"] = len(index)
    for name in _EVENT_INTEGERS[1:]:
        arrays[name] = content.numbers(name, {"event": len(index)}, integers=True)
    for name, values, count in (("event", index, len(watched)), ("particle", arrays["event_particle"], p)):
        if len(values) and not 0 <= values.min() <= values.max() < count:
            raise InvalidInput(f"the {name}s of occurrences are not all from 0 to {count - 1}, those of the file")
    arrays |= {name: numbers(name, "event", *dims) for name, (dims, _) in _OF_EVENTS.items()}
    return {"arrays": arrays, "watched": watched}
