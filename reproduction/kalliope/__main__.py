"""``python -m reproduction.kalliope``: the light of Kalliope and Linus fitted, and the table of their mutual events."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ..publishing import command
from .report import write

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Fit and report."""
    text = (
        "Fit four light curves of (22) Kalliope and Linus of November 2021, with their mutual events and a Fourier "
        "series of Kalliope's rotation or a free form of it, and write report.md, figures, tables of events and "
        "numbers.json, with a verdict on the published numbers. Takes about a quarter of an hour."
    )
    return command("kalliope", text, "out/kalliope", write, argv)


if __name__ == "__main__":
    sys.exit(main())
