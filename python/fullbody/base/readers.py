"""What a file is that was given to the wrong reader, and what reads it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

__all__ = ["other_reader"]

#: The attributes of NetCDF files of this package, with what they are and their readers.
_CONTENTS = {
    "fullbody_format": ("a run", "fullbody.load"),
    "fullbody_fit": ("a fit", "fullbody.load"),
    "fullbody_flight": ("a flight", "fullbody.load_flight"),
}
_SUFFIXES = {
    ".toml": ("a system as text", "fullbody.read_toml"),
    **dict.fromkeys((".obj", ".ply", ".stl"), ("a shape", "fullbody.Polyhedron.load")),
}


def other_reader(path: Path, own: str, attributes: Mapping[str, Any] | None = None) -> str:
    """Return a phrase about what a file is and which function reads it; it is empty if that is ``own`` or not known.

    Parameters
    ----------
    path : Path
    own : str
        The reader that was called.
    attributes : mapping, optional
        Those of a file of NetCDF that could be read. Here it is not opened, since HDF5 trusts what it reads.
    """
    found = None
    if attributes is not None:
        found = next((entry for name, entry in _CONTENTS.items() if name in attributes), None)
        if str(attributes.get("title", "")).startswith("fullbody sweep"):
            found = ("a map", "xarray.load_dataset")
    elif path.is_file():
        with path.open("rb") as file:
            begin = file.read(8)
        if begin == b"FULLBODY":
            found = ("a simulation", "fullbody.Simulation.load")
        elif not begin.startswith(b"\x89HDF"):
            found = _SUFFIXES.get(path.suffix.lower())
        elif not own.startswith("fullbody.load"):
            found = ("NetCDF, as of runs, fits and flights", "fullbody.load or fullbody.load_flight")
    return "" if found is None or found[1] == own else f"; it is {found[0]}, which {found[1]} reads"
