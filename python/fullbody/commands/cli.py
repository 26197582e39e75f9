"""The command line: ``fullbody`` or ``python -m fullbody``."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from ..base.version import version
from ..errors import FullbodyError
from . import completion, info, init, kw4, pictures, run


def build_parser() -> argparse.ArgumentParser:
    """Return the parser with all subcommands."""
    parser = argparse.ArgumentParser(
        prog="fullbody",
        description="Rigid bodies (ellipsoids, polyhedra, composites) that move and rotate in each other's gravity.",
    )
    parser.add_argument("--version", action="version", version=f"fullbody {version()}")
    subparsers = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (init, run, info, pictures, kw4):
        command.register(subparsers)
    completion.register(subparsers, parser)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command; an error is reported as one line on standard error and a non-zero exit code."""
    arguments = build_parser().parse_args(argv)
    try:
        code = int(arguments.run(arguments))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # The reader has closed the pipe, as head does after ten lines. Flushing at Python's end must not fail either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + 13
    except (FullbodyError, ImportError, OSError) as error:
        print(f"fullbody: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("fullbody: interrupted", file=sys.stderr)
        return 130
