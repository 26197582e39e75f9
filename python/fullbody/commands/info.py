"""``fullbody info file``: describe a recorded run, a flight, a map or a ``system.toml``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import tables
from ..ensembles.dataset import FAILURE
from ..ensembles.store import ATTRIBUTE
from ..errors import FullbodyError
from ..files import npz
from ..files.reading import netcdf
from ..loading import load, load_flight
from ..motion.run import Run
from ..setups.toml import read_toml

if TYPE_CHECKING:
    import xarray


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "info",
        help="what a recorded run, a flight, a map or a system.toml contains",
        description="Print what a recorded run, a flight of particles, a map of a sweep (NetCDF) or a system.toml "
        "contains. A file that cannot be read is reported, and the others are printed.",
    )
    parser.add_argument("files", nargs="+", metavar="file", type=Path)
    parser.add_argument("--json", action="store_true", help="print one JSON object with the tables of each file")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    failed = 0
    contents: dict[str, list[tables.Table]] = {}
    for path in arguments.files:
        try:
            described = toml_tables(path) if path.suffix.lower() == ".toml" else recorded_tables(path)
        except (FullbodyError, ImportError, OSError) as error:
            # Both streams may go to the same place, where the order of the lines must be kept.
            sys.stdout.flush()
            print(f"fullbody: {error}", file=sys.stderr)
            failed += 1
            continue
        if not arguments.json:
            print(f"\n{path}" if contents else path)
            print(tables.to_text(*described))
        contents[str(path)] = described
    if arguments.json:
        objects = {path: {table.caption: as_json(table) for table in found} for path, found in contents.items()}
        print(json.dumps(objects))
    return 1 if failed else 0


def as_json(table: tables.Table) -> Any:
    """Return a table for JSON: a list of a dict for each row, or without a header one dict of all rows."""
    if not table.header:
        return {row[0]: row[1] if len(row) == 2 else list(row[1:]) for row in table.rows}
    return [dict(zip(table.header, row, strict=True)) for row in table.rows]


def recorded_tables(path: Path) -> list[tables.Table]:
    """Describe the content of a file that this package wrote."""
    if path.suffix.lower() == npz.SUFFIX:
        return run_tables(path)
    attributes: dict[str, Any] = {}
    # A file that cannot be opened here is loaded as a run, which raises the error to report.
    with suppress(Exception), netcdf().open_dataset(path, engine="h5netcdf") as file:
        attributes = dict(file.attrs)
        if ATTRIBUTE in attributes:
            return map_tables(file)
    if "fullbody_flight" in attributes:
        return tables.tables_of(load_flight(path))
    return run_tables(path)


def map_tables(dataset: xarray.Dataset) -> list[tables.Table]:
    """Describe the content of a sweep's map."""
    dimensions = [tables.Table("Map", (), [(name, f"{size} values") for name, size in dataset.error.sizes.items()])]
    rows: list[Sequence[str]] = [
        (str(name), ", ".join(map(str, item.dims)), str(item.attrs.get("units", "")))
        for group in (dataset.coords, dataset.data_vars)
        for name, item in group.items()
        if name not in FAILURE
    ]
    kinds, counts = np.unique(dataset.error.values, return_counts=True)
    counted = zip(kinds.tolist(), counts.tolist(), strict=True)
    errors: list[Sequence[str]] = [(kind or "none", str(count)) for kind, count in counted]
    variables = tables.Table("Variables", ("name", "dimensions", "unit"), rows)
    return [*dimensions, variables, tables.Table("Errors", ("kind", "rows"), errors)]


def run_tables(path: Path) -> list[tables.Table]:
    """Describe the content of a recorded run, or of a fit."""
    run = load(path)
    if not isinstance(run, Run):
        return tables.tables_of(run)
    # The run, and its last state if it has samples.
    described = tables.tables_of(run, *run[-1:])
    if len(run) and len(run.system) > 1:
        about, body = run.system.context.names[:2]
        (elements,) = tables.tables_of(run.elements())
        elements.caption = f"Kepler elements of {body} about {about}, {len(run)} samples"
        described.append(elements)
    return described


def toml_tables(path: Path) -> list[tables.Table]:
    """Describe the content of a TOML file."""
    configuration = read_toml(path)
    rows = [
        ("until", tables.number(configuration.until)),
        ("output", "every step" if configuration.output is None else str(configuration.output)),
        ("integrator", repr(configuration.integrator)),
        ("writes", str(configuration.file)),
    ]
    return tables.tables_of(configuration.system, configuration.state, tables.Table("Run", (), list(rows)))
