"""Names and readers of files, and atomic writing: a name refers to the complete old file or the complete new one."""

from __future__ import annotations

import errno
import os
import stat
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from ..errors import InvalidInput

#: The errors by which a system says that it cannot flush a file of this kind, or cannot open a folder.
_NO_FLUSH = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EACCES, errno.EPERM)

#: The attributes that mark NetCDF files of this package, with the names of their contents and their readers.
_CONTENTS = {
    "fullbody_format": ("a run", "fullbody.load"),
    "fullbody_fit": ("a fit", "fullbody.load"),
    "fullbody_flight": ("a flight", "fullbody.load_flight"),
}
_SUFFIXES = {
    ".toml": ("a system as text", "fullbody.read_toml"),
    **dict.fromkeys((".obj", ".ply", ".stl"), ("a shape", "fullbody.Polyhedron.load")),
}


def as_path(path: Any, what: str = "path") -> Path:
    """Return the path that an argument gives, or raise an error that names the argument."""
    try:
        if b"\0" in os.fsencode(path):
            raise ValueError("the name contains a null character")
        return Path(path)
    except (TypeError, ValueError) as error:
        raise InvalidInput(f"{what} is {path!r}; expected the name of a file, as text or a Path") from error


def content(path: Any) -> bytes:
    """Return all bytes of a file; devices are refused, since some of them have no end."""
    with as_path(path).open("rb") as file:
        if stat.S_ISCHR(os.fstat(file.fileno()).st_mode):
            raise InvalidInput(f"{path} is a device; expected a file")
        return file.read()


def check_suffix(path: Any, suffixes: tuple[str, ...]) -> None:
    """Raise an error for a name that ends in none of these suffixes."""
    if as_path(path).suffix.lower() not in suffixes:
        raise InvalidInput(f"path is {str(path)!r}; expected a name that ends in one of {', '.join(suffixes)}")


def check_target(path: Any) -> None:
    """Raise the :class:`OSError` that :func:`replacing` would raise for a path, so that no work is done in vain."""
    with suppress(_Untouched), replacing(path):
        raise _Untouched


class _Untouched(Exception):
    """Leaves a block of :func:`replacing` without a file."""


@contextmanager
def replacing(path: Any) -> Iterator[Path]:
    """Context manager for an empty file, beside ``path`` and with its ending, that replaces it if the block has no
    error.

    The file is on the disk before it replaces the old one. A symbolic link stays, and the file that it points to is
    replaced. A replaced file's permissions are kept, and its owner where the system allows it; a new file has the
    permissions that the umask leaves. Other hard links to a replaced file keep the old content. An :class:`OSError`
    names ``path`` only, and is raised before the block if its reason is known by then: devices, pipes and
    write-protected files are refused.
    """
    path = as_path(path)
    old = _present(path)
    target = Path(os.path.realpath(path))
    if not target.parent.is_dir():
        raise FileNotFoundError(f"no folder {target.parent} to write {target.name} in")
    # The module tempfile makes files that nobody else may read. A name has at most 255 bytes.
    mark = uuid.uuid4().hex
    temporary = target.with_name(f".{target.stem[:12]}.{mark}.part{target.suffix[:12]}")
    try:
        # The file is made at once, since the block may take long before it writes. A file that replaces a private one
        # is private from its first byte on.
        os.close(os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666 if old is None else 0o600))
        yield temporary
        _flush(temporary)
        if old is not None:
            _take_over(temporary, old)
        os.replace(temporary, target)
        # The folder, which contains the new name, is flushed too.
        _flush(target.parent)
    except BaseException as error:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        if not isinstance(error, OSError):
            raise
        readable = _about(error, path, mark)
        if readable is error:
            raise
        raise readable from None


def _present(path: Path) -> os.stat_result | None:
    """Return the status of the file to be replaced, if there is one, or raise an error if it must not be replaced."""
    try:
        status = path.stat()
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(status.st_mode) or _is_open_file(path):
        raise OSError(errno.EINVAL, "Not a regular file, which alone can be replaced", str(path))
    if not os.access(path, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    return status


def _is_open_file(path: Path) -> bool:
    """Return whether a name such as /dev/stdout refers to a file that a process has open and would lose."""
    while path.is_symlink():
        path = path.parent / os.readlink(path)
        if os.path.realpath(path.parent).startswith("/proc/"):
            return True
    return False


def _take_over(temporary: Path, old: os.stat_result) -> None:
    """Give a file the owner and permissions of another."""
    new = temporary.stat()
    if (new.st_uid, new.st_gid) != (old.st_uid, old.st_gid):
        # Most users may not change a file's owner.
        with suppress(OSError):
            os.chown(temporary, old.st_uid, old.st_gid)
    os.chmod(temporary, stat.S_IMODE(old.st_mode))


def _flush(path: Path) -> None:
    """Have the system write a file or folder to the disk."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
    except OSError as error:
        if error.errno not in _NO_FLUSH:
            raise


def _about(error: OSError, path: Path, mark: str) -> OSError:
    """Return an error about the temporary file, whose name has the mark, as one about ``path``; others unchanged."""
    nameless = error.filename is None and error.errno is not None
    if mark not in str(error) and not nameless:
        return error
    if error.errno is None:
        return OSError(f"{path} cannot be written: {type(error).__name__}")
    # Python chooses the class of the error by its number.
    return OSError(error.errno, os.strerror(error.errno), str(path))


def other_reader(path: Path, reader: str, attributes: Mapping[str, Any] | None = None) -> str:
    """Return a phrase that names the content of a file, by its attributes if HDF5 read it, and its proper reader."""
    kind = None
    if attributes is not None:
        kind = next((entry for name, entry in _CONTENTS.items() if name in attributes), None)
        if str(attributes.get("title", "")).startswith("fullbody sweep"):
            kind = ("a map", "xarray.load_dataset")
    elif path.is_file():
        with path.open("rb") as file:
            begin = file.read(8)
        if begin == b"FULLBODY":
            kind = ("a simulation", "fullbody.Simulation.load")
        elif not begin.startswith(b"\x89HDF"):
            kind = _SUFFIXES.get(path.suffix.lower())
        elif not reader.startswith("fullbody.load"):
            kind = ("NetCDF, as of runs, fits and flights", "fullbody.load or fullbody.load_flight")
    return "" if kind is None or kind[1] == reader else f"; it is {kind[0]}, which {kind[1]} reads"
