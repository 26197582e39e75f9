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
from ..base.units import UNITLESS, gathered, is_quantity, need, numbers, refuse_booleans, strip_to
from ..errors import InconsistentInput, InvalidInput, caution
from ..typing import Floats

#: The spacing of a type's numbers relative to their standard error above which they are refused.
_ROUNDED = 0.1


def column(given: Any, what: str, unit: Any = None) -> tuple[Floats, Any]:
    """Return the numbers of a column in a unit, with NaN for missing values, and the unit that it came with."""
    refuse_booleans(given, what)
    if hasattr(given, "dims") or getattr(getattr(given, "dtype", None), "kind", "") == "m":
        given = array_or_quantity(given, what)
    try:
        given, mask = _unmasked(given)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidInput(f"{what} has values that are no numbers: {error}") from error
    given = gathered(given, what)
    if is_quantity(given):
        try:
            own = usable_unit(given.unit)
        except ValueError as error:
            raise InvalidInput(f"{what} has a unit that cannot be used: {error}") from error
        found = strip_to(given, own if unit is None else unit_named(unit), what)
    else:
        found, own = numbers(given, what), None
    found = np.array(found, dtype=np.float64)
    if mask is not None:
        found[mask] = np.nan
    beyond = found[np.abs(found) > LARGEST]
    if beyond.size:
        raise InvalidInput(
            f"{what} has the value {float(beyond[0])}; expected numbers of at most {LARGEST} in size, or masked ones"
        )
    return found, own


def refuse_rounded(given: Any, values: Floats, sigma: Floats, what: str) -> None:
    """Raise an error for numbers whose given type rounds them to more than a tenth of their standard errors."""
    if (kind := _short(given)) is None:
        return
    values, sigma = np.atleast_1d(values), sigma.min(axis=-1) if sigma.ndim > values.ndim else sigma
    apart = np.abs(values) * float(np.finfo(kind).eps)
    if sigma.shape in ((), values.shape) and (bad := apart > _ROUNDED * sigma).any():
        k = int(np.argmax(bad))
        error = np.broadcast_to(sigma, apart.shape)[k]
        raise InvalidInput(
            f"{what} are numbers of the type {kind}, which near {values[k]:.6g} are {apart[k]:.2g} apart, with a "
            f"standard error of {error:.2g}; expected float64, in which the data have to be read"
        )


def _short(given: Any) -> Any:
    """Return the type of floats of less than 64 bits, or ``None`` for other values."""
    kind = getattr(given, "dtype", None)
    short = getattr(kind, "kind", "") == "f" and kind.itemsize < 8  # type: ignore[union-attr]
    return np.dtype(f"f{kind.itemsize}") if short else None  # type: ignore[union-attr]


def _unmasked(given: Any) -> tuple[Any, Any]:
    """Return values without their mask, and the mask if there is one."""
    if hasattr(given, "to_numpy"):
        # The column is one of pandas, whose missing values may have a type of their own.
        if getattr(given.dtype, "kind", "") in ("c", "M"):
            raise TypeError("they are complex or dates")
        given = given.to_numpy(dtype=np.float64, na_value=np.nan)
    if isinstance(given, np.ma.MaskedArray):
        plain = np.array(np.ma.getdata(given), dtype=np.float64)
        unit = getattr(given, "unit", None)
        return (plain if unit is None else plain * unit), np.ma.getmaskarray(given)
    if hasattr(given, "unmasked"):
        return given.unmasked, np.asarray(given.mask)
    return given, None


class Rows:
    """Which rows of a table of observations are kept, in the order of time.

    The table has ``given`` rows, of which those with the indices ``kept`` (K,) have the ``times`` (K,), and those with
    the indices ``missing`` are left out, since a value is masked or NaN.
    """

    def __init__(self, times: Any, given: dict[str, Floats], observed: Sequence[str], owner: str) -> None:
        for name in observed:
            if given[name].ndim != 1:
                # One number in place of a column is accepted for errors and correlations only.
                expected = "expected (K,), one for each of times"
                raise InvalidInput(f"{name} of {owner} has shape {given[name].shape}; {expected}")
        times = dates_of(times, f"times of {owner}")
        if are_dates(times):
            mask = np.asarray(times.mask) if getattr(times, "masked", False) else None
            plain = times.unmasked if mask is not None and hasattr(times, "unmasked") else times
            try:
                axis = np.asarray((plain - plain[0]).to_value("s") if np.ndim(plain) else 0.0, dtype=np.float64)
            except ValueError as error:
                # The library of time scales knows UTC for a limited range of years.
                raise InvalidInput(f"times of {owner} are dates that cannot be subtracted: {error}") from error
            if mask is not None:
                axis[mask] = np.nan
        else:
            refuse_coarse(times, None, f"times of {owner}")
            axis, unit = column(times, f"times of {owner}")
            plain = axis if unit is None else axis * unit
        if axis.ndim != 1 or not len(axis):
            raise InvalidInput(f"times of {owner} has shape {axis.shape}; expected (K,), one time or more")
        absent = np.isnan(axis)
        for name, values in given.items():
            if values.shape[:1] not in ((), axis.shape):
                raise InvalidInput(
                    f"{name} of {owner} has shape {values.shape}; expected {len(axis)} rows, one for each of times"
                )
            absent |= np.isnan(values).reshape(*values.shape[:1], -1).any(axis=-1)
        order = np.argsort(axis, kind="stable")
        self.kept = order[~absent[order]]
        self.missing = tuple(int(place) for place in np.flatnonzero(absent))
        if not len(self.kept):
            raise InvalidInput(f"{owner} has no row without masked or missing values; expected one or more")
        if self.missing:
            some = ", ".join(map(str, self.missing[:5])) + (", ..." if len(self.missing) > 5 else "")
            caution(
                f"{len(self.missing)} of {len(axis)} rows of {owner} have masked or missing values and are left out: "
                f"row {some}",
                InconsistentInput,
            )
        self.times = plain[self.kept]
        self.given = len(axis)
        self._owner, self._columns = owner, given

    def of(self, name: str, *shape: int) -> Floats:
        """Return the kept rows (K, C) or (K,) of a column, whose values are (), (K,) or (K, C)."""
        values, what = self._columns[name], f"{name} of {self._owner}"
        had = values.shape
        if values.ndim and len(values) == self.given:
            values = values[self.kept]
        while values.ndim and values.ndim < 1 + len(shape):
            values = values[..., None]
        try:
            return np.array(np.broadcast_to(values, (len(self.kept), *shape)), dtype=np.float64)
        except ValueError as error:
            wanted = " or ".join(str(one) for one in {(self.given,): 0, (self.given, *shape): 0})
            raise InvalidInput(f"{what} has shape {had}; expected {wanted}, or one number") from error


def labels_of(given: Any, what: str, rows: Rows, default: Any) -> tuple[Any, Any]:
    """Return the distinct labels of rows, and the index of each kept row's label among them.

    ``given`` is one label for each of the given rows. ``None``, or nothing but ``None``, stands for the ``default``
    labels of the kept ones.
    """
    if given is not None and np.shape(given) != (rows.given,):
        raise InvalidInput(f"{what} has shape {np.shape(given)}; expected ({rows.given},), one for each of times")
    values = np.ma.getdata(given) if hasattr(given, "dtype") else np.array(given, dtype=object)
    try:
        missing = np.ma.getmask(given) | np.array(values != values, dtype=bool)
    except TypeError as error:
        raise InvalidInput(f"{what} is {shown(given)}; expected a label for each of times") from error
    if np.any(missing):
        raise InvalidInput(f"{what} has no label in row {int(np.argmax(missing))}; expected one for each of times")
    absent = given is None or all(label is None for label in np.asarray(given))
    try:
        return np.unique(default if absent else np.asarray(given)[rows.kept], return_inverse=True)
    except TypeError as error:
        raise InvalidInput(f"{what} is {shown(given)}, labels of several kinds; expected one kind") from error


def positive_rows(values: Floats, what: str) -> Floats:
    """Return standard errors after checking that they are positive, and that their squares are too."""
    if not (values >= SMALLEST).all():
        least = f" and not below {SMALLEST}" if (values > 0.0).all() else ""
        raise InvalidInput(f"{what} has the value {float(values.min())}; expected standard errors above zero{least}")
    return values


def jitter_of(given: Any, unit: Any) -> float:
    """Return a jitter as a number in a unit, after checking that it is zero or above."""
    limits = Limits(least=0.0, text="a standard deviation, zero or above")
    return UNITLESS.number(column(given, "jitter", unit)[0], "number", "jitter", limits)


class DataColumn(NamedTuple):
    """A column that a class of observations reads from a table.

    The name is that of the argument, and of the column unless the user names another one; ``parts`` are the names of
    several columns that are the argument together. ``errors`` is the column of its standard errors, if they are not an
    argument that is declared by itself. Each table has the ``required`` columns; without any such column it has one of
    the others or several. Values may have a unit, numbers have none, and labels may be anything. A ``named`` column is
    read only if the user names it.
    """

    name: str
    parts: tuple[str, ...] = ()
    errors: str = ""
    required: bool = True
    kind: Literal["values", "numbers", "labels"] = "values"
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

    The ``declared`` columns are those of the class besides ``times``, and ``columns`` the names of the columns of
    arguments, one or several for each, where they differ from these. The ``unit`` of values without one is one for all
    or by the argument. ``dates`` has the format and the scale of columns that hold dates as numbers or texts, as in
    astropy's ``Time``: ``("jd", "utc")``.
    """
    found = getattr(table, "colnames", getattr(table, "columns", None))
    if found is None:
        raise InvalidInput(f"table of {owner} is {table!r}; expected a table of astropy or pandas")
    names = list(found)
    has = [c for c in declared if c.required or c.name in columns or (c.name in names and not c.named)]
    if not has:
        either = " or ".join(repr(c.name) for c in declared)
        raise InvalidInput(f"the table has no column {either} of {owner}; it has {names}")
    if isinstance(unit, Mapping):
        known = [name for c in declared if c.kind == "values" for name in (c.name, c.errors) if name]
        refuse_unknown(map(str, unit), known, f"unit of {owner}")
    wanted: dict[str, Any] = {"times": "times"} | {c.name: c.parts or c.name for c in has}
    wanted |= {c.errors: c.errors for c in has if c.errors} | dict(columns)
    kinds, arguments = {c.name: c.kind for c in declared}, {}
    for argument, named in wanted.items():
        kind, what, parts = kinds.get(argument, "values"), f"{argument} of {owner}", []
        for name in (named,) if isinstance(named, str) else named:
            if name not in names:
                raise InvalidInput(f"the table has no column {name!r} for {what}; it has {names}")
            parts.append(table[name])
        if argument == "times":
            arguments[argument] = _dates(parts[0], dates, getattr(table, "attrs", {}))
        elif kind == "labels":
            arguments[argument] = np.asanyarray(parts[0])
        else:
            own = unit.get(argument) if isinstance(unit, Mapping) else unit
            own = _unit_of(own, argument) if kind == "values" else None
            pairs = [column(part, what) for part in parts]
            units = [had if had is not None else own for _, had in pairs]
            # Numbers keep a short type, which may be too coarse for their errors.
            short = [values.astype(_short(part) or float) for (values, _), part in zip(pairs, parts, strict=True)]
            scaled = [values if one is None else values * one for values, one in zip(short, units, strict=True)]
            try:
                arguments[argument] = scaled[0] if isinstance(named, str) else np.stack(scaled, axis=-1)
            except (ValueError, TypeError) as error:
                raise InvalidInput(f"the columns of {what} do not go together: {error}") from error
    return arguments


def _unit_of(given: Any, argument: str) -> Any:
    """Return a unit, which may be given as text."""
    if given is None:
        return None
    try:
        return usable_unit(given)
    except (ValueError, TypeError, OverflowError) as error:
        raise InvalidInput(f"unit of {argument} is {given!r}; expected a unit or its name: {error}") from error


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

    def read(given: Any) -> Any:
        return Time(given, format=dates[0], scale=dates[1])

    column = np.asarray(values)
    try:
        refuse_coarse(column, lambda one, other: abs((read(other) - read(one)).to_value("s")), "times of the table")
        return read(column.astype(str) if column.dtype.kind in "OT" else column)
    except InvalidInput:
        raise
    except (ValueError, TypeError, ScaleValueError) as error:
        raise InvalidInput(f"times of the table are not dates of the format and scale {dates!r}: {error}") from error
