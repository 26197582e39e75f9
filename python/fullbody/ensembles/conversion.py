"""Unit conversion of maps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.units import need
from ..errors import InvalidInput

if TYPE_CHECKING:
    import xarray

__all__ = ["in_units"]


def in_units(dataset: xarray.Dataset, **units: str) -> xarray.Dataset:
    """Convert some variables of a map, or of another dataset of this package, to other units.

    Functions of numpy, such as ``np.degrees``, leave the attribute ``units`` of an xarray variable as it is: a plot of
    their result has the label of the old unit. This function changes numbers and attribute together.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset from :func:`fullbody.sweep`, ``run.to_xarray()`` or ``flight.to_xarray()``.
    **units
        New units by the names of variables or coordinates, as astropy writes them.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    InvalidInput
        For a name that the dataset does not have, for a variable without a unit, and for a text that is not a unit or a
        unit of another dimension. Maps of systems without units have none; their angles are radians, which
        ``dataset.libration.attrs["units"] = "rad"`` declares.

    Examples
    --------
    >>> import fullbody
    >>> def setup(angle):
    ...     system, state = fullbody.systems.kw4(units=True)
    ...     return system, state.rotated("Beta", [0, 0, 1], angle)
    >>> options = {"measure": "libration", "output": "0.5 hour"}
    >>> found = fullbody.sweep(setup, {"angle": ["0 deg", "10 deg"]}, "200 hour", **options)
    >>> found.libration.units, fullbody.ensembles.in_units(found, libration="deg").libration.units
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
    return dataset.assign_coords({name: item for name, item in changed.items() if name in dataset.coords}).assign(
        {name: item for name, item in changed.items() if name not in dataset.coords}
    )
