"""Angular velocities against time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidInput
from ._style import attitudes, check_samples, grid, label, legend, line, panels, steady, time_label

if TYPE_CHECKING:
    from ..run import Run


def spins(run: Run, axes: Any, *, frame: str, **kwargs: Any) -> Any:
    """See :meth:`fullbody.plots.Plots.spins`."""
    if frame not in ("body", "inertial"):
        raise InvalidInput(f"frame is {frame!r}; expected 'body' or 'inertial'")
    check_samples(run)
    names = run.system.names
    flat, result = panels(axes, (len(names),), (7.0, 2.4 * len(names)))
    time = run._record["time"]
    for body, (ax, name) in enumerate(zip(flat, names, strict=True)):
        spin = run._record["spin"][:, body]
        if frame == "inertial":
            spin = np.einsum("kij,kj->ki", attitudes(run, body).rotation_matrix, spin)
        for component, letter in enumerate("xyz"):
            ax.plot(time, spin[:, component], **line(component, {"label": rf"$\omega_{letter}$", **kwargs}))
        ax.set_ylabel(label(run, "spin", "spin"))
        ax.set_title(f"{name}, {frame} frame", fontsize="medium", loc="left")
        ax.ticklabel_format(axis="y", useOffset=False)
        steady(ax, spin)
        grid(ax)
        legend(ax)
    time_label(flat[-1], run)
    return result
