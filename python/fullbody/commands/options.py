"""Options that several commands share."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..base.atomic import check_suffix, check_target
from ..base.units import from_text
from ..errors import InvalidInput
from ..files.text import refuse_underscores
from ..loading import load
from ..motion.run import Run


def add_quiet(parser: argparse.ArgumentParser) -> None:
    """Add ``--quiet``."""
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")


def add_until(parser: argparse.ArgumentParser, text: str, **options: Any) -> None:
    """Add ``--until``; the text gives the meaning of a plain number."""
    parser.add_argument("--until", help=f"{text}, or text such as '3 day'", **options)


def time(text: str | None) -> Any:
    """Return a time as a plain number, or as a Quantity if the text has a unit."""
    try:
        return None if text is None else float(refuse_underscores(text))
    except ValueError:
        return from_text(str(text), "--until", "time")


def hours(text: str) -> float:
    """Return a time in hours, in which a plain number is."""
    value = time(text)
    return float(value.to_value("h") if hasattr(value, "unit") else value)


def check_output(path: Path, suffixes: tuple[str, ...]) -> None:
    """Raise the error that would prevent a file from being written, before the work for it."""
    check_suffix(path, suffixes)
    check_target(path)


def saved_run(path: Path) -> Run:
    """Read a run; a fit is refused."""
    run = load(path)
    if not isinstance(run, Run):
        raise InvalidInput(f"{path} is a fit; expected a run")
    return run
