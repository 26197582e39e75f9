"""Columns of observations: numbers with or without units, of which some rows may be masked or missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from ..base.arguments import refuse_unknown
from ..base.epochs import dates as dates_of
from ..base.epochs import refuse_coarse
from ..base.foreign import are_dates, array_or_quantity, shown
from ..base.limits import LARGEST, SMALLEST, Limits
from ..base.unit_names import unit_named, usable_unit
from ..base.units import UNITLESS, as_quantity, is_quantity, need, numbers, refuse_booleans, strip_to
from ..errors import InconsistentInput, InvalidInput, caution
from ..typing import Floats
from .times import unmasked

#: The spacing of a type's numbers relative to their standard error above which they are refused.
_ROUNDED = 0.1


def column(source: Any, what: str, unit: Any = None) -> tuple[Floats, Any]:
    """Return the numbers of a column in a unit, with NaN for missing values, and the unit that it came with."""
    refuse_booleans(source, what)
    if hasattr(source, "dims") or getattr(getattr(source, "dtype", None), "kind", "") == "m":
        source = array_or_quantity(source, what)
    try:
        source, mask = _unmasked(source)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"{what} has values that are no numbers: {error}") from error
    source = as_quantity(source, what)
    if is_quantity(source):
        try:
            unit_of_source = usable_unit(source.unit)
        except ValueError as error:
            raise InvalidInput(f"{what} has a unit that cannot be used: {error}") from error
        values = strip_to(source, unit_of_source if unit is None else unit_named(unit), what)
    else:
        values, unit_of_source = numbers(source, what), None
    values = np.array(values, dtype=np.float64)
    if mask is not None:
        values[mask] = np.nan
    beyond = values[np.abs(values) > LARGEST]
    if beyond.size:
        raise InvalidInput(
            f"{what} has the value {float(beyond[0])}; expected numbers of at most {LARGEST} in size, or masked ones"
        )
    return values, unit_of_source


def refuse_rounded(source: Any, values: Floats, sigma: Floats, what: str) -> None:
    """Raise an error for numbers whose given type rounds them to more than a tenth of their standard errors."""
    if (kind := _short(source)) is None:
        return
    values, sigma = np.atleast_1d(values), sigma.min(axis=-1) if sigma.ndim > values.ndim else sigma
    spacing = np.abs(values) * float(np.finfo(kind).eps)
    if sigma.shape in ((), values.shape) and (bad := spacing > _ROUNDED * sigma).any():
        k = int(np.argmax(bad))
        error = np.broadcast_to(sigma, spacing.shape)[k]
        raise InvalidInput(
            f"{what} are numbers of the type {kind}, which near {values[k]:.6g} are {spacing[k]:.2g} apart, with a "
            f"standard error of {error:.2g}; expected float64, in which the data have to be read"
        )


def _short(source: Any) -> Any:
    """Return the type of floats of less than 64 bits, or ``None`` for other values."""
    kind = getattr(source, "dtype", None)
    short = getattr(kind, "kind", "") == "f" and kind.itemsize < 8  # type: ignore[union-attr]
    return np.dtype(f"f{kind.itemsize}") if short else None  # type: ignore[union-attr]


def _unmasked(source: Any) -> tuple[Any, Any]:
    """Return values without their mask, and the mask if there is one."""
    if hasattr(source, "to_numpy"):
        # The column is one of pandas, whose missing values may have a type of their own.
        if getattr(source.dtype, "kind", "") in ("c", "M"):
            raise TypeError("they are complex or dates")
        source = source.to_numpy(dtype=np.float64, na_value=np.nan)
    if isinstance(source, np.ma.MaskedArray):
        values = np.array(np.ma.getdata(source), dtype=np.float64)
        unit = getattr(source, "unit", None)
        return (values if unit is None else values * unit), np.ma.getmaskarray(source)
    if hasattr(source, "unmasked"):
        return source.unmasked, np.asarray(source.mask)
    return source, None


class Rows:
    """The rows of a table of observations that have all values, in the order of time.

    The table has ``count`` rows, of which those with the ``indices`` (K,) have the ``times`` (K,), and those with
    the indices ``missing`` are left out, since a value is masked or NaN.
    """

    def __init__(self, times: Any, columns: dict[str, Floats], observed: Sequence[str], owner: str) -> None:
        for name in observed:
            if columns[name].ndim != 1:
                # One number in place of a column is accepted for errors and correlations only.
                expected = "expected (K,), one for each of times"
                raise InvalidInput(f"{name} of {owner} has shape {columns[name].shape}; {expected}")
        times = dates_of(times, f"times of {owner}")
        if are_dates(times):
            times, mask = unmasked(times)
            try:
                axis = np.where(mask, np.nan, (times - times[0]).to_value("s") if np.ndim(times) else 0.0)
            except ValueError as error:
                # The library of time scales knows UTC for a limited range of years.
                raise InvalidInput(f"times of {owner} are dates that cannot be subtracted: {error}") from error
        else:
            refuse_coarse(times, None, f"times of {owner}")
            axis, unit = column(times, f"times of {owner}")
            times = axis if unit is None else axis * unit
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
        self.indices = order[~absent[order]]
        self.missing = tuple(int(index) for index in np.flatnonzero(absent))
        if not len(self.indices):
            raise InvalidInput(f"{owner} has no row without masked or missing values; expected one or more")
        if self.missing:
            some = ", ".join(map(str, self.missing[:5])) + (", ..." if len(self.missing) > 5 else "")
            caution(
                f"{len(self.missing)} of {len(axis)} rows of {owner} have masked or missing values and are left out: "
                f"row {some}",
                InconsistentInput,
            )
        self.times = times[self.indices]
        self.count = len(axis)
        self._owner, self.columns = owner, columns

    def column(self, name: str, *shape: int) -> Floats:
        """Return the rows (K, C) or (K,) of a column, whose values are (), (K,) or (K, C)."""
        values, what = self.columns[name], f"{name} of {self._owner}"
        had = values.shape
        if values.ndim and len(values) == self.count:
            values = values[self.indices]
        while values.ndim and values.ndim < 1 + len(shape):
            values = values[..., None]
        try:
            return np.array(np.broadcast_to(values, (len(self.indices), *shape)), dtype=np.float64)
        except ValueError as error:
            wanted = " or ".join(map(str, dict.fromkeys([(self.count,), (self.count, *shape)])))
            raise InvalidInput(f"{what} has shape {had}; expected {wanted}, or one number") from error


def labels_of(labels: Any, what: str, rows: Rows, default: Any) -> tuple[Any, Any]:
    """Return the distinct labels of rows, and the index of each row's label among them.

    ``labels`` are one for each of the rows of the table. ``None``, or nothing but ``None``, stands for the ``default``
    labels of these rows.
    """
    if labels is not None and np.shape(labels) != (rows.count,):
        raise InvalidInput(f"{what} has shape {np.shape(labels)}; expected ({rows.count},), one for each of times")
    values = np.ma.getdata(labels) if hasattr(labels, "dtype") else np.array(labels, dtype=object)
    try:
        missing = np.ma.getmask(labels) | np.array(values != values, dtype=bool)
    except TypeError as error:
        raise InvalidInput(f"{what} is {shown(labels)}; expected a label for each of times") from error
    if np.any(missing):
        raise InvalidInput(f"{what} has no label in row {int(np.argmax(missing))}; expected one for each of times")
    absent = labels is None or all(label is None for label in np.asarray(labels))
    try:
        return np.unique(default if absent else np.asarray(labels)[rows.indices], return_inverse=True)
    except TypeError as error:
        raise InvalidInput(f"{what} is {shown(labels)}, labels of several kinds; expected one kind") from error


def positive_rows(values: Floats, what: str) -> Floats:
    """Return standard errors after checking that they are positive, and that their squares are too."""
    if not (values >= SMALLEST).all():
        least = f" and not below {SMALLEST}" if (values > 0.0).all() else ""
        raise InvalidInput(f"{what} has the value {float(values.min())}; expected standard errors above zero{least}")
    return values


def jitter_of(jitter: Any, unit: Any) -> float:
    """Return a jitter as a number in a unit, after checking that it is zero or above."""
    limits = Limits(least=0.0, text="a standard deviation, zero or above")
    return UNITLESS.number(column(jitter, "jitter", unit)[0], "number", "jitter", limits)


class DataColumn(NamedTuple):
    """A column that a class of observations reads from a table.

    The name is that of the argument, and of the column unless the user names another one; ``parts`` are the names of
    several columns that are the argument together. ``errors`` is the column of its standard errors, if they are not an
    argument that is declared by itself. Each table has the ``required`` columns; without any such column it has one of
    the others or several. Values may have a unit, numbers have none but their own, and labels may be anything. A
    ``named`` column is read only if the user names it.
    """

    name: str
    parts: tuple[str, ...] = ()
    errors: str = ""
    required: bool = True
    kind: Literal["values", "numbers", "labels", "times"] = "values"
    named: bool = False


def read_table(
    table: Any,
    declared: Sequence[DataColumn],
    columns: Mapping[str, Any],
    unit: Any,
    dates: tuple[str, str] | None,
    owner: str,
) -> dict[str, Any]:
    """Return arguments of a class of observations from the columns of an astropy ``Table`` or a pandas ``DataFrame``.

    The ``declared`` columns are those of the class, besides ``times`` if it declares no others of this kind, and
    ``columns`` the names of the columns of arguments, one or several for each, where they differ from these. The
    ``unit`` of values without one is one for all or by the argument. ``dates`` has the format and the scale of columns
    that hold dates as numbers or texts, as in astropy's ``Time``: ``("jd", "utc")``.
    """
    colnames = getattr(table, "colnames", getattr(table, "columns", None))
    if colnames is None:
        raise InvalidInput(f"table of {owner} is {table!r}; expected a table of astropy or pandas")
    names = list(colnames)
    has = [c for c in declared if c.required or c.name in columns or (c.name in names and not c.named)]
    if not has:
        either = " or ".join(repr(c.name) for c in declared)
        raise InvalidInput(f"the table has no column {either} of {owner}; it has {names}")
    arguments_of_class = [name for c in declared for name in (c.name, c.errors) if name]
    refuse_unknown(map(str, columns), ["times", *arguments_of_class], f"columns of {owner}")
    if isinstance(unit, Mapping):
        numeric = [name for c in declared if c.kind == "values" for name in (c.name, c.errors) if name]
        refuse_unknown(map(str, unit), numeric, f"unit of {owner}")
    wanted: dict[str, Any] = {} if any(c.kind == "times" for c in declared) else {"times": "times"}
    wanted |= {c.name: c.parts or c.name for c in has}
    wanted |= {c.errors: c.errors for c in has if c.errors} | dict(columns)
    kinds: dict[str, str] = {"times": "times"} | {c.name: c.kind for c in declared}
    arguments: dict[str, Any] = {}
    for argument, named in wanted.items():
        kind, what, parts = kinds.get(argument, "values"), f"{argument} of {owner}", []
        for name in (named,) if isinstance(named, str) else named:
            if name not in names:
                raise InvalidInput(f"the table has no column {name!r} for {what}; it has {names}")
            parts.append(table[name])
        if kind == "times":
            times = _dates(parts[0], dates, getattr(table, "attrs", {}))
            arguments[argument] = times if argument == "times" or are_dates(times) else _with_unit(times, what, unit)
        elif kind == "labels":
            arguments[argument] = np.asanyarray(parts[0])
        else:
            unit_of_column = unit.get(argument) if isinstance(unit, Mapping) else unit
            unit_of_column = _unit_of(unit_of_column, argument) if kind == "values" else None
            pairs = [column(part, what) for part in parts]
            units = [had if had is not None else unit_of_column for _, had in pairs]
            # Numbers keep a short type, which may be too coarse for their errors.
            short = [values.astype(_short(part) or float) for (values, _), part in zip(pairs, parts, strict=True)]
            scaled = [part if factor is None else part * factor for part, factor in zip(short, units, strict=True)]
            try:
                arguments[argument] = scaled[0] if isinstance(named, str) else np.stack(scaled, axis=-1)
            except (ValueError, TypeError) as error:
                raise InvalidInput(f"the columns of {what} do not go together: {error}") from error
    return arguments


def _with_unit(times: Any, what: str, unit: Any) -> Any:
    """Return times that are no dates as numbers or a Quantity, in their own unit or a default one."""
    values, unit_of_column = column(times, what)
    if unit_of_column is None and not isinstance(unit, Mapping):
        unit_of_column = _unit_of(unit, what)
    return values if unit_of_column is None else values * unit_of_column


def _unit_of(unit: Any, argument: str) -> Any:
    """Return a unit, which may be given as text."""
    if unit is None:
        return None
    try:
        return usable_unit(unit)
    except (ValueError, TypeError, OverflowError) as error:
        raise InvalidInput(f"unit of {argument} is {unit!r}; expected a unit or its name: {error}") from error


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

    def read(numbers_or_texts: Any) -> Any:
        return Time(numbers_or_texts, format=dates[0], scale=dates[1])

    mask = np.ma.getmaskarray(np.ma.asarray(values))
    column = np.asarray(values)
    column = np.where(mask, column[int(np.argmin(mask))], column) if mask.any() else column
    try:
        refuse_coarse(column, lambda first, last: abs((read(last) - read(first)).to_value("s")), "times of the table")
        times = read(column.astype(str) if column.dtype.kind in "OT" else column)
    except InvalidInput:
        raise
    except (ValueError, TypeError, ScaleValueError) as error:
        raise InvalidInput(f"times of the table are not dates of the format and scale {dates!r}: {error}") from error
    if mask.any():
        times[mask] = np.ma.masked
    return times
