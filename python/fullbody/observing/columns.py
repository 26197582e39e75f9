"""Columns of observations: numbers with or without units, of which some rows may be masked or missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from ..base.arguments import refuse_unknown
from ..base.epochs import dates as dates_of
from ..base.epochs import refuse_coarse
from ..base.foreign import are_dates, array_or_quantity
from ..base.limits import LARGEST, SMALLEST, Limits
from ..base.unit_names import unit_named, usable_unit
from ..base.units import (
    UNITLESS,
    gathered,
    is_quantity,
    need,
    numbers,
    refuse_booleans,
    strip_to,
)
from ..errors import InconsistentInput, InvalidInput, caution

__all__ = ["DataColumn", "Rows", "column", "jitter_of", "positive_rows", "read_table"]

_Array = npt.NDArray[np.float64]


def column(values: Any, what: str, unit: Any = None) -> tuple[_Array, Any]:
    """Return the numbers of a column, with NaN for masked or missing values, and the unit that it came with.

    Values with a unit are converted to ``unit``; plain numbers are taken to be in it.
    """
    refuse_booleans(values, what)
    if hasattr(values, "dims") or getattr(getattr(values, "dtype", None), "kind", "") == "m":
        values = array_or_quantity(values, what)
    try:
        values, mask = _unmasked(values)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"{what} has values that are no numbers: {error}") from error
    values = gathered(values, what)
    if is_quantity(values):
        try:
            unit_of_column = usable_unit(values.unit)
        except ValueError as error:
            raise InvalidInput(f"{what} has a unit that cannot be used: {error}") from error
        result = strip_to(values, unit_of_column if unit is None else unit_named(unit), what)
    else:
        result, unit_of_column = numbers(values, what), None
    result = np.array(result, dtype=np.float64)
    if mask is not None:
        result[mask] = np.nan
    beyond = result[np.abs(result) > LARGEST]
    if beyond.size:
        raise InvalidInput(
            f"{what} has the value {float(beyond[0])}; expected numbers of at most {LARGEST} in size, or masked ones"
        )
    return result, unit_of_column


def _unmasked(values: Any) -> tuple[Any, Any]:
    """Return values without their mask, and the mask if there is one."""
    if hasattr(values, "to_numpy"):
        # The column is one of pandas, whose missing values may have a type of their own.
        if getattr(values.dtype, "kind", "") in ("c", "M"):
            raise TypeError("they are complex or dates")
        values = values.to_numpy(dtype=np.float64, na_value=np.nan)
    if isinstance(values, np.ma.MaskedArray):
        bare = np.array(np.ma.getdata(values), dtype=np.float64)
        unit = getattr(values, "unit", None)
        return (bare if unit is None else bare * unit), np.ma.getmaskarray(values)
    if hasattr(values, "unmasked"):
        return values.unmasked, np.asarray(values.mask)
    return values, None


class Rows:
    """Which rows of a table of observations are kept, in the order of time.

    Attributes
    ----------
    times : Time, Quantity or ndarray, (K,)
    kept : ndarray of int, (K,)
        The indices of the kept rows in the table, in the order of time.
    missing : tuple of int
        The indices of the rows that are left out, since a value is masked or NaN.
    given : int
        The number of rows of the table.
    """

    def __init__(self, times: Any, columns: dict[str, _Array], observed: Sequence[str], owner: str) -> None:
        for name in observed:
            if columns[name].ndim != 1:
                # One number in place of a column is accepted for errors and correlations only.
                expected = "expected (K,), one for each of times"
                raise InvalidInput(f"{name} of {owner} has shape {columns[name].shape}; {expected}")
        times = dates_of(times, f"times of {owner}")
        if are_dates(times):
            mask = np.asarray(times.mask) if getattr(times, "masked", False) else None
            bare = times.unmasked if mask is not None and hasattr(times, "unmasked") else times
            try:
                axis = np.asarray((bare - bare[0]).to_value("s") if np.ndim(bare) else 0.0, dtype=np.float64)
            except ValueError as error:
                # The library of time scales knows UTC for a limited range of years.
                raise InvalidInput(f"times of {owner} are dates that cannot be subtracted: {error}") from error
            if mask is not None:
                axis[mask] = np.nan
        else:
            refuse_coarse(times, None, f"times of {owner}")
            axis, unit = column(times, f"times of {owner}")
            bare = axis if unit is None else axis * unit
        if axis.ndim != 1 or not len(axis):
            raise InvalidInput(f"times of {owner} has shape {axis.shape}; expected (K,), one time or more")
        absent = np.isnan(axis)
        for name, values in columns.items():
            if values.shape[:1] not in ((), axis.shape):
                raise InvalidInput(
                    f"{name} of {owner} has shape {values.shape}; expected {len(axis)} rows, one for each of times"
                )
            absent |= np.isnan(values).reshape(*values.shape[:1], -1).any(axis=-1)
        order = np.argsort(axis, kind="stable")
        self.kept = order[~absent[order]]
        self.missing = tuple(int(index) for index in np.flatnonzero(absent))
        if not len(self.kept):
            raise InvalidInput(f"{owner} has no row without masked or missing values; expected one or more")
        if self.missing:
            some = ", ".join(map(str, self.missing[:5])) + (", ..." if len(self.missing) > 5 else "")
            caution(
                f"{len(self.missing)} of {len(axis)} rows of {owner} have masked or missing values and are left out: "
                f"row {some}",
                InconsistentInput,
            )
        self.times = bare[self.kept]
        self.input_length = len(axis)
        self._owner, self._columns = owner, columns

    def of(self, name: str, *shape: int) -> _Array:
        """Return the kept rows (K, C) or (K,) of a column, whose values are (), (K,) or (K, C)."""
        values, what = self._columns[name], f"{name} of {self._owner}"
        had = values.shape
        if values.ndim and len(values) == self.input_length:
            values = values[self.kept]
        while values.ndim and values.ndim < 1 + len(shape):
            values = values[..., None]
        try:
            return np.array(np.broadcast_to(values, (len(self.kept), *shape)), dtype=np.float64)
        except ValueError as error:
            shapes = " or ".join(str(item) for item in {(self.input_length,): 0, (self.input_length, *shape): 0})
            raise InvalidInput(f"{what} has shape {had}; expected {shapes}, or one number") from error


def positive_rows(values: _Array, what: str) -> _Array:
    """Return standard errors after checking that they are positive, and that their squares are too."""
    if not (values >= SMALLEST).all():
        least = f" and not below {SMALLEST}" if (values > 0.0).all() else ""
        raise InvalidInput(f"{what} has the value {float(values.min())}; expected standard errors above zero{least}")
    return values


def jitter_of(values: Any, unit: Any) -> float:
    """Return a jitter as a number in a unit, after checking that it is zero or above."""
    limits = Limits(least=0.0, text="a standard deviation, zero or above")
    return UNITLESS.number(column(values, "jitter", unit)[0], "number", "jitter", limits)


class DataColumn(NamedTuple):
    """A column that a class of observations reads from a table.

    Attributes
    ----------
    name : str
        The argument of the class, which is also the name of the column unless the user names another one.
    parts : tuple of str
        The names of the columns that are the argument together, if they are several.
    errors : str
        The name of the column of its standard errors, if they are not an argument that is declared by itself.
    required : bool
        Whether each table has the column. Without any such column a table has one of the others or several.
    kind : "values", "numbers" or "labels"
        Values may have a unit, and numbers have none. Labels may be anything, and are read only if the user names their
        column.
    """

    name: str
    parts: tuple[str, ...] = ()
    errors: str = ""
    required: bool = True
    kind: Literal["values", "numbers", "labels"] = "values"


def read_table(
    table: Any,
    declared: Sequence[DataColumn],
    columns: Mapping[str, Any],
    unit: Any,
    dates: tuple[str, str] | None,
    owner: str,
) -> dict[str, Any]:
    """Return arguments of a class of observations from the columns of an astropy ``Table`` or a pandas ``DataFrame``.

    Parameters
    ----------
    table : Table, QTable or DataFrame
    declared : sequence of DataColumn
        The columns of the class besides ``times``.
    columns : dict
        The name of the column of each argument, or the names of several columns that are one argument, where they
        differ from the declared ones.
    unit : dict or unit
        Units of values without a unit, one for all or by the argument.
    dates : (format, scale), optional
        The format and the scale of columns that hold dates as numbers or texts, as in astropy's ``Time``:
        ``("jd", "utc")``.
    owner : str
    """
    column_names = getattr(table, "colnames", getattr(table, "columns", None))
    if column_names is None:
        raise InvalidInput(f"table of {owner} is {table!r}; expected a table of astropy or pandas")
    names = list(column_names)
    has = [c for c in declared if c.required or c.name in columns or (c.name in names and c.kind != "labels")]
    if not has:
        either = " or ".join(repr(c.name) for c in declared)
        raise InvalidInput(f"the table has no column {either} of {owner}; it has {names}")
    if isinstance(unit, Mapping):
        known_names = [name for c in declared if c.kind == "values" for name in (c.name, c.errors) if name]
        refuse_unknown(map(str, unit), known_names, f"unit of {owner}")
    shapes: dict[str, Any] = {"times": "times"} | {c.name: c.parts or c.name for c in has}
    shapes |= {c.errors: c.errors for c in has if c.errors} | dict(columns)
    kinds, arguments = {c.name: c.kind for c in declared}, {}
    for argument, named in shapes.items():
        kind, what, parts = kinds.get(argument, "values"), f"{argument} of {owner}", []
        for name in (named,) if isinstance(named, str) else named:
            if name not in names:
                raise InvalidInput(f"the table has no column {name!r} for {what}; it has {names}")
            parts.append(table[name])
        if argument == "times":
            arguments[argument] = _dates(parts[0], dates, getattr(table, "attrs", {}))
        elif kind == "labels":
            arguments[argument] = np.asarray(parts[0])
        else:
            unit_of_column = unit.get(argument) if isinstance(unit, Mapping) else unit
            unit_of_column = _unit_of(unit_of_column, argument) if kind == "values" else None
            pairs = [column(part, what) for part in parts]
            units = [had if had is not None else unit_of_column for _, had in pairs]
            scaled = [values if unit is None else values * unit for (values, _), unit in zip(pairs, units, strict=True)]
            arguments[argument] = scaled[0] if isinstance(named, str) else _stacked(scaled, what)
    return arguments


def _unit_of(values: Any, argument: str) -> Any:
    """Return a unit, which may be given as text."""
    if values is None:
        return None
    try:
        return usable_unit(values)
    except (ValueError, TypeError, OverflowError) as error:
        raise InvalidInput(f"unit of {argument} is {values!r}; expected a unit or its name: {error}") from error


def _stacked(parts: list[Any], what: str) -> Any:
    try:
        return np.stack(parts, axis=-1)
    except (ValueError, TypeError) as error:
        raise InvalidInput(f"the columns of {what} do not go together: {error}") from error


def _dates(values: Any, dates: tuple[str, str] | None, attrs: Mapping[str, Any]) -> Any:
    if dates is None or are_dates(values):
        try:
            return dates_of(values, "times of the table", attrs.get("time_scale", "utc"))
        except InvalidInput as error:
            raise InvalidInput(f"{error}, or dates=('isot', 'utc')") from error
    with need("observing", "dates of a table"):
        from astropy.time import ScaleValueError, Time

    if not isinstance(dates, tuple | list) or len(dates) != 2:
        raise InvalidInput(f"dates is {dates!r}; expected a format and a scale, such as ('jd', 'utc')")

    def read(texts: Any) -> Any:
        return Time(texts, format=dates[0], scale=dates[1])

    column = np.asarray(values)
    try:
        refuse_coarse(column, lambda item, other: abs((read(other) - read(item)).to_value("s")), "times of the table")
        return read(column.astype(str) if column.dtype.kind in "OT" else column)
    except InvalidInput:
        raise
    except (ValueError, TypeError, ScaleValueError) as error:
        raise InvalidInput(f"times of the table are not dates of the format and scale {dates!r}: {error}") from error
