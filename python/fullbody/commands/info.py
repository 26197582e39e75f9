"""``fullbody info file``: describe a recorded run, a flight, a map or a ``system.toml``."""

from __future__ import annotations

import argparse
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
from ..files.reading import netcdf
from ..loading import load, load_flight
from ..setups.toml import read_toml

if TYPE_CHECKING:
    import xarray


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "info",
        help="what a recorded run, a flight, a map or a system.toml holds",
        description="Print what a recorded run, a flight of particles, a map of a sweep (NetCDF) or a system.toml "
        "holds. A file that cannot be read is named; the others are shown.",
    )
    parser.add_argument("files", nargs="+", metavar="file", type=Path)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    shown = failed = 0
    for path in arguments.files:
        try:
            text = of_toml(path) if path.suffix.lower() == ".toml" else of_netcdf(path)
        except (FullbodyError, ImportError, OSError) as error:
            # Both streams may go to the same place, where the order of the lines must be kept.
            sys.stdout.flush()
            print(f"fullbody: {error}", file=sys.stderr)
            failed += 1
            continue
        if shown:
            print()
        print(path)
        print(text)
        shown += 1
    return 1 if failed else 0


def of_netcdf(path: Path) -> str:
    """Describe the content of a NetCDF file of this package."""
    attributes: dict[str, Any] = {}
    # Errors in a file are reported when it is loaded as a run.
    with suppress(Exception), netcdf().open_dataset(path, engine="h5netcdf") as file:
        attributes = dict(file.attrs)
        if ATTRIBUTE in attributes:
            return of_map(file)
    if "fullbody_flight" in attributes:
        return tables.to_text(load_flight(path))
    return of_run(path)


def of_map(dataset: xarray.Dataset) -> str:
    """Describe the content of a sweep's map."""
    dimensions = [tables.Table("Map", (), [(name, f"{size} values") for name, size in dataset.error.sizes.items()])]
    rows: list[Sequence[str]] = [
        (str(name), ", ".join(map(str, item.dims)), str(item.attrs.get("units", "")))
        for group in (dataset.coords, dataset.data_vars)
        for name, item in group.items()
        if name not in FAILURE
    ]
    kinds, counts = np.unique(dataset.error.values, return_counts=True)
    errors: list[Sequence[str]] = [
        (kind or "none", str(count)) for kind, count in zip(kinds.tolist(), counts.tolist(), strict=True)
    ]
    variables = tables.Table("Variables", ("name", "dimensions", "unit"), rows)
    return tables.to_text(*dimensions, variables, tables.Table("Errors", ("kind", "rows"), errors))


def of_run(path: Path) -> str:
    """Print the content of a recorded run."""
    run = load(path)
    parts: list[tables.Tabled] = [run]
    if len(run):
        parts.append(run[-1])
        if len(run.system) > 1:
            parts.append(run.elements())
    return tables.to_text(*parts)


def of_toml(path: Path) -> str:
    """Print the content of a description in TOML."""
    configuration = read_toml(path)
    output = "every step" if configuration.output is None else f"{configuration.output}"
    rows = [
        ("until", tables.number(configuration.until)),
        ("output", output),
        ("integrator", repr(configuration.integrator)),
        ("writes", str(configuration.file)),
    ]
    return tables.to_text(configuration.system, configuration.state, tables.Table("Run", (), list(rows)))
