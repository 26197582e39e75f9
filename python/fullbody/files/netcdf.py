"""Runs as files: NetCDF through xarray."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from ..base.arguments import integer
from ..base.atomic import as_path, check_suffix, replacing
from ..base.units import need
from ..base.version import version
from ..errors import InvalidInput, UncheckedFile, caution
from ..model.composite import Composite
from ..model.polyhedron import Polyhedron
from ..model.system import BaseSystem
from ..record.base import STOP_REASONS, BaseRun
from ..record.derivatives import departures
from ..record.integrators import Integrator, rebuild
from ..record.statistics import Statistics
from . import occurrences, seal
from .stored import Stored, check_order, check_unit, opened

_Built = TypeVar("_Built")

if TYPE_CHECKING:
    import pandas
    import xarray

__all__ = ["load", "save", "to_pandas", "to_xarray"]

_Run = TypeVar("_Run", bound=BaseRun)

#: Variables: dimensions after time, dimension of the unit, meaning.
_VARIABLES: dict[str, tuple[tuple[str, ...], str | None, str]] = {
    "position": (("body", "axis"), "length", "centres, inertial frame"),
    "velocity": (("body", "axis"), "velocity", "velocities of the centres, inertial frame"),
    "attitude": (("body", "quaternion"), None, "unit quaternions, body frame to inertial"),
    "spin": (("body", "axis"), "spin", "angular velocities, body frames"),
    "energy": (("part",), "energy", "energies"),
    "angular_momentum": (("axis",), "angular momentum", "total angular momentum about the origin, inertial"),
}
#: The same of what each force from outside did, after the dimensions time and force; in runs that have some.
_OF_FORCES: dict[str, tuple[tuple[str, ...], str, str]] = {
    "work": ((), "energy", "work of each force from outside since the start of the run"),
    "impulse": (("axis",), "momentum", "impulse of each force from outside since the start of the run, inertial"),
    "angular_impulse": (
        ("axis",),
        "angular momentum",
        "angular impulse of each force from outside since the start of the run, about the origin, inertial",
    ),
}
#: The same of derivatives, after the dimension time, without units: a departure has several; in runs that have some.
_DERIVATIVES: dict[str, tuple[tuple[str, ...], str]] = {
    "transition": (("departure", "start_departure"), "transition matrices from the start of the run"),
    "sensitivity": (("parameter", "departure"), "derivatives by parameters of the system"),
    "chaos": (("indicator",), "mean of MEGNO, Lyapunov exponent, fast Lyapunov indicator, since the start of the run"),
}
_COORDINATES = {
    "axis": ["x", "y", "z"],
    "quaternion": ["w", "x", "y", "z"],
    "part": ["total", "translational", "rotational", "potential"],
}
#: The same in runs whose chaos was measured.
_INDICATORS = ["megno", "lyapunov", "fast_lyapunov"]
#: Conserved quantities at the start: places in the eight numbers (see :mod:`fullbody.record.conserved`), dimensions,
#: dimension of the unit.
_START: dict[str, tuple[Any, tuple[str, ...], str]] = {
    "start_time": (0, (), "time"),
    "start_energy": (slice(1, 5), ("part",), "energy"),
    "start_angular_momentum": (slice(5, 8), ("axis",), "angular momentum"),
}
#: Format 1, of version 0.1.0, has no start; format 2 has no forces from outside, format 3 no composites, format 4 no
#: derivatives. A run has the first format that holds it.
_FORMAT = 5
#: Attributes of text that a run is rebuilt from. One checksum over all of them and the start protects the numbers in
#: them.
_TEXTS = ("fullbody_setup", "fullbody_statistics", "fullbody_events", "stop_reason")
#: Another of these, in runs with forces from outside.
_SWITCHED_OFF = "fullbody_switched_off"
#: Another, in runs with derivatives: the parameters by which they are.
_PARAMETERS = "fullbody_parameters"
#: Endings of the names of runs' files.
SUFFIXES = (".nc", ".nc4")


def to_xarray(run: BaseRun) -> xarray.Dataset:
    """The run as an ``xarray.Dataset``; see :meth:`fullbody.Run.to_xarray`."""
    with need("data", "a run as a dataset"):
        import xarray as xr

    units = run.system._units

    def attributes(dimension: str | None, text: str) -> dict[str, str]:
        unit = {"units": str(units.unit(dimension))} if dimension and units.known else {}
        return {"long_name": text, **unit}

    variables = {
        name: (("time", *dims), run._record[name], attributes(dimension, text))
        for name, (dims, dimension, text) in _VARIABLES.items()
    }
    if run._start is not None:
        for name, (numbers, dims, dimension) in _START.items():
            text = f"{dimension} at the start of the run"
            variables[name] = (dims, run._start[numbers], attributes(dimension, text))
    coordinates: dict[str, Any] = {name: (name, labels) for name, labels in _COORDINATES.items()}
    coordinates["body"] = ("body", list(run.system.names))
    coordinates["time"] = ("time", run._record["time"], attributes("time", "time"))
    if forces := [force.name for force in run.system.forces]:
        coordinates["force"] = ("force", forces, {"long_name": "forces from outside"})
        for name, (dims, dimension, text) in _OF_FORCES.items():
            variables[name] = (("time", "force", *dims), run._record[name], attributes(dimension, text))
    if "transition" in run._record:
        numbers = departures(run.system.names)
        coordinates |= {name: (name, numbers) for name in ("departure", "start_departure")}
        if run._parameters:
            coordinates["parameter"] = ("parameter", list(run._parameters))
    if "chaos" in run._record:
        coordinates["indicator"] = ("indicator", _INDICATORS)
    for name, (dims, text) in _DERIVATIVES.items():
        if name in run._record:
            variables[name] = (("time", *dims), run._record[name], attributes(None, text))
    of_events, labels, watched = occurrences.to_dataset(run, attributes)
    s = run.statistics
    return xr.Dataset(
        variables | of_events,
        coordinates | labels,
        {
            "title": "fullbody run",
            "fullbody_version": version(),
            "fullbody_format": _needed(run),
            "fullbody_setup": json.dumps(_describe(run.system, run.integrator)),
            "fullbody_statistics": json.dumps([s.steps, s.rejected, s.evaluations]),
            "fullbody_events": watched,
            "stop_reason": run.stop_reason,
            "references": "Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35",
        }
        | ({_SWITCHED_OFF: json.dumps(run.switched_off)} if forces else {})
        | ({_PARAMETERS: json.dumps(run._parameters)} if "transition" in run._record else {}),
    )


def _needed(run: BaseRun) -> int:
    """The first format that holds a run."""
    if run._record.keys() & _DERIVATIVES:
        return 5
    if any(isinstance(body.shape, Composite | Polyhedron) for body in run.system.bodies):
        return 4
    if run.system.forces:
        return 3
    return 1 if run._start is None else 2


def netcdf() -> Any:
    """The package xarray, where it can read and write NetCDF."""
    with need("data", "a run as a file"):
        import h5netcdf  # noqa: F401
        import h5py  # noqa: F401
        import xarray as xr
    return xr


def to_pandas(run: BaseRun) -> pandas.DataFrame:
    """The run as a ``pandas.DataFrame``; see :meth:`fullbody.Run.to_pandas`."""
    with need("data", "a run as a table"):
        import pandas as pd

    units = run.system._units
    columns, values, named = [], [], {}
    for name, (dims, dimension, _) in _VARIABLES.items():
        rows = run._record[name]
        values.append(rows.reshape(len(rows), int(np.prod(rows.shape[1:]))))
        bodies = run.system.names if "body" in dims else ("",)
        columns += [(name, body, part) for body in bodies for part in _COORDINATES[dims[-1]]]
        if dimension and units.known:
            named[name] = str(units.unit(dimension))
    if units.known:
        named["time"] = str(units.unit("time"))
    frame = pd.DataFrame(
        np.concatenate(values, axis=1),
        index=pd.Index(run._record["time"], name="time"),
        columns=pd.MultiIndex.from_tuples(columns, names=["quantity", "body", "component"]),
    )
    # Sorted, since pandas warns of slow look-ups otherwise.
    frame = frame.sort_index(axis=1)
    frame.attrs["units"] = named
    return frame


def save(run: BaseRun, path: Any) -> None:
    """Write a run; see :meth:`fullbody.Run.save`."""
    check_suffix(path, SUFFIXES)
    if run._start is None and _needed(run) > 1:
        raise InvalidInput("this run has forces or composites, but no start; expected a run that an integration made")
    netcdf()
    dataset = to_xarray(run)
    dataset.attrs["fullbody_checksum"] = _checksum(
        dataset.attrs, [dataset[name].values for name in _START if name in dataset]
    )
    # HDF5 has no checksums for a number by itself.
    numbers = {name: of for name, of in dataset.variables.items() if of.ndim and of.dtype.kind in "fi"}
    encoding = {name: _protected(of) for name, of in numbers.items()}
    with replacing(path) as temporary:
        temporary.write_bytes(sealed(dataset, encoding))


def sealed(dataset: xarray.Dataset, encoding: Mapping[Any, Any]) -> memoryview:
    """A NetCDF-4 file with its seal, made in memory: on a full disk HDF5 itself would end the whole process."""
    from xarray.backends import H5NetCDFStore
    from xarray.backends.locks import HDF5_LOCK

    whole = BytesIO()
    # Left to itself, xarray asks a client of dask for a lock, which knows none of what is in memory.
    store = H5NetCDFStore.open(whole, mode="w", lock=HDF5_LOCK)
    try:
        dataset.dump_to_store(store, encoding=encoding)
    finally:
        store.close()
    whole.write(seal.seal(whole))
    return whole.getbuffer()


def _protected(variable: Any) -> dict[str, Any]:
    """Settings that add checksums of HDF5's own, checked whenever the numbers are read, by whatever program."""
    if not variable.size:
        return {"fletcher32": True}
    # Pieces of whole rows, about a megabyte each: left to itself, HDF5 cuts rows too, which takes longer to write.
    rows = min(len(variable), max(1, 2**20 * len(variable) // variable.nbytes))
    return {"fletcher32": True, "chunksizes": (rows, *variable.shape[1:])}


def load(path: Any, system: type[BaseSystem], run: type[_Run]) -> _Run:
    """Read a run; see :func:`fullbody.load`. The two classes are those of the run's system and of the run."""
    path = as_path(path)
    try:
        with opened(path) as stored:
            found = _run(stored, system, run)
    except InvalidInput as error:
        raise InvalidInput(f"{path} is not a readable run of fullbody: {error}") from error
    if not stored.sealed:
        text = "another program or an earlier version of fullbody wrote it, and damage may go unseen"
        caution(f"{path} has no checksum of the whole file: {text}", UncheckedFile)
    return found


def _parsed(stored: Stored, name: str, default: str | None, build: Callable[[Any], _Built]) -> _Built:
    """The object that is built from an attribute's JSON; errors name the attribute."""
    text = stored.text(name, default)
    try:
        return build(json.loads(text))
    except json.JSONDecodeError as error:
        raise InvalidInput(f"attribute {name} is no JSON: {error}") from error
    except RecursionError as error:
        raise InvalidInput(f"attribute {name} has brackets in brackets, too deep to be read") from error
    except KeyError as error:
        raise InvalidInput(f"attribute {name} has no entry {error}") from error
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        # The errors are of many kinds, since the text may be any JSON.
        raise InvalidInput(f"attribute {name}: {error}") from error


def _checksum(attributes: Mapping[str, Any], start: Sequence[npt.NDArray[np.float64]]) -> str:
    texts = [str(attributes.get(name)) for name in _TEXTS] + [str(values.tolist()) for values in start]
    texts += [str(attributes[name]) for name in (_SWITCHED_OFF, _PARAMETERS) if attributes.get(name) is not None]
    whole = "\n".join(texts)
    return f"{zlib.crc32(whole.encode()):08x}"


def _format(stored: Stored) -> int:
    """The format of a file; one that is not known is refused."""
    found = stored.attribute("fullbody_format")
    if found is None:
        flight = stored.attribute("fullbody_flight") is not None
        raise InvalidInput("it is a flight (fullbody.load_flight)" if flight else "it has no attribute fullbody_format")
    written = integer(found)
    if written is None or written < 1:
        raise InvalidInput(f"attribute fullbody_format is {found!r}; expected a whole number above zero")
    if written > _FORMAT:
        raise InvalidInput(f"a newer fullbody wrote it, {stored.attribute('fullbody_version')}")
    return written


def _run(stored: Stored, system_type: type[BaseSystem], run_type: type[_Run]) -> _Run:
    """The run in a file."""
    texts = {name: stored.attribute(name) for name in (*_TEXTS, _SWITCHED_OFF, _PARAMETERS)}
    # Files of version 0.1.0 do not tell their start.
    start = []
    if _format(stored) > 1:
        lengths = {name: len(labels) for name, labels in _COORDINATES.items()}
        start = [stored.numbers(name, {dim: lengths[dim] for dim in dims}) for name, (_, dims, _) in _START.items()]
    # Checked even under a seal of the whole file, since it stays where other programs write the file anew.
    if stored.text("fullbody_checksum", found := _checksum(texts, start)) != found:
        raise InvalidInput(
            f"attribute fullbody_checksum does not fit: one of {', '.join((*_TEXTS, *_START))} has been altered; "
            "where that was meant, delete fullbody_checksum"
        )
    system, integrator = _parsed(stored, "fullbody_setup", None, lambda setup: _restore(setup, system_type))
    counts = _parsed(stored, "fullbody_statistics", None, _statistics)
    watched = _parsed(stored, "fullbody_events", "[]", lambda events: occurrences.watched_events(events, system))
    record = {"time": stored.numbers("time", {"time": None})}
    sizes = {**{name: len(labels) for name, labels in _COORDINATES.items()}, "body": len(system)}
    sizes["time"] = len(record["time"])
    for name, (dims, _, _) in _VARIABLES.items():
        record[name] = stored.numbers(name, {dim: sizes[dim] for dim in ("time", *dims)})
    if system.forces:
        sizes["force"] = len(system.forces)
        for name, (dims, _, _) in _OF_FORCES.items():
            record[name] = stored.numbers(name, {dim: sizes[dim] for dim in ("time", "force", *dims)})
    parameters = None
    if stored.attribute(_PARAMETERS) is not None:
        parameters = _parsed(stored, _PARAMETERS, None, _names)
        sizes["departure"] = sizes["start_departure"] = 12 * len(system)
        sizes["parameter"] = len(parameters)
    sizes["indicator"] = len(_INDICATORS)
    kept = {"transition": parameters is not None, "sensitivity": bool(parameters), "chaos": "chaos" in stored}
    for name, (of, _) in _DERIVATIVES.items():
        if kept[name]:
            record[name] = stored.numbers(name, {dim: sizes[dim] for dim in ("time", *of)})
    check_order(record["time"], "time", repeated=False)
    check_unit(record["attitude"], "attitude")
    run = run_type(system, record, counts, integrator)
    run._start = np.concatenate([values.reshape(-1) for values in start]) if start else None
    run._parameters = parameters or ()
    run.events = occurrences.from_file(stored, system, watched)
    if system.forces:
        run.switched_off = _parsed(stored, _SWITCHED_OFF, None, lambda counts: _switched_off(counts, system))
    run.stop_reason = stored.text("stop_reason", "unknown")
    if run.stop_reason not in STOP_REASONS:
        raise InvalidInput(f"attribute stop_reason is {run.stop_reason!r}; expected one of {', '.join(STOP_REASONS)}")
    return run


def _statistics(counts: list[Any]) -> Statistics:
    numbers = [number for count in counts if (number := integer(count)) is not None and 0 <= number < 2**63]
    if len(counts) != 3 or len(numbers) != 3:
        raise InvalidInput(f"{counts!r} is no list of three counts")
    return Statistics(*numbers)


def _names(names: list[Any]) -> tuple[str, ...]:
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InvalidInput(f"{names!r} is no list of names")
    return tuple(names)


def _switched_off(counts: dict[str, Any], system: BaseSystem) -> dict[str, int]:
    names = [force.name for force in system.forces]
    for name, count in counts.items():
        if name not in names or (number := integer(count)) is None or not 0 <= number < 2**63:
            raise InvalidInput(f"{name!r} has {count!r}; expected a force of the system and a count")
    return counts


def _restore(setup: dict[str, Any], system_type: type[BaseSystem]) -> tuple[BaseSystem, Integrator]:
    return system_type._rebuild(setup), rebuild(setup["integrator"])


def _describe(system: BaseSystem, integrator: Integrator) -> dict[str, Any]:
    """The set-up as JSON; floats keep all their digits there."""

    def strip(step: Any) -> float:
        return float(system._units.strip(step, "time", "step"))

    return {**system._describe(), "integrator": integrator._describe(strip)}
