"""The figures of ``fullbody kw4``, laid out like the paper's."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import paper
from ..run import Run

_STYLES = {
    "ellipsoid": {"color": "#0072b2", "linestyle": "-", "label": "ellipsoids"},
    "spheroid": {"color": "#d55e00", "linestyle": ":", "label": "spheroids"},
}
_AXES = {"x": "#0072b2", "y": "#d55e00", "z": "#222222"}


def all_figures(runs: dict[str, Run]) -> dict[str, Any]:
    """The three figures by name."""
    return {"elements": elements(runs), "beta_spin": beta_spin(runs), "errors": errors(runs)}


def _figure(rows: int, height: float) -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, height), layout="constrained")
    return figure, figure.subplots(rows, 1, sharex=True)


def elements(runs: dict[str, Run]) -> Any:
    """Eccentricity, semi-major axis and inclination to the first orbit's plane over the year."""
    from astropy import units as u

    from .kw4 import inclination_to_first

    figure, axes = _figure(3, 7.0)
    for shape, run in runs.items():
        hours = run.time.to_value(u.hour)
        orbit = run.elements()
        style = {**_STYLES[shape], "linewidth": 0.5, "alpha": 0.8}
        for ax, values in zip(axes, (orbit.e, orbit.a.to_value(u.km), inclination_to_first(run)), strict=True):
            # The fast oscillation fills a band: draw its edges, orbit by orbit, and the band between them.
            low, high, middle = _envelope(hours, values, 17.4)
            ax.fill_between(middle, low, high, color=style["color"], alpha=0.25, linewidth=0)
            for edge in (low, high):
                ax.plot(middle, edge, color=style["color"], linestyle=style["linestyle"], linewidth=0.9)
        axes[0].plot([], [], **_STYLES[shape])
    for ax, label in zip(
        axes, ("eccentricity", "semi-major axis [km]", "inclination to\nthe first orbit [deg]"), strict=True
    ):
        ax.set_ylabel(label)
        ax.margins(x=0)
    axes[0].legend(loc="upper right", ncols=2, title="range over each orbit")
    axes[0].set_ylim(top=0.0205)
    axes[-1].set_xlabel("time [h]")
    figure.suptitle("1999 KW4: Beta's osculating orbit about Alpha")
    return figure


def beta_spin(runs: dict[str, Run]) -> Any:
    """Beta's angular velocity in its own frame over the first 200 hours."""
    from astropy import units as u

    figure, axes = _figure(3, 6.5)
    for shape, run in runs.items():
        hours = run.time.to_value(u.hour)
        first = hours <= 200.0
        spin = run.spin[first, 1].to_value(u.rad / u.s) * 1e5
        for ax, component in zip(axes, spin.T, strict=True):
            ax.plot(hours[first], component, linewidth=1.0, **_STYLES[shape])
    for ax, (axis, (low, high)) in zip(axes, paper.KW4_SPIN.items(), strict=True):
        ax.axhspan(low, high, color="0.85", zorder=0, label="range the paper prints (ellipsoids)")
        ax.set_ylabel(rf"$\hat\omega_{axis}$ [$10^{{-5}}$ rad/s]")
        ax.margins(x=0)
    axes[0].legend(loc="upper center", ncols=3, bbox_to_anchor=(0.5, 1.28), frameon=False)
    axes[-1].set_xlabel("time [h]")
    figure.suptitle("1999 KW4: Beta's spin in its own frame")
    return figure


def errors(runs: dict[str, Run]) -> Any:
    """Errors of the energy and of the angular momentum: from step to step, as in the paper, and from the start."""
    from astropy import units as u

    figure, axes = _figure(2, 6.0)
    for shape, run in runs.items():
        hours = run.time.to_value(u.hour)
        energy = run.energy.value
        colour = _STYLES[shape]["color"]
        step = np.abs(np.diff(energy) / energy[:-1])
        axes[0].plot(hours[1:], positive(step), ".", color=colour, alpha=0.3, markersize=1.5, rasterized=True)
        axes[0].plot(hours, positive(np.abs(run.energy_drift_orbital)), color=colour, linewidth=0.7)
    momentum = runs["ellipsoid"].angular_momentum.value
    hours = runs["ellipsoid"].time.to_value(u.hour)
    for k, (axis, colour) in enumerate(_AXES.items()):
        drift = np.abs((momentum[:, k] - momentum[0, k]) / momentum[0, k])
        axes[1].plot(hours, positive(drift), color=colour, linewidth=0.8, label=f"$J_{axis}$")
    axes[0].set_ylabel("relative energy error")
    axes[0].set_title("dots: step to step; lines: from the start, relative to the orbital energy", fontsize="medium")
    for shape in runs:
        axes[0].plot([], [], color=_STYLES[shape]["color"], label=_STYLES[shape]["label"])
    axes[1].set_ylabel("relative error of the angular\nmomentum, from the start")
    axes[1].set_title("ellipsoids, by component", fontsize="medium")
    for ax in axes:
        ax.set_yscale("log")
        ax.margins(x=0)
    # Clear of the curves: below the upper panel, and in the lower one's empty corner.
    axes[0].legend(loc="upper center", ncols=2, bbox_to_anchor=(0.5, -0.02), frameon=False)
    axes[1].set_ylim(top=2e-11)
    axes[1].legend(loc="upper left", ncols=3, frameon=False)
    axes[-1].set_xlabel("time [h]")
    return figure


def positive(values: Any) -> Any:
    """Zeros as gaps, for a logarithmic axis."""
    return np.where(values > 0, values, np.nan)


def _envelope(hours: Any, values: Any, width: float) -> tuple[Any, Any, Any]:
    """Smallest and largest value in windows of a width, and the windows' middles."""
    starts = np.unique(np.searchsorted(hours, np.arange(hours[0], hours[-1], width)))
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    ends = np.append(starts[1:], len(hours)) - 1
    return low, high, 0.5 * (hours[starts] + hours[ends])
