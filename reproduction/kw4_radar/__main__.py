"""Run a year of (66391) 1999 KW4 with its radar shapes and with the ellipsoids of the same inertia.

The shapes have 9,168 and 2,292 faces, and gravity is exact in both runs. Writes report.md, a figure and numbers.json.
Takes a minute or two.
"""

from __future__ import annotations

import sys

from ..publishing import study_command
from .study import write

main = study_command(__package__, __doc__, "out/kw4_radar", write)

if __name__ == "__main__":
    sys.exit(main())
