"""Attitude of a body in the frame of its orbit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidInput
from ..observables import roll_pitch_yaw
from ..record.record import Record
from ..typing import Floats
from . import _style
from ._style import RunPlots

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: A body whose yaw in radians exceeds this rotates relative to the line to the other body, so it does not librate.
_ROUND = 2.0 * np.pi


def libration(plots: RunPlots, ax: Any = None, *, body: int | str = 1, about: int | str = 0, **kwargs: Any) -> Axes:
    """Draw roll, pitch and yaw of a body in its orbit's frame against time, in degrees.

    For a body that rotates relative to the line between the bodies, or whose samples are too far apart to follow
    its attitude, the angle of its z-axis from the orbit's normal is drawn instead; see
    :func:`fullbody.observables.roll_pitch_yaw`.

    Parameters
    ----------
    ax : matplotlib Axes, optional
    body, about : int or str
        Indices in the system, or names.
    **kwargs
        Passed to ``Axes.plot``.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    InvalidInput
        If there is no orbit: a single body, or motion along a line.
    """
    run = plots.sampled()
    body, about = _style.check_body(run, body, "body"), _style.check_body(run, about, "about")
    kwargs = _style.wishes(kwargs)
    angles = _angles(run, body, about)
    ax = _style.single(ax, (7.0, 3.2))
    for index, (name, angle) in enumerate(angles.items()):
        _style.draw_angle(ax, _style.times(run), np.rad2deg(angle), _style.line(index, {"label": name, **kwargs}))
    ax.set_ylabel("angle [deg]")
    what = "z-axis from the orbit's normal" if len(angles) == 1 else "in its orbit's frame"
    ax.set_title(f"{_style.called(run, body)}, {what}", fontsize="medium", loc="left")
    _style.degrees(ax)
    _style.grid(ax)
    if len(angles) > 1:
        _style.legend(ax)
    _style.time_label(ax, run)
    return ax


def _angles(run: Record, body: int, about: int) -> dict[str, Any]:
    """Return roll, pitch and yaw (K,) of a body that librates, or the tilt of the z-axis of one that does not."""
    try:
        angles_of_body = np.asarray(roll_pitch_yaw(run, body=body, about=about))
        if np.ptp(angles_of_body[:, 2]) <= _ROUND:
            return dict(zip(("roll", "pitch", "yaw"), angles_of_body.T, strict=True))
    except InvalidInput:
        # Samples too far apart to follow the attitude still give the tilt; motion along a line has no orbital frame.
        if not _normal(run, body, about).any(axis=1).all():
            raise
    normal, axis = _normal(run, body, about), _style.matrices(run, body)[:, :, 2]
    across = np.linalg.norm(np.cross(normal, axis), axis=1)
    return {"tilt": np.arctan2(across, np.sum(normal * axis, axis=1))}


def _normal(run: Record, body: int, about: int) -> Floats:
    """Return normals (K, 3) of the orbit, of any length; zero if the motion is along a line."""
    r, v = (run.arrays[name][:, body] - run.arrays[name][:, about] for name in ("position", "velocity"))
    return np.asarray(np.cross(r, v))
