"""``python -m reproduction.kw4_radar``: a year of 1999 KW4 with its radar shapes, beside its equivalent ellipsoids."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ..publishing import command
from .study import write

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Write the report and print it."""
    text = (
        "Run a year of (66391) 1999 KW4 with its radar shapes, 9,168 and 2,292 faces, and with the ellipsoids of the "
        "same inertia, both in exact gravity, and write report.md, a figure and numbers.json. Takes a minute or two."
    )
    return command("kw4_radar", text, "out/kw4_radar", write, argv)


if __name__ == "__main__":
    sys.exit(main())
