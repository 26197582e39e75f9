"""The tumbling bodies as a film: MP4, GIF or a page of HTML."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._files import check_suffix, replacing
from ..errors import FullbodyError, InvalidInput
from ._style import barycentric, check_samples, unit
from .sampling import evenly, warn_if_aliased
from .scene import draw_body, scene

if TYPE_CHECKING:
    from ..run import Run

__all__ = ["animate"]

_ICONS = {
    "minus": "\u2212",
    "plus": "+",
    "fast-backward": "|\u25c0",
    "step-backward": "\u25c0|",
    "step-forward": "|\u25b6",
    "fast-forward": "\u25b6|",
    "play fa-flip-horizontal": "\u25c0",
    "play": "\u25b6",
    "pause": "||",
}
_SUFFIXES = (".mp4", ".gif", ".html")


def animate(run: Run, path: Any, *, seconds: float, fps: int, size: tuple[float, float], dpi: float) -> Path:
    """See :meth:`fullbody.Run.animate`."""
    path = Path(path)
    kind = path.suffix.lower()
    check_suffix(path, _SUFFIXES)
    if not isinstance(seconds, int | float) or not 0.0 < seconds < float("inf"):
        raise InvalidInput(f"seconds is {seconds!r}; expected a number above zero")
    if not isinstance(fps, int) or fps < 1:
        raise InvalidInput(f"fps is {fps!r}; expected a whole number above zero")
    check_samples(run)
    from matplotlib import animation

    if kind == ".mp4" and not animation.writers.is_available("ffmpeg"):
        raise FullbodyError("an MP4 needs the program ffmpeg, which is not found; install it, or write .gif or .html")
    places = evenly(run, max(2, round(seconds * fps)))
    warn_if_aliased(run, places)

    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    # A figure of no window: a film is a file.
    figure = Figure(figsize=size)
    FigureCanvasAgg(figure)
    ax = figure.add_axes((0.02, 0.06, 0.9, 0.88), projection="3d")
    scene(run, None, ax, path=True)
    # The bodies are drawn anew in each picture; their paths stay.
    moving: list[Any] = [*ax.collections, *(line for line in ax.lines if not str(line.get_label()).startswith("_"))]
    for artist in moving:
        artist.remove()
    centres, names, name = barycentric(run), run.system.names, unit(run, "time")
    writer: Any
    if kind == ".html":
        writer = animation.HTMLWriter(fps=fps, embed_frames=True, default_mode="loop", embed_limit=2000.0)
    elif kind == ".gif":
        writer = animation.PillowWriter(fps=fps)
    else:
        # Even numbers of dots and this layout of colours are what players of MP4 expect.
        writer = animation.FFMpegWriter(fps=fps, codec="h264", extra_args=["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2"])
    with replacing(path) as temporary:
        with writer.saving(figure, str(temporary), dpi):
            for index in places:
                artists: list[Any] = []
                for body, called in enumerate(names):
                    centre = centres[index, body]
                    artists += draw_body(ax, run, body, int(index), centre, called, {}, mesh=(25, 13))
                ax.set_title(f"time {run._record['time'][index]:.6g}{' ' + name if name else ''}", fontsize="medium")
                writer.grab_frame()
                for artist in artists:
                    artist.remove()
        if kind == ".html":
            temporary.write_text(_offline(temporary.read_text(encoding="utf-8")), encoding="utf-8")
    return Path(path)


def _offline(page: str) -> str:
    """Matplotlib's page without its one link: buttons show characters instead of a font from the network."""
    page = re.sub(r"<link[^>]*>", "", page)
    return re.sub(r'<i class="fa fa-([a-z -]+)"></i>', lambda icon: _ICONS[icon[1]], page)
