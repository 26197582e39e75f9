"""Counts of steps and evaluations."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Statistics"]


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
