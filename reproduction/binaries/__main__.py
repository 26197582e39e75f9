"""``python -m reproduction.binaries``: binaries beyond Neptune fitted again and compared with the published numbers."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ..publishing import command
from . import report

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Fit and report."""
    text = (
        "Fit the relative astrometry of 27 binaries beyond Neptune, of Eris, Lempo and Haumea, and write report.md, "
        "figures and numbers.json, with a verdict on every published number. Takes some minutes."
    )
    return command("binaries", text, "out/binaries", report.write, argv)


if __name__ == "__main__":
    sys.exit(main())
