"""Figures of the scans, of the light curves with the fit, and of the shape."""

from __future__ import annotations

import fullbody
import numpy as np
import numpy.typing as npt
from fullbody.fitting import Fit
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from .chords import Size
from .model import shape
from .study import POLES, Results

__all__ = ["CAPTIONS", "all_figures"]

Floats = npt.NDArray[np.float64]

CAPTIONS = {
    "scans": "Chi2 over the degrees of freedom against the sidereal period, with a convex shape of degree 3 and a pole "
    "fitted at each: the nights of one apparition (above), and all nights near its lowest minimum (below).",
    "curves": "The sixteen longest of the light curves of nights, with the fit: magnitudes without their zero points "
    "against hours from the first of each.",
    "shape": "The convex shape from two sides of its equator, 90 degrees apart, and from its pole, lit from the "
    "direction of view. Relative light does not tell the size.",
    "chords": "The chords of the occultation in the plane of the sky, with the outline of the shape from light at its "
    "best pole (left) and at the mirror pole (right), scaled to fit them.",
}
#: The number of light curves in their figure.
CURVES = 16


def all_figures(results: Results) -> dict[str, Figure]:
    """Return all figures by name."""
    return {
        "scans": _scans(results),
        "curves": _curves(results.best),
        "shape": _shape(results.best),
        "chords": _chords(results.sizes),
    }


def _scans(results: Results) -> Figure:
    figure = Figure(figsize=(8.0, 6.0), layout="constrained")
    for axes, scan in zip(figure.subplots(2, 1), (results.coarse, results.scan), strict=True):
        scan.plot(axes)
    return figure


def _curves(fit: Fit) -> Figure:
    data = fit.observations[0]
    night = data.to_table()["night"]
    names, counts = np.unique(night, return_counts=True)
    longest = sorted(
        names[np.argsort(-counts, kind="stable")[:CURVES]], key=lambda name: data.times[night == name][0].jd
    )
    predicted = np.asarray(data.magnitude - fit.residuals[0])
    figure = Figure(figsize=(11.0, 8.0), layout="constrained")
    for axes, name in zip(figure.subplots(4, 4).flat, longest, strict=False):
        rows = np.flatnonzero(night == name)
        zero = fit.linear[0][f"zero point of {name}"]
        hours = (data.times[rows] - data.times[rows[0]]).to_value("h")
        axes.plot(hours, data.magnitude[rows] - zero, ".", ms=3.0, color="0.45")
        axes.plot(hours, predicted[rows] - zero, color="C3", lw=1.0)
        axes.set_title(f"{name}, {data.times[rows[0]].utc.strftime('%Y-%m-%d')}", fontsize=8)
        axes.tick_params(labelsize=7)
        axes.invert_yaxis()
    figure.supxlabel("hours from the first magnitude", fontsize=9)
    figure.supylabel("magnitude without its zero point", fontsize=9)
    return figure


def _shape(fit: Fit) -> Figure:
    solid = shape(fit.values["coefficients"]).polyhedron()
    vertices = np.asarray(solid.vertices.to_value("km"))
    vertices = vertices / np.cbrt(3.0 / (4.0 * np.pi) * solid.volume.to_value("km3"))
    faces = np.asarray(solid.faces)
    figure = Figure(figsize=(10.0, 3.7), layout="constrained")
    for axes, view, title in zip(
        figure.subplots(1, 3),
        ((0.0, 0.0), (90.0, 0.0), (0.0, 90.0)),
        ("longitude 0", "longitude 90 degrees", "pole"),
        strict=True,
    ):
        _draw(axes, vertices, faces, np.radians(view))
        axes.set_title(title, fontsize=9)
    return figure


def _chords(sizes: dict[str, Size]) -> Figure:
    best = [sizes[name] for name in (f"shape from light, {pole}" for pole in POLES) if name in sizes]
    figure = Figure(figsize=(5.0 * len(best), 4.8), layout="constrained")
    for axes, size in zip(np.atleast_1d(figure.subplots(1, len(best))), best, strict=True):
        size.fit.observations[0].plot(size.fit.run, axes)
        axes.set_title(f"diameter {size.diameter:.1f} km, chi2 {size.fit.chi2:.0f}", fontsize=9)
    return figure


def _draw(axes: object, vertices: Floats, faces: npt.NDArray[np.int64], view: Floats) -> None:
    """Draw the faces visible from a direction (longitude, latitude), as bright as their cosines of incidence."""
    direction = fullbody.frames.pole_vector(*view)
    sine, cosine = np.sin(view), np.cos(view)
    up = np.array([-sine[1] * cosine[0], -sine[1] * sine[0], cosine[1]])
    right = np.cross(up, direction)
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    incidence = normals @ direction / np.linalg.norm(normals, axis=1)
    visible = incidence > 0.0
    flat = np.stack([corners @ right, corners @ up], axis=-1)[visible]
    grey = np.repeat(0.2 + 0.75 * incidence[visible, None], 3, axis=1)
    axes.add_collection(PolyCollection(flat, facecolors=grey, edgecolors=grey, linewidths=0.3))  # type: ignore[attr-defined]
    axes.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5), aspect="equal", xlabel="radii of equal volume")  # type: ignore[attr-defined]
