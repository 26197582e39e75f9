"""Flights as files: NetCDF through xarray."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..base.atomic import as_path, check_suffix, replacing
from ..base.units import need
from ..base.version import version
from ..errors import InvalidInput, UncheckedFile, caution
from ..files.netcdf import SUFFIXES, netcdf, sealed
from ..files.stored import Stored, opened
from ..model.system import BaseSystem
from .events import ParticleEvent, rebuilt
from .rules import FATES

if TYPE_CHECKING:
    import xarray

__all__ = ["load", "save", "to_xarray"]

_Flight = TypeVar("_Flight")

#: Variables with a number for each particle: dimensions after it, dimension of the unit, meaning.
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
_EVENT_WHOLE = ("event_asked", "event_particle", "event_rising")
#: Names of the core's arrays.
_CORE = {"event_asked": "event"}


def to_xarray(flight: Any) -> xarray.Dataset:
    """The flight as an ``xarray.Dataset``; see :meth:`fullbody.Flight.to_xarray`."""
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
            "fullbody_flight": 1,
            "fullbody_setup": json.dumps(flight.system._describe()),
            "fullbody_events": json.dumps([event._describe(flight.system) for event in flight.watched]),
        },
    )


def save(flight: Any, path: Any) -> None:
    """Write a flight; see :meth:`fullbody.Flight.save`."""
    check_suffix(path, SUFFIXES)
    netcdf()
    dataset = to_xarray(flight)
    plain: dict[Any, Any] = {name: {"_FillValue": None} for name in dataset.variables if name != "axis"}
    with replacing(path) as temporary:
        temporary.write_bytes(sealed(dataset, plain))


def load(path: Any, system: type[BaseSystem], flight: Callable[..., _Flight]) -> _Flight:
    """Read a flight; see :func:`fullbody.load_flight`. The classes are those of its system and of the flight."""
    path = as_path(path)
    try:
        with opened(path) as stored:
            found = flight(*_flight(stored, system))
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
        raise InvalidInput(f"{path} is not a readable flight of fullbody: {error}") from error
    if not stored.sealed:
        caution(f"{path} has no checksum of the whole file: damage may go unseen", UncheckedFile)
    return found


def _flight(stored: Stored, system_type: type[BaseSystem]) -> tuple[BaseSystem, dict[str, Any], list[ParticleEvent]]:
    """What a flight in a file is made of."""
    if (written := stored.attribute("fullbody_flight")) != 1:
        raise InvalidInput(f"attribute fullbody_flight is {written!r}; expected 1")
    system = system_type._rebuild(json.loads(stored.text("fullbody_setup")))
    watched = [rebuilt(event) for event in json.loads(stored.text("fullbody_events"))]
    time = stored.numbers("time", {"time": None})
    fate = stored.numbers("fate", {"particle": None}, whole=True)
    k, p = len(time), len(fate)
    sizes: dict[str, int | None] = {"time": k, "particle": p, "axis": 3}

    def numbers(name: str, *dims: str) -> Any:
        return stored.numbers(name, {dim: sizes[dim] for dim in dims}, missing=True)

    both = [numbers(name, "time", "particle", "axis") for name in ("position", "velocity")]
    last = [numbers(name, "particle", "axis") for name in ("last_position", "last_velocity")]
    record: dict[str, Any] = {
        "time": time,
        "samples": np.ascontiguousarray(np.concatenate(both, axis=-1).transpose(1, 0, 2)),
        "last": np.concatenate(last, axis=-1),
    }
    record |= {name: numbers(name, "particle", *dims) for name, (dims, _, _) in _NUMBERS.items()}
    whole = {name: stored.numbers(name, {"particle": p}, whole=True) for name in _WHOLE}
    for name, low, high in (("fate", 0, len(FATES) - 1), ("fate_body", -1, len(system) - 1), ("strikes", 0, 2**32 - 1)):
        if p and not (low <= whole[name].min() and whole[name].max() <= high):
            raise InvalidInput(f"{name} has other values than whole numbers from {low} to {high}")
    kinds = {"fate": np.int8, "fate_body": np.int32, "strikes": np.uint32}
    record |= {name: whole[name].astype(kind) for name, kind in kinds.items()}
    asked = stored.numbers("event_asked", {"event": None}, whole=True)
    sizes["event"] = len(asked)
    record["event"] = asked
    if len(asked) and not 0 <= asked.min() <= asked.max() < len(watched):
        raise InvalidInput("event_asked counts beyond the events of the file")
    for name in _EVENT_WHOLE[1:]:
        record[name] = stored.numbers(name, {"event": len(asked)}, whole=True)
    record |= {name: numbers(name, "event", *dims) for name, (dims, _) in _OF_EVENTS.items()}
    return system, record, watched
