"""The store of a sweep: what is done of it, on the disk, chunk by chunk."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from ..base.atomic import as_path, content, replacing
from ..errors import FullbodyError, InvalidInput
from ..files import seal
from ..files.netcdf import SUFFIXES, netcdf, sealed
from .identity import digest
from .work import Failure, Measured, Outcome

if TYPE_CHECKING:
    import xarray

__all__ = ["ATTRIBUTE", "Manifest", "Store", "opened"]

#: What a sweep is: digests by what they are of.
Manifest = Mapping[str, str]
#: The attribute of a map that holds the manifest.
ATTRIBUTE = "fullbody_sweep"
_MANIFEST, _LOCK = "sweep.json", "lock"
#: What a process that was killed while it wrote a file leaves behind; see :func:`fullbody.base.atomic.replacing`.
_LEFT = re.compile(r"\..*\.[0-9a-f]{32}\.part\.(npz|json)")


@contextmanager
def opened(path: Any, manifest: Manifest) -> Iterator[Store]:
    """The store at a path, held against other processes.

    Raises
    ------
    InvalidInput
        Where something else lies there, or a sweep that differs; names what does.
    FullbodyError
        Where another process has it.
    """
    store = Store(as_path(path, "store"), manifest)
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
        # Another may have ended between the look at the map and now.
        if not store.look():
            store.begin()
        yield store


if sys.platform == "win32":

    def _hold(file: IO[bytes]) -> bool:
        """Lock a file for this process, which ends with it."""
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
    """A folder of chunks, and where the path ends in ``.nc`` the map that they become.

    Attributes
    ----------
    path : Path
        As given.
    folder : Path
        Of the chunks.
    map : xarray.Dataset or None
        The map, where it was there at the last look.
    """

    map: xarray.Dataset | None = None

    def __init__(self, path: Path, manifest: Manifest) -> None:
        self.path, self._manifest = path, dict(manifest)
        self._of_map = path.suffix.lower() in SUFFIXES
        if self._of_map:
            # What is missing is known before all work, not at the end of it.
            netcdf()
        self.folder = path.with_name(path.name + ".parts") if self._of_map else path
        self._mark = digest(self._manifest)

    def look(self) -> bool:
        """Whether the map is there, which is then read."""
        if not self._of_map or not self.path.exists():
            return False
        xr = netcdf()
        try:
            file = BytesIO(content(self.path))
            if not seal.check(file):
                raise InvalidInput("another program wrote it, or changed it")
            with xr.open_dataset(file, engine="h5netcdf") as stored:
                self.map = stored.load()
            if ATTRIBUTE not in self.map.attrs:
                raise InvalidInput("it is something else")
        except InvalidInput as error:
            raise InvalidInput(f"{self.path} is no map of a sweep: {error}; expected one, or a new name") from error
        self._compare(self.map.attrs[ATTRIBUTE])
        return True

    def begin(self) -> None:
        """Make sure that the folder belongs to this sweep."""
        for file in self.folder.iterdir():
            if _LEFT.fullmatch(file.name):
                file.unlink()
        described = self.folder / _MANIFEST
        if described.exists():
            self._compare(described.read_text(encoding="utf-8", errors="replace"))
            return
        others = sorted(file.name for file in self.folder.iterdir() if file.name != _LOCK)
        if others:
            # Nothing of ours stays in a folder that is another's.
            (self.folder / _LOCK).unlink()
            raise InvalidInput(f"{self.folder} has {others[0]}, but no sweep; expected a new or empty folder")
        with replacing(described) as temporary:
            temporary.write_text(json.dumps(self._manifest, indent=1), encoding="utf-8")

    def _compare(self, text: str) -> None:
        """Refuse another sweep by what differs."""
        try:
            known = json.loads(text)
            changed = [name for name in {**known, **self._manifest} if known.get(name) != self._manifest.get(name)]
        except (ValueError, TypeError, AttributeError) as error:
            raise InvalidInput(f"{self.path} has a damaged description of its sweep: {error}") from error
        if changed:
            raise InvalidInput(
                f"{self.path} has a sweep that differs in: {', '.join(changed)}; expected the same, or another store"
            )

    def outcomes(self) -> dict[int, Outcome]:
        """What is done, by rows."""
        found: dict[int, Outcome] = {}
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
            if mark != self._mark:
                raise InvalidInput("it belongs to another sweep")
            return list(_unpacked(index, numbers))
        except InvalidInput as error:
            raise InvalidInput(f"{file} cannot be used: {error}; expected a chunk of this sweep") from error
        except OSError:
            raise
        except Exception as error:
            # A damaged archive gives errors of many kinds.
            raise InvalidInput(
                f"{file} is truncated or damaged; where it is deleted, its rows are computed again"
            ) from error

    def add(self, outcomes: list[Outcome]) -> None:
        """Keep a chunk."""
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
        with replacing(self.folder / f"{outcomes[0].row:08d}.npz") as temporary:
            temporary.write_bytes(whole.getbuffer())

    def finish(self, found: xarray.Dataset) -> xarray.Dataset:
        """Turn the chunks into the map, where the path is one's; the map as it is in the file."""
        if not self._of_map:
            return found
        with replacing(self.path) as temporary:
            temporary.write_bytes(sealed(found.assign_attrs({ATTRIBUTE: json.dumps(self._manifest)}), {}))
        for file in (*self.folder.glob("*.npz"), self.folder / _MANIFEST):
            file.unlink(missing_ok=True)
        # What others have put there stays, and an open file does so on Windows.
        with suppress(OSError):
            (self.folder / _LOCK).unlink()
            self.folder.rmdir()
        self.look()
        assert self.map is not None
        return self.map


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
