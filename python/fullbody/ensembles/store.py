"""The store of a sweep: its finished chunks on the disk."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from ..base.atomic import as_path, content, replacing
from ..errors import FullbodyError, InvalidInput
from ..files import checksum
from ..files.netcdf import SUFFIXES, write
from ..files.reading import netcdf
from .dataset import FAILURE
from .identity import digest
from .parameters import Columns, Plan, identities, plain_columns
from .work import Failure, Measured, Outcome

if TYPE_CHECKING:
    import xarray

__all__ = ["ATTRIBUTE", "Manifest", "Store", "opened"]

#: The identity of a sweep: digests of its parts by their names.
Manifest = Mapping[str, str]
#: The attribute of a map that holds the manifest.
ATTRIBUTE = "fullbody_sweep"
_LOCK = "lock"
#: First words of the names of the parts that may differ in a sweep that extends another one.
_EXTENSIBLE = ("dimensions", "parameter ")
#: Names of files left by a process that was killed while writing; see :func:`fullbody.base.atomic.replacing`.
_LEFT = re.compile(r"\..*\.[0-9a-f]{32}\.part\.(npz|json)")


@contextmanager
def opened(path: Any, manifest: Manifest, plan: Plan) -> Iterator[Store]:
    """Open the store at a path, locked against other processes.

    Raises
    ------
    InvalidInput
        If something else lies there, or a sweep that differs; the message names the differences.
    FullbodyError
        If another process has the store open.
    """
    store = Store(as_path(path, "store"), manifest, plan)
    if store.look():
        yield store
        return
    if not store.folder.parent.is_dir():
        raise FileNotFoundError(f"no folder {store.folder.parent} to keep {store.path.name} in")
    if store.folder.exists() and not store.folder.is_dir():
        raise InvalidInput(f"{store.folder} is a file; expected a folder, or a name that ends in .nc")
    store.folder.mkdir(exist_ok=True)
    with (store.folder / _LOCK).open("a+b") as lock:
        if not _hold(lock):
            raise FullbodyError(f"another process works on {store.path}; expected one at a time")
        # Another process may have finished between the look at the map and now.
        if not store.look():
            store.begin()
        yield store


if sys.platform == "win32":

    def _hold(file: IO[bytes]) -> bool:
        """Lock a file for this process; the lock ends with the process."""
        import msvcrt

        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

else:

    def _hold(file: IO[bytes]) -> bool:
        """Lock a file for this process alone: forked workers that outlive it do not keep the lock."""
        import fcntl

        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True


class Store:
    """A folder of chunks, and the map that they become if the path ends in ``.nc``.

    Attributes
    ----------
    path : Path
        The path as given.
    folder : Path
        The folder of the chunks.
    map : xarray.Dataset or None
        The map, if it was there when it was last looked for.
    """

    map: xarray.Dataset | None = None

    def __init__(self, path: Path, manifest: Manifest, plan: Plan) -> None:
        self.path, self._manifest, self._plan = path, dict(manifest), plan
        self._of_map = path.suffix.lower() in SUFFIXES
        if self._of_map:
            # A missing package is reported before all work, not at the end of it.
            netcdf()
        self.folder = path.with_name(path.name + ".parts") if self._of_map else path
        self._mark = digest(self._manifest)
        #: For each sweep whose chunks are here, by its mark: the rows of this sweep that its rows correspond to.
        self._rows: dict[str, list[int]] = {self._mark: list(range(len(plan)))}
        #: Rows of this sweep that come from a map that it extends.
        self._kept: dict[int, Outcome] = {}

    def look(self) -> bool:
        """Read the map if it is there and return whether it is complete.

        A map that this sweep extends provides its rows.
        """
        if not self._of_map or not self.path.exists():
            return False
        xr = netcdf()
        try:
            file = BytesIO(content(self.path))
            if not checksum.check(file):
                raise InvalidInput("another program wrote or changed the file")
            with xr.open_dataset(file, engine="h5netcdf") as stored:
                found = stored.load()
            if ATTRIBUTE not in found.attrs:
                raise InvalidInput(f"the file has no attribute {ATTRIBUTE}")
        except InvalidInput as error:
            raise InvalidInput(f"{self.path} is not a sweep's map: {error}; expected one, or a new name") from error
        names = {name: found.coords[name] for name in found.coords if f"parameter {name}" in self._manifest}
        columns: Columns = {
            name: (one.dims, one.values.ravel().tolist(), one.attrs.get("units")) for name, one in names.items()
        }
        dimensions = {name: found.sizes[name] for name in found.error.dims}
        rows = self._compare(found.attrs[ATTRIBUTE], dimensions, columns)
        if rows is None:
            self.map = found
            return True
        self._kept = {row: outcome for row, outcome in zip(rows, _outcomes(found, rows), strict=True)}
        return False

    def begin(self) -> None:
        """Check that the folder belongs to this sweep, or to sweeps that it extends."""
        for file in self.folder.iterdir():
            if _LEFT.fullmatch(file.name):
                file.unlink()
        described = sorted(self.folder.glob("sweep*.json"))
        others = sorted(file.name for file in self.folder.iterdir() if file.name != _LOCK)
        if others and not described:
            # The store leaves no file of its own in a folder that belongs to someone else.
            (self.folder / _LOCK).unlink()
            raise InvalidInput(f"{self.folder} has {others[0]}, but no sweep; expected a new or empty folder")
        known = False
        for file in described:
            try:
                found = json.loads(file.read_text(encoding="utf-8", errors="replace"))
                manifest, dimensions, columns = (found[name] for name in ("sweep", "dimensions", "parameters"))
            except (ValueError, TypeError, LookupError) as error:
                raise InvalidInput(f"{self.path} has a damaged description of its sweep: {error}") from error
            rows = self._compare(json.dumps(manifest), dimensions, columns)
            known |= rows is None
            if rows is not None:
                self._rows[digest(manifest)] = rows
        if not known:
            dimensions, columns = self._plan.dimensions, plain_columns(self._plan)
            text = json.dumps({"sweep": self._manifest, "dimensions": dimensions, "parameters": columns}, indent=1)
            with replacing(self.folder / f"sweep{len(described) or ''}.json") as temporary:
                temporary.write_text(text, encoding="utf-8")

    def _compare(self, text: str, dimensions: Mapping[str, int], columns: Columns) -> list[int] | None:
        """Compare another sweep with this one; return ``None`` if they are equal, or its rows' numbers in this one.

        Raises
        ------
        InvalidInput
            If they differ in more than the parameters, or if this sweep does not have all of its rows.
        """
        try:
            known = json.loads(text)
            changed = [name for name in {**known, **self._manifest} if known.get(name) != self._manifest.get(name)]
            if not changed:
                return None
            rows = None
            if all(name.startswith(_EXTENSIBLE) for name in changed) and len(known) == len(self._manifest):
                rows = self._included(identities(dimensions, columns))
        except (ValueError, TypeError, AttributeError, LookupError) as error:
            raise InvalidInput(f"{self.path} has a damaged description of its sweep: {error}") from error
        if rows is None:
            raise InvalidInput(
                f"{self.path} has a sweep that differs in: {', '.join(changed)}; expected the same, parameters that "
                "include all of its rows, or another store"
            )
        return rows

    def _included(self, stored: list[tuple[str, ...]]) -> list[int] | None:
        """Return the rows of this sweep with the stored rows' parameters, or ``None`` if one is missing.

        Random numbers depend on the row's number, which then has to agree too.
        """
        own = identities(self._plan.dimensions, plain_columns(self._plan))
        if self._manifest["seed"] != "None":
            return list(range(len(stored))) if own[: len(stored)] == stored else None
        places: dict[tuple[str, ...], list[int]] = {}
        for row in reversed(range(len(own))):
            places.setdefault(own[row], []).append(row)
        found = [places[one].pop() if places.get(one) else -1 for one in stored]
        return None if -1 in found else found

    def outcomes(self) -> dict[int, Outcome]:
        """Return the outcomes so far by rows."""
        found = dict(self._kept)
        for file in sorted(self.folder.glob("*.npz")):
            for outcome in self._read(file):
                if outcome.row in found:
                    raise InvalidInput(f"{file} has row {outcome.row} once more; expected each row in one file")
                found[outcome.row] = outcome
        return found

    def _read(self, file: Path) -> list[Outcome]:
        try:
            with np.load(BytesIO(content(file))) as chunk:
                mark, index, numbers = str(chunk["sweep"]), json.loads(str(chunk["index"])), chunk["numbers"]
            if mark not in self._rows:
                raise InvalidInput("the chunk belongs to another sweep")
            rows = self._rows[mark]
            return [replace(outcome, row=rows[outcome.row]) for outcome in _unpacked(index, numbers)]
        except InvalidInput as error:
            raise InvalidInput(f"{file} cannot be used: {error}; expected a chunk of this sweep") from error
        except OSError:
            raise
        except Exception as error:
            # A damaged archive raises errors of many kinds.
            raise InvalidInput(
                f"{file} is truncated or damaged; where it is deleted, its rows are computed again"
            ) from error

    def add(self, outcomes: list[Outcome]) -> None:
        """Store a chunk."""
        numbers = [o.value.reshape(-1) for out in outcomes for o in out.values.values() if not isinstance(o.value, str)]
        index = [
            {
                "row": out.row,
                "failure": None if out.failure is None else [out.failure.name, out.failure.text, out.failure.stage],
                "values": {
                    name: one.value if isinstance(one.value, str) else [one.value.shape, one.unit]
                    for name, one in out.values.items()
                },
            }
            for out in outcomes
        ]
        whole = BytesIO()
        np.savez(
            whole,
            sweep=np.array(self._mark),
            index=np.array(json.dumps(index)),
            numbers=np.concatenate(numbers) if numbers else np.empty(0),
        )
        # Chunks of a sweep that this one extends have that sweep's row numbers.
        extends = f"-{self._mark[:8]}" if len(self._rows) > 1 else ""
        with replacing(self.folder / f"{outcomes[0].row:08d}{extends}.npz") as temporary:
            temporary.write_bytes(whole.getbuffer())

    def finish(self, found: xarray.Dataset) -> xarray.Dataset:
        """Turn the chunks into the map, if the path ends in ``.nc``, and return the map as it is in the file."""
        if not self._of_map:
            return found
        write(found.assign_attrs({ATTRIBUTE: json.dumps(self._manifest)}), self.path)
        for file in (*self.folder.glob("*.npz"), *self.folder.glob("sweep*.json")):
            file.unlink(missing_ok=True)
        # Other files stay in the folder; on Windows open files stay, too.
        with suppress(OSError):
            (self.folder / _LOCK).unlink()
            self.folder.rmdir()
        self.look()
        assert self.map is not None
        return self.map


def _outcomes(found: xarray.Dataset, rows: list[int]) -> Iterator[Outcome]:
    """Yield the outcomes that a map was made of, with new row numbers."""
    names = [name for name in found.data_vars if name not in FAILURE]
    dims = found.error.dims
    flat = {
        name: (one.values.reshape(len(rows), *one.shape[len(dims) :]), one.attrs.get("units"))
        for name, one in ((str(name), found[name].transpose(*dims, ...)) for name in names)
    }
    failures = zip(*(found[name].values.ravel().tolist() for name in FAILURE), strict=True)
    for place, (row, failure) in enumerate(zip(rows, failures, strict=True)):
        values = {
            name: Measured(str(value[place])) if value.dtype.kind in "OUT" else Measured(value[place], unit)
            for name, (value, unit) in flat.items()
        }
        yield Outcome(row, values, Failure(*failure) if failure[0] else None)


def _unpacked(index: Any, numbers: Any) -> Iterable[Outcome]:
    place = 0
    for entry in index:
        values: dict[str, Measured] = {}
        for name, told in entry["values"].items():
            if isinstance(told, str):
                values[name] = Measured(told)
                continue
            shape, unit = told
            size = int(np.prod(shape, dtype=np.int64))
            values[name] = Measured(numbers[place : place + size].reshape(shape), unit)
            place += size
        failure = entry["failure"]
        yield Outcome(entry["row"], values, None if failure is None else Failure(*failure))
