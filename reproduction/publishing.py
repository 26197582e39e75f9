"""What studies of many runs share: a command, and a folder with a report, its figures and its numbers."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from fullbody.base.atomic import replacing
from fullbody.errors import FullbodyError

__all__ = [
    "Study",
    "as_json",
    "command",
    "listed",
    "percent",
    "publish",
    "reported",
    "table",
    "with_error",
    "write_numbers",
]

#: A function that writes a study into a folder (its draft or all of it, with or without a progress bar) and returns
#: the path of the report.
Study = Callable[[Path, bool, bool], Path]


def command(name: str, text: str, out: str, study: Study, argv: Sequence[str] | None) -> int:
    """Run the command ``python -m reproduction.NAME``."""
    parser = argparse.ArgumentParser(prog=f"python -m reproduction.{name}", description=text)
    parser.add_argument("--out", type=Path, default=Path(out), help="folder (%(default)s)")
    parser.add_argument("--draft", action="store_true", help="a small grid and short runs")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    arguments = parser.parse_args(argv)

    def work() -> None:
        arguments.out.mkdir(parents=True, exist_ok=True)
        report = study(arguments.out, arguments.draft, sys.stderr.isatty() and not arguments.quiet)
        if not arguments.quiet:
            print(report.read_text(encoding="utf-8"))
            print(f"The report is {report}")

    return reported(work)


def reported(work: Callable[[], None]) -> int:
    """Do the work of a command; an error is reported as one line on standard error and a non-zero exit code."""
    try:
        work()
    except (FullbodyError, ImportError, OSError) as error:
        print(f"reproduction: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as interrupt:
        print(f"reproduction: {interrupt}; the same command goes on from there", file=sys.stderr)
        return 130
    return 0


def publish(folder: Path, text: str, figures: Mapping[str, Any], numbers: Mapping[str, Any]) -> Path:
    """Write ``report.md``, whose text shows the figures by name, the figures as PNG, and ``numbers.json`` at last."""
    for name, figure in figures.items():
        with replacing(folder / f"{name}.png") as temporary:
            figure.savefig(temporary, dpi=130)
    with replacing(folder / "report.md") as temporary:
        temporary.write_text(text, encoding="utf-8")
    write_numbers(folder / "numbers.json", dict(numbers))
    return folder / "report.md"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def with_error(value: str, error: float, message: str) -> str:
    """Return a value with its error, in parentheses if a message says that the fit stopped before a minimum."""
    return f"{value} ({error:.2g})" if message else f"{value} +- {error:.2g}"


def listed(items: Mapping[str, Any]) -> str:
    """Return a list in Markdown of named items."""
    return "\n".join(f"- **{name}**: {value}." for name, value in items.items())


def percent(share: float) -> str:
    """Return a share with its sign; a dash for none."""
    return "-" if np.isnan(share) else f"{100 * share:.1f} %"


def as_json(value: Any) -> Any:
    """Return a value as dictionaries, lists, numbers and text only; a number that does not exist becomes ``None``."""
    if is_dataclass(value):
        return {field.name: as_json(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {str(key): as_json(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return as_json(value.tolist())
    if isinstance(value, list | tuple):
        return [as_json(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value


def write_numbers(path: Path, value: Any) -> None:
    """Write a file of JSON, without the NaN that some readers refuse; it is written completely or not at all."""
    text = json.dumps(as_json(value), indent=1, allow_nan=False) + "\n"
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
