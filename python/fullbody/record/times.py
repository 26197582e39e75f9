"""The times of a run as a caller gives them: its end, and those that are recorded."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.tables import number
from ..base.units import Units, scalar
from ..errors import InvalidInput, caution

__all__ = ["end_arguments", "end_of_run", "sampling", "spacing_warning"]


def end_arguments(until: Any, duration: Any) -> dict[str, Any]:
    """Return the one of both that is given, by its name, or raise an error."""
    if (until is None) == (duration is None):
        problem = "neither until nor duration" if until is None else "both until and duration"
        raise InvalidInput(f"{problem} are given; expected until, a time, or duration, a length of time")
    return {"until": until} if duration is None else {"duration": duration}


def end_of_run(until: Any, duration: Any, start: float, units: Units) -> float:
    """Return the end of a run, of which either a time or the length is given.

    Warns
    -----
    InconsistentInput
        For a text that is a time before the start.
    """
    if "duration" in end_arguments(until, duration):
        return start + units.number(duration, "time", "duration")
    end = scalar(units.strip(until, "time", "until"), "until")
    if isinstance(until, str) and end < start:
        begin, length = (number(units.attach(np.float64(value), "time")) for value in (start, start - end))
        caution(
            f"until is {until!r}, a time before that of the start, {begin}: the run goes backwards by {length}; a run "
            f"of that length has duration={until!r}"
        )
    return end


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


def spacing_warning(output: Any, length: float, units: Units) -> str | None:
    """Return a warning of a spacing of times that is longer than the run, or ``None``."""
    if not (isinstance(output, float) and np.inf > output > abs(length) > 0.0):
        return None
    spacing, whole = (number(units.attach(np.float64(value), "time")) for value in (output, abs(length)))
    return (
        f"output is {spacing}, a spacing of times, and the run is only {whole} long: its start and its end are "
        "recorded; expected a shorter spacing, or 'ends'"
    )
