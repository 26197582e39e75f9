"""Values of other libraries: xarray, pint, pandas, tables and times, as numbers or astropy Quantities."""

from __future__ import annotations

import reprlib
from datetime import timedelta
from typing import Any

import numpy as np

from ..errors import InvalidInput

#: The number of values of a column that a message shows.
_SHOWN = 3


def are_dates(value: Any) -> bool:
    """Return whether a value is an astropy ``Time``, and not a time between two dates."""
    return hasattr(value, "jd1") and not hasattr(value, "to")


def shown(value: Any) -> str:
    """Return a value as text for a message, with at most three values of an array or a list."""
    if hasattr(value, "to_numpy"):
        value = value.to_numpy()
    if hasattr(value, "ravel") and np.size(value) > _SHOWN:
        value = value.ravel()
    is_list = isinstance(value, list | tuple) or (hasattr(value, "ravel") and np.ndim(value) == 1)
    omitted = len(value) - _SHOWN if is_list else 0
    # A whole number may have hundreds of digits.
    text = str if are_dates(value) else reprlib.repr if isinstance(value, int) else repr
    return f"{text(value[:_SHOWN])} and {omitted} more" if omitted > 0 else text(value)


def array_or_quantity(value: Any, what: str) -> Any:
    """Return a value of another library as an array or a Quantity, whose unit numpy would drop, and others unchanged.

    These are times between dates, columns of astropy, arrays of xarray with ``attrs["units"]`` and Quantities of pint.
    A date is an error, and so is a unit that astropy does not know.
    """
    if are_dates(value):
        expected = "the time since the system's epoch, such as date - system.epoch"
        raise InvalidInput(f"{what} is the date {shown(value)}; expected {expected}")
    if hasattr(value, "jd1"):
        return value.to("day")
    if isinstance(value, timedelta) or getattr(getattr(value, "dtype", None), "kind", "") == "m":
        return _with_unit(np.asarray(value, dtype="timedelta64[ns]") / np.timedelta64(1, "s"), "s", what)
    if getattr(value, "unit", None) is not None and hasattr(value, "quantity"):
        value = value.quantity
    elif hasattr(value, "attrs") and hasattr(value, "dims"):
        unit = value.attrs.get("units")
        return array_or_quantity(value.data, what) if unit is None else _with_unit(value.to_numpy(), unit, what)
    elif hasattr(value, "magnitude") and hasattr(value, "units"):
        return _with_unit(value.magnitude, str(value.units), what)
    return value.data if isinstance(value, np.ma.MaskedArray) else getattr(value, "unmasked", value)


def _with_unit(numbers: Any, unit: Any, what: str) -> Any:
    from astropy import units as u

    try:
        # Pint's name of the unit of pure numbers is a word.
        return u.Quantity(numbers, "" if unit == "dimensionless" else unit)
    except (ValueError, TypeError) as error:
        raise InvalidInput(f"{what} has the unit {unit!r}, which astropy cannot read: {error}") from error
