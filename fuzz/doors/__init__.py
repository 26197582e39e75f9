"""Doors of the package: where input of others comes in.

Whatever comes in, there is a right object or a :class:`fullbody.FullbodyError`; never another error, a number that is
none, a crash, or no end. Each door has a strategy of hypothesis for its input, and a function that goes through it.
"""

from __future__ import annotations

from . import calls, observed, runs, texts
from .door import Door

__all__ = ["DOORS", "Door"]

#: All doors by name.
DOORS: dict[str, Door] = {door.name: door for door in (*runs.DOORS, *texts.DOORS, *calls.DOORS, *observed.DOORS)}
