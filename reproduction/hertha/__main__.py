"""``python -m reproduction.hertha``: the period, the pole and the shape of Hertha from light, and its size."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ..publishing import command
from .report import write

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Scan, fit and report."""
    text = (
        "Scan the sidereal period of (135) Hertha in its light curves of 1978 to 2008, fit its pole and a convex shape "
        "from the minima of the scan, scale the shape by the chords of an occultation, and write report.md, figures "
        "and numbers.json, with a verdict on the published numbers. Takes a few minutes."
    )
    return command("hertha", text, "out/hertha", write, argv)


if __name__ == "__main__":
    sys.exit(main())
