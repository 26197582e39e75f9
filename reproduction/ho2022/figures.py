"""Maps of fates over tilt and mass ratio, and the times of secondary fission."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch

if TYPE_CHECKING:
    import xarray

__all__ = ["all_figures"]

_COLOURS = {"bound": "#3b528b", "escape": "#f2c14e"}


def all_figures(dataset: xarray.Dataset) -> dict[str, Figure]:
    """Return a map of fates for each excess, and the times."""
    maps = {f"fates-{k}": _fates(dataset.sel(excess=excess)) for k, excess in enumerate(dataset.excess.values)}
    return maps | {"fission": _times(dataset)}


def _fates(part: xarray.Dataset) -> Figure:
    figure = Figure(figsize=(11, 6.6), layout="constrained")
    axes = figure.subplots(2, 3, sharex=True, sharey=True)
    image: Any = None
    for axis, case in zip(axes.flat, part.case.values, strict=True):
        selected = part.sel(case=case)
        coordinates = (selected.tilt.values, selected.mass_ratio.values)
        for fate, colour in _COLOURS.items():
            mask = np.where(selected.fate.values == fate, 1.0, np.nan)
            axis.pcolormesh(*coordinates, mask, cmap=ListedColormap([colour]), shading="nearest")
        ends = np.where(selected.fate.values == "contact", selected.fate_time.values, np.nan)
        image = axis.pcolormesh(*coordinates, ends, cmap="Greens_r", norm=LogNorm(5e-3, 5e3), shading="nearest")
        share = 100 * float((selected.fate == "contact").mean())
        axis.set_title(f"{case}: {share:.0f} % impacts", fontsize=10)
    for axis in axes[-1]:
        axis.set_xlabel("tilt of the secondary [deg]")
    for axis in axes[:, 0]:
        axis.set_ylabel("mass ratio")
    figure.colorbar(image, ax=axes, label="time of the impact [h]", shrink=0.8)
    figure.legend(
        handles=[Patch(color=colour, label=fate) for fate, colour in _COLOURS.items()],
        loc="outside upper right",
        ncols=2,
    )
    excess = float(part.excess)
    start = "at the fission limit" if excess == 0.0 else f"{100 * excess:g} per cent above the fission limit"
    figure.suptitle(f"Fates of two ellipsoids that start {start}", x=0.02, ha="left")
    return figure


def _times(dataset: xarray.Dataset) -> Figure:
    figure = Figure(figsize=(9, 4), layout="constrained")
    bins = np.geomspace(0.05, 5000.0, 41)
    for axis, excess in zip(
        figure.subplots(1, dataset.sizes["excess"], sharey=True), dataset.excess.values, strict=True
    ):
        part = dataset.sel(excess=excess).fission
        times = [part.sel(case=case).values.ravel() for case in dataset.case.values]
        times = [values[np.isfinite(values)] for values in times]
        labels = [f"{case}: {len(values)}" for case, values in zip(dataset.case.values, times, strict=True)]
        axis.hist(times, bins, stacked=True, label=labels)
        axis.axvline(5.0, color="k", lw=1, ls="--")
        axis.set_xscale("log")
        axis.set_title("at the fission limit" if excess == 0.0 else f"{100 * excess:g} per cent above it", fontsize=10)
        axis.set_xlabel("time of secondary fission [h]; dashed: 5 h")
        axis.legend(fontsize=8, title="runs")
    figure.axes[0].set_ylabel("runs")
    return figure
