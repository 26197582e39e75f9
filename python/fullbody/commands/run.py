"""``fullbody run system.toml``: integrate the system that a file describes, and write the run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from ..base import tables
from ..base.atomic import replacing
from ..base.figures import matplotlib
from ..errors import FullbodyError, Interrupted, InvalidInput
from ..files import npz
from ..files.netcdf import RUN_SUFFIXES
from ..files.reading import netcdf
from ..motion.run import Run
from ..setups.toml import read_toml
from .options import add_quiet, add_until, check_output, time
from .pictures import FIGURES, page

_TABLE = ".csv"
#: The quantities of a table in the order of its columns.
_QUANTITIES = ("position", "velocity", "attitude", "spin", "energy", "angular_momentum")


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "run",
        help="integrate what a system.toml describes",
        description="Integrate what a system.toml describes and write the run. See the documentation of "
        "fullbody.setups.toml for the file's keys.",
    )
    parser.add_argument("file", type=Path, help="the description, a .toml; - for standard input")
    suffixes = f"{', '.join(RUN_SUFFIXES)}, or {_TABLE} for a table"
    help_out = f"file to write ({suffixes}); as in the description, unless given"
    parser.add_argument("-o", "--out", type=Path, help=help_out)
    add_until(parser, "another end: a number in the system's units")
    parser.add_argument("--page", type=Path, help="draw the one-page summary into this file too (.png, .pdf, .svg)")
    add_quiet(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    piped = str(arguments.file) == "-"
    if piped and arguments.out is None:
        raise InvalidInput("-o is not given; expected a file to write for a description from standard input")
    configuration = read_toml(sys.stdin.buffer if piped else arguments.file)
    out = configuration.file if arguments.out is None else arguments.out
    # Everything that could prevent the result from being written is checked before the work.
    unfinished = out.with_suffix(f".partial{out.suffix}")
    for path in (out, unfinished):
        check_output(path, (*RUN_SUFFIXES, _TABLE))
    if out.suffix.lower() != npz.SUFFIX:
        netcdf()
    if arguments.page is not None:
        check_output(arguments.page, FIGURES)
        matplotlib("figure")
    progress = sys.stderr.isatty() and not arguments.quiet
    try:
        result = configuration.run(time(arguments.until), progress=progress)
    except (FullbodyError, Interrupted) as error:
        if error.run is not None and len(error.run):
            write(error.run, unfinished)
            print(f"fullbody: stopped early; what was recorded until then is in {unfinished}", file=sys.stderr)
        raise
    write(result, out)
    if arguments.page is not None:
        with replacing(arguments.page) as temporary:
            page(result).savefig(temporary)
    if not arguments.quiet:
        print(tables.to_text(tables.tables_of(result)[0]))
        print(f"written to {out}")
    return 0


def write(run: Run, path: Path) -> None:
    """Write a run to a file, or to a table of comma-separated values with one row per sample."""
    if path.suffix.lower() != _TABLE:
        run.save(path)
        return
    frame = run.to_pandas()
    units, bodies = frame.attrs["units"], ("", *run.context.names)
    columns = sorted(frame.columns, key=lambda column: (_QUANTITIES.index(column[0]), bodies.index(column[1])))
    frame = frame[columns]
    frame.columns = [" ".join((*filter(None, column), *_unit(units, column[0]))) for column in columns]
    frame.index.name = " ".join(("time", *_unit(units, "time")))
    with replacing(path) as temporary:
        frame.to_csv(temporary)


def _unit(units: dict[str, str], quantity: str) -> list[str]:
    """Return the unit of a quantity in brackets, or nothing for a system without units."""
    return [f"[{units[quantity]}]"] if quantity in units else []
