"""Plots of a run, for :attr:`fullbody.Run.plot`, and of fields, impacts, sweeps and astrometry.

Matplotlib is imported when a plot is drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from textwrap import fill
from typing import Any

from ..base.figures import matplotlib
from ..base.kinds import instance
from ..errors import InvalidInput
from ._style import RunPlots, escaped, names_of
from .curves import angles, elements, energy, libration, spins, work
from .fields import impacts, roche_lobes, surface_map, surface_scene, zero_velocity
from .light import light_curve
from .radar import delay_doppler, radar_spectrum
from .scene import orbit, scene
from .sky_tracks import sky_track
from .sweeps import sweep
from .telescope import sky

__all__ = [
    "Plots",
    "impacts",
    "roche_lobes",
    "sky_track",
    "surface_map",
    "surface_scene",
    "sweep",
    "zero_velocity",
]


@dataclass(frozen=True, slots=True, repr=False)
class Page:
    """A page of plots: the figure, and its axes by their content.

    It is not the figure itself, which a notebook would show a second time as the value of a cell's last line.

    Attributes
    ----------
    figure : matplotlib.figure.Figure or SubFigure
    axes : mapping of str to matplotlib Axes
        ``"orbit"``, ``"a"``, ``"e"``, ``"i"``, ``"energy"``, with forces ``"work"``; and for each body
        ``"spin of NAME"`` and ``"attitude of NAME"``.
    """

    figure: Any
    axes: Mapping[str, Any]

    def __repr__(self) -> str:
        return f"<page of {len(self.axes)} plots: {', '.join(self.axes)}; its .figure saves it>"


def summary(plots: RunPlots, figure: Any = None, *, body: int | str = 1, about: int | str = 0) -> Page:
    """Draw one page: orbit, elements, spins, librations, conservation, and the work of external forces.

    Parameters
    ----------
    figure : matplotlib Figure or SubFigure, optional
    body, about : int or str
        The body whose orbit is shown and the one it orbits; indices in the system, or names.

    Returns
    -------
    Page
        For motion along a line, notes replace the elements and the librations, which do not exist.
    """
    run = plots.sampled()
    count = len(run.context)
    pair, forces = count > 1, list(run.context.forces)
    if figure is None:
        size = (11.0, (4.6 if pair else 0.6) + 2.1 * count + 2.4 + (2.4 if forces else 0.0))
        figure = matplotlib().figure(figsize=size, layout="constrained")
    instance(figure, "figure", matplotlib("figure").FigureBase, "a matplotlib Figure or SubFigure")
    heights = ([4.4] if pair else []) + [2.1 * count, 2.2] + ([2.2] if forces else [])
    rows = list(figure.subfigures(len(heights), 1, height_ratios=heights))
    axes: dict[str, Any] = {}
    if pair:
        left, right = rows.pop(0).subfigures(1, 2, width_ratios=(1.0, 1.1))
        axes["orbit"] = orbit(plots, left.subplots(), about=about)
        names = ("a", "e", "i")
        panels = right.subplots(len(names), 1, sharex=True)
        body, about = run.context.pair(body, about)
        try:
            elements(plots, panels, body=body, about=about, names=names)
            axes.update(zip(names, panels, strict=True))
        except InvalidInput as error:
            for ax in panels:
                ax.remove()
            right.text(0.5, 0.5, f"no elements: {fill(str(error), 48)}", ha="center", va="center")
    left, right = rows[0].subfigures(1, 2)
    spins(plots, left.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    axes |= {f"spin of {name}": ax for name, ax in zip(run.context.names, left.axes, strict=True)}
    for index, ax in enumerate(right.subplots(count, 1, sharex=True, squeeze=False)[:, 0]):
        other = body if index == about else about
        try:
            axes[f"attitude of {run.context.names[index]}"] = libration(plots, ax, body=index, about=other)
            # The lowest panel labels the time axis for all.
            ax.label_outer()
        except InvalidInput as error:
            ax.remove()
            note = f"no frame of an orbit: {fill(str(error), 48)}"
            right.text(0.5, 1.0 - (index + 0.5) / count, note, ha="center", va="center")
    axes["energy"] = energy(plots, rows[1].subplots())
    if forces:
        axes["work"] = work(plots, rows[2].subplots())
    figure.align_ylabels()
    options, s = run.system.options, run.statistics
    title = f"{names_of(run)}: {options['gravity']} gravity, {type(run.integrator).__name__}, "
    title += f"{s.steps} steps, {len(run)} samples"
    if forces:
        title += "\n" + fill(f"with {', '.join(forces)}", 110)
    figure.suptitle(escaped(title), fontsize="medium")
    return Page(figure, axes)


class Plots(RunPlots):
    """The plots of a run: ``run.plot()`` draws a page, ``run.plot.orbit()`` and so on one picture.

    Each method draws on the matplotlib axes ``ax`` or makes its own, and returns them; a plot of several panels takes
    and returns an array of axes. Further keyword arguments are passed to ``Axes.plot``. Lengths, times and spins are in
    the system's units, angles in degrees.

    Parameters
    ----------
    run : Run
        A run with at least one sample.

    Examples
    --------
    >>> import fullbody
    >>> system, state = fullbody.systems.case1()
    >>> system.integrate(state, 10.0, output=1.0).plot
    <plots of 11 samples: angles, delay_doppler, elements, energy, libration, light_curve, orbit, radar_spectrum, scene,
    sky, spins, work; call it for a summary>
    """

    __slots__ = ()

    angles = angles
    delay_doppler = delay_doppler
    elements = elements
    energy = energy
    libration = libration
    light_curve = light_curve
    orbit = orbit
    radar_spectrum = radar_spectrum
    scene = scene
    sky = sky
    spins = spins
    work = work
    __call__ = summary

    def __eq__(self, other: object) -> bool:
        return self.run == other.run if isinstance(other, Plots) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        names = ", ".join(name for name in vars(Plots) if not name.startswith("_"))
        return f"<plots of {len(self.run)} samples: {names}; call it for a summary>"
