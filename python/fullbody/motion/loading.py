"""Runs and flights from files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..base.arguments import named_options
from ..files import netcdf
from .simulation import Run, System

if TYPE_CHECKING:
    from ..particles.flight import Flight

__all__ = ["load", "load_flight"]


@named_options
def load(path: Any) -> Run:
    """Read a run that :meth:`fullbody.Run.save` wrote.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Run
        Equal to the one that was saved, bit for bit, with its events and stop reason; see :meth:`fullbody.Run.save` for
        what a file cannot hold.

    Raises
    ------
    InvalidInput
        For a file that is not a run of this package, or a damaged one; says what is wrong.
    FileNotFoundError
        Where there is no such file.

    Warns
    -----
    UncheckedFile
        For a file without a checksum of the whole, which another program or an earlier version wrote. It is read, if
        its content is that of a run.
    """
    return netcdf.load(path, System, Run)


@named_options
def load_flight(path: Any) -> Flight:
    """Read a flight that :meth:`fullbody.Flight.save` wrote.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Flight
        Equal to the one that was saved, bit for bit; functions that were watched for have their names alone.

    Raises
    ------
    InvalidInput
        For a file that is not a flight of this package, or a damaged one; says what is wrong.
    FileNotFoundError
        Where there is no such file.

    Warns
    -----
    UncheckedFile
        For a file without a checksum of the whole.
    """
    from ..particles import files
    from ..particles.flight import Flight

    return files.load(path, System, Flight)
