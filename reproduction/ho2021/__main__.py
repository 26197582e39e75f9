"""``python -m reproduction.ho2021``: all computations of the paper, repeated and compared with its numbers."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from ..judging import counts
from ..publishing import run_command
from .judging import WORDS
from .page import write_report

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Write the report and print its verdicts."""
    parser = argparse.ArgumentParser(
        prog="python -m reproduction.ho2021",
        description="Repeat all computations of Ho, Wold, Conway & Poursina (2021) and write report.html (one file), "
        "the figures and numbers.json, with a verdict on every number. Takes some minutes.",
    )
    parser.add_argument("--out", type=Path, default=Path("out/ho2021"), help="folder (%(default)s)")
    parser.add_argument("--draft", action="store_true", help="coarser scans and shorter long runs")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    arguments = parser.parse_args(argv)

    def run() -> None:
        progress = sys.stderr.isatty() and not arguments.quiet
        report = write_report(arguments.out, draft=arguments.draft, progress=progress)
        if not arguments.quiet:
            width = max(len(verdict.quantity) for verdict in report.verdicts)
            for verdict in report.verdicts:
                print(f"{verdict.verdict:<8}{verdict.quantity:<{width}}  {verdict.printed}  |  {verdict.computed}")
            print(", ".join(f"{number} {word}" for word, number in counts(report.verdicts, WORDS).items()))
            print(f"The report is {report.page}")

    return run_command(run)


if __name__ == "__main__":
    sys.exit(main())
