"""``python -m reproduction.agrusa2021``: the attitude of Dimorphos after an impact, for many axis ratios."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ..publishing import command
from .study import write

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Write the report and print it."""
    text = (
        "Run Didymos and Dimorphos for a year after an impact, for 625 shapes and two impacts, and write report.md, a "
        "map and numbers.json beside what Agrusa et al. (2021) state. Takes about ten minutes on two cores; when it is "
        "cut short, the same command goes on from there."
    )
    return command("agrusa2021", text, "out/dimorphos", write, argv)


if __name__ == "__main__":
    sys.exit(main())
