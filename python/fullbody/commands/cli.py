"""The command line: ``fullbody`` or ``python -m fullbody``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from ..base.version import version
from ..errors import FullbodyError
from . import info, kw4, run


def build_parser() -> argparse.ArgumentParser:
    """Return the parser with all subcommands."""
    parser = argparse.ArgumentParser(
        prog="fullbody",
        description="Rigid bodies (ellipsoids, polyhedra, composites) moving and turning in each other's exact "
        "gravity.",
    )
    parser.add_argument("--version", action="version", version=f"fullbody {version()}")
    subparsers = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (run, info, kw4):
        command.register(subparsers)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; an error is reported as one line on standard error and a non-zero exit code."""
    arguments = build_parser().parse_args(argv)
    try:
        return int(arguments.run(arguments))
    except (FullbodyError, ImportError, OSError) as error:
        print(f"fullbody: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("fullbody: interrupted", file=sys.stderr)
        return 130
