"""Scan the sidereal period of (135) Hertha in its light curves of 1978 to 2008, and fit its pole and a convex shape.

The fits start from the minima of the scan, and the chords of an occultation scale the shape. Writes report.md, figures
and numbers.json, with a verdict on the published numbers. Takes a few minutes.
"""

from __future__ import annotations

import sys

from ..publishing import study_command
from .report import write

main = study_command(__package__, __doc__, "out/hertha", write)

if __name__ == "__main__":
    sys.exit(main())
