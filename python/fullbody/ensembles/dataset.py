"""The rows of a sweep as one dataset over its parameters, and unit conversion of datasets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.units import need
from ..errors import InvalidInput
from .parameters import ParameterColumn, ParameterTable
from .work import Failure, MeasuredValue, Outcome

if TYPE_CHECKING:
    import xarray

#: Variables that describe the error of a row, with their meanings.
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

    results = sorted(outcomes, key=attrgetter("row"))
    failures = [_UNDONE] * len(table)
    #: The use of each name, that of a parameter, variable or dimension.
    uses = dict.fromkeys((*table.columns, *table.dimensions, *FAILURE), "a parameter or kept for errors")
    variables: dict[str, _Variable] = {}
    models = _models(results)
    for outcome in results:
        failure = outcome.failure
        for name, measured in outcome.values.items():
            try:
                if name not in variables:
                    variable = _Variable(name, *models[name], len(table))
                    if taken := [label for label in (name, *variable.inner) if label in uses]:
                        raise InvalidInput(f"measure gives {name}, but {taken[0]} is the name of {uses[taken[0]]}")
                    uses |= dict.fromkeys((name, *variable.inner), f"a dimension of {name}")
                    variables[name] = variable
                variables[name].put(outcome.row, measured)
            except InvalidInput as error:
                failure = Failure.of(error, "measure").combined(failure)
        failures[outcome.row] = failure or Failure("", "", "")
    dims = tuple(table.dimensions)
    fields: dict[str, Any] = {}
    for name, variable in variables.items():
        shape = (*table.shape, *variable.values.shape[1:])
        values = variable.values.astype(str) if variable.values.dtype == object else variable.values
        fields[name] = ((*dims, *variable.inner), values.reshape(shape), variable.attributes)
    for name, parts in zip(FAILURE, zip(*failures, strict=True), strict=True):
        fields[name] = (dims, np.array(parts, dtype=str).reshape(table.shape), {"long_name": FAILURE[name]})
    coordinates: dict[str, Any] = {}
    for name, column in table.coordinates.items():
        units = {} if column.unit is None else {"units": str(column.unit)}
        coordinates[name] = (column.dimensions + column.inner, column.values, units)
    return xr.Dataset(fields, coordinates, dict(attributes))


def table_of(dataset: xarray.Dataset) -> ParameterTable:
    """Return the rows of the sweep that a map was made of, with all coordinates as columns."""
    columns, outer = {}, tuple(map(str, dataset.error.dims))
    for name, item in dataset.coords.items():
        dims = tuple(map(str, item.dims))
        inner = tuple(dimension for dimension in dims if dimension not in outer)
        outer_dims = dims[: len(dims) - len(inner)]
        columns[str(name)] = ParameterColumn(item.values, outer_dims, item.attrs.get("units"), inner)
    return ParameterTable({str(name): size for name, size in dataset.error.sizes.items()}, columns)


def _models(outcomes: Iterable[Outcome]) -> dict[str, tuple[MeasuredValue, int]]:
    """Return the model of each variable and its row: a value with a unit, or else one that is not missing."""
    results: dict[str, tuple[MeasuredValue, int]] = {}
    for outcome in outcomes:
        for name, measured in outcome.values.items():
            model = results.get(name, (None, 0))[0]
            if model is None or (model.missing and not measured.missing) or (model.unit is None and measured.unit):
                results[name] = (measured, outcome.row)
    return results


class _Variable:
    """One measured quantity of all rows, with the kind, shape and unit of a model, which is the value in some row."""

    def __init__(self, name: str, model: MeasuredValue, row: int, rows: int) -> None:
        self._name, self._model, self._row = name, model, row
        if isinstance(model.value, str):
            self.values: Any = np.full(rows, "", dtype=object)
        else:
            self.values = np.full((rows, *model.value.shape), np.nan)
        #: Names of the dimensions within each row.
        self.inner = tuple(f"{name}_{axis}" for axis in range(self.values.ndim - 1))
        self.attributes = {} if model.unit is None else {"units": model.unit}

    def put(self, row: int, measured: MeasuredValue) -> None:
        """Store the values of a row, or raise an error if they do not match those of the model."""
        value, model = measured.value, self._model.value
        if measured.missing:
            return
        if isinstance(value, str) or isinstance(model, str):
            if type(value) is not type(model):
                raise InvalidInput(self._difference("a text" if isinstance(value, str) else "numbers", "the other"))
            self.values[row] = value
            return
        if value.shape != model.shape:
            text = self._difference(f"of shape {value.shape}", f"of shape {model.shape}")
            raise InvalidInput(f"{text}; expected one shape throughout, filled up with nan")
        unit, model_unit = measured.unit, self._model.unit
        if unit != model_unit:
            from astropy import units as u

            if unit is None or model_unit is None:
                raise InvalidInput(self._difference(f"with the unit {unit}", f"with {model_unit}"))
            try:
                value = u.Quantity(value, unit).to_value(model_unit)
            except u.UnitConversionError as error:
                raise InvalidInput(self._difference(f"in {unit}", f"in {model_unit}")) from error
        self.values[row] = value

    def _difference(self, description: str, of_model: str) -> str:
        return f"measure gives {self._name} {description}, but {of_model} in row {self._row}"


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
            names = ", ".join(map(str, dataset.variables))
            raise InvalidInput(f"the dataset has no {name!r}; expected some of {names}")
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
