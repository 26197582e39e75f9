"""Saving and loading of fits as NetCDF files, through xarray."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

import fullbody._core as _core

from ..base.atomic import check_suffix
from ..base.unit_names import unit_named
from ..base.units import without_unit
from ..base.version import version
from ..files.netcdf import SUFFIXES, write
from ..files.reading import Content, netcdf
from ..model.state import PARTS, strip, wrap
from ..motion.system import System, system_of
from ..record.integrators import rebuild
from .free import ARRAYS, Free, Parameters

#: The attribute that marks a file as a fit, and the number of the format, the only one that is read.
FORMAT = ("fullbody_fit", 2)
#: The attributes of a fit that JSON can hold.
_JSON_ATTRIBUTES = (
    *("chi2", "loss", "dof", "p_value", "condition", "weakest", "unconstrained", "differenced", "at_bounds", "starts"),
    *("differenced_observations", "message", "iterations", "runs", "refused", "last_refusal", "labels", "_of_setup"),
)


def description(fit: Any) -> dict[str, Any]:
    """Return the part of a fit that JSON can hold: everything but its arrays."""
    parameters, context = fit.parameters, fit.system.context
    core, names_and_units = strip(fit.state, context), zip(fit.described.names, fit.described.units, strict=True)
    columns = zip(*(getattr(parameters, array) for array in ARRAYS), strict=True)
    units = [(name, None if unit is None else str(unit)) for name, unit in names_and_units]
    return {
        **{name: getattr(fit, name) for name in _JSON_ATTRIBUTES},
        "parameters": {name: list(map(float, row)) for name, row in zip(parameters.names, columns, strict=True)},
        "shapes_of_parameters": [(name, parameters.shapes[name]) for name in parameters.arguments],
        "units": [unit for _, unit in units[: len(parameters)]],
        "unknowns": units[len(parameters) :],
        "minima": [
            (*parameters.numbers(item.values).tolist(), item.loss, item.chi2, item.starts, item.message)
            for item in fit.minima
        ],
        "state": [core.time, *(getattr(core, name).tolist() for name in PARTS)],
        "integrator": fit.integrator and fit.integrator._describe(context.units),
        "shapes": [(len(times), *np.shape(pulls)) for times, pulls in zip(fit.times, fit.pulls, strict=True)],
    }


def save(fit: Any, path: Any) -> None:
    """Write the fit to a NetCDF file; :func:`fullbody.load` reads it.

    A file keeps values, errors, pulls with their times, minima, the system, the state and the integrator. It keeps
    neither the setup nor the observations, so that a fit from a file has no residuals and no posterior density.

    Parameters
    ----------
    path : str or Path
        A name that ends in ``.nc`` or ``.nc4``.
    """
    check_suffix(path, SUFFIXES)
    units = fit.system.context.units
    times = [units.strip(times, "time", "times") for times in fit.times]
    infinite = np.isinf(fit.covariance)
    variables = {
        "value": ("parameter", fit.numbers),
        "covariance": (("parameter", "other_parameter"), np.where(infinite, np.nan, fit.covariance)),
        "pulls": ("row", np.concatenate([np.ravel(pulls) for pulls in fit.pulls])),
        "times": ("sample", np.concatenate(times)),
    }
    names = {name: (name, list(fit.names)) for name in ("parameter", "other_parameter")}
    attributes = {"title": "fullbody fit", "fullbody_version": version(), FORMAT[0]: FORMAT[1]}
    attributes |= {"fullbody_system": json.dumps(fit.system.context.describe())}
    attributes |= {"fullbody_results": json.dumps(description(fit))}
    write(netcdf().Dataset(variables, names, attributes), path)


def contents(content: Content) -> dict[str, Any]:
    """Return the attributes of the fit in a file, by name."""
    content.check_format(*FORMAT)
    system = content.parsed("fullbody_system", system_of)
    attributes: dict[str, Any] = content.parsed("fullbody_results", lambda results: _attributes(results, system))
    shapes = attributes.pop("shapes")
    count, samples = len(attributes["names"]), [shape[0] for shape in shapes]
    sizes = [int(np.prod(shape[1:])) for shape in shapes]
    square: dict[str, int | None] = {"parameter": count, "other_parameter": count}
    covariance = content.numbers("covariance", square, missing=True)
    pulls = np.split(content.numbers("pulls", {"row": sum(sizes)}), np.cumsum(sizes)[:-1])
    times = np.split(content.numbers("times", {"sample": sum(samples)}), np.cumsum(samples)[:-1])
    return attributes | {
        "system": system,
        "numbers": content.numbers("value", {"parameter": count}),
        "covariance": np.where(np.isnan(covariance), np.inf, covariance),
        "pulls": [part.reshape(shape[1:]) for part, shape in zip(pulls, shapes, strict=True)],
        "times": [system.context.units.attach(part, "time") for part in times],
    }


def _attributes(results: dict[str, Any], system: System) -> dict[str, Any]:
    """Return the attributes of a fit that :func:`description` wrote, by name."""
    # Files of earlier versions have neither arrays nor differenced observations.
    missing = {"shapes_of_parameters": [(name, ()) for name in results["parameters"]], "differenced_observations": {}}
    results = {**missing, **results}
    units = [None if unit is None else unit_named(unit) for unit in results["units"]]
    free, first, rows = {}, 0, np.array(list(results["parameters"].values()), dtype=np.float64)
    for name, shape in results["shapes_of_parameters"]:
        count = int(np.prod(shape))
        part, unit = rows[first : first + count].T.reshape(-1, *shape), units[first]
        first += count
        start, lower, upper, mean, sigma = part if unit is None else part * unit
        prior = None if _limit(sigma) is None else (mean, sigma)
        free[name] = Free(start, min=_limit(lower), max=_limit(upper), prior=prior)
    parameters, context = Parameters(free), system.context
    unknowns = tuple((name, None if unit is None else unit_named(unit)) for name, unit in results["unknowns"])
    time, *arrays = results["state"]
    core = _core.State(time, *(np.array(values, dtype=np.float64) for values in arrays))
    count = len(parameters)
    minima = [(parameters.named(np.array(row[:count])), *row[count:]) for row in results["minima"]]
    return {
        **{name: results[name] for name in _JSON_ATTRIBUTES},
        "parameters": parameters,
        "names": (*parameters.names, *(name for name, _ in unknowns)),
        "_unknowns": unknowns,
        "linear": [],
        **{name: tuple(results[name]) for name in ("at_bounds", "labels", "_of_setup")},
        "minima": minima,
        "state": wrap(core, context),
        "integrator": results["integrator"] and rebuild(results["integrator"]),
        "shapes": [list(map(int, shape)) for shape in results["shapes"]],
        "observations": [],
        "residuals": [],
        "_objective": None,
    }


def _limit(numbers: Any) -> Any:
    """Return bounds or errors, ``None`` where none is finite."""
    return numbers if np.isfinite(without_unit(numbers)).any() else None
