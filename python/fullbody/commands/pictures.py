"""``fullbody plot``, ``view`` and ``animate``: pictures of a recorded run."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..base.atomic import replacing
from ..base.figures import matplotlib
from ..motion.run import Run
from ..plots import Plots
from .options import add_quiet, check_output, saved_run

FIGURES = (".png", ".pdf", ".svg")
_ANIMATIONS = (".gif", ".mp4", ".html")
#: The plots that need times and a geometry, which no option gives.
_OBSERVATIONS = {"delay_doppler", "light_curve", "radar_spectrum", "sky"}
#: The summary, and the names of single plots.
_KINDS = ("page", *(name for name in vars(Plots) if not name.startswith("_") and name not in _OBSERVATIONS))


def register(subparsers: Any) -> None:
    """Add the commands."""
    for name, text, default, suffixes in (
        ("plot", "draw a recorded run", ".png", FIGURES),
        ("view", "write the page on which a recorded run is seen in 3D", ".html", (".html",)),
        ("animate", "write an animation of a recorded run", ".gif", _ANIMATIONS),
    ):
        parser = subparsers.add_parser(name, help=text, description=f"{text.capitalize()}.")
        parser.add_argument("file", type=Path, help="a run, as 'fullbody run' writes it")
        help_out = f"file to write ({', '.join(suffixes)}); by default the name of the run with {default}"
        parser.add_argument("-o", "--out", type=Path, help=help_out)
        if name == "plot":
            parser.add_argument("--kind", choices=_KINDS, default="page", help="what is drawn (%(default)s)")
        if name == "animate":
            parser.add_argument("--seconds", type=float, default=10.0, help="length (%(default)s)")
            parser.add_argument("--fps", type=int, default=20, help="frames per second (%(default)s)")
        add_quiet(parser)
        parser.set_defaults(run=run, command=name, default=default, suffixes=suffixes)


def run(arguments: argparse.Namespace) -> int:
    """Run one of the commands."""
    out = arguments.file.with_suffix(arguments.default) if arguments.out is None else arguments.out
    check_output(out, arguments.suffixes)
    recorded = saved_run(arguments.file)
    if arguments.command == "plot":
        draw(recorded, arguments.kind, out)
    elif arguments.command == "view":
        recorded.view().save_html(out)
    else:
        recorded.animate(out, seconds=arguments.seconds, fps=arguments.fps)
    if not arguments.quiet:
        print(f"written to {out}")
    return 0


def draw(recorded: Run, kind: str, out: Path) -> None:
    """Draw the summary of a run, or one of its plots, into a file."""
    if kind == "page":
        figure = page(recorded)
    else:
        axes = getattr(recorded.plot, kind)()
        figure = (axes.flat[0] if hasattr(axes, "flat") else axes).figure
    with replacing(out) as temporary:
        figure.savefig(temporary)


def page(recorded: Run) -> Any:
    """Return the page of plots of a run, on a figure without a window."""
    figure = matplotlib("figure").Figure(figsize=(11.0, 7.0 + 2.1 * len(recorded.system)), layout="constrained")
    recorded.plot(figure)
    return figure
