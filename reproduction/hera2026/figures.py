"""The figures of the study: outcomes over axis ratios, angles of the last days, a night, and sensitivities."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline

from . import measures, posterior, weights
from .earth import NIGHT
from .inputs import ARRIVAL, STUDY_DATE

if TYPE_CHECKING:
    import xarray

__all__ = ["angles", "night", "outcomes", "sensitivity"]

#: The colour and the marker of each outcome; the colours differ also without red and green.
_STYLES = {
    "locked": ("#0072b2", "o"),
    "rolling": ("#e69f00", "^"),
    "end over end": ("#cc79a7", "s"),
    "unmeasured": ("0.6", "x"),
    "contact": ("k", "P"),
    "escape": ("k", "*"),
    "unfinished": ("0.3", "v"),
    "failed": ("0.3", "+"),
}


def outcomes(dataset: xarray.Dataset, axes_map: xarray.Dataset) -> Figure:
    """Draw members over their axis ratios, with areas by weight, over the day on which the first roll begins."""
    figure = Figure(figsize=(7.2, 5.4), layout="constrained")
    axes = figure.subplots()
    days = np.where(np.isfinite(axes_map.tumbling_time), axes_map.tumbling_time / 24.0, posterior.OBSERVED_DAYS)
    image = axes.pcolormesh(
        axes_map.a_b, axes_map.b_c, days.T, cmap="Greys", vmin=0, vmax=1.6 * posterior.OBSERVED_DAYS
    )
    bar = figure.colorbar(
        image, ax=axes, label="first day with a roll beyond 60 degrees (of 67)", boundaries=np.arange(0, 68)
    )
    bar.set_ticks([0, 20, 40, 60, 67], labels=["0", "20", "40", "60", "none"])
    weight = weights.normalized(dataset.log_weight.values)
    for word, (colour, mark) in _STYLES.items():
        rows = dataset.outcome.values == word
        if rows.any():
            size = 6.0 + 5000.0 * weight[rows]
            edges = [(0.0, 0.0, 0.0, 1.0 if change else 0.0) for change in dataset.changed.values[rows]]
            axes.scatter(
                dataset.a_b[rows],
                dataset.b_c[rows],
                s=size,
                facecolors=to_rgba(colour, 0.75),
                marker=mark,
                edgecolors=edges,
                label=f"{word}: {100 * weight[rows].sum():.0f} % of the weight",
            )
    axes.scatter([], [], s=34, facecolors="none", edgecolors="k", label="orbit changed in days 67 to 120")
    axes.set_xlabel("a/b of Dimorphos")
    axes.set_ylabel("b/c of Dimorphos")
    axes.set_xlim(1.12, 1.44)
    axes.set_ylim(1.0, 1.5)
    figure.legend(loc="outside upper center", fontsize=9, ncols=3, title=f"Dimorphos on {ARRIVAL[:10]}")
    return figure


def angles(dataset: xarray.Dataset, count: int = 12) -> Figure:
    """Draw yaw and roll over the last days of locked and of rolling members, between -90 and 90 degrees."""
    figure = Figure(figsize=(7.4, 4.8), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey="row", squeeze=False)
    hours = measures.SPACING * (np.arange(dataset.sizes["time"]) - dataset.sizes["time"] + 1)
    fine = np.linspace(hours[0], hours[-1], 20 * len(hours))
    words = dataset.outcome.values[dataset.member.values.astype(int)]
    for column, word in enumerate(("locked", "rolling")):
        angles_of_members = dataset.angles.values[words == word][:count].astype(float)
        panels[0, column].set_title(f"{len(angles_of_members)} {word} members", fontsize=10)
        panels[1, column].set_xlabel(f"hours before {ARRIVAL[:10]}")
        for axis, panel_row in zip(panels[:, column], (2, 0), strict=True):
            for member in angles_of_members:
                # An ellipsoid looks the same after half a rotation, and lines stop at the ends of the axis.
                angle = CubicSpline(hours, np.unwrap(member[:, panel_row], period=np.pi))(fine)
                angle = np.rad2deg((angle + np.pi / 2) % np.pi - np.pi / 2)
                angle[1:][np.abs(np.diff(angle)) > 90] = np.nan
                axis.plot(fine, angle, color=_STYLES[word][0], lw=0.9, alpha=0.7)
    for row, name in zip(panels, ("yaw", "roll"), strict=True):
        row[0].set_ylabel(f"{name} (degrees)")
        row[0].set_ylim(-90, 90)
        row[0].set_yticks([-90, -45, 0, 45, 90])
    return figure


def night(result: dict[str, Any]) -> Figure:
    """Draw the light curves of a night: the median and the middle 90 per cent of the members."""
    figure = Figure(figsize=(7.2, 3.6), layout="constrained")
    axes = figure.subplots()
    time, curves = np.asarray(result["time"]), np.asarray(result["magnitude"])
    low, middle, high = np.percentile(curves, [5, 50, 95], axis=0)
    axes.fill_between(time, low, high, color="#56b4e9", alpha=0.5, lw=0, label="90 per cent of the members")
    axes.plot(time, middle, color="#0072b2", lw=1.2, label="median")
    axes.invert_yaxis()
    axes.set_xlabel("hours after the middle of an occultation of Dimorphos")
    axes.set_ylabel("magnitude, relative")
    axes.set_title(f"a day of {NIGHT[:10]}, as of {STUDY_DATE}", fontsize=10)
    figure.legend(loc="outside lower center", fontsize=8, ncols=2)
    return figure


def sensitivity(table: dict[str, dict[str, float]]) -> Figure:
    """Draw the rank correlations of predicted quantities with the inputs."""
    figure = Figure(figsize=(7.6, 4.6), layout="constrained")
    axes = figure.subplots()
    values = np.array([list(row.values()) for row in table.values()])
    image = axes.imshow(values, cmap="RdBu_r", vmin=-1, vmax=1, aspect="auto")
    for (j, k), value in np.ndenumerate(values):
        if np.isfinite(value) and abs(value) > 0.3:
            axes.text(
                k, j, f"{value:.1f}", ha="center", va="center", fontsize=7, color="w" if abs(value) > 0.6 else "k"
            )
    axes.set_xticks(range(values.shape[1]), list(next(iter(table.values()))), rotation=55, ha="right", fontsize=8)
    axes.set_yticks(range(values.shape[0]), list(table), fontsize=8)
    figure.colorbar(image, ax=axes, label="rank correlation")
    return figure
