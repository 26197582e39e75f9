"""Writing of kernel files, either completely or not at all, with SPICE's errors as this package's."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from ..base.atomic import replacing
from ..base.version import version
from ..errors import FullbodyError
from ..record.record import Record
from .conventions import spiceypy


@contextmanager
def binary(path: Any, opener: str, run: Record) -> Iterator[int]:
    """Yield the handle of a new kernel that replaces ``path``; its comments tell its origin."""
    spice = spiceypy()
    with replacing(path) as temporary:
        # SPICE creates its files itself.
        temporary.unlink()
        handle = None
        try:
            handle = getattr(spice, opener)(str(temporary), "fullbody", 0)
            spice.dafac(handle, _comments(run))
            yield handle
        except spice.utils.exceptions.SpiceyError as error:
            raise FullbodyError(f"{path} cannot be written: {message_of(error)}") from error
        finally:
            if handle is not None:
                with suppress(spice.utils.exceptions.SpiceyError):
                    spice.dafcls(handle)


def message_of(error: Exception) -> str:
    """Return the message of an error of SPICE in one line."""
    return str(getattr(error, "long", "") or getattr(error, "explain", "") or error).strip()


def _comments(run: Record) -> list[str]:
    """Return the comments as lines of ASCII, the only characters that kernels hold."""
    system = run.system
    lines = [f"Written by fullbody {version()}.", f"System: {system!r}", f"Integrator: {run.integrator!r}"]
    lines += [f"Epoch of the system: {system.options['epoch']}, its frame: {system.context.frame}"]
    return [line.encode("ascii", "backslashreplace").decode()[:1000] for line in lines]
