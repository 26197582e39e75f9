"""``fullbody info file``: what a recorded run or a ``system.toml`` holds."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from ..base import tables
from ..errors import FullbodyError
from ..motion.loading import load
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
    parts = list(run._tables())
    if len(run):
        parts.append(run[-1]._table(run.system.names))
        if len(run.system) > 1:
            parts += run.elements()._tables()
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
    parts = [*setup.system._tables(), setup.state._table(setup.system.names)]
    return tables.to_text(*parts, tables.Table("Run", (), list(rows)))
