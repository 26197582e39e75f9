"""``fullbody run system.toml``: integrate the system that a file describes, and write the run."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from ..base.atomic import check_suffix, check_target, replacing
from ..base.figures import matplotlib
from ..base.units import from_text
from ..errors import FullbodyError, Interrupted
from ..files.netcdf import SUFFIXES
from ..files.reading import netcdf
from ..motion.run import Run
from ..setups.toml import read_toml

_PAGES = (".png", ".pdf", ".svg")


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "run",
        help="integrate what a system.toml describes",
        description="Integrate what a system.toml describes and write the run as NetCDF. See the documentation of "
        "fullbody.setups.toml for the file's keys.",
    )
    parser.add_argument("file", type=Path, help="the description, a .toml")
    parser.add_argument("-o", "--out", type=Path, help="NetCDF file to write; as in the description, unless given")
    parser.add_argument("--until", help="another end: a number in the system's units, or text such as '3 day'")
    parser.add_argument("--page", type=Path, help="draw the one-page summary into this file too (.png, .pdf, .svg)")
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no summary")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    from ..base import tables

    configuration = read_toml(arguments.file)
    out = configuration.file if arguments.out is None else arguments.out
    unfinished = out.with_suffix(f".partial{out.suffix}")
    # Everything that could prevent the result from being written is checked before the work.
    for path, suffixes in ((out, SUFFIXES), (unfinished, SUFFIXES), (arguments.page, _PAGES)):
        if path is None:
            continue
        check_suffix(path, suffixes)
        check_target(path)
    netcdf()
    if arguments.page is not None:
        matplotlib("figure")
    progress = sys.stderr.isatty() and not arguments.quiet
    try:
        result = configuration.run(_time(arguments.until), progress=progress)
    except (FullbodyError, Interrupted) as error:
        if error.run is not None and len(error.run):
            error.run.save(unfinished)
            print(f"fullbody: stopped early; what was recorded until then is in {unfinished}", file=sys.stderr)
        raise
    result.save(out)
    if arguments.page is not None:
        with replacing(arguments.page) as temporary:
            page(result).savefig(temporary)
    if not arguments.quiet:
        print(tables.to_text(tables.tables_of(result)[0]))
        print(f"written to {out}")
    return 0


def _time(text: str | None) -> Any:
    """Return the end of the run as a plain number, or as a Quantity if the text has a unit."""
    try:
        return None if text is None else float(text)
    except ValueError:
        return from_text(str(text), "--until", "time")


def page(run: Run) -> Any:
    """Return the page of plots of a run, on a figure without a window."""
    figure = matplotlib("figure").Figure(figsize=(11.0, 7.0 + 2.1 * len(run.system)), layout="constrained")
    run.plot(figure)
    return figure
