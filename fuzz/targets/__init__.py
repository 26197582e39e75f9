"""The targets of fuzzing: functions of the package that take external input.

For any input they return a valid object or raise a :class:`fullbody.FullbodyError`. Another error, a NaN, a crash and a
computation without end are faults. Each target has a strategy of hypothesis for its input, and a function that checks
the result of the package.
"""

from __future__ import annotations

from . import calls, observed, runs, texts
from .target import Target

__all__ = ["TARGETS", "Target"]

#: All targets by name.
TARGETS: dict[str, Target] = {
    target.name: target for target in (*runs.TARGETS, *texts.TARGETS, *calls.TARGETS, *observed.TARGETS)
}
