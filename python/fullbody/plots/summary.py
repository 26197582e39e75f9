"""A run on one page."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

from ..errors import InvalidInput
from ._style import check_body, check_samples, joined, matplotlib, plain
from .angles import angles
from .elements import elements
from .energy import energy
from .orbit import orbit
from .spins import spins

if TYPE_CHECKING:
    from ..run import Run


def summary(run: Run, figure: Any, *, body: int, about: int) -> Any:
    """See :meth:`fullbody.plots.Plots.__call__`."""
    check_samples(run)
    if figure is not None and not isinstance(figure, matplotlib("figure").FigureBase):
        raise InvalidInput(f"figure is {figure!r}; expected a matplotlib Figure or SubFigure")
    count = len(run.system)
    pair = count > 1
    if figure is None:
        size = (11.0, (4.6 if pair else 0.6) + 2.1 * count + 2.4)
        figure = matplotlib().figure(figsize=size, layout="constrained")
    heights = ([4.4] if pair else []) + [2.1 * count, 2.2]
    rows = list(figure.subfigures(len(heights), 1, height_ratios=heights))
    if pair:
        left, right = rows.pop(0).subfigures(1, 2, width_ratios=(1.0, 1.1))
        orbit(run, left.subplots(), about=about, plane="xy", shapes=True)
        names = ("a", "e", "i")
        panels = right.subplots(len(names), 1, sharex=True)
        body, about = check_body(run, body, "body"), check_body(run, about, "about")
        run.system.mu(body, about)
        try:
            elements(run, panels, mu=None, body=body, about=about, names=names)
        except InvalidInput as error:
            # Such as motion along a line.
            for ax in panels:
                ax.remove()
            right.text(0.5, 0.5, f"no elements: {fill(str(error), 48)}", ha="center", va="center")
    left, right = rows[0].subfigures(1, 2, width_ratios=(1.0, 1.4))
    spins(run, left.subplots(count, 1, sharex=True, squeeze=False)[:, 0], frame="body")
    angles(run, right.subplots(count, 2, sharex=True, squeeze=False))
    energy(run, rows[1].subplots())
    figure.align_ylabels()
    options, s = run.system.options, run.statistics
    figure.suptitle(
        f"{plain(joined(run))}: {options['gravity']} gravity, {type(run.integrator).__name__}, "
        f"{s.steps} steps, {len(run)} samples",
        fontsize="medium",
    )
    return figure
