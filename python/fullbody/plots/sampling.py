"""Whether pictures and samples lie close enough together to show the true motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import caution
from ._style import Array

if TYPE_CHECKING:
    from ..record.base import BaseRun

__all__ = ["warn_if_aliased"]


def warn_if_aliased(run: BaseRun, times: Array) -> None:
    """Warn where a body turns by more than half a turn between two pictures: it would seem to turn otherwise.

    So it would between two samples, unless the run keeps its continuous solution.
    """
    known = run._record["time"]
    advice = {"pictures": "show more of them, or a shorter time"}
    if run.dense is None:
        advice["samples"] = "record more of them (output=), or with dense=True"
    # Of two samples that coincide either will do.
    order = np.unique(known, return_index=True)[1]
    rate = np.linalg.norm(run._record["spin"][order], axis=2)
    for what, moments in (("pictures", np.sort(times)), ("samples", known[order])):
        if what not in advice or len(moments) < 2:
            continue
        fastest = [np.interp(moments[:-1], known[order], rate[:, body]) for body in range(len(run.system))]
        turns = (np.array(fastest) * np.diff(moments)).max(axis=1) / (2.0 * np.pi)
        body = int(np.argmax(turns))
        if turns[body] > 0.5:
            caution(
                f"{run.system.names[body]} makes up to {turns[body]:.2g} turns between two {what} and will seem to "
                f"turn otherwise; {advice[what]}",
                UserWarning,
            )
            return
