"""Kernels as files: written whole or not at all, with SPICE's errors as this package's."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from ..base.atomic import replacing
from ..base.version import version
from ..errors import FullbodyError
from ..record.base import BaseRun
from .place import spiceypy

__all__ = ["binary", "plain"]


@contextmanager
def binary(path: Any, opener: str, run: BaseRun) -> Iterator[int]:
    """The handle of a new kernel that takes the place of ``path``; its comments tell where it comes from."""
    spice = spiceypy()
    with replacing(path) as temporary:
        # SPICE makes its files itself.
        temporary.unlink()
        handle = None
        try:
            handle = getattr(spice, opener)(str(temporary), "fullbody", 0)
            spice.dafac(handle, _comments(run))
            yield handle
        except spice.utils.exceptions.SpiceyError as error:
            raise FullbodyError(f"{path} cannot be written: {plain(error)}") from error
        finally:
            if handle is not None:
                with suppress(spice.utils.exceptions.SpiceyError):
                    spice.dafcls(handle)


def plain(error: Exception) -> str:
    """What an error of SPICE says, in one line."""
    return str(getattr(error, "long", "") or getattr(error, "explain", "") or error).strip()


def _comments(run: BaseRun) -> list[str]:
    """Lines of ASCII, which is all that kernels hold."""
    system = run.system
    lines = [f"Written by fullbody {version()}.", f"System: {system!r}", f"Integrator: {run.integrator!r}"]
    lines += [f"Epoch of the system: {system.options['epoch']}, its frame: {system.frame}"]
    return [line.encode("ascii", "backslashreplace").decode()[:1000] for line in lines]
