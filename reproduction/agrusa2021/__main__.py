"""Run Didymos and Dimorphos for a year after an impact, for 625 shapes and two impacts.

Writes report.md, a map and numbers.json beside what Agrusa et al. (2021) state. Takes about ten minutes on two cores;
when it is cut short, the same command goes on from there.
"""

from __future__ import annotations

import sys

from ..publishing import study_command
from .study import write

main = study_command(__package__, __doc__, "out/dimorphos", write)

if __name__ == "__main__":
    sys.exit(main())
