"""Flights as files: NetCDF through xarray."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.atomic import check_suffix
from ..base.units import need
from ..base.version import version
from ..errors import InvalidInput
from ..files.netcdf import SUFFIXES, write
from ..files.reading import Content, netcdf
from .events import rebuilt
from .rules import FATES

if TYPE_CHECKING:
    import xarray

    from ..motion.system import System

__all__ = ["FORMAT", "contents", "save", "to_xarray"]

#: The attribute that marks a file as a flight, and the number of the format, the only one that is read.
FORMAT = ("fullbody_flight", 1)

#: The variables with one number for each particle: their further dimensions, the dimension of their unit, their
#: meaning.
_NUMBERS: dict[str, tuple[tuple[str, ...], str, str]] = {
    "fate_time": ((), "time", "when the flight ended"),
    "longitude": ((), "angle", "longitude of the impact, body frame"),
    "latitude": ((), "angle", "latitude of the impact, body frame"),
    "speed": ((), "velocity", "speed of the impact relative to the surface"),
    "incidence": ((), "angle", "angle between path and normal at the impact"),
    "last_time": ((), "time", "time to which the particle was followed"),
}
_WHOLE = {"fate": "what became of the particle", "fate_body": "place of the body, -1 without one", "strikes": "impacts"}
_OF_EVENTS = {
    "event_time": ((), "time"),
    "event_position": (("axis",), "length"),
    "event_velocity": (("axis",), "velocity"),
}
_EVENT_WHOLE = ("event_index", "event_particle", "event_rising")
#: Names of the arrays in the core.
_CORE = {"event_index": "event"}


def to_xarray(flight: Any) -> xarray.Dataset:
    """Convert a flight to an ``xarray.Dataset``; see :meth:`fullbody.Flight.to_xarray`."""
    with need("data", "a flight as a dataset"):
        import xarray as xr

    units, record = flight.system._units, flight._record

    def attributes(dimension: str, text: str) -> dict[str, str]:
        return {"long_name": text} | ({"units": str(units.unit(dimension))} if units.known else {})

    samples = record["samples"].transpose(1, 0, 2)
    variables: dict[str, Any] = {
        "position": (("time", "particle", "axis"), samples[..., :3], attributes("length", "positions, inertial")),
        "velocity": (("time", "particle", "axis"), samples[..., 3:], attributes("velocity", "velocities, inertial")),
        "last_position": (
            ("particle", "axis"),
            record["last"][:, :3],
            attributes("length", "last positions, inertial"),
        ),
        "last_velocity": (
            ("particle", "axis"),
            record["last"][:, 3:],
            attributes("velocity", "last velocities, inertial"),
        ),
    }
    for name, (dims, dimension, text) in _NUMBERS.items():
        variables[name] = (("particle", *dims), record[name], attributes(dimension, text))
    for name, text in _WHOLE.items():
        variables[name] = ("particle", record[name].astype(np.int64), {"long_name": text})
    variables["fate"][2]["flag_values"] = list(range(len(FATES)))
    variables["fate"][2]["flag_meanings"] = " ".join(FATES)
    for name, (dims, dimension) in _OF_EVENTS.items():
        variables[name] = (("event", *dims), record[name], attributes(dimension, f"{dimension} of each event"))
    for name in _EVENT_WHOLE:
        variables[name] = ("event", record[_CORE.get(name, name)].astype(np.int64))
    return xr.Dataset(
        variables,
        {"time": ("time", record["time"], attributes("time", "time")), "axis": ("axis", ["x", "y", "z"])},
        {
            "title": "fullbody flight",
            "fullbody_version": version(),
            FORMAT[0]: FORMAT[1],
            "fullbody_system": json.dumps(flight.system._describe()),
            "fullbody_events": json.dumps([event._describe(flight.system.context) for event in flight.watched]),
        },
    )


def save(flight: Any, path: Any) -> None:
    """Write a flight to a file; see :meth:`fullbody.Flight.save`."""
    check_suffix(path, SUFFIXES)
    netcdf()
    write(to_xarray(flight), path)


def contents(content: Content, system: System) -> dict[str, Any]:
    """Return the arguments of ``Flight``, except its system, by name."""
    watched = content.parsed("fullbody_events", lambda described: [rebuilt(event) for event in described])
    time = content.numbers("time", {"time": None})
    fate = content.numbers("fate", {"particle": None}, whole=True)
    k, p = len(time), len(fate)
    sizes: dict[str, int | None] = {"time": k, "particle": p, "axis": 3}

    def numbers(name: str, *dims: str) -> Any:
        return content.numbers(name, {dim: sizes[dim] for dim in dims}, missing=True)

    both = [numbers(name, "time", "particle", "axis") for name in ("position", "velocity")]
    last = [numbers(name, "particle", "axis") for name in ("last_position", "last_velocity")]
    record: dict[str, Any] = {
        "time": time,
        "samples": np.ascontiguousarray(np.concatenate(both, axis=-1).transpose(1, 0, 2)),
        "last": np.concatenate(last, axis=-1),
    }
    record |= {name: numbers(name, "particle", *dims) for name, (dims, _, _) in _NUMBERS.items()}
    whole = {name: content.numbers(name, {"particle": p}, whole=True) for name in _WHOLE}
    for name, low, high in (("fate", 0, len(FATES) - 1), ("fate_body", -1, len(system) - 1), ("strikes", 0, 2**32 - 1)):
        if p and not (low <= whole[name].min() and whole[name].max() <= high):
            raise InvalidInput(f"{name} has other values than whole numbers from {low} to {high}")
    kinds = {"fate": np.int8, "fate_body": np.int32, "strikes": np.uint32}
    record |= {name: whole[name].astype(kind) for name, kind in kinds.items()}
    index = content.numbers("event_index", {"event": None}, whole=True)
    sizes["event"] = len(index)
    record["event"] = index
    if len(index) and not 0 <= index.min() <= index.max() < len(watched):
        raise InvalidInput("event_index counts beyond the events of the file")
    for name in _EVENT_WHOLE[1:]:
        record[name] = content.numbers(name, {"event": len(index)}, whole=True)
    record |= {name: numbers(name, "event", *dims) for name, (dims, _) in _OF_EVENTS.items()}
    return {"record": record, "watched": watched}
