"""Loading of runs, fits and flights from files."""

from __future__ import annotations

from typing import Any

from .files import netcdf
from .files.reading import Content, read
from .motion.run import Run
from .motion.system import System, system_of
from .particles import files as flights
from .particles.flight import Flight
from .record.integrators import rebuild


def load(path: Any) -> Run | Any:
    """Read a run that :meth:`fullbody.Run.save` wrote, or a fit that :meth:`fullbody.fitting.Fit.save` wrote.

    It is equal bit for bit to what was saved; these methods say what a file cannot hold.

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


def run_in(content: Content) -> Run[System]:
    """Return the run in a file."""
    content.check_format(*netcdf.FORMAT)
    system = content.parsed("fullbody_system", system_of)
    integrator = content.parsed("fullbody_integrator", rebuild)
    return Run(system, integrator, **netcdf.contents(content, system.context))


def load_flight(path: Any) -> Flight[System]:
    """Read a flight that :meth:`fullbody.Flight.save` wrote, with names for functions of events.

    The errors and the warning are those of :func:`load`.
    """
    return read(path, "flight", _flight)


def _flight(content: Content) -> Flight[System]:
    content.check_format(*flights.FORMAT)
    system = content.parsed("fullbody_system", system_of)
    return Flight(system, **flights.contents(content, system.context))
