"""Files written whole: under their name stands either the old one or the new one, never half of one."""

from __future__ import annotations

import errno
import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from .errors import InvalidInput

__all__ = ["check_place", "check_suffix", "replacing"]


def check_suffix(path: Any, suffixes: tuple[str, ...]) -> None:
    """Refuse a name that ends otherwise."""
    if Path(path).suffix.lower() not in suffixes:
        raise InvalidInput(f"path is {str(path)!r}; expected a name that ends in one of {', '.join(suffixes)}")


def check_place(path: Any) -> None:
    """Refuse a path that :func:`replacing` could not write; for asking before the work.

    Raises
    ------
    OSError
        Of the fitting kind, with the path.
    """
    with suppress(_Untouched), replacing(path):
        raise _Untouched


class _Untouched(Exception):
    """Leaves a block of :func:`replacing` without a file."""


@contextmanager
def replacing(path: Any) -> Iterator[Path]:
    """A temporary file beside ``path``, put in its place when the block ends without an error.

    Parameters
    ----------
    path : str or Path

    Yields
    ------
    Path
        To write to; it has the ending of ``path``.

    Raises
    ------
    OSError
        Where the file cannot be written, before the block where that is known then; names ``path`` alone.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise FileNotFoundError(f"no folder {path.parent} to write {path.name} in")
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    # Not from tempfile, whose files nobody else may read.
    mark = uuid.uuid4().hex
    temporary = path.with_name(f".{path.stem}.{mark}.part{path.suffix}")
    try:
        # Tried at once, since the block may work for long before it writes.
        temporary.touch()
        temporary.unlink()
        yield temporary
        os.replace(temporary, path)
    except BaseException as error:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        if not isinstance(error, OSError):
            raise
        plain = _about(error, path, mark)
        if plain is error:
            raise
        raise plain from None


def _about(error: OSError, path: Path, mark: str) -> OSError:
    """The error about the wanted path, where it is about the temporary file, whose name carries the mark."""
    nameless = error.filename is None and error.errno is not None
    if mark not in str(error) and not nameless:
        return error
    if error.errno is None:
        return OSError(f"{path} cannot be written: {type(error).__name__}")
    # Python picks the class that belongs to the number.
    return OSError(error.errno, os.strerror(error.errno), str(path))
