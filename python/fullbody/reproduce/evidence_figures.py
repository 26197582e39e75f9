"""Figures of what the paper does not show: round-off, other starts, the physical system."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import paper
from ..plots._style import LINES, grid, legend
from . import kw4

if TYPE_CHECKING:
    from .results import Results

__all__ = ["all_figures"]


def all_figures(results: Results) -> dict[str, Any]:
    """The figures by name."""
    return {
        "z_motion": z_motion(results),
        "spin_starts": spin_starts(results),
        "inclination": inclination(results),
        "physical": physical(results),
    }


def _figure(rows: int, columns: int, size: tuple[float, float], **kwargs: Any) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **kwargs)


def z_motion(results: Results) -> Any:
    """Case 1's motion along z by kind of arithmetic."""
    figure, axes = _figure(1, 1, (7.0, 4.2))
    ax = axes[0, 0]
    labels = {
        "seeded": "default integrator, started with z = 1e-11",
        "double": "DOP853, plain doubles",
        "compensated": "default integrator, compensated sums",
        "symmetric": "DOP853, rates exactly symmetric: z = 0 throughout",
    }
    for k, (name, text) in enumerate(labels.items()):
        motion = results.z_motion[name]
        shown = np.where(motion.z > 0, motion.z, np.nan)
        ax.plot(motion.time, shown, linewidth=1.3, label=text, **LINES[k])
    ax.set_yscale("log")
    ax.set_ylim(1e-18, 1e3)
    ax.axhline(0.1, color="0.6", linewidth=0.8)
    place = {"xycoords": ax.get_yaxis_transform(), "fontsize": "small", "color": "0.35", "va": "bottom"}
    ax.annotate("the paper's order at t = 2200", (0.01, 0.13), **place)
    ax.set_xlabel("time")
    ax.set_ylabel("|z| of A, largest in 25 units of time")
    ax.margins(x=0)
    grid(ax)
    ax.legend(loc="lower right", fontsize="small")
    figure.suptitle("Case 1: the motion along z is round-off that an instability makes grow")
    return figure


def spin_starts(results: Results) -> Any:
    """Beta's spin over the first 200 h along families of starts, beside the printed ranges."""
    figure, axes = _figure(4, len(results.scans), (10.5, 9.5), sharex="col", sharey="row")
    for column, scan in enumerate(results.scans):
        for row, (axis, printed) in enumerate(paper.KW4_SPIN.items()):
            ax = axes[row, column]
            low, high = scan.ranges[:, row].T
            ax.fill_between(scan.values, low, high, color=LINES[0]["color"], alpha=0.25, linewidth=0)
            ax.plot(scan.values, low, scan.values, high, linewidth=1.0, **LINES[0])
            for value in printed:
                ax.axhline(value, color="0.2", linewidth=0.9, linestyle=(0, (4, 2)))
            if column == 0:
                ax.set_ylabel(rf"$\hat\omega_{axis}$ [$10^{{-5}}$ rad/s]")
        ax = axes[3, column]
        ax.plot(scan.values, scan.misfit, linewidth=1.2, **LINES[4])
        ax.set_yscale("log")
        ax.set_xticks(np.arange(-90, 91, 45))
        ax.set_xlabel(f"{scan.name} [deg]", fontsize="small")
        if column == 0:
            ax.set_ylabel("largest difference from\nthe printed [$10^{-5}$ rad/s]")
    for ax in axes.flat:
        grid(ax)
        ax.margins(x=0)
        ax.axvline(0.0, color="0.6", linewidth=0.8)
    figure.suptitle("Range of Beta's spin over 200 h by start (bands); the paper's ranges (dashed); its start (0 deg)")
    return figure


def inclination(results: Results) -> Any:
    """The two inclinations over the year, and the nodal period by the orbit's inclination."""
    from astropy import units as u

    figure, axes = _figure(3, 1, (7.0, 9.0))
    first, own, by = axes[:, 0]
    for k, (shape, run) in enumerate(results.year_runs.items()):
        thinned = run[::16]
        hours = thinned.time.to_value(u.hour)
        style = {**LINES[2 * k], "linewidth": 1.0}
        first.plot(hours, kw4.inclination_to_first(thinned), label=f"{shape}s", **style)
        own.plot(hours, thinned.elements().i.to_value(u.deg), label=f"{shape}s", **style)
        inclinations, periods = results.nodal[shape]
        by.plot(inclinations, periods, label=f"{shape}s", **{**style, "linewidth": 1.4})
        printed = paper.KW4[shape].inclination_period
        own.axvline(printed, color=style["color"], linewidth=0.9, linestyle=(0, (4, 2)))
        by.axhline(printed, color=style["color"], linewidth=0.9, linestyle=(0, (4, 2)))
        by.annotate(f"printed, {shape}s", (139.5, printed), fontsize="small", va="bottom", color="0.25")
    by.axvline(156.1, color="0.6", linewidth=0.8)
    first.set_ylabel("inclination to the\nfirst orbit's plane [deg]")
    own.set_ylabel("inclination to the\nxy-plane [deg]")
    by.set_ylabel("period of the node [h]")
    for ax in (first, own):
        ax.set_xlabel("time [h]")
    by.set_xlabel("initial inclination of the orbit [deg]; the paper's start at 156.1")
    by.set_ylim(bottom=3250)
    for ax in axes[:, 0]:
        grid(ax)
        legend(ax)
        ax.margins(x=0)
    figure.suptitle("1999 KW4: inclination; dashed: the printed periods, drawn from the start")
    return figure


def physical(results: Results) -> Any:
    """Eccentricity and Beta's spin of the physical states and of the paper's."""
    figure, axes = _figure(4, len(results.physical), (11.0, 8.5), sharex=True, sharey="row")
    for column, motion in enumerate(results.physical):
        shown = motion.run.time <= 500.0
        hours = motion.run.time[shown]
        panels = [motion.run.elements().e[shown], *(motion.run.spin[shown, 1].T * 1e5 / 3600.0)]
        for ax, values in zip(axes[:, column], panels, strict=True):
            ax.plot(hours, values, linewidth=0.6, color=LINES[0]["color"])
            grid(ax)
            ax.margins(x=0)
        swing = "turns under Alpha" if np.isnan(motion.libration) else f"libration {motion.libration:.1f} deg"
        axes[0, column].set_title(f"{motion.name}\n{swing}", fontsize="medium")
        axes[-1, column].set_xlabel("time [h]")
    axes[0, 0].set_ylabel("eccentricity")
    for row, axis in enumerate("xyz", start=1):
        axes[row, 0].set_ylabel(rf"$\hat\omega_{axis}$ [$10^{{-5}}$ rad/s]")
    figure.suptitle("1999 KW4: the paper's start beside physical ones (first 500 h)")
    return figure
