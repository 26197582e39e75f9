"""``fullbody info file``: what a recorded run or a ``system.toml`` holds."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from ..base import tables
from ..errors import FullbodyError
from ..files.netcdf import load
from ..setups.toml import read_toml

__all__ = ["register"]


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "info",
        help="what a recorded run or a system.toml holds",
        description="Print what a recorded run (NetCDF) or a system.toml holds. A file that cannot be read is named; "
        "the others are shown.",
    )
    parser.add_argument("files", nargs="+", metavar="file", type=Path)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    shown = failed = 0
    for path in arguments.files:
        try:
            text = of_toml(path) if path.suffix.lower() == ".toml" else of_run(path)
        except (FullbodyError, ImportError, OSError) as error:
            # Both streams may go to one place, where the order is to be kept.
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


def of_run(path: Path) -> str:
    """What a recorded run holds."""
    run = load(path)
    parts = [tables.of_run(run), tables.of_system(run.system), tables.of_bodies(run.system)]
    if len(run):
        parts.append(tables.of_state(run[-1], run.system.names))
        if len(run.system) > 1:
            parts.append(tables.of_elements(run.elements()))
    return tables.to_text(*parts)


def of_toml(path: Path) -> str:
    """What a description asks for."""
    setup = read_toml(path)
    output = "every step" if setup.output is None else f"{setup.output}"
    rows = [
        ("until", tables.number(setup.until)),
        ("output", output),
        ("integrator", repr(setup.integrator)),
        ("writes", str(setup.file)),
    ]
    start = tables.of_state(setup.state, setup.system.names)
    parts = [tables.of_system(setup.system), tables.of_bodies(setup.system), start]
    return tables.to_text(*parts, tables.Table("Run", (), list(rows)))
