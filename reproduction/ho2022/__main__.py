"""``python -m reproduction.ho2022``: two ellipsoids after rotational fission, for many tilts, mass ratios and cases."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from ..publishing import command
from .study import write

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Write the report and print it."""
    text = (
        "Run two ellipsoids from the moment of rotational fission on, 19,980 times, and write report.md, figures and "
        "numbers.json beside the statements of Ho, Wold, Poursina & Conway (2022). Takes about ten minutes on two "
        "cores; when it is cut short, the same command goes on from there."
    )
    return command("ho2022", text, "out/fission", write, argv)


if __name__ == "__main__":
    sys.exit(main())
