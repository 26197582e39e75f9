"""What a file is that was given to the wrong reader, and what reads it."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

__all__ = ["other_reader"]

#: The attributes of NetCDF files of this package, with what they are and their readers.
_CONTENTS = {
    "fullbody_format": ("run", "fullbody.load"),
    "fullbody_fit": ("fit", "fullbody.load"),
    "fullbody_flight": ("flight", "fullbody.load_flight"),
}
_SUFFIXES = {
    ".toml": ("system as text", "fullbody.read_toml"),
    **dict.fromkeys((".obj", ".ply", ".stl"), ("shape", "fullbody.Polyhedron.load")),
}


def other_reader(path: Path, own: str) -> str:
    """Return a phrase about what a file is and which function reads it; it is empty if that is ``own`` or not known."""
    found = None
    with suppress(OSError, ImportError, KeyError, RuntimeError):
        with path.open("rb") as file:
            begin = file.read(8)
        if begin == b"FULLBODY":
            found = ("simulation", "fullbody.Simulation.load")
        elif begin.startswith(b"\x89HDF"):
            import h5py

            with h5py.File(path, "r") as content:
                attributes = dict(content.attrs)
            known = [entry for name, entry in _CONTENTS.items() if name in attributes]
            is_map = str(attributes.get("title", "")).startswith("fullbody sweep")
            found = known[0] if known else ("map", "xarray.load_dataset") if is_map else None
        else:
            found = _SUFFIXES.get(path.suffix.lower())
    return "" if found is None or found[1] == own else f"; it is a {found[0]}, which {found[1]} reads"
