"""Tables, and columns of times in which those that an event does not have are masked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..base.epochs import to_time
from ..base.units import need
from ..model.context import SystemLike
from .times import seconds


def table_of(columns: Mapping[str, Any], meta: Mapping[str, Any] | None = None) -> Any:
    """Return an astropy ``QTable`` of columns."""
    with need("observing", "a table"):
        from astropy.table import QTable

    return QTable(dict(columns), meta=meta)


def masked_times(times: Sequence[Any], system: SystemLike) -> Any:
    """Return times or durations as a column of numbers, in which ``None`` is masked."""
    from astropy.table import MaskedColumn

    units = system.context.units
    numbers = [0.0 if time is None else float(units.strip(time, "time", "time")) for time in times]
    unit = units.unit("time") if units.defined else None
    return MaskedColumn(numbers, mask=[time is None for time in times], unit=unit, dtype=float)


def time_column(times: Sequence[Any], system: SystemLike) -> Any:
    """Return times of a system's clock as a column of dates in UTC, or of numbers if the system has no epoch.

    ``None`` is masked.
    """
    column, context = masked_times(times, system), system.context
    if context.epoch is None:
        return column
    from astropy.time import TimeDelta

    elapsed = TimeDelta(np.asarray(column.data.data) * seconds(system, "a table of times"), format="sec")
    dates = (to_time(context.epoch).tdb + elapsed).utc.copy()
    dates.format = "iso"
    if column.mask.any():
        dates[column.mask] = np.ma.masked
    return dates
