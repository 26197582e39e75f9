"""Statistics of an integration: counts of steps and evaluations, and the reason for its end."""

from __future__ import annotations

from dataclasses import dataclass

#: The reasons for which a run may end, with texts that describe an early end.
STOP_REASONS = {
    "end": None,
    "event": "by the last event",
    "interrupted": "by an interrupt",
    "unfinished": "by an error",
}


@dataclass(frozen=True, slots=True)
class Statistics:
    """Counts of an integration.

    Attributes
    ----------
    steps, rejected, evaluations : int
        Accepted steps, rejected attempts, evaluations of the rates of change.
    """

    steps: int
    rejected: int
    evaluations: int
