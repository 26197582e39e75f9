"""Files written whole: under their name stands either the old one or the new one, never half of one."""

from __future__ import annotations

import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .errors import InvalidInput

__all__ = ["check_suffix", "replacing"]


def check_suffix(path: Any, suffixes: tuple[str, ...]) -> None:
    """Refuse a name that ends otherwise."""
    if Path(path).suffix.lower() not in suffixes:
        raise InvalidInput(f"path is {str(path)!r}; expected a name that ends in one of {', '.join(suffixes)}")


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
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise FileNotFoundError(f"no folder {path.parent} to write {path.name} in")
    # Not from tempfile, whose files nobody else may read.
    temporary = path.with_name(f".{path.stem}.{uuid.uuid4().hex}.part{path.suffix}")
    try:
        yield temporary
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
