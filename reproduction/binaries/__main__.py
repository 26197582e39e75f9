"""Fit the relative astrometry of 27 binaries beyond Neptune, of Eris, Lempo and Haumea.

Writes report.md, figures and numbers.json, with a verdict on every published number. Takes some minutes.
"""

from __future__ import annotations

import sys

from ..publishing import study_command
from .report import write

main = study_command(__package__, __doc__, "out/binaries", write)

if __name__ == "__main__":
    sys.exit(main())
