"""Fit four light curves of (22) Kalliope and Linus of November 2021, with their mutual events.

A Fourier series of Kalliope's rotation or a free form of Kalliope describes the rest. Writes report.md, figures, tables
of events and numbers.json, with a verdict on the published numbers. Takes about a quarter of an hour.
"""

from __future__ import annotations

import sys

from ..publishing import study_command
from .report import write

main = study_command(__package__, __doc__, "out/kalliope", write)

if __name__ == "__main__":
    sys.exit(main())
