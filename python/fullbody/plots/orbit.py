"""Paths about one body, projected."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.kinds import choice
from ..record.record import Record
from ..typing import Floats
from . import _style
from ._style import LINES, RunPlots

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


def orbit(
    plots: RunPlots, ax: Any = None, *, about: int | str = 0, plane: str = "xy", shapes: bool = True, **kwargs: Any
) -> Axes:
    """Draw paths about one body, projected on a plane of the inertial frame, with the bodies' outlines at the end.

    Parameters
    ----------
    about : int or str
        The body at the origin; its index in the system, or its name.
    plane : {"xy", "xz", "yz"}
    shapes : bool
        Whether to draw the bodies' outlines.
    """
    choice(plane, "plane", _PLANES)
    run = plots.sampled()
    about = _style.check_body(run, about, "about")
    ax = _style.single(ax, (5.5, 5.0))
    across, up = _PLANES[plane]
    position = run.arrays["position"]
    kwargs = _style.wishes(kwargs)
    near, far = _style.split_far(run, about)
    for index, body in enumerate(k for k in near if k != about):
        path = position[:, body] - position[:, about]
        style = _style.line(index, {"linewidth": 0.9, "label": _style.called(run, body), **kwargs})
        ax.plot(path[:, across], path[:, up], **style)
    for body, distance in far:
        ax.plot([], [], linestyle="none", label=_style.far_label(run, body, distance))
    if shapes:
        for body in near:
            end = (position[-1, body] - position[-1, about])[[across, up]]
            _outline(ax, run, body, end, [across, up])
    ax.set_aspect("equal", adjustable="datalim")
    for set_label, letter in zip((ax.set_xlabel, ax.set_ylabel), plane, strict=True):
        set_label(_style.label(run, f"{letter} from {_style.called(run, about)}", "length"))
    _style.grid(ax)
    _style.legend(ax)
    return ax


def _outline(ax: Any, run: Record, body: int, centre: Floats, plane: list[int]) -> None:
    """Draw the outline of each part as seen along the third axis: the ellipse of P R diag(a^2) R^T P^T."""
    drawn = _style.surfaces(run, body)
    if not drawn:
        ax.plot(*centre[:, None], marker="+", color=LINES[2]["color"], linestyle="none")
        return
    matrix = _style.matrices(run, body)[-1][plane]
    angles = np.linspace(0.0, 2.0 * np.pi, 73)
    for surface in drawn:
        columns = matrix @ surface.columns
        if surface.triangles is not None:
            corners = surface.triangles @ columns.T + (centre + matrix @ surface.position)
            # Edges are not drawn: the outline is that of all faces together.
            style = {"facecolor": "0.8", "edgecolor": "0.8", "linewidth": 0.3, "zorder": 3}
            ax.add_collection(_style.matplotlib("collections").PolyCollection(corners, **style))
            continue
        edge = np.linalg.cholesky(columns @ columns.T) @ np.array([np.cos(angles), np.sin(angles)])
        index = centre + matrix @ surface.position
        ax.fill(*(index[:, None] + edge), facecolor="0.8", edgecolor="0.2", linewidth=0.8, zorder=3)
