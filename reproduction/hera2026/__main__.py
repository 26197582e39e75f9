"""``python -m reproduction.hera2026``: what Hera should find, from the published values to a dated prediction."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ..publishing import command
from .report import write

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Write the report and print it."""
    text = (
        "Weigh starts of Didymos and Dimorphos by the published values, run them from the impact of DART to the survey "
        "of Hera, and write report.md, figures, numbers.json and the small files of results. The study is a small one "
        "unless HERA_WHOLE is set. When it is cut short, the same command goes on from there."
    )
    return command("hera2026", text, "out/hera", write, argv)


if __name__ == "__main__":
    sys.exit(main())
