"""Times of observations (dates of any scale, or times since a system's epoch), and the sizes of a system's units."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..base import epochs
from ..base.foreign import are_dates
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats

#: The speed of light in km/s.
LIGHT_SPEED = 299792.458


def system_epoch(system: SystemLike, what: str) -> Any:
    """Return the date of a system's time zero, TDB; the error for a system without one says what needs it."""
    if system.context.epoch is None:
        raise InvalidInput(
            f"{what} needs the date of the system's time zero; give fullbody.System(..., epoch='2022-09-26 TDB')"
        )
    return epochs.to_time(system.context.epoch).tdb


def in_system(times: Any, system: SystemLike, what: str) -> Floats:
    """Return times, or dates of any scale, as numbers in a system's unit of time since its epoch."""
    times = epochs.dates(times, what)
    if are_dates(times):
        since = (times.tdb - system_epoch(system, f"a date in {what}")).to_value("s")
        times = np.asarray(since, dtype=np.float64) / seconds(system, f"a date in {what}")
    return system.context.units.numbers(times, "time", what)


def unmasked(dates: Any) -> tuple[Any, Any]:
    """Return dates without their mask, and the mask, which is false for dates that have none."""
    if not getattr(dates, "masked", False):
        return dates, np.zeros(dates.shape, dtype=bool)
    return getattr(dates, "unmasked", dates), np.asarray(dates.mask)


def _size(system: SystemLike, what: str, dimension: str, unit: str) -> float:
    if not system.context.units.defined:
        raise InvalidInput(f"{what} needs the system's units; give fullbody.System(..., units=('km', 'hour', 'kg'))")
    return float(system.context.units.unit(dimension).to(unit))


#: The numbers of seconds and of kilometres in the units of a system, by functions of it and of what needs them.
seconds = partial(_size, dimension="time", unit="s")
kilometres = partial(_size, dimension="length", unit="km")
