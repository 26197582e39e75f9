"""``fullbody reproduce``: everything that the paper shows, run again and laid beside its numbers."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

__all__ = ["register"]


def register(subparsers: Any) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "reproduce",
        help="the whole paper run again: report.html, figures, numbers.json",
        description="Run everything that Ho, Wold, Conway & Poursina (2021) show and write report.html (one file), the "
        "figures and numbers.json, with a verdict on every number. Takes some minutes.",
    )
    parser.add_argument("--out", type=Path, default=Path("out/reproduce"), help="folder (%(default)s)")
    parser.add_argument("--draft", action="store_true", help="coarser scans and shorter long runs")
    parser.add_argument("--quiet", action="store_true", help="no progress bar and no table")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    from ..reproduce import write_report
    from ..reproduce.results import counts

    report = write_report(arguments.out, draft=arguments.draft, progress=sys.stderr.isatty() and not arguments.quiet)
    if not arguments.quiet:
        width = max(len(verdict.quantity) for verdict in report.verdicts)
        for verdict in report.verdicts:
            print(f"{verdict.verdict:<8}{verdict.quantity:<{width}}  {verdict.printed}  |  {verdict.ours}")
        print(", ".join(f"{number} {word}" for word, number in counts(list(report.verdicts))))
        print(f"The report is {report.page}")
    return 0
