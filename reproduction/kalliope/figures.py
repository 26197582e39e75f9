"""Figures of the light curves with the fit, of the loss of light in the events, and of the free form."""

from __future__ import annotations

import fullbody
import numpy as np
import numpy.typing as npt
from fullbody.fitting import Fit
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from .freeform import principal
from .model import AXES, Light

__all__ = ["CAPTIONS", "curves", "losses", "shape"]

Floats = npt.NDArray[np.float64]

CAPTIONS = {
    "curves": "The four light curves with the fit of a series of order 10, two ellipsoids and a free albedo of Linus "
    "(upper panels), and the residuals in standard errors (lower panels). Grey: the times of mutual events that change "
    "the light.",
    "losses": "The loss of light in the mutual events: observed magnitudes, and those of the fit, minus those of the "
    "model without events, with the same zero points and series.",
    "shape_curves": "The four light curves with the fit of a free form of Kalliope, without a series (upper panels), "
    "and the residuals in standard errors (lower panels). Grey: the times of mutual events that change the light.",
    "shape": "The free form of Kalliope along its principal axes, with the faces shaded by their inclination to the "
    "viewer, the outline of the ellipsoid of the other fits (dashed), and Linus to scale.",
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
            transform = panel.get_xaxis_transform()
            panel.fill_between(hours[rows], 0.0, 1.0, in_event[rows], transform=transform, color="0.9", lw=0)
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
    """Return the observed and the predicted loss of light in magnitudes, relative to the model without events."""
    data = fit.observations[0]
    order = 0 if data.rotation is None else data.rotation.order
    model = light.data(order=order, mutual=False, albedo=fit.values["albedo"])
    without_events = model.predict(fit.run, fit.linear[0])
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


def shape(polyhedron: fullbody.Polyhedron, radius: float) -> Figure:
    """Draw a polyhedron along its three principal axes, beside a sphere of a radius in km."""
    solid = principal(polyhedron)
    corners = np.asarray(solid.vertices)[np.asarray(solid.faces)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    extent = max(float(np.abs(corners).max()), max(AXES))
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    circle = np.array([np.cos(angle), np.sin(angle)])
    figure = Figure(figsize=(11.0, 3.8), layout="constrained")
    for axes, viewed in zip(figure.subplots(1, 3, sharey=True), (2, 1, 0), strict=True):
        right, up = [(0, 1), (0, 2), (1, 2)][2 - viewed]
        # Seen along y, x points to the left.
        sign = -1.0 if viewed == 1 else 1.0
        visible = normals[:, viewed] > 0.0
        order = np.argsort(corners[visible][:, :, viewed].mean(axis=1))
        grey = (0.25 + 0.7 * normals[visible, viewed])[order]
        flat = corners[visible][order][:, :, [right, up]] * [sign, 1.0]
        colours = np.repeat(grey[:, None], 3, axis=1)
        axes.add_collection(PolyCollection(list(flat), facecolors=colours, edgecolors=colours, linewidths=0.3))
        axes.plot(AXES[right] * circle[0], AXES[up] * circle[1], "--", color="C3", lw=1.0)
        axes.add_patch(Circle((extent + 1.5 * radius, -extent + radius), radius, facecolor="0.75", edgecolor="0.3"))
        axes.set(xlabel=f"{'-' if sign < 0 else ''}{'xyz'[right]} [km]", ylabel=f"{'xyz'[up]} [km]", aspect="equal")
        axes.set(xlim=(-1.1 * extent, 1.1 * extent + 3.0 * radius), ylim=(-1.1 * extent, 1.1 * extent))
    return figure
