"""Loading of runs and fits from files."""

from __future__ import annotations

from typing import Any

from .files.reading import Content, read
from .motion.loading import run_in
from .motion.run import Run

__all__ = ["load"]


def load(path: Any) -> Run | Any:
    """Read a run that :meth:`fullbody.Run.save` wrote, or a fit that :meth:`fullbody.fitting.Fit.save` wrote.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Run or Fit
        The object that was saved, equal bit for bit; see :meth:`fullbody.Run.save` and
        :meth:`fullbody.fitting.Fit.save` for what a file cannot hold.

    Raises
    ------
    InvalidInput
        If the file is neither of these, or is damaged; the message says what is wrong.
    FileNotFoundError
        If there is no such file.

    Warns
    -----
    UncheckedFile
        For a file without a checksum, which another program wrote. It is read if its content is that of a run or a fit.
    """
    return read(path, "run", _content)


def _content(content: Content) -> Any:
    if content.has_attribute("fullbody_fit"):
        from .fitting.result import fit_in

        return fit_in(content)
    return run_in(content)
