"""What all studies share: a command, and a folder with a report, its figures and its numbers."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from fullbody import __version__
from fullbody.base.atomic import replacing
from fullbody.errors import FullbodyError

__all__ = [
    "PROGRAM",
    "Study",
    "as_json",
    "cpu_seconds",
    "formatted",
    "listed",
    "percent",
    "pictures",
    "publish",
    "run_command",
    "study_command",
    "table",
    "with_error",
    "write_numbers",
]

PROGRAM = f"fullbody {__version__}"
#: A function that writes a study into a folder (its draft or all of it, with or without a progress bar) and returns
#: the path of the report.
Study = Callable[[Path, bool, bool], Path]


def study_command(package: str | None, description: str | None, out: str, study: Study) -> Callable[..., int]:
    """Return the function of arguments that runs the command ``python -m PACKAGE`` and returns its exit code.

    ``out`` is the folder into which it writes by default.
    """

    def main(argv: Sequence[str] | None = None) -> int:
        parser = argparse.ArgumentParser(prog=f"python -m {package}", description=description)
        parser.add_argument("--out", type=Path, default=Path(out), help="folder (%(default)s)")
        parser.add_argument("--draft", action="store_true", help="a small grid and short runs")
        parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
        arguments = parser.parse_args(argv)

        def run() -> None:
            arguments.out.mkdir(parents=True, exist_ok=True)
            report = study(arguments.out, arguments.draft, sys.stderr.isatty() and not arguments.quiet)
            if not arguments.quiet:
                print(report.read_text(encoding="utf-8"))
                print(f"The report is {report}")

        return run_command(run)

    return main


def run_command(run: Callable[[], None]) -> int:
    """Run a command; an error is reported as one line on standard error and a non-zero exit code."""
    try:
        run()
    except (FullbodyError, ImportError, OSError) as error:
        print(f"reproduction: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt as interrupt:
        message = str(interrupt) or "interrupted"
        print(f"reproduction: {message}; the same command goes on from what it has saved", file=sys.stderr)
        return 130
    return 0


def publish(
    folder: Path, figures: Mapping[str, Any], numbers: Mapping[str, Any], text: Callable[[dict[str, Any]], str]
) -> Path:
    """Write ``report.md``, the figures as PNG, and last ``numbers.json``; return the path of the report.

    The numbers get the name and the version of the program as ``program``. ``text`` makes the report of them, which
    shows the figures by name.
    """
    numbers = {"program": PROGRAM, **numbers}
    for name, figure in figures.items():
        with replacing(folder / f"{name}.png") as temporary:
            figure.savefig(temporary, dpi=130)
    with replacing(folder / "report.md") as temporary:
        temporary.write_text(text(numbers), encoding="utf-8")
    write_numbers(folder / "numbers.json", numbers)
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


def pictures(captions: Mapping[str, str]) -> str:
    """Return the figures with these names in Markdown, each above its caption."""
    return "\n\n".join(f"![{caption}]({name}.png)\n\n*{caption}*" for name, caption in captions.items())


def formatted(value: float | None, specification: str) -> str:
    """Return a number by a format specification; a dash for ``None`` and NaN."""
    return "-" if value is None or math.isnan(value) else format(value, specification)


def percent(share: float) -> str:
    """Return a share in per cent; a dash for NaN."""
    return "-" if math.isnan(share) else f"{100 * share:.1f} %"


def cpu_seconds(function: Callable[[], Any], calls: int) -> float:
    """Return the processor time of a function in seconds, the mean over some calls."""
    started = time.process_time()
    for _ in range(calls):
        function()
    return (time.process_time() - started) / calls


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
