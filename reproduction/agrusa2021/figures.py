"""The maps of roll, pitch and yaw, with the resonances of the linear theory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .theory import RESONANCES, frequencies

if TYPE_CHECKING:
    import xarray

__all__ = ["all_figures"]

_COLOURS = ("#e41a1c", "#ff7f00", "#ffffff", "#f781bf", "#4daf4a", "#00e5ff", "#a6d854", "#ffff33", "#cab2d6")


def all_figures(dataset: xarray.Dataset) -> dict[str, Figure]:
    """Return the only map, by its name."""
    return {"map": _map(dataset)}


def _map(dataset: xarray.Dataset) -> Figure:
    figure = Figure(figsize=(12, 8.2), layout="constrained")
    betas = dataset.beta.values
    axes = figure.subplots(len(betas), 3, sharex=True, sharey=True, squeeze=False)
    a_b, b_c = (np.linspace(dataset[name].values[0], dataset[name].values[-1], 300) for name in ("a_b", "b_c"))
    triple = frequencies(*np.meshgrid(a_b, b_c, indexing="ij"))
    image: Any = None
    drawn: dict[str, Line2D] = {}
    for row, beta in zip(axes, betas, strict=True):
        for axis, name in zip(row, ("roll", "pitch", "yaw"), strict=True):
            values = np.rad2deg(dataset[f"largest_{name}"].sel(beta=beta).values).T
            image = axis.pcolormesh(
                dataset.a_b, dataset.b_c, values, vmin=0, vmax=180, cmap="viridis", shading="nearest"
            )
            for colour, (label, combination) in zip(_COLOURS, RESONANCES.items(), strict=True):
                values = combination(*triple)
                if values.min() < 0.0 < values.max():
                    axis.contour(a_b, b_c, values.T, levels=[0.0], colors=colour, linewidths=1.3)
                    drawn[label] = Line2D([], [], color=colour, lw=2, label=label)
            axis.set_title(f"largest {name}, beta = {beta:g}", fontsize=10)
    for axis in axes[-1]:
        axis.set_xlabel("a/b")
    for axis in axes[:, 0]:
        axis.set_ylabel("b/c")
    figure.colorbar(image, ax=axes, label="degrees; 180 or more in one colour", shrink=0.8)
    legend = figure.legend(handles=list(drawn.values()), loc="outside lower center", ncols=3, fontsize=9)
    legend.get_frame().set_facecolor("0.45")
    for text in legend.get_texts():
        text.set_color("white")
    return figure
