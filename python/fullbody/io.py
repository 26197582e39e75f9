"""Runs as files: NetCDF through xarray."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _occurrences
from ._arguments import integer, named_options
from ._files import check_suffix, replacing
from ._units import need
from .errors import InvalidInput
from .integrators import Integrator, rebuild
from .run import Run, Statistics
from .system import System

if TYPE_CHECKING:
    import pandas
    import xarray

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
#: Endings of the names of runs' files.
SUFFIXES = (".nc", ".nc4")


def to_xarray(run: Run) -> xarray.Dataset:
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
        import h5py  # type: ignore[import-untyped]  # noqa: F401
        import xarray as xr
    return xr


def to_pandas(run: Run) -> pandas.DataFrame:
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
    dataset.attrs["fullbody_checksum"] = _checksum(dataset)
    encoding = {name: _protected(of) for name, of in dataset.variables.items() if of.dtype.kind in "fi"}
    with replacing(path) as temporary:
        # Through memory: where a disk is full, HDF5 itself would end the whole process.
        whole = BytesIO()
        dataset.to_netcdf(whole, engine="h5netcdf", encoding=encoding)
        temporary.write_bytes(whole.getbuffer())


def _protected(variable: Any) -> dict[str, Any]:
    """Settings that add checksums of HDF5's own, checked whenever the numbers are read, by whatever program."""
    if not variable.size:
        return {"fletcher32": True}
    # Pieces of whole rows, about a megabyte each: left to itself, HDF5 cuts rows too, which takes longer to write.
    rows = min(len(variable), max(1, 2**20 * len(variable) // variable.nbytes))
    return {"fletcher32": True, "chunksizes": (rows, *variable.shape[1:])}


@named_options
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
    """
    xr = netcdf()
    path = Path(path)
    try:
        _check_signature(path)
        return _run(_dataset(xr, path))
    except KeyError as error:
        raise InvalidInput(f"{path} is not a readable run of fullbody: it has no {error}") from error
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{path} is not a readable run of fullbody: {error}") from error


def _check_signature(path: Path) -> None:
    """Refuse what is no NetCDF-4 file by its first bytes; the libraries' own messages tell of their inner workings."""
    if not path.exists():
        raise FileNotFoundError(f"no file {path}")
    if path.is_dir():
        raise InvalidInput("it is a folder")
    with path.open("rb") as file:
        begin = file.read(20)
    if not begin:
        raise InvalidInput("it is empty")
    if begin.startswith(b"fullbody simulation"):
        raise InvalidInput("it is a simulation; fullbody.Simulation.load reads it")
    if begin.startswith(b"CDF"):
        raise InvalidInput("it is NetCDF of the classic kind; runs are NetCDF-4")
    if not begin.startswith(b"\x89HDF\r\n\x1a\n"):
        raise InvalidInput("it is not a NetCDF file")


def _dataset(xr: Any, path: Path) -> Any:
    """All of a file, in memory."""
    import h5py

    try:
        # By itself, since h5netcdf prints a second error where a file fails here.
        with h5py.File(path, "r") as file:
            dict(file.attrs)
        with xr.open_dataset(path, engine="h5netcdf", decode_times=False) as dataset:
            return dataset.load()
    except MemoryError:
        raise
    except Exception as error:
        # Of any kind: three libraries meet a damaged file each in ways of their own.
        raise InvalidInput("it is truncated or damaged") from error


@contextmanager
def _attribute(name: str) -> Iterator[None]:
    """A context whose errors name the attribute that is read in it."""
    try:
        yield
    except json.JSONDecodeError as error:
        raise InvalidInput(f"attribute {name} is no JSON: {error}") from error
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"attribute {name}: {error}") from error


def _checksum(dataset: Any) -> str:
    texts = "\n".join(str(dataset.attrs.get(name)) for name in _TEXTS)
    return f"{zlib.crc32(texts.encode()):08x}"


def _check_attributes(dataset: Any) -> None:
    """Refuse attributes that are missing, of another format or altered."""
    for name in ("fullbody_format", "fullbody_setup", "fullbody_statistics"):
        if name not in dataset.attrs:
            raise InvalidInput(f"it has no attribute {name}")
    written = integer(dataset.attrs["fullbody_format"])
    if written is None or written < 1:
        found = dataset.attrs["fullbody_format"]
        raise InvalidInput(f"attribute fullbody_format is {found!r}; expected a whole number above zero")
    if written > _FORMAT:
        raise InvalidInput(f"a newer fullbody wrote it, {dataset.attrs.get('fullbody_version')}")


def _run(dataset: Any) -> Run:
    """The run in a dataset."""
    _check_attributes(dataset)
    for name in ("time", *_VARIABLES):
        if name not in dataset.variables:
            raise InvalidInput(f"it has no variable {name}")
    with _attribute("fullbody_setup"):
        system, integrator = _restore(json.loads(dataset.attrs["fullbody_setup"]))
    with _attribute("fullbody_statistics"):
        counts = Statistics(*json.loads(dataset.attrs["fullbody_statistics"]))
    # Files of earlier versions have none.
    if dataset.attrs.get("fullbody_checksum", found := _checksum(dataset)) != found:
        raise InvalidInput(
            f"attribute fullbody_checksum does not fit: one of {', '.join(_TEXTS)} has been altered; "
            "where that was meant, delete fullbody_checksum"
        )
    record = {name: np.array(dataset[name].values, dtype=np.float64, order="C") for name in ("time", *_VARIABLES)}
    sizes = {**{name: len(labels) for name, labels in _COORDINATES.items()}, "body": len(system)}
    for name, (dims, _, _) in _VARIABLES.items():
        expected = (len(record["time"]), *(sizes[dim] for dim in dims))
        if record[name].shape != expected:
            raise InvalidInput(f"{name} has shape {record[name].shape}; expected {expected}")
    for name, values in record.items():
        _occurrences.check_finite(values, name)
    run = Run(system, record, counts, integrator)
    with _attribute("fullbody_events"):
        asked = _occurrences.asked_for(dataset.attrs.get("fullbody_events", "[]"))
    run.events = _occurrences.from_dataset(dataset, system, asked)
    run.stop_reason = dataset.attrs.get("stop_reason", "unknown")
    return run


def _describe(system: System, integrator: Integrator) -> dict[str, Any]:
    """The set-up as JSON; floats keep all their digits there."""

    def strip(step: Any) -> float:
        return float(system._units.strip(step, "time", "step"))

    return {**system._describe(), "integrator": integrator._describe(strip)}


def _restore(setup: dict[str, Any]) -> tuple[System, Integrator]:
    return System._rebuild(setup), rebuild(setup["integrator"])
