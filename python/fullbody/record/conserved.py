"""Drifts of the conserved quantities of a motion.

The conserved quantities are stored in eight numbers: the time, the total, translational, rotational and potential
energy, and the angular momentum.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.units import Units
from ..model.interactions import Energy, Invariants
from ..typing import Floats


def named(numbers: Any, units: Units) -> Invariants:
    """Return the eight numbers under their names, with units if the system has them."""
    energies = (units.attach(float(energy), "energy") for energy in numbers[1:5])
    momentum = units.attach(np.array(numbers[5:], dtype=np.float64), "angular momentum")
    return Invariants(units.attach(float(numbers[0]), "time"), Energy(*energies), momentum)


def size(name: str, start: Floats) -> float:
    """Return the size to which a drift is relative, which may be zero."""
    _, total, translational, _, potential, *momentum = start
    if name == "angular_momentum_drift":
        return float(np.linalg.norm(momentum))
    return float(abs(total if name == "energy_drift" else translational + potential))


def drift(name: str, start: Floats, record: Mapping[str, Floats]) -> Floats:
    """Return the drift (K,) since the start of energies (K, 4) or angular momenta (K, 3), less the work or the angular
    impulse of external forces if the record has them; it is absolute if its size is zero.
    """
    if name == "angular_momentum_drift":
        change = record["angular_momentum"] - start[5:]
        if "angular_impulse" in record:
            change = change - record["angular_impulse"].sum(axis=1)
        change = np.linalg.norm(change, axis=1)
    else:
        change = record["energy"][:, 0] - start[1]
        if "work" in record:
            change = change - record["work"].sum(axis=1)
    return np.asarray(change / (size(name, start) or 1.0))
