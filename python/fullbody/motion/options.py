"""Checks of the options of a run before it starts: output, events, autosave."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..base.arguments import names_of, sequence
from ..base.atomic import as_path
from ..base.units import Units, from_text
from ..errors import InvalidInput
from ..events import Event
from ..record.integrators import Integrator

__all__ = ["autosaving", "check_for_all", "differentiated", "sampling", "watched"]


def sampling(output: Any, units: Units) -> Any:
    """Return the times to record in the form that the core takes: ``None``, ``"ends"``, a spacing, or times."""
    expected = "a spacing above zero, or times"
    if output is None or (isinstance(output, str) and output == "ends"):
        return output
    if isinstance(output, bool):
        raise InvalidInput(f"output is {output!r}; expected None, 'ends', {expected}")
    values = units.strip(output, "time", "output")
    if values.ndim > 1:
        raise InvalidInput(f"output has shape {values.shape}; expected a number or (K,)")
    if values.ndim == 1:
        return values
    if not values > 0.0:
        raise InvalidInput(f"output is {output!r}; expected {expected}")
    return float(values)


def check_for_all(integrator: Any, output: Any, until: Any) -> None:
    """Raise an error for options that are invalid for any system, whatever its units are."""
    if integrator is not None and not isinstance(integrator, Integrator):
        raise InvalidInput(f"integrator is {integrator!r}; expected one of fullbody's, such as Verner98(...)")
    for name, value in (("output", output), ("until", until)):
        if isinstance(value, str) and not (name == "output" and value == "ends"):
            from_text(value, name, "time")


def autosaving(autosave: Any) -> tuple[Path, float]:
    """Return the path to write to, and the number of seconds between two files."""
    try:
        where, every = autosave
        path, seconds = as_path(where), float(every)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"autosave is {autosave!r}; expected (path, seconds)") from error
    if not 0.0 <= seconds < 1e9:
        raise InvalidInput(f"seconds of autosave is {seconds!r}; expected a number from 0 to below 1e9")
    return path, seconds


def watched(events: Iterable[Event]) -> list[Event]:
    """Return the events as a list, or raise an error that shows what is not an event."""
    if isinstance(events, str):
        raise InvalidInput(f"events is {events!r}, which is text; expected a list of fullbody.events")
    return list(sequence(events, Event, "events", "a list of fullbody.events", "fullbody.events"))


def differentiated(derivatives: Any) -> list[str] | None:
    """Return the parameters by which a run is differentiated, or ``None`` if it is not differentiated."""
    if isinstance(derivatives, bool):
        return [] if derivatives else None
    return names_of(derivatives, "derivatives")
