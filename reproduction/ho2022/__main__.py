"""Run two ellipsoids from the moment of rotational fission on, 19,980 times.

Writes report.md, figures and numbers.json beside the statements of Ho, Wold, Poursina & Conway (2022). Takes about ten
minutes on two cores; when it is cut short, the same command goes on from there.
"""

from __future__ import annotations

import sys

from ..publishing import study_command
from .study import write

main = study_command(__package__, __doc__, "out/fission", write)

if __name__ == "__main__":
    sys.exit(main())
