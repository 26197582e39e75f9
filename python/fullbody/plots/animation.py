"""Animations of the bodies as MP4, GIF or an HTML page."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from subprocess import CalledProcessError
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..base.atomic import check_suffix, replacing
from ..base.figures import grid, matplotlib
from ..base.kinds import choice, whole_number
from ..base.limits import POSITIVE, Limits
from ..base.units import UNITLESS
from ..errors import FullbodyError, InvalidInput
from ..record.record import Record
from ..typing import Floats
from ._style import RunPlots, check_samples, label, near_and_far
from .between import poses, warn_if_aliased
from .scene import draw_body, new_axes, scene, title
from .sunlight import Sunlight, directions

if TYPE_CHECKING:
    from ..observing.vectors import Vectors

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
#: The default width and height of pictures in inches, and the least number of points of a light curve.
_SIZES = {"scene": (6.4, 4.8), "sky": (9.6, 4.8)}
_CURVE = 600


def animate(
    run: Record,
    path: Any,
    *,
    seconds: float = 10.0,
    fps: int = 20,
    size: tuple[float, float] | None = None,
    dpi: float = 100.0,
    geometry: Vectors | None = None,
    view: Literal["scene", "sky"] = "scene",
) -> Path:
    """Write an animation of the bodies to a file.

    Parameters
    ----------
    path : str or Path
        A name that ends in ``.mp4`` (which needs the program ffmpeg), ``.gif`` or ``.html`` (one page that works
        offline).
    seconds : float
        Length of the animation.
    fps : int
        Pictures per second, at equal steps of time; between samples they are drawn as in
        :meth:`fullbody.plots.Plots.scene`.
    size : (float, float), optional
        Width and height in inches; by default 6.4 and 4.8, and for the sky 9.6 and 4.8.
    dpi : float
        Dots per inch.
    geometry : fullbody.observing.Geometry, optional
        Lights the bodies by its Sun, with their shadows on each other. A polyhedron casts the shadow of an
        ellipsoid.
    view : {"scene", "sky"}
        What is shown: the bodies in 3D, or the bodies in the sky, as :meth:`fullbody.plots.Plots.sky` draws them, with
        their light curve beside it. The sky needs a geometry with the Sun, and a run with ``dense=True``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    FullbodyError
        If ffmpeg is needed but missing.

    Warns
    -----
    UserWarning
        If a body makes more than half a turn between two pictures, or between two samples of a run without
        ``dense=True``.
    """
    path = Path(path)
    kind = path.suffix.lower()
    check_suffix(path, _SUFFIXES)
    UNITLESS.number(seconds, "number", "seconds", POSITIVE)
    whole_number(fps, "fps")
    choice(view, "view", ("scene", "sky"))
    size, dpi = _dots(_SIZES[view] if size is None else size, dpi)
    check_samples(run)
    animation = matplotlib("animation")
    if kind == ".mp4" and not animation.writers.is_available("ffmpeg"):
        raise FullbodyError("an MP4 needs the program ffmpeg, which is not found; install it, or write .gif or .html")
    samples = run.arrays["time"]
    times = np.linspace(samples[0], samples[-1], max(2, round(seconds * fps)) if len(samples) > 1 else 1)
    warn_if_aliased(run, times)
    # The figure has no window, since the animation goes to a file.
    figure = matplotlib("figure").Figure(figsize=size)
    matplotlib("backends.backend_agg").FigureCanvasAgg(figure)
    draw = _sky(run, figure, times, geometry) if view == "sky" else _scene(run, figure, times, geometry)
    # Players of MP4 expect even numbers of pixels and this colour layout.
    writers: dict[str, tuple[str, dict[str, Any]]] = {
        ".html": ("HTMLWriter", {"embed_frames": True, "default_mode": "loop", "embed_limit": 2000.0}),
        ".gif": ("PillowWriter", {}),
        ".mp4": ("FFMpegWriter", {"codec": "h264", "extra_args": ["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2"]}),
    }
    writer = getattr(animation, writers[kind][0])(fps=fps, **writers[kind][1])
    with _failing_by_name(path), replacing(path) as temporary:
        with writer.saving(figure, str(temporary), dpi):
            for index in range(len(times)):
                artists = draw(index)
                writer.grab_frame()
                for artist in artists:
                    artist.remove()
        if kind == ".html":
            # The buttons of matplotlib's page show characters instead of a font from the network, its one link.
            page = re.sub(r"<link[^>]*>", "", temporary.read_text(encoding="utf-8"))
            page = re.sub(r'<i class="fa fa-([a-z -]+)"></i>', lambda icon: _ICONS[icon[1]], page)
            temporary.write_text(page, encoding="utf-8")
    return path


def _scene(run: Record, figure: Any, times: Floats, geometry: Vectors | None) -> Callable[[int], list[Any]]:
    """Draw the paths of the bodies in 3D, and return the function that draws the bodies at one of the times."""
    ax = new_axes(figure)
    scene(RunPlots(run), None, ax)
    # The bodies are redrawn in each picture; their paths stay.
    moving: list[Any] = [*ax.collections, *(line for line in ax.lines if not str(line.get_label()).startswith("_"))]
    for artist in moving:
        artist.remove()
    centres, attitudes = poses(run, times)
    suns = None if geometry is None else directions(run, geometry, times)
    near = near_and_far(run)[0]
    # All pictures show as many decimals as make their times distinct.
    step = float(np.ptp(times)) / len(times)
    decimals = max(0, int(np.ceil(-np.log10(step)))) if step > 0.0 else 3

    def draw(index: int) -> list[Any]:
        artists: list[Any] = []
        centre, attitude = centres[index], attitudes[index]
        light = None if suns is None else Sunlight(run, suns[index], centre, attitude)
        for body in near:
            pose = (body, centre[body], attitude[body], run.context.names[body])
            artists += draw_body(ax, run, *pose, {}, mesh=(25, 13), light=light)
        title(ax, run, f"{times[index]:.{decimals}f}")
        return artists

    return draw


def _sky(run: Record, figure: Any, times: Floats, geometry: Vectors | None) -> Callable[[int], list[Any]]:
    """Draw the frame of the sky and the light curve, and return the function that draws one of the times."""
    from ..observing.light_curve import light_curve
    from ..observing.vectors import local_geometry
    from .telescope import SkyFrames

    if geometry is None:
        raise InvalidInput("geometry is None, but view='sky' shows what its observer sees; expected a Geometry")
    arrival = local_geometry(geometry, run.system).arrival(times)
    pictures = SkyFrames(run, arrival, geometry)
    left, right = figure.subplots(1, 2, gridspec_kw={"width_ratios": (1.1, 1.0)})
    figure.set_layout_engine("constrained")
    pictures.prepare(left)
    fine = np.linspace(arrival[0], arrival[-1], max(len(times), _CURVE))
    curve = light_curve(run, fine, geometry)
    right.plot(fine, np.where(np.isfinite(curve), curve, np.nan), color="black", linewidth=1.0)
    right.invert_yaxis()
    right.set(xlabel=label(run, "time", "time"), ylabel="magnitude")
    grid(right)
    magnitude = light_curve(run, arrival, geometry)

    def draw(index: int) -> list[Any]:
        artists = pictures.draw(left, index, True, {})
        if np.isfinite(magnitude[index]):
            artists += right.plot(arrival[index], magnitude[index], marker="o", color="#D55E00")
        return artists

    return draw


@contextmanager
def _failing_by_name(path: Path) -> Iterator[None]:
    """Context manager that converts a failure of ffmpeg to an error that names the caller's file."""
    try:
        yield
    except CalledProcessError as error:
        message = str(error.stderr or "").strip().splitlines() or [f"status {error.returncode}"]
        # The message of matplotlib's error names the temporary file, which the caller does not know.
        words = re.sub(r"\S*\.[0-9a-f]{32}\.part\.mp4", str(path).replace("\\", r"\\"), "; ".join(message[-2:]))
        raise OSError(f"{path} cannot be written; ffmpeg ended with: {words}") from error


def _dots(size: Any, dpi: Any) -> tuple[tuple[float, float], float]:
    """Check the width and height of a picture and the number of pixels per inch."""
    sides = Limits(above=0.0, text="(width, height) in inches, both above zero")
    width, height = UNITLESS.numbers(size, "number", "size", (2,), sides).tolist()
    dots = UNITLESS.number(dpi, "number", "dpi", POSITIVE)
    # Matplotlib draws no larger pictures.
    if not 1.0 <= min(width, height) * dots <= max(width, height) * dots < 2.0**16:
        raise InvalidInput(
            f"size is {size!r} and dpi is {dpi!r}, pictures of {width * dots:.6g} by {height * dots:.6g} dots; "
            "expected 1 to 65535 each way"
        )
    return (width, height), dots
