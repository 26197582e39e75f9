"""Figures of the light curves with the fit, and of the light that is lost in the events."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from fullbody.fitting import Fit
from matplotlib.figure import Figure

from .model import Light

__all__ = ["CAPTIONS", "curves", "losses"]

Floats = npt.NDArray[np.float64]

CAPTIONS = {
    "curves": "The four light curves with the fit of a series of order 10, two ellipsoids and a free albedo of Linus "
    "(upper panels), and the residuals in standard errors (lower panels). Grey: the times of mutual events that change "
    "the light.",
    "losses": "The loss of light in the mutual events: observed magnitudes, and those of the fit, minus those of the "
    "model without events, with the same zero points and series.",
}


def _nights(light: Light) -> list[tuple[int, npt.NDArray[np.bool_]]]:
    """Return the labels of the nights, each with the mask of its rows."""
    night = light.table["night"].to_numpy()
    return [(int(label), night == label) for label in np.unique(night)]


def curves(light: Light, fit: Fit) -> Figure:
    """Draw each night with the fit through it, and its residuals."""
    data, table = fit.observations[0], light.table
    predicted = np.asarray(data.magnitude - fit.residuals[0])
    hours = 24.0 * (table["jd_tdb"].to_numpy() - np.floor(table["jd_tdb"].to_numpy()))
    in_event = np.abs(_loss(light, fit)[1]) > 1e-3
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    axes = figure.subplots(2, 4, sharey="row", height_ratios=[2.5, 1.0])
    for column, (night, rows) in zip(axes.T, _nights(light), strict=True):
        upper, lower = column
        for panel in column:
            across = panel.get_xaxis_transform()
            panel.fill_between(hours[rows], 0.0, 1.0, in_event[rows], transform=across, color="0.9", lw=0)
        upper.plot(hours[rows], data.magnitude[rows], ".", ms=2.5, color="0.45")
        upper.plot(hours[rows], predicted[rows], color="C3", lw=1.0)
        upper.set_title(f"series {night}, JD {np.floor(table['jd_tdb'].to_numpy()[rows][0]):.0f}", fontsize=9)
        lower.plot(hours[rows], fit.pulls[0][rows, 0], ".", ms=2.0, color="0.45")
        lower.axhline(0.0, color="C3", lw=0.8)
        lower.set_xlabel("hours (TDB) after the Julian day")
    axes[0, 0].invert_yaxis()
    axes[0, 0].set_ylabel("magnitude")
    axes[1, 0].set_ylabel("residual / error")
    return figure


def _loss(light: Light, fit: Fit) -> tuple[Floats, Floats]:
    """Return the observed and the predicted loss of light in magnitudes, against the model without events."""
    data = fit.observations[0]
    without_events = light.data(mutual=False, albedo=fit.values["albedo"]).predict(fit.run, fit.linear[0])
    return np.asarray(data.magnitude - without_events), np.asarray(data.magnitude - fit.residuals[0] - without_events)


def losses(light: Light, fit: Fit) -> Figure:
    """Draw the loss of light in the events of each night, observed and fitted."""
    observed, predicted = _loss(light, fit)
    hours = 24.0 * (light.table["jd_tdb"].to_numpy() - np.floor(light.table["jd_tdb"].to_numpy()))
    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    for axes, (night, rows) in zip(figure.subplots(1, 4, sharey=True), _nights(light), strict=True):
        axes.plot(hours[rows], observed[rows], ".", ms=2.5, color="0.45")
        axes.plot(hours[rows], predicted[rows], color="C3", lw=1.2)
        axes.set_title(f"series {night}", fontsize=9)
        axes.set_xlabel("hours (TDB) after the Julian day")
    figure.axes[0].invert_yaxis()
    figure.axes[0].set_ylabel("loss of light [mag]")
    return figure
