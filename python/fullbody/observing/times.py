"""Times of observations (dates of any scale, or times since a system's epoch), exposures, and a system's units."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..base import epochs
from ..base.foreign import are_dates
from ..base.limits import NOT_NEGATIVE
from ..errors import InvalidInput
from ..model.context import SystemLike
from ..typing import Floats

#: The speed of light in km/s.
LIGHT_SPEED = 299792.458
#: The number of times at which what is observed in an exposure is computed.
_NODES = 5


def system_epoch(system: SystemLike, what: str) -> Any:
    """Return the date of a system's time zero, TDB; the error for a system without one says what needs it."""
    if system.context.epoch is None:
        raise InvalidInput(
            f"{what} needs the date of the system's time zero; give fullbody.System(..., epoch='2022-09-26 TDB')"
        )
    return epochs.to_time(system.context.epoch).tdb


def to_system_times(times: Any, system: SystemLike, what: str) -> Floats:
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


def exposure_rule(exposure: Any, system: SystemLike) -> list[tuple[float, float]]:
    """Return times from the middle of an exposure in a system's unit of time, each with its weight in the mean.

    Gauss's rule with five nodes averages a polynomial of the ninth degree exactly. The exposure is one time for all
    observations.
    """
    length = system.context.units.number(exposure, "time", "exposure", NOT_NEGATIVE)
    if length == 0.0:
        return [(0.0, 1.0)]
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    return list(zip((0.5 * length * nodes).tolist(), (0.5 * weights).tolist(), strict=True))


def _size(system: SystemLike, what: str, dimension: str, unit: str) -> float:
    if not system.context.units.defined:
        raise InvalidInput(f"{what} needs the system's units; give fullbody.System(..., units=('km', 'hour', 'kg'))")
    return float(system.context.units.unit(dimension).to(unit))


#: The numbers of seconds and of kilometres in the units of a system, by functions of it and of what needs them.
seconds = partial(_size, dimension="time", unit="s")
kilometres = partial(_size, dimension="length", unit="km")
