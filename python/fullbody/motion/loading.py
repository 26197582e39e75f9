"""Loading of runs and flights from files."""

from __future__ import annotations

from typing import Any

from ..files import netcdf
from ..files.reading import Content, read
from ..particles import files as flights
from ..particles.flight import Flight
from ..record.integrators import rebuild
from .run import Run
from .system import System, system_of

__all__ = ["load_flight", "run_in"]


def run_in(content: Content) -> Run[System]:
    """Return the run in a file."""
    netcdf.check_format(content)
    system = content.parsed("fullbody_system", system_of)
    integrator = content.parsed("fullbody_integrator", rebuild)
    return Run(system, integrator, **netcdf.contents(content, system.context))


def load_flight(path: Any) -> Flight[System]:
    """Read a flight that :meth:`fullbody.Flight.save` wrote.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Flight
        The flight that was saved, equal bit for bit; functions of events are represented by their names.

    Raises
    ------
    InvalidInput
        If the file is not a flight of this package, or is damaged; the message says what is wrong.
    FileNotFoundError
        If there is no such file.

    Warns
    -----
    UncheckedFile
        For a file without a checksum.
    """
    return read(path, "flight", _flight)


def _flight(content: Content) -> Flight[System]:
    content.check_format(*flights.FORMAT)
    system = content.parsed("fullbody_system", system_of)
    return Flight(system, **flights.contents(content, system.context))
