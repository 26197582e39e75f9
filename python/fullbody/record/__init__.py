"""Integrators, and the record of a run: samples, the start, the continuous solution."""

from .dense import Dense, Samples
from .derivatives import EventDerivatives, FunctionDerivatives
from .record import Statistics
from .track import Track

__all__ = ["Dense", "EventDerivatives", "FunctionDerivatives", "Samples", "Statistics", "Track"]
