"""The arguments of times: the end of a run, and the times that are recorded."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.limits import Limits
from ..base.units import Units, as_quantity
from ..errors import InvalidInput, caution

#: Julian dates of 1858 to 2132, and calendar years.
_JULIAN, _YEARS = (2.4e6, 2.5e6), (1900.0, 2100.0)


def end_arguments(until: Any, duration: Any) -> dict[str, Any]:
    """Return until or duration, whichever is not None, by its name; both or neither are an error."""
    if (until is None) == (duration is None):
        problem = "neither until nor duration" if until is None else "both until and duration"
        raise InvalidInput(f"{problem} are given; expected until, a time, or duration, a length of time")
    return {"until": until} if duration is None else {"duration": duration}


def end_of_run(until: Any, duration: Any, start: float, units: Units) -> float:
    """Return the end of a run, from a time or the length, and warn of a text before the start and of a date."""
    if "duration" in end_arguments(until, duration):
        return start + units.number(duration, "time", "duration")
    end = units.number(until, "time", "until")
    _warn_of_date(until, end, start, units)
    if isinstance(until, str) and end < start:
        caution(
            f"until is {until!r}, a time before that of the start, {units.text(start, 'time')}: the run goes backwards "
            f"by {units.text(start - end, 'time')}; a run of that length has duration={until!r}"
        )
    return end


def _warn_of_date(until: Any, end: float, start: float, units: Units) -> None:
    """Warn of an end that looks like a Julian date, or like a calendar year, which is too far for a run."""
    unit = str(getattr(as_quantity(until, "until", "time"), "unit", ""))
    ranges = {"": _JULIAN, "d": _JULIAN, "yr": _YEARS, "a": _YEARS}
    if unit not in ranges:
        return
    factor = units.unit("time").to(unit) if unit else 1.0
    first, last = ranges[unit]
    if first <= end * factor <= last and not first <= start * factor <= last:
        caution(
            f"until is {until}, which looks like a date, and is taken as a time since time zero: the run is "
            f"{units.text(end - start, 'time')} long; expected the time of a date since the system's epoch, such as "
            "date - system.epoch"
        )


def sampling(output: Any, units: Units) -> Any:
    """Return the times to record in the form that the core takes: ``None``, ``"ends"``, a spacing, or times."""
    if output is None or (isinstance(output, str) and output == "ends"):
        return output
    limits = Limits(infinite=True, text="None, 'ends', a spacing above zero, or finite times")
    values = units.numbers(output, "time", "output", limits=limits)
    if values.ndim > 1:
        raise InvalidInput(f"output has shape {values.shape}; expected a number or (K,)")
    if values.ndim == 0 and not values > 0.0:
        raise InvalidInput(f"output is {output!r}; expected {limits.text}")
    return values if values.ndim else float(values)


def refuse_flood(output: Any, start: float, end: float, numbers: int, units: Units) -> None:
    """Raise an error for more samples of so many numbers than the memory can hold, before the process is killed."""
    limit = 2.0**34 / (8.0 * numbers)
    if isinstance(output, float) and (count := abs(end - start) / output) > limit:
        until, spacing = (units.attach(value, "time") for value in (end, output))
        raise InvalidInput(
            f"until is {until} and output is {spacing}, which ask for {count:.3g} samples; expected a time and a "
            f"spacing with at most {limit:.3g}, which take 17 GB"
        )


def spacing_warning(output: Any, length: float, units: Units) -> str | None:
    """Return a warning of a spacing of times that is longer than the run, or ``None``."""
    if not (isinstance(output, float) and np.inf > output > abs(length) > 0.0):
        return None
    return (
        f"output is {units.text(output, 'time')}, a spacing of times, and the run is only "
        f"{units.text(abs(length), 'time')} long: its start and its end are recorded; expected a shorter spacing, or "
        "'ends'"
    )
