"""Fuzz targets for the files that the package itself writes: runs in NetCDF, and simulations."""

from __future__ import annotations

import functools
import hashlib
import io
import json
import re
import tempfile
from pathlib import Path
from typing import Any

import fullbody
import h5py
import numpy as np
from fullbody import events
from hypothesis import strategies as st

from .target import Target, check_finite, check_object, file_target

#: The signatures with which the internal structures of an HDF5 file begin, from the specification of the format.
_STRUCTURES = re.compile(rb"GCOL|TREE|SNOD|HEAP|OHDR|OCHK|FRHP|FHDB|FHIB|BTHD|BTLF|BTIN|FAHD|EAHD|\x89HDF")
#: Integers near the limits of the types that a file contains.
_SPECIAL = [0, 1, 2, 7, 8, 16, 127, 128, 255, 256, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1]
#: Any value of JSON, of a few levels.
_JSON = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=4), st.just(10**400)),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=5,
)


@functools.cache
def _saved(kind: str) -> bytes:
    """Return the bytes of the file of a small run, or of a simulation, of a kind in ``_KINDS`` or ``"simulation"``."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.nc")
        units = kind == "units"
        system, state = fullbody.systems.kw4(units=True) if units else fullbody.systems.case1(gravity="point")
        if kind == "simulation":
            fullbody.Simulation(system, state).save(path)
            return path.read_bytes()
        run_events = [events.Separation(0, 1, "2.55 km"), events.Periapsis(0, 1)] if units else []
        run = system.integrate(state, 20.0, output=10.0, events=run_events)
        run.save(path)
        if kind == "packed":
            import xarray as xr

            with xr.open_dataset(path, decode_times=False) as dataset:
                decoded = dataset.drop_encoding()
                packed = {name: {"zlib": True, "shuffle": True, "fletcher32": True} for name in ("time", "position")}
                decoded.to_netcdf(path.with_suffix(".packed"), engine="h5netcdf", encoding=packed)
            return _with_checksum(path.with_suffix(".packed").read_bytes())
        return path.read_bytes()


_KINDS = ["plain", "units", "packed"]


def _hdf5_size(data: bytes) -> int:
    """Return the number of bytes of a run's file before the checksum, from the header of HDF5."""
    return int.from_bytes(data[40:48], "little")


def _with_checksum(body: bytes) -> bytes:
    """Return the contents of an HDF5 file with their correct checksum appended."""
    digest = hashlib.sha256(body).hexdigest()
    return body + f"\nfullbody: sha256 of the {len(body)} bytes before this line: {digest}\n".encode()


@st.composite
def _damaged(draw: Any, kinds: list[str]) -> bytes:
    """Strategy of a run's or simulation's file with some bytes damaged."""
    data = bytearray(_saved(draw(st.sampled_from(kinds))))
    structures = [match.start() for match in _STRUCTURES.finditer(data)] or [0]

    def position() -> int:
        """Return a position anywhere in the file, or in one of HDF5's structures."""
        if draw(st.booleans()):
            return draw(st.integers(0, len(data) - 1))
        return min(draw(st.sampled_from(structures)) + draw(st.integers(0, 600)), len(data) - 1)

    for _ in range(draw(st.integers(1, 4))):
        first = position()
        match draw(st.sampled_from(["bit", "number", "number", "zeros", "swap", "copy", "cut", "insert"])):
            case "bit":
                data[first] ^= 1 << draw(st.integers(0, 7))
            case "number":
                width = draw(st.sampled_from([1, 2, 4, 8]))
                number = draw(st.sampled_from(_SPECIAL) | st.integers(0, 2**64 - 1))
                data[first : first + width] = (number % 256**width).to_bytes(width, "little")
            case "zeros":
                size = draw(st.sampled_from([8, 16, 64, 512, 4096]))
                first -= first % min(size, 8)
                data[first : first + size] = bytes(len(data[first : first + size]))
            case "swap":
                size, other = draw(st.sampled_from([8, 64, 512, 4096])), position()
                block, other_block = bytes(data[first : first + size]), bytes(data[other : other + size])
                data[first : first + len(other_block)], data[other : other + len(block)] = other_block, block
            case "copy":
                size, other = draw(st.sampled_from([8, 64, 512])), position()
                data[first : first + size] = data[other : other + size]
            case "cut":
                if draw(st.integers(0, 3)) == 0:
                    del data[first:]
            case "insert":
                if draw(st.integers(0, 3)) == 0:
                    data[first:first] = bytes(draw(st.integers(1, 64)))
        if len(data) < 64:
            break
    return bytes(data)


@st.composite
def _rewritten(draw: Any) -> bytes:
    """Strategy of a valid HDF5 file in which attributes and variables were overwritten, with a correct checksum."""
    stream = io.BytesIO(_saved(draw(st.sampled_from(_KINDS))))
    with h5py.File(stream, "r+") as file:
        for _ in range(draw(st.integers(1, 3))):
            texts = [name for name in file.attrs if name.startswith("fullbody") or name == "stop_reason"]
            variables = [name for name, variable in file.items() if variable.dtype.kind in "fi"]
            name = draw(st.sampled_from(texts if draw(st.booleans()) else variables))
            if name in texts:
                file.attrs[name] = _changed_text(draw, file.attrs.get(name))
            else:
                _write_variable(draw, file, name)
    return _with_checksum(stream.getvalue()[: _hdf5_size(stream.getvalue())])


def _changed_text(draw: Any, text: Any) -> Any:
    """Return a replacement for the text of an attribute: JSON with one entry changed or deleted, or any value."""
    try:
        value = json.loads(text)
        root, key = [value], 0
        inner: Any = root
        while isinstance(inner[key], dict | list) and inner[key] and draw(st.integers(0, 4)):
            inner = inner[key]
            key = draw(st.sampled_from(list(inner) if isinstance(inner, dict) else range(len(inner))))
        if inner is not root and draw(st.integers(0, 4)) == 0:
            del inner[key]
        else:
            inner[key] = draw(_JSON | st.sampled_from([-1.0, 0.0, 1e300, 1e-300, "Sphere", "h", "multipole:6"]))
        return json.dumps(root[0])
    except (TypeError, ValueError):
        return draw(
            st.one_of(st.text(max_size=8).filter(lambda text: "\0" not in text), st.integers(-5, 5), st.floats())
        )


def _write_variable(draw: Any, file: h5py.File, name: str) -> None:
    """Change a number, an attribute, the type or the shape of a variable, or delete it."""
    variable = file[name]
    match draw(st.sampled_from(["number", "number", "attribute", "type", "shape", "delete"])):
        case "number":
            if variable.size and variable.dtype.kind == "f":
                index = tuple(draw(st.integers(0, size - 1)) for size in variable.shape)
                variable[index] = draw(st.floats() | st.sampled_from([0.0, 1.0, -1.0, 1e154, 1e300, np.nan, np.inf]))
        case "attribute":
            names = ["scale_factor", "add_offset", "_FillValue", "missing_value", "units", "dtype"]
            variable.attrs[draw(st.sampled_from(names))] = draw(st.floats() | st.text("ab ", max_size=4))
        case "type":
            numbers = np.nan_to_num(variable[()])
            del file[name]
            kind = draw(st.sampled_from(["f4", ">f8", "f2", "i8", "u1", "c16", "S3"]))
            with np.errstate(all="ignore"):
                file.create_dataset(name, data=numbers.astype(kind))
        case "shape":
            numbers = variable[()]
            del file[name]
            shape = draw(st.lists(st.integers(0, 4) | st.just(10**4), max_size=4))
            if draw(st.booleans()):
                file.create_dataset(name, tuple(shape), "f8")
            else:
                file.create_dataset(name, data=numbers[..., None])
        case "delete":
            del file[name]


def _load(path: Path) -> None:
    """Check that a file is refused, or gives a consistent run that can be saved again."""
    run = fullbody.load(path)
    check_finite(run.time, run.position, run.velocity, run.attitude, run.spin, run.energy, run.angular_momentum)
    check_object(run)
    assert len(run) == len(run.time) == len(list(run))
    assert np.abs(np.linalg.norm(run.attitude, axis=-1) - 1.0).max(initial=0.0) < 2e-6
    check_finite(*(event.state.position for event in run.events))
    saved = path.with_name("saved.nc")
    run.save(saved)
    assert fullbody.load(saved) == run


def _resume(path: Path) -> None:
    """Check that a file is refused, or gives a simulation in a finite state."""
    sim = fullbody.Simulation.load(path)
    check_object(sim)
    check_finite(sim.time, sim.state.position)


TARGETS: list[Target] = [
    file_target("netcdf", ".nc", _damaged(_KINDS), _load),
    file_target("netcdf-content", ".nc", _rewritten(), _load),
    file_target("simulation", ".sim", _damaged(["simulation"]), _resume),
]
