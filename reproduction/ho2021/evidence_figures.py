"""Figures that are not in the paper: round-off, other starts, the physical system."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
from fullbody.base.figures import LINES, grid, legend, matplotlib

from . import paper, spin, symmetry
from .drawing import SHAPES, new_figure
from .results import Results
from .starts import SKY

__all__ = ["all_figures"]

#: The style of lines for the paper's values.
_PRINTED = {"linewidth": 1.0, "linestyle": (0, (4, 2))}
_NOTE = {"fontsize": "small", "color": "0.25"}
#: The length of the drawn motion of the physical states, hours.
_LENGTH = 200.0
#: Inclination between prograde and retrograde orbits, degrees.
_POLAR = 90.0


def all_figures(results: Results) -> dict[str, Any]:
    """Return the figures by name."""
    return {
        "z_motion": z_motion(results),
        "spin_starts": spin_starts(results),
        "inclination": inclination(results),
        "physical": physical(results),
    }


def z_motion(results: Results) -> Any:
    """Draw case 1's motion along z by kind of arithmetic."""
    figure, axes = new_figure(1, 1, (7.0, 4.6))
    ax = axes[0, 0]
    labels = {
        "seeded": f"default integrator, started with z = {symmetry.NOISE:.0e}",
        "double": "DOP853, double precision",
        "compensated": "default integrator, compensated sums",
        "symmetric": "DOP853, exactly symmetric rates",
    }
    lowest, zero = np.inf, []
    for k, (name, text) in enumerate(labels.items()):
        motion = results.z_motion[name]
        if not motion.z.any():
            zero.append(f"{text}: z = 0 throughout")
            continue
        lowest = min(lowest, float(motion.z[motion.z > 0].min()))
        ax.plot(motion.time, np.where(motion.z > 0, motion.z, np.nan), linewidth=1.3, label=text, **LINES[k])
    statement = paper.STATEMENTS["case1.z_long"].text
    order = float(statement.split()[-1])
    ax.axhline(order, color="0.35", **_PRINTED)
    options = {"xycoords": ax.get_yaxis_transform(), **_NOTE}
    ax.annotate(f"the paper at t = {paper.CASES_LONG_END:g}: {statement}", (0.01, 2 * order), va="bottom", **options)
    ax.annotate("\n".join(zero), (0.99, 0.03), xycoords="axes fraction", ha="right", **_NOTE)
    ax.set_yscale("log")
    # The limits leave space for the two notes.
    ax.set_ylim(lowest / 1e3, 1e3 * order)
    ax.set_xlabel("time (dimensionless)")
    ax.set_ylabel(f"|z| of A (dimensionless),\nlargest in {symmetry.WINDOW:g} units of time")
    ax.margins(x=0)
    ax.set_xlim(left=0.0)
    grid(ax)
    figure.legend(loc="outside lower center", fontsize="small", frameon=False, handlelength=3.0)
    figure.suptitle("Case 1: the motion along z is round-off, amplified by an instability")
    return figure


def spin_starts(results: Results) -> Any:
    """Draw Beta's spin over the first 200 h along families of starts, beside the printed ranges."""
    columns = len(results.scans)
    figure, axes = new_figure(4, columns, (10.5, 9.0), sharex="col", sharey="row")
    for column, scan in enumerate(results.scans):
        for row, (axis, limits) in enumerate(paper.SPIN.items()):
            ax = axes[row, column]
            low, high = scan.ranges[:, row].T
            ax.fill_between(scan.values, low, high, color=LINES[0]["color"], alpha=0.25, linewidth=0)
            ax.plot(scan.values, low, scan.values, high, linewidth=1.2, **LINES[0])
            for value in limits:
                ax.axhline(value, color="0.1", **_PRINTED)
            axes[row, 0].set_ylabel(rf"$\hat\omega_{axis}$ [$10^{{-5}}$ rad/s]")
        ax = axes[3, column]
        ax.plot(scan.values, spin.misfit(scan.ranges), linewidth=1.2, **LINES[0])
        ax.set_yscale("log")
        if scan.unit == "deg":
            ax.xaxis.set_major_locator(matplotlib("ticker").MultipleLocator(45))
        ax.set_xlabel(fill(f"{scan.name} [{scan.unit}]", 28))
        for ax in axes[:, column]:
            grid(ax)
            ax.margins(x=0)
            ax.axvline(scan.stated, color="0.4", linewidth=1.0, linestyle=(0, (1, 1.2)))
    axes[3, 0].set_ylabel("largest difference from\nthe printed [$10^{-5}$ rad/s]")
    figure.suptitle(
        f"Range of Beta's spin in the first {paper.SPIN_HOURS:g} h by start; dashed: printed; dotted: stated"
    )
    figure.get_layout_engine().set(w_pad=0.08)
    return figure


def inclination(results: Results) -> Any:
    """Draw the inclination to the xy-plane over the year, and the nodal period by the orbit's inclination."""
    from astropy import units as u

    figure, axes = new_figure(2, 1, (7.0, 6.8))
    panel, periods_panel = axes[:, 0]
    for shape, run in results.runs.year.items():
        thinned = run[::16]
        style, nodal = SHAPES[shape], results.nodal[shape]
        panel.plot(thinned.time.to_value(u.hour), thinned.elements().i.to_value(u.deg), linewidth=1.2, **style)
        # The node of a polar orbit hardly moves, so that prograde and retrograde ones are apart.
        for side, name in ((nodal.inclination < _POLAR, style["label"]), (nodal.inclination > _POLAR, None)):
            tilts, periods = nodal.inclination[side], nodal.period[side]
            periods_panel.plot(tilts, periods, linewidth=1.5, marker=".", markersize=4.0, **{**style, "label": name})
        period = paper.YEAR[shape].inclination_period
        panel.axvline(period, color=style["color"], **_PRINTED)
        edge, shift = ("left", 3) if shape == "ellipsoid" else ("right", -3)
        placement = {
            "xycoords": panel.get_xaxis_transform(),
            "xytext": (shift, 0),
            "textcoords": "offset points",
            "ha": edge,
        }
        panel.annotate(f"{period:.0f} h", (period, 0.04), **placement, **_NOTE)
        periods_panel.axhline(period, color=style["color"], **_PRINTED)
        note = f"printed, {shape}s: {period:.0f} h"
        periods_panel.annotate(
            note, (_POLAR, period), (0, 2), textcoords="offset points", ha="center", va="bottom", **_NOTE
        )
    start = SKY["i"]
    periods_panel.axvline(start, color="0.4", linewidth=1.0)
    panel.set_ylabel("inclination to the\nxy-plane [deg]")
    periods_panel.set_ylabel("period of the node [h]")
    panel.set_xlabel("time [h]")
    periods_panel.set_xlabel(f"initial inclination of the orbit [deg]; vertical line: the paper's start, {start:g}")
    for ax, text in (
        (panel, "dashed: the printed periods, drawn from the start"),
        (periods_panel, "dashed: the printed periods"),
    ):
        ax.set_title(text, loc="left", fontsize="small")
        grid(ax)
        legend(ax, markerscale=1.0)
        ax.margins(x=0)
    periods_panel.set_xlim(0.0, 180.0)
    periods_panel.xaxis.set_major_locator(matplotlib("ticker").MultipleLocator(30))
    figure.suptitle("1999 KW4: inclination of the orbit")
    return figure


def physical(results: Results) -> Any:
    """Draw the eccentricity and Beta's spin of the physical states and of the paper's."""
    figure, axes = new_figure(4, len(results.physical), (10.5, 8.5), sharex=True, sharey="row")
    for column, (name, motion) in enumerate(results.physical.items()):
        run = results.runs.physical[name]
        rows = run.time <= _LENGTH
        hours = run.time[rows]
        panels = [run.elements().e[rows], *(run.spin[rows, 1].T * 1e5 / 3600.0)]
        for ax, values in zip(axes[:, column], panels, strict=True):
            ax.plot(hours, values, linewidth=0.7, color=LINES[0]["color"])
            grid(ax)
        swing = "circulates" if np.isnan(motion.libration) else f"libration {motion.libration:.1f} deg"
        axes[0, column].set_title(f"{fill(name, 16)}\n{swing}", fontsize="small")
        axes[-1, column].set_xlabel("time [h]")
    for ax in axes[1:3].flat:
        # The size of a motion that is too small for the axis is written as a number.
        values = ax.lines[0].get_ydata()
        low, high = ax.get_ylim()
        if np.ptp(values) < 0.1 * (high - low):
            note = f"within {np.abs(values).max():.1g}" if values.any() else "zero"
            ax.annotate(note, (0.97, 0.6), xycoords="axes fraction", ha="right", **_NOTE)
    axes[0, 0].set_xlim(0.0, _LENGTH)
    axes[0, 0].xaxis.set_major_locator(matplotlib("ticker").MultipleLocator(100))
    axes[0, 0].set_ylabel("eccentricity\n(dimensionless)")
    for row, axis in enumerate("xyz", start=1):
        axes[row, 0].set_ylabel(rf"$\hat\omega_{axis}$ [$10^{{-5}}$ rad/s]")
    figure.suptitle(f"1999 KW4: the paper's start and physical states (first {_LENGTH:g} h)")
    return figure
