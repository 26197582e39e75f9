"""The store of a sweep: its finished chunks on the disk."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
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
from .dataset import FAILURE, table_of
from .parameters import ParameterTable
from .work import Failure, MeasuredValue, Outcome

if TYPE_CHECKING:
    import xarray

#: The description of a sweep: texts by their names.
Manifest = Mapping[str, str]
#: The attribute of a map that holds the description of its sweep.
ATTRIBUTE = "fullbody_sweep"
_LOCK, _DESCRIPTION = "lock", "sweep.json"
#: Names of files left by a process that was killed while writing; see :func:`fullbody.base.atomic.replacing`.
_ABANDONED = re.compile(r"\..*\.[0-9a-f]{32}\.part\.(npz|json)")


@contextmanager
def opened(path: Any, manifest: Manifest, table: ParameterTable) -> Iterator[Store]:
    """Open the store at a path, locked against other processes; any other file or folder there is an error."""
    store = Store(as_path(path, "store"), manifest, table)
    store.refresh()
    if store.map is not None:
        yield store
        return
    if not store.folder.parent.is_dir():
        raise FileNotFoundError(f"no folder {store.folder.parent} to keep {store.path.name} in")
    if store.folder.exists() and not store.folder.is_dir():
        raise InvalidInput(f"{store.folder} is a file; expected a folder, or a name that ends in .nc")
    with _locked(store):
        # Another process may have finished since the map was read.
        store.refresh()
        if store.map is None:
            store.begin()
        yield store


@contextmanager
def _locked(store: Store) -> Iterator[None]:
    """Hold the lock of a store's folder, which is made if it is missing."""
    store.folder.mkdir(exist_ok=True)
    path = store.folder / _LOCK
    busy = FullbodyError(f"another process works on {store.path}; expected one at a time")
    try:
        lock = path.open("a+b")
    except FileNotFoundError:
        raise busy from None
    with lock:
        # The process that completes the map removes the lock, which then locks nothing.
        if not _hold(lock) or not path.exists() or not os.path.samestat(os.fstat(lock.fileno()), path.stat()):
            raise busy
        yield


def _hold(file: IO[bytes]) -> bool:
    """Lock a file for this process alone: forked workers that outlive it do not keep the lock."""
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


class Store:
    """A folder of chunks, and the map that they become if the path ends in ``.nc``.

    The ``path`` is the caller's and ``folder`` that of the chunks; ``map`` is the complete map, if it existed at the
    last :meth:`refresh`, and ``outcomes`` has the stored outcomes by rows.
    """

    map: xarray.Dataset | None = None

    def __init__(self, path: Path, manifest: Manifest, table: ParameterTable) -> None:
        self.path, self._manifest, self._table = path, dict(manifest), table.texts()
        self._of_map = path.suffix.lower() in SUFFIXES
        if self._of_map:
            # A missing package is reported before all work, not at the end of it.
            netcdf()
        self.folder = path.with_name(path.name + ".parts") if self._of_map else path
        self._numbered = manifest["rng"] != "None"
        self._identities = table.identities(self._numbered)
        self._rows = {identity: row for row, identity in enumerate(self._identities)}
        self.outcomes: dict[int, Outcome] = {}

    def refresh(self) -> None:
        """Read the map if it exists; a map that this sweep extends provides its rows."""
        self.outcomes = {}
        if not self._of_map or not self.path.exists():
            return
        xr = netcdf()
        try:
            file = BytesIO(content(self.path))
            if not checksum.check(file):
                raise InvalidInput("another program wrote or changed the file")
            with xr.open_dataset(file, engine="h5netcdf") as stored:
                dataset = stored.load()
            if ATTRIBUTE not in dataset.attrs:
                raise InvalidInput(f"the file has no attribute {ATTRIBUTE}")
        except InvalidInput as error:
            raise InvalidInput(f"{self.path} is not a sweep's map: {error}; expected one, or a new name") from error
        table = table_of(dataset)
        outcomes = dict(zip(table.identities(self._numbered), _outcomes(dataset), strict=True))
        if self._is_same(json.loads(dataset.attrs[ATTRIBUTE]), table.texts(), outcomes):
            self.map = dataset
        else:
            self._take(outcomes)

    def begin(self) -> None:
        """Read the chunks, after a check that the folder belongs to this sweep or to one that it extends."""
        for file in self.folder.iterdir():
            if _ABANDONED.fullmatch(file.name):
                file.unlink()
        described, is_described = self.folder / _DESCRIPTION, False
        if described.exists():
            try:
                dataset = json.loads(described.read_text(encoding="utf-8", errors="replace"))
                manifest, table = ({**dataset[name]} for name in ("sweep", "parameters"))
            except (ValueError, TypeError, LookupError) as error:
                raise InvalidInput(f"{self.path} has a damaged description of its sweep: {error}") from error
            chunks = {file: self._read(file, manifest) for file in sorted(self.folder.glob("*.npz"))}
            is_described = self._is_same(manifest, table, set(itertools.chain(*chunks.values())))
            of_map = self.outcomes.copy()
            for file, outcomes in chunks.items():
                # A process that was killed after it wrote the map left its chunks.
                if twice := [row for row in self._take(outcomes) if row not in of_map]:
                    raise InvalidInput(f"{file} has row {twice[0]} once more; expected each row in one file")
        elif names := sorted(file.name for file in self.folder.iterdir() if file.name != _LOCK):
            # The store leaves no file of its own in a folder that belongs to someone else.
            (self.folder / _LOCK).unlink()
            raise InvalidInput(f"{self.folder} has {names[0]}, but no sweep; expected a new or empty folder")
        if not is_described:
            text = json.dumps({"sweep": self._manifest, "parameters": self._table}, indent=1)
            with replacing(described) as temporary:
                temporary.write_text(text, encoding="utf-8")

    def _is_same(self, manifest: Manifest, table: Manifest, rows: Iterable[str]) -> bool:
        """Return whether a stored sweep is this one, or one that it extends; any other is an error."""
        changed = _differences(manifest, self._manifest)
        extended = _differences(table, self._table)
        if changed or not self._rows.keys() >= set(rows):
            raise InvalidInput(
                f"{self.path} has a sweep that differs in: {'; '.join(changed + extended)}; expected the same, "
                "parameters that include all of its rows, or another store"
            )
        return not extended

    def _take(self, outcomes: Mapping[str, Outcome]) -> list[int]:
        """Add stored outcomes, given by the identities of their rows, and return the rows that were there before."""
        by_row = {self._rows[identity]: outcome for identity, outcome in outcomes.items()}
        twice = [row for row in by_row if row in self.outcomes]
        self.outcomes |= {row: replace(outcome, row=row) for row, outcome in by_row.items()}
        return twice

    def _read(self, file: Path, manifest: Manifest) -> dict[str, Outcome]:
        """Return the outcomes in a chunk by the identities of their rows."""
        try:
            with np.load(BytesIO(content(file))) as chunk:
                mark, index, numbers = str(chunk["sweep"]), json.loads(str(chunk["index"])), chunk["numbers"]
            if mark != _mark(manifest):
                raise InvalidInput("the chunk belongs to another sweep")
            return dict(_unpacked(index, numbers))
        except InvalidInput as error:
            raise InvalidInput(f"{file} cannot be used: {error}; expected a chunk of this sweep") from error
        except OSError:
            raise
        except Exception as error:
            # A damaged archive raises errors of many kinds.
            expected = "if it is deleted, its rows are computed again"
            raise InvalidInput(f"{file} is truncated or damaged; {expected}") from error

    def add(self, outcomes: list[Outcome]) -> None:
        """Store a chunk."""
        numbers = [o.value.reshape(-1) for out in outcomes for o in out.values.values() if not isinstance(o.value, str)]
        index = [
            {
                "row": self._identities[out.row],
                "failure": out.failure,
                "values": {
                    name: item.value if isinstance(item.value, str) else [item.value.shape, item.unit]
                    for name, item in out.values.items()
                },
            }
            for out in outcomes
        ]
        archive = BytesIO()
        mark, texts = np.array(_mark(self._manifest)), np.array(json.dumps(index))
        np.savez(archive, sweep=mark, index=texts, numbers=np.concatenate(numbers) if numbers else np.empty(0))
        # A chunk of a sweep that this one extends may begin with a row of the same number.
        names = (f"{outcomes[0].row:08d}{f'-{k}' if k else ''}.npz" for k in itertools.count())
        path = next(path for name in names if not (path := self.folder / name).exists())
        with replacing(path) as temporary:
            temporary.write_bytes(archive.getbuffer())

    def finish(self, dataset: xarray.Dataset) -> xarray.Dataset:
        """Turn the chunks into the map, if the path ends in ``.nc``, and return the map as it is in the file."""
        if not self._of_map:
            return dataset
        write(dataset.assign_attrs({ATTRIBUTE: json.dumps(self._manifest)}), self.path)
        for file in (*self.folder.glob("*.npz"), self.folder / _DESCRIPTION):
            file.unlink(missing_ok=True)
        # Other files stay in the folder; on Windows open files stay, too.
        with suppress(OSError):
            (self.folder / _LOCK).unlink()
            self.folder.rmdir()
        self.refresh()
        assert self.map is not None
        return self.map


def _mark(manifest: Manifest) -> str:
    """Return a digest of the description of a sweep, which its chunks have."""
    return hashlib.sha256(json.dumps(manifest, sort_keys=True).encode()).hexdigest()


def _differences(stored: Manifest, present: Manifest) -> list[str]:
    """Return the names of the texts that differ, each with the first lines that do."""
    differences = []
    for name in sorted(stored.keys() | present.keys()):
        lines = itertools.zip_longest(*(str(texts.get(name, "")).splitlines() for texts in (stored, present)))
        if pair := next((pair for pair in lines if pair[0] != pair[1]), None):
            lines_of_both = ("nothing" if line is None else _short(line.strip()) for line in pair)
            differences.append(f"{name} ({', here '.join(lines_of_both)})")
    return differences


def _short(line: str) -> str:
    return line if len(line) <= 60 else f"{line[:57]}..."


def _outcomes(dataset: xarray.Dataset) -> Iterator[Outcome]:
    """Yield the outcomes of the rows that a map was made of."""
    names = [name for name in dataset.data_vars if name not in FAILURE]
    dims = dataset.error.dims
    flat = {
        name: (item.values.reshape(-1, *item.shape[len(dims) :]), item.attrs.get("units"))
        for name, item in ((str(name), dataset[name].transpose(*dims, ...)) for name in names)
    }
    failures = zip(*(dataset[name].values.ravel().tolist() for name in FAILURE), strict=True)
    for row, failure in enumerate(failures):
        values = {
            name: MeasuredValue(str(value[row])) if value.dtype.kind in "OUT" else MeasuredValue(value[row], unit)
            for name, (value, unit) in flat.items()
        }
        yield Outcome(row, values, Failure(*failure) if failure[0] else None)


def _unpacked(index: Any, numbers: Any) -> Iterator[tuple[str, Outcome]]:
    """Yield the identities and outcomes of rows from the parts of a chunk."""
    start = 0
    for row, entry in enumerate(index):
        values: dict[str, MeasuredValue] = {}
        for name, stored in entry["values"].items():
            if isinstance(stored, str):
                values[name] = MeasuredValue(stored)
                continue
            shape, unit = stored
            size = int(np.prod(shape, dtype=np.int64))
            values[name] = MeasuredValue(numbers[start : start + size].reshape(shape), unit)
            start += size
        failure = entry["failure"]
        yield entry["row"], Outcome(row, values, None if failure is None else Failure(*failure))
