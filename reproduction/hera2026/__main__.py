"""Weigh starts of Didymos and Dimorphos by the published values, and run them from DART's impact to Hera's survey.

Writes report.md, figures, numbers.json and the small files of results. The study is a small one unless HERA_WHOLE is
set. When it is cut short, the same command goes on from there.
"""

from __future__ import annotations

import sys

from ..publishing import study_command
from .report import write

main = study_command(__package__, __doc__, "out/hera", write)

if __name__ == "__main__":
    sys.exit(main())
