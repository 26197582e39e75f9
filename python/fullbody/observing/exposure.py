"""Averages over the time of an integration."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.limits import NOT_NEGATIVE
from ..model.context import SystemLike
from ..typing import Floats

#: The number of times at which what is observed in an integration is computed.
_NODES = 5


def exposure_rule(exposure: Any, system: SystemLike) -> tuple[Floats, Floats]:
    """Return times (Q,) from the middle of an exposure in a system's unit of time, and their weights (Q,).

    Gauss's rule with five nodes averages a polynomial of the ninth degree exactly. The exposure is one time for all
    observations.
    """
    length = system.context.units.number(exposure, "time", "exposure", NOT_NEGATIVE)
    if length == 0.0:
        return np.zeros(1), np.ones(1)
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    return 0.5 * length * nodes, 0.5 * weights
