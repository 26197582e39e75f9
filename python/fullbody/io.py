"""Runs as files: NetCDF through xarray."""

from __future__ import annotations

import json
import warnings
import zlib
from collections.abc import Callable, Mapping
from io import BytesIO
from typing import Any, TypeVar

import numpy as np

from . import _occurrences, _seal
from ._arguments import integer
from ._files import as_path, check_suffix, replacing
from ._stored import Stored, check_order, check_unit, opened
from ._units import need
from .errors import InvalidInput, UncheckedFile
from .integrators import Integrator, rebuild
from .run import Run, Statistics
from .system import System

_Built = TypeVar("_Built")

__all__ = ["load", "save", "to_pandas", "to_xarray"]

#: Variables: dimensions after time, dimension of the unit, meaning.
_VARIABLES: dict[str, tuple[tuple[str, ...], str | None, str]] = {
    "position": (("body", "axis"), "length", "centres, inertial frame"),
    "velocity": (("body", "axis"), "velocity", "velocities of the centres, inertial frame"),
    "attitude": (("body", "quaternion"), None, "unit quaternions, body frame to inertial"),
    "spin": (("body", "axis"), "spin", "angular velocities, body frames"),
    "energy": (("part",), "energy", "energies"),
    "angular_momentum": (("axis",), "angular momentum", "total angular momentum about the origin, inertial"),
}
_COORDINATES = {
    "axis": ["x", "y", "z"],
    "quaternion": ["w", "x", "y", "z"],
    "part": ["total", "translational", "rotational", "potential"],
}
_FORMAT = 1
#: Text that a run is rebuilt from; the numbers in it have no other protection than the checksum of all of it.
_TEXTS = ("fullbody_setup", "fullbody_statistics", "fullbody_events", "stop_reason")
#: What may have ended a run.
_REASONS = ("end", "event", "interrupted", "unfinished", "unknown")
#: Endings of the names of runs' files.
SUFFIXES = (".nc", ".nc4")


def to_xarray(run: Run) -> Any:
    """The run as an ``xarray.Dataset``; see :meth:`fullbody.Run.to_xarray`."""
    with need("data", "a run as a dataset"):
        import xarray as xr

    from . import __version__

    units = run.system._units

    def attributes(dimension: str | None, text: str) -> dict[str, str]:
        unit = {"units": str(units.unit(dimension))} if dimension and units.known else {}
        return {"long_name": text, **unit}

    variables = {
        name: (("time", *dims), run._record[name], attributes(dimension, text))
        for name, (dims, dimension, text) in _VARIABLES.items()
    }
    coordinates: dict[str, Any] = {name: (name, labels) for name, labels in _COORDINATES.items()}
    coordinates["body"] = ("body", list(run.system.names))
    coordinates["time"] = ("time", run._record["time"], attributes("time", "time"))
    of_events, labels, asked = _occurrences.to_dataset(run, attributes)
    s = run.statistics
    return xr.Dataset(
        variables | of_events,
        coordinates | labels,
        {
            "title": "fullbody run",
            "fullbody_version": __version__,
            "fullbody_format": _FORMAT,
            "fullbody_setup": json.dumps(_describe(run.system, run.integrator)),
            "fullbody_statistics": json.dumps([s.steps, s.rejected, s.evaluations]),
            "fullbody_events": asked,
            "stop_reason": run.stop_reason,
            "references": "Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35",
        },
    )


def netcdf() -> Any:
    """xarray, able to read and write NetCDF."""
    with need("data", "a run as a file"):
        import h5netcdf  # noqa: F401
        import h5py  # noqa: F401
        import xarray as xr
    return xr


def to_pandas(run: Run) -> Any:
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


def save(run: Run, path: Any) -> None:
    """Write a run; see :meth:`fullbody.Run.save`."""
    check_suffix(path, SUFFIXES)
    netcdf()
    dataset = run.to_xarray()
    dataset.attrs["fullbody_checksum"] = _checksum(dataset.attrs)
    encoding = {name: _protected(of) for name, of in dataset.variables.items() if of.dtype.kind in "fi"}
    with replacing(path) as temporary:
        # Through memory: where a disk is full, HDF5 itself would end the whole process.
        whole = BytesIO()
        dataset.to_netcdf(whole, engine="h5netcdf", encoding=encoding)
        whole.write(_seal.seal(whole))
        temporary.write_bytes(whole.getbuffer())


def _protected(variable: Any) -> dict[str, Any]:
    """Settings that add checksums of HDF5's own, checked whenever the numbers are read, by whatever program."""
    if not variable.size:
        return {"fletcher32": True}
    # Pieces of whole rows, about a megabyte each: left to itself, HDF5 cuts rows too, which takes longer to write.
    rows = min(len(variable), max(1, 2**20 * len(variable) // variable.nbytes))
    return {"fletcher32": True, "chunksizes": (rows, *variable.shape[1:])}


def load(path: Any) -> Run:
    """Read a run that :meth:`fullbody.Run.save` wrote.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Run
        Equal to the one that was saved, bit for bit, with its events and stop reason; see :meth:`fullbody.Run.save` for
        what a file cannot hold.

    Raises
    ------
    InvalidInput
        For a file that is not a run of this package, or a damaged one; says what is wrong.
    FileNotFoundError
        Where there is no such file.

    Warns
    -----
    UncheckedFile
        For a file without a checksum of the whole, which another program or an earlier version wrote. It is read, if
        its content is that of a run.
    """
    path = as_path(path)
    try:
        with opened(path) as stored:
            run = _run(stored)
    except InvalidInput as error:
        raise InvalidInput(f"{path} is not a readable run of fullbody: {error}") from error
    if not stored.sealed:
        text = "another program or an earlier version of fullbody wrote it, and damage may go unseen"
        warnings.warn(f"{path} has no checksum of the whole file: {text}", UncheckedFile, stacklevel=2)
    return run


def _parsed(stored: Stored, name: str, default: str | None, build: Callable[[Any], _Built]) -> _Built:
    """What is built from the JSON of an attribute; its errors name the attribute."""
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
        # Of whatever kind: the text may be any JSON.
        raise InvalidInput(f"attribute {name}: {error}") from error


def _checksum(attributes: Mapping[str, Any]) -> str:
    texts = "\n".join(str(attributes.get(name)) for name in _TEXTS)
    return f"{zlib.crc32(texts.encode()):08x}"


def _check_format(stored: Stored) -> None:
    """Refuse a file that says it is of another format."""
    found = stored.attribute("fullbody_format")
    if found is None:
        raise InvalidInput("it has no attribute fullbody_format")
    written = integer(found)
    if written is None or written < 1:
        raise InvalidInput(f"attribute fullbody_format is {found!r}; expected a whole number above zero")
    if written > _FORMAT:
        raise InvalidInput(f"a newer fullbody wrote it, {stored.attribute('fullbody_version')}")


def _run(stored: Stored) -> Run:
    """The run in a file."""
    _check_format(stored)
    texts = {name: stored.attribute(name) for name in _TEXTS}
    # Checked even under a seal of the whole file, since it stays where other programs write the file anew.
    if stored.text("fullbody_checksum", found := _checksum(texts)) != found:
        raise InvalidInput(
            f"attribute fullbody_checksum does not fit: one of {', '.join(_TEXTS)} has been altered; "
            "where that was meant, delete fullbody_checksum"
        )
    system, integrator = _parsed(stored, "fullbody_setup", None, _restore)
    counts = _parsed(stored, "fullbody_statistics", None, _statistics)
    asked = _parsed(stored, "fullbody_events", "[]", lambda events: _occurrences.asked_for(events, system))
    record = {"time": stored.numbers("time", {"time": None})}
    sizes = {**{name: len(labels) for name, labels in _COORDINATES.items()}, "body": len(system)}
    sizes["time"] = len(record["time"])
    for name, (dims, _, _) in _VARIABLES.items():
        record[name] = stored.numbers(name, {dim: sizes[dim] for dim in ("time", *dims)})
    check_order(record["time"], "time", repeated=False)
    check_unit(record["attitude"], "attitude")
    run = Run(system, record, counts, integrator)
    run.events = _occurrences.from_file(stored, system, asked)
    run.stop_reason = stored.text("stop_reason", "unknown")
    if run.stop_reason not in _REASONS:
        raise InvalidInput(f"attribute stop_reason is {run.stop_reason!r}; expected one of {', '.join(_REASONS)}")
    return run


def _statistics(counts: list[Any]) -> Statistics:
    numbers = [number for count in counts if (number := integer(count)) is not None and 0 <= number < 2**63]
    if len(counts) != 3 or len(numbers) != 3:
        raise InvalidInput(f"{counts!r} is no list of three counts")
    return Statistics(*numbers)


def _describe(system: System, integrator: Integrator) -> dict[str, Any]:
    """The set-up as JSON; floats keep all their digits there."""

    def strip(step: Any) -> float:
        return float(system._units.strip(step, "time", "step"))

    return {**system._describe(), "integrator": integrator._describe(strip)}


def _restore(setup: dict[str, Any]) -> tuple[System, Integrator]:
    return System._rebuild(setup), rebuild(setup["integrator"])
