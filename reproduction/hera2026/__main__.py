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
        "Fit the published values of Didymos and Dimorphos, run draws from their posterior from the impact of DART to "
        "the arrival of Hera, and write report.md, figures, numbers.json and the small files of results. HERA_MEMBERS "
        "is the number of members, 24 unless set, 2000 for the whole study; each takes some seconds of one core. When "
        "it is cut short, the same command goes on from there, also with more members."
    )
    return command("hera2026", text, "out/hera", write, argv)


if __name__ == "__main__":
    sys.exit(main())
