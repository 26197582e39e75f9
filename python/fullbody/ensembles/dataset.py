"""The rows of a sweep as one dataset over its parameters, and unit conversion of datasets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.units import need
from ..errors import InvalidInput
from .parameters import ParameterColumn, ParameterTable
from .work import Failure, MeasuredValue, Outcome, ordered

if TYPE_CHECKING:
    import xarray

#: Variables that describe what went wrong in a row, with their meanings.
FAILURE = {
    "error": "the kind of error that a row ended with; empty for none",
    "error_text": "what the error says",
    "error_stage": "whether the error came in setup, run or measure",
}
_UNDONE = Failure("NotComputed", "the sweep ended before this row", "setup")


def dataset(table: ParameterTable, outcomes: Iterable[Outcome], attributes: Mapping[str, Any]) -> xarray.Dataset:
    """Make a dataset of the outcomes so far; missing rows have an error that says so."""
    with need("data", "a sweep"):
        import xarray as xr

    results = ordered(outcomes)
    failures = [_UNDONE] * len(table)
    #: What has each name of a parameter, variable or dimension.
    owners = dict.fromkeys((*table.columns, *table.dimensions, *FAILURE), "a parameter or kept for errors")
    variables: dict[str, _Variable] = {}
    models = _models(results)
    for outcome in results:
        failure = outcome.failure
        for name, measured in outcome.values.items():
            try:
                if name not in variables:
                    variable = _Variable(name, *models[name], len(table))
                    if taken := [label for label in (name, *variable.inner) if label in owners]:
                        raise InvalidInput(f"measure gives {name}, but {taken[0]} is the name of {owners[taken[0]]}")
                    owners |= dict.fromkeys((name, *variable.inner), f"a dimension of {name}")
                    variables[name] = variable
                variables[name].put(outcome.row, measured)
            except InvalidInput as error:
                failure = Failure.of(error, "measure").after(failure)
        failures[outcome.row] = failure or Failure("", "", "")
    dims = tuple(table.dimensions)
    fields: dict[str, Any] = {}
    for name, variable in variables.items():
        shape = (*table.shape, *variable.values.shape[1:])
        values = variable.values.astype(str) if variable.values.dtype == object else variable.values
        fields[name] = ((*dims, *variable.inner), values.reshape(shape), variable.attributes)
    for name, parts in zip(FAILURE, zip(*failures, strict=True), strict=True):
        fields[name] = (dims, np.array(parts, dtype=str).reshape(table.shape), {"long_name": FAILURE[name]})
    coordinates = {
        name: (
            column.dimensions + column.inner,
            column.values,
            {} if column.unit is None else {"units": str(column.unit)},
        )
        for name, column in table.coordinates.items()
    }
    return xr.Dataset(fields, coordinates, dict(attributes))


def table_of(dataset: xarray.Dataset) -> ParameterTable:
    """Return the rows of the sweep that a map was made of, with all coordinates as columns."""
    columns, outer = {}, tuple(map(str, dataset.error.dims))
    for name, item in dataset.coords.items():
        along = tuple(map(str, item.dims))
        inner = tuple(dimension for dimension in along if dimension not in outer)
        columns[str(name)] = ParameterColumn(
            item.values, along[: len(along) - len(inner)], item.attrs.get("units"), inner
        )
    return ParameterTable({str(name): size for name, size in dataset.error.sizes.items()}, columns)


def _models(outcomes: Iterable[Outcome]) -> dict[str, tuple[MeasuredValue, int]]:
    """Return for each variable the value that sets its kind and unit, and its row: with a unit, or else not missing."""
    results: dict[str, tuple[MeasuredValue, int]] = {}
    for outcome in outcomes:
        for name, measured in outcome.values.items():
            model = results.get(name, (None, 0))[0]
            if model is None or (model.missing and not measured.missing) or (model.unit is None and measured.unit):
                results[name] = (measured, outcome.row)
    return results


class _Variable:
    """One measured quantity of all rows, with the kind, shape and unit of a model, which is the value in some row."""

    def __init__(self, name: str, first: MeasuredValue, row: int, rows: int) -> None:
        self._name, self._first, self._row = name, first, row
        if isinstance(first.value, str):
            self.values: Any = np.full(rows, "", dtype=object)
        else:
            self.values = np.full((rows, *first.value.shape), np.nan)
        #: Names of the dimensions within each row.
        self.inner = tuple(f"{name}_{axis}" for axis in range(self.values.ndim - 1))
        self.attributes = {} if first.unit is None else {"units": first.unit}

    def put(self, row: int, measured: MeasuredValue) -> None:
        """Store the values of a row, or raise an error if they do not match those of the model."""
        value, first = measured.value, self._first.value
        if measured.missing:
            return
        if isinstance(value, str) or isinstance(first, str):
            if type(value) is not type(first):
                raise InvalidInput(self._unlike("a text" if isinstance(value, str) else "numbers", "the other"))
            self.values[row] = value
            return
        if value.shape != first.shape:
            text = self._unlike(f"of shape {value.shape}", f"of shape {first.shape}")
            raise InvalidInput(f"{text}; expected one shape throughout, filled up with nan")
        unit, wanted = measured.unit, self._first.unit
        if unit != wanted:
            from astropy import units as u

            if unit is None or wanted is None:
                raise InvalidInput(self._unlike(f"with the unit {unit}", f"with {wanted}"))
            try:
                value = u.Quantity(value, unit).to_value(wanted)
            except u.UnitConversionError as error:
                raise InvalidInput(self._unlike(f"in {unit}", f"in {wanted}")) from error
        self.values[row] = value

    def _unlike(self, here: str, there: str) -> str:
        return f"measure gives {self._name} {here}, but {there} in row {self._row}"


def in_units(dataset: xarray.Dataset, /, **units: str) -> xarray.Dataset:
    """Convert some variables of a map, or of another dataset of this package, to other units.

    Functions of numpy, such as ``np.degrees``, leave the attribute ``units`` of an xarray variable as it is: a plot of
    their result has the label of the old unit. This function changes numbers and attribute together.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset from :func:`fullbody.sweep`, ``run.to_xarray()`` or ``flight.to_xarray()``.
    **units
        New units by the names of variables or coordinates, as astropy writes them.

    Raises
    ------
    InvalidInput
        For a variable without a unit. Maps of systems without units have none; their angles are radians, which
        ``dataset.libration.attrs["units"] = "rad"`` declares.

    Examples
    --------
    >>> import fullbody
    >>> def setup(angle):
    ...     system, state = fullbody.systems.kw4(units=True)
    ...     return system, state.rotated("Beta", [0, 0, 1], angle)
    >>> options = {"measure": "libration", "output": "0.5 hour"}
    >>> dataset = fullbody.sweep(setup, {"angle": ["0 deg", "10 deg"]}, "200 hour", **options)
    >>> dataset.libration.units, fullbody.ensembles.in_units(dataset, libration="deg").libration.units
    ('rad', 'deg')
    """
    with need("units", "a change of units"):
        from astropy import units as u

    changed = {}
    for name, unit in units.items():
        if name not in dataset.variables:
            raise InvalidInput(
                f"the dataset has no {name!r}; expected some of {', '.join(map(str, dataset.variables))}"
            )
        old = dataset[name].attrs.get("units")
        if old is None:
            raise InvalidInput(
                f"{name} has no unit; expected one in its attributes, such as .{name}.attrs['units'] = 'rad' for the "
                "angles of a system without units"
            )
        try:
            new = u.Unit(unit)
            values = u.Quantity(dataset[name].values, old).to_value(new)
        except (u.UnitsError, ValueError, TypeError) as error:
            raise InvalidInput(f"{name} cannot be converted to {unit!r}: {error}") from error
        changed[name] = (dataset[name].dims, values, {**dataset[name].attrs, "units": str(new)})
    coordinates = {name: changed.pop(name) for name in [*changed] if name in dataset.coords}
    return dataset.assign_coords(coordinates).assign(changed)
