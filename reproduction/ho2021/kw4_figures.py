"""The figures of the year of 1999 KW4, with the panels of the paper's."""

from __future__ import annotations

from typing import Any

import numpy as np
from fullbody import Run
from fullbody.base.figures import LINES, grid, legend, matplotlib

from . import kw4, paper
from .drawing import SHAPES, floor, largest, new_figure, windows

__all__ = ["all_figures"]

#: The number of orbits over which the range of an element is drawn as a band.
_ORBITS = 5
#: The length in hours of the windows in which the largest errors are drawn.
_WINDOW = 100.0


def all_figures(runs: dict[kw4.Shape, Run]) -> dict[str, Any]:
    """Return the three figures by name."""
    return {"elements": elements(runs), "beta_spin": beta_spin(runs), "errors": errors(runs)}


def elements(runs: dict[kw4.Shape, Run]) -> Any:
    """Draw eccentricity, semi-major axis and inclination to the first orbit's plane over the year."""
    figure = matplotlib("figure").Figure(figsize=(8.0, 7.5), layout="constrained")
    names = list(runs)
    axes = figure.subplot_mosaic([[f"e {s}" for s in names], [f"a {s}" for s in names], ["inclination"] * len(names)])
    width = _ORBITS * paper.YEAR["ellipsoid"].period
    # In a short run the oscillation itself can be seen.
    is_long = min(float(kw4.without_unit(run.time)[-1]) for run in runs.values()) > 10 * width
    tilt = axes["inclination"]
    for shape, run in runs.items():
        hours, orbit, style = kw4.without_unit(run.time), run.elements(), SHAPES[shape]
        line = {"color": style["color"], "linewidth": 0.9}
        for name, values in (("e", orbit.e), ("a", kw4.without_unit(orbit.a))):
            ax = axes[f"{name} {shape}"]
            if is_long:
                middle, low, high = windows(hours, values, width)
                ax.fill_between(middle, low, high, color=style["color"], alpha=0.3, linewidth=0.0)
                for edge in (low, high):
                    ax.plot(middle, edge, **line)
            else:
                ax.plot(hours, values, **line)
            # Both shapes have the same scale, which the legend of the first panel explains.
            first = axes[f"{name} {names[0]}"]
            ax.tick_params(labelbottom=name == "a", labelleft=ax is first)
            if ax is not first:
                ax.sharey(first)
            ax.margins(x=0)
            ax.locator_params(axis="x", nbins=5)
            grid(ax)
        title = f"range over {_ORBITS} orbits" if is_long else "each step"
        axes[f"e {shape}"].set_title(f"{style['label']}: {title}", fontsize="medium")
        thinned = run[::16] if is_long else run
        tilt.plot(kw4.without_unit(thinned.time), kw4.inclination_to_first(thinned), linewidth=1.3, **style)
    axes[f"e {names[0]}"].set_ylabel("eccentricity\n(dimensionless)")
    axes[f"a {names[0]}"].set_ylabel("semi-major axis [km]")
    tilt.set_ylabel("inclination to the\nfirst orbit's plane [deg]")
    tilt.set_xlabel("time [h]")
    tilt.margins(x=0)
    grid(tilt)
    legend(tilt)
    figure.align_ylabels()
    figure.suptitle("1999 KW4: Beta's osculating orbit about Alpha")
    return figure


def beta_spin(runs: dict[kw4.Shape, Run]) -> Any:
    """Draw Beta's angular velocity in its own frame over the first 200 hours."""
    figure, axes = new_figure(3, 1, (7.0, 6.5), sharex=True)
    until = 0.0
    for shape, run in runs.items():
        hours = kw4.without_unit(run.time)
        until = max(until, min(paper.SPIN_HOURS, float(hours[-1])))
        # One more sample is needed for the line to reach the edge.
        first = slice(0, int(np.searchsorted(hours, until)) + 1)
        spin = kw4.without_unit(run.spin)[first, 1] * (1e5 / 3600.0)
        for ax, component in zip(axes[:, 0], spin.T, strict=True):
            ax.plot(hours[first], component, linewidth=1.1, **SHAPES[shape])
    for ax, (axis, (low, high)) in zip(axes[:, 0], paper.SPIN.items(), strict=True):
        ax.axhspan(low, high, color="0.88", zorder=0, linewidth=0, label="range that the paper prints (ellipsoids)")
        ax.set_ylabel(rf"$\hat\omega_{axis}$ [$10^{{-5}}$ rad/s]")
    legend(axes[0, 0])
    axes[2, 0].set_xlim(0.0, until)
    axes[2, 0].set_xlabel("time [h]")
    figure.suptitle("1999 KW4: Beta's spin in its own frame")
    return figure


def errors(runs: dict[kw4.Shape, Run]) -> Any:
    """Draw errors of energy and angular momentum: from step to step, as in the paper, and since the start."""
    figure, axes = new_figure(2, 2, (10.0, 7.0), sharex=True)
    end = max(float(kw4.without_unit(run.time)[-1]) for run in runs.values())
    width = min(_WINDOW, end / 20)
    for shape, run in runs.items():
        hours, energy, style = kw4.without_unit(run.time), kw4.without_unit(run.energy), SHAPES[shape]
        axes[0, 0].plot(*largest(hours[1:], np.diff(energy) / energy[:-1], width), linewidth=1.2, **style)
        for drift, name, width_of_line in (
            (run.energy_drift_orbital, "of the orbital energy", 2.0),
            (run.energy_drift, "of the total", 1.0),
        ):
            label = f"{style['label']}, {name}"
            axes[0, 1].plot(*largest(hours, drift, width), **{**style, "linewidth": width_of_line, "label": label})
    run = runs["ellipsoid"]
    hours, momenta = kw4.without_unit(run.time), kw4.momentum_of_samples(run)
    step = np.diff(momenta, axis=0) / momenta[:-1]
    for k, axis in enumerate("xyz"):
        axes[1, 0].plot(*largest(hours[1:], step[:, k], width), linewidth=1.2, label=f"$J_{axis}$", **LINES[k])
    for k, (drift, name) in enumerate(
        (
            (kw4.drift(momenta), "r x m v of the bodies' positions"),
            (run.angular_momentum_drift, "barycentre's part separate"),
        )
    ):
        axes[1, 1].plot(*largest(hours, drift, width), linewidth=1.2, label=name, **LINES[k])
    for ax, name in zip(axes[0], ("step to step (the paper's)", "from the start"), strict=True):
        ax.set_title(name, pad=34.0)
    axes[0, 0].set_ylabel("error of the energy\n(relative)")
    axes[1, 0].set_ylabel("error of the angular momentum,\nellipsoids (relative, by component)")
    axes[1, 1].set_ylabel("the same (relative to its length)")
    for ax in axes.flat:
        ax.set_yscale("log")
        ax.set_xlim(0.0, end)
        grid(ax)
        legend(ax)
    floor(axes[0, 0], min(abs(kw4.without_unit(run.energy)[0]) for run in runs.values()))
    for ax in axes[1]:
        ax.set_xlabel("time [h]")
    figure.align_ylabels()
    figure.suptitle(f"1999 KW4: the largest errors in each {width:.3g} h")
    return figure
