"""Conversion of other programs' input files and objects to systems and states."""

from .gubas import read_gubas
from .rebound import from_rebound, to_rebound
from .sians import read_sians

__all__ = ["from_rebound", "read_gubas", "read_sians", "to_rebound"]
