"""Positions of the bodies as an SPK kernel of type 13, Hermite interpolation between uneven times."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.atomic import as_path, check_suffix
from ..errors import InvalidInput
from .conventions import Conventions, body_numbers, number, spiceypy
from .kernel import binary
from .nodes import centres, nodes

if TYPE_CHECKING:
    from ..motion.run import Run

__all__ = ["write"]

#: The tolerance of the interpolation between the nodes, km.
_TOLERANCE = 1e-9


def write(run: Run, path: Any, ids: Any, barycentre: Any) -> Path:
    """Write positions of the bodies; see :meth:`fullbody.Run.to_spk`."""
    check_suffix(path, (".bsp",))
    place = Conventions(run.system, "an SPK kernel")
    bodies, centre = body_numbers(ids, run.system.names), number(barycentre, "barycentre")
    if centre in bodies.values():
        raise InvalidInput(f"barycentre is {centre}, the id of a body; expected the number of the system as a whole")
    found = nodes(run, place, centres(place, run.system._masses), _TOLERANCE, "{:.1e} km".format)
    spice = spiceypy()
    first, last = float(found.et[0]), float(found.et[-1])
    with binary(path, "spkopn", run) as handle:
        for k, body in bodies.items():
            states = np.hstack([found.values[:, k], found.rates[:, k]])
            name = _segment(run.system.names[k])
            spice.spkw13(handle, body, centre, "J2000", first, last, name, found.degree, len(states), states, found.et)
    return as_path(path)


def _segment(name: str) -> str:
    """Return the name of a segment, which has at most forty characters of ASCII."""
    return name.encode("ascii", "replace").decode()[:40]
