"""Runs as NetCDF files, as archives of numpy, and as tables of other libraries."""

from __future__ import annotations

import json
from functools import partial
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.atomic import as_path, check_suffix, replacing
from ..base.kinds import whole_number
from ..base.units import Units, need
from ..base.version import version
from ..errors import InvalidInput
from ..model.context import Context
from ..record.columns import tangent_labels
from ..record.record import STOP_REASONS, Record, Statistics
from . import checksum, npz, occurrences
from .reading import Content, check_order, check_unit, netcdf

if TYPE_CHECKING:
    import pandas
    import xarray

#: Variables: further dimensions after time, dimension of the unit, meaning.
_VARIABLES: dict[str, tuple[tuple[str, ...], str | None, str]] = {
    **occurrences.STATES,
    "energy": (("part",), "energy", "energies"),
    "angular_momentum": (("axis",), "angular momentum", "total angular momentum about the origin, inertial"),
}
#: Variables of runs with external forces, derivatives, whose components have various units, and indicators of chaos.
_OPTIONAL: dict[str, tuple[tuple[str, ...], str | None, str]] = {
    "work": (("force",), "energy", "work of each external force since the start of the run"),
    "impulse": (("force", "axis"), "momentum", "impulse of each external force since the start of the run, inertial"),
    "angular_impulse": (
        ("force", "axis"),
        "angular momentum",
        "angular impulse of each external force since the start of the run, about the origin, inertial",
    ),
    "transition": (("tangent", "start_tangent"), None, "transition matrices from the start of the run"),
    "sensitivity": (("parameter", "tangent"), None, "derivatives by parameters of the system"),
    "chaos": (
        ("indicator",),
        None,
        "mean of MEGNO, Lyapunov exponent, fast Lyapunov indicator, since the start of the run",
    ),
}
_COORDINATES = {
    "axis": ["x", "y", "z"],
    "quaternion": ["w", "x", "y", "z"],
    "part": ["total", "translational", "rotational", "potential"],
}
#: Labels of the dimension ``indicator``, in runs with ``chaos=True``.
_INDICATORS = ["megno", "lyapunov", "fast_lyapunov"]
#: Conserved quantities at the start: indices in the eight numbers (see ``fullbody.record.conserved``), dimensions,
#: dimension of the unit.
_START: dict[str, tuple[Any, tuple[str, ...], str]] = {
    "start_time": (0, (), "time"),
    "start_energy": (slice(1, 5), ("part",), "energy"),
    "start_angular_momentum": (slice(5, 8), ("axis",), "angular momentum"),
}
#: The largest count in a file.
_MOST = 2**63 - 1
#: The attribute that marks a file as a run, and the number of the format, the only one that is read.
FORMAT = ("fullbody_format", 2)
#: Suffixes of the names of NetCDF files, and of all files in which a run can be saved.
SUFFIXES = (".nc", ".nc4")
RUN_SUFFIXES = (*SUFFIXES, npz.SUFFIX)


def described(units: Units, dimension: str | None, text: str) -> dict[str, str]:
    """Return the attributes of a variable by the dimension of its unit, if it has one, and its meaning."""
    return {"long_name": text} | ({"units": str(units.unit(dimension))} if dimension and units.defined else {})


def to_xarray(run: Record) -> xarray.Dataset:
    """Convert the run to an ``xarray.Dataset``, with units, the system and the integrator in its attributes.

    Returns
    -------
    xarray.Dataset
        A dataset with the samples along the dimension ``time``. Events that happened have the dimension ``event``,
        labelled with their kinds, and variables ``event_time``, ``event_position`` and so on;
        ``.attrs["fullbody_events"]`` lists the requested events as JSON, and ``event_index`` is the index in that list.
        ``start_time``, ``start_energy`` and ``start_angular_momentum`` are those of ``run.start``. External forces have
        the dimension ``force``, labelled with their names, and variables ``work``, ``impulse`` and ``angular_impulse``;
        ``.attrs["fullbody_switched_off"]`` is ``run.switched_off`` as JSON.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> run = system.integrate(state, 100.0, output=50.0, events=[fullbody.events.Apoapsis(0, 1)])
    >>> run.to_xarray().event_time.round(3).values.tolist()
    [48.719, 92.867]
    """
    with need("data", "a run as a dataset"):
        import xarray as xr

    return xr.Dataset(*_content(run))


def _content(run: Record) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Return variables and coordinates, each as (dimensions, values, attributes), and attributes of the whole."""
    units, attributes = run.context.units, partial(described, run.context.units)
    forces = list(run.context.forces)
    optional = {name: entry for name, entry in _OPTIONAL.items() if forces or "force" not in entry[0]}
    variables = {
        name: (("time", *dims), run.arrays[name], attributes(dimension, text))
        for name, (dims, dimension, text) in (_VARIABLES | optional).items()
        if name in run.arrays
    }
    for name, (numbers, dims, dimension) in _START.items():
        text = f"{dimension} at the start of the run"
        variables[name] = (dims, run.invariants[numbers], attributes(dimension, text))
    coordinates: dict[str, Any] = {name: (name, labels) for name, labels in _COORDINATES.items()}
    coordinates["body"] = ("body", list(run.context.names))
    coordinates["time"] = ("time", run.arrays["time"], attributes("time", "time"))
    if forces:
        coordinates["force"] = ("force", forces, {"long_name": "external forces"})
    if "transition" in run.arrays:
        numbers = tangent_labels(run.context.names)
        coordinates |= {name: (name, numbers) for name in ("tangent", "start_tangent")}
        if run.parameters:
            coordinates["parameter"] = ("parameter", list(run.parameters))
    if "chaos" in run.arrays:
        coordinates["indicator"] = ("indicator", _INDICATORS)
    of_events, labels, watched = occurrences.to_dataset(run, attributes)
    s = run.statistics
    return (
        variables | of_events,
        coordinates | labels,
        {
            "title": "fullbody run",
            "fullbody_version": version(),
            FORMAT[0]: FORMAT[1],
            "fullbody_system": json.dumps(run.context.describe()),
            "fullbody_integrator": json.dumps(run.integrator._describe(units)),
            "fullbody_statistics": json.dumps([s.steps, s.rejected, s.evaluations]),
            "fullbody_events": watched,
            "stop_reason": run.stop_reason,
            "references": "Ho, Wold, Conway & Poursina (2021), Celest. Mech. Dyn. Astron. 133, 35",
        }
        | ({"fullbody_switched_off": json.dumps(run.switched_off)} if forces else {})
        | ({"fullbody_parameters": json.dumps(run.parameters)} if "transition" in run.arrays else {}),
    )


def to_pandas(run: Record) -> pandas.DataFrame:
    """Convert the run to a ``pandas.DataFrame`` with a row per sample and a column per number.

    The columns are (quantity, body, component) and the index is the time; ``.attrs["units"]`` names the units if the
    system has them.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> frame = system.integrate(state, 10.0, output=5.0).to_pandas()
    >>> frame["position", "A", "x"].round(3).to_list()
    [-4.0, -3.607, -2.444]
    """
    with need("data", "a run as a table"):
        import pandas as pd

    units = run.context.units
    columns, values, named = [], [], {}
    for name, (dims, dimension, _) in _VARIABLES.items():
        rows = run.arrays[name]
        values.append(rows.reshape(len(rows), int(np.prod(rows.shape[1:]))))
        bodies = run.context.names if "body" in dims else ("",)
        columns += [(name, body, part) for body in bodies for part in _COORDINATES[dims[-1]]]
        if dimension and units.defined:
            named[name] = str(units.unit(dimension))
    if units.defined:
        named["time"] = str(units.unit("time"))
    frame = pd.DataFrame(
        np.concatenate(values, axis=1),
        index=pd.Index(run.arrays["time"], name="time"),
        columns=pd.MultiIndex.from_tuples(columns, names=["quantity", "body", "component"]),
    )
    # The rows are sorted, since pandas otherwise warns of slow look-ups.
    frame = frame.sort_index(axis=1)
    frame.attrs["units"] = named
    return frame


def save(run: Record, path: Any) -> None:
    """Write the run to a file, exactly and atomically; :func:`fullbody.load` reads it.

    The file is NetCDF-4, or an archive of numpy with the same arrays and attributes, which needs no other package.

    A file keeps the samples, the start, the system, the integrator, the statistics, the events and the stop reason. It
    keeps neither the continuous solution of ``dense=True`` nor the functions of :class:`fullbody.events.Function` and
    :class:`fullbody.forces.Function`, but their names: events stay with times and states, and the integration of a
    system with such a force raises an error that names it.

    A NetCDF file ends with a checksum of its content, after the part that NetCDF reads, which :func:`fullbody.load`
    checks. Other programs ignore it and remove it when they write to the file; :func:`fullbody.load` then warns.

    The file is on the disk before it replaces another one. If the path is a symbolic link, the file that it points to
    is replaced, and other hard links to that file keep the old content. The permissions of a replaced file are kept; a
    new file has the permissions that the umask leaves.

    Parameters
    ----------
    path : str or Path
        A name that ends in ``.nc`` or ``.nc4``, or in ``.npz`` for an archive of numpy; others are refused.

    Raises
    ------
    OSError
        If the file cannot be written, for lack of space or permission, or because the path is a write-protected file, a
        folder or a device; the error has the path.
    """
    check_suffix(path, RUN_SUFFIXES)
    if as_path(path).suffix.lower() == npz.SUFFIX:
        variables, coordinates, attributes = _content(run)
        with replacing(path) as temporary:
            npz.write(variables | coordinates, attributes, temporary)
        return
    netcdf()
    write(to_xarray(run), path)


def write(dataset: xarray.Dataset, path: Any) -> None:
    """Write a NetCDF-4 file with its checksum, made in memory: on a full disk HDF5 would end the whole process."""
    from xarray.backends import H5NetCDFStore
    from xarray.backends.locks import HDF5_LOCK

    with replacing(path) as temporary:
        buffer = BytesIO()
        # Otherwise xarray would ask a client of dask for a lock, which cannot refer to a file in memory.
        store = H5NetCDFStore.open(buffer, mode="w", lock=HDF5_LOCK)
        try:
            dataset.dump_to_store(store)
        finally:
            store.close()
        buffer.write(checksum.line(buffer, buffer.seek(0, 2)))
        temporary.write_bytes(buffer.getbuffer())


def contents(content: Content, context: Context) -> dict[str, Any]:
    """Return the arguments of ``Run``, except its system and integrator, by name."""
    lengths = {name: len(labels) for name, labels in _COORDINATES.items()}
    start = [content.numbers(name, {dim: lengths[dim] for dim in dims}) for name, (_, dims, _) in _START.items()]
    time = content.numbers("time", {"time": None})
    sizes: dict[str, int | None] = {**lengths, "body": len(context), "time": len(time)}
    switched_off: dict[str, int] = {}
    parameters: tuple[str, ...] = ()
    if context.forces:
        sizes["force"] = len(context.forces)
        switched_off = content.parsed("fullbody_switched_off", lambda counts: _switched_off(counts, context))
    if content.has_attribute("fullbody_parameters"):
        parameters = content.parsed("fullbody_parameters", _names)
        sizes |= dict.fromkeys(("tangent", "start_tangent"), 12 * len(context))
        sizes |= {"parameter": len(parameters)} if parameters else {}
    if "chaos" in content:
        sizes["indicator"] = len(_INDICATORS)
    # A file has the variables whose dimensions it has.
    dims_of = {name: dims for name, (dims, _, _) in (_VARIABLES | _OPTIONAL).items() if sizes.keys() >= set(dims)}
    arrays = {
        name: content.numbers(name, {dim: sizes[dim] for dim in ("time", *dims)}) for name, dims in dims_of.items()
    }
    check_order(time, "time", repeated=False)
    check_unit(arrays["attitude"], "attitude")
    reason = content.text("stop_reason")
    if reason not in STOP_REASONS:
        raise InvalidInput(f"attribute stop_reason is {reason!r}; expected one of {', '.join(STOP_REASONS)}")
    return {
        "arrays": {"time": time, **arrays},
        "start": np.concatenate([values.reshape(-1) for values in start]),
        "statistics": content.parsed("fullbody_statistics", _statistics),
        "events": occurrences.from_file(content, context, len(parameters)),
        "stop_reason": reason,
        "switched_off": switched_off,
        "parameters": parameters,
    }


def _statistics(counts: list[Any]) -> Statistics:
    if len(counts) != 3:
        raise InvalidInput(f"{counts!r} is not a list of three counts")
    return Statistics(*(whole_number(count, "one of the three counts", 0, _MOST) for count in counts))


def _names(names: list[Any]) -> tuple[str, ...]:
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InvalidInput(f"{names!r} is not a list of names")
    return tuple(names)


def _switched_off(counts: dict[str, Any], context: Context) -> dict[str, int]:
    for name, count in counts.items():
        if name not in context.forces:
            raise InvalidInput(f"{name!r} is not a force of the system")
        whole_number(count, f"the count of {name}", 0, _MOST)
    return counts
