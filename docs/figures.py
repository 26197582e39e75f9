"""Figures of the theory's pages: each function returns a figure of matplotlib."""

from __future__ import annotations

from typing import Any

import fullbody
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Arc, Circle, Ellipse, FancyArrowPatch, Polygon

__all__ = [
    "byorp",
    "cost_of_distance",
    "focal_ellipse",
    "freely_falling",
    "lune",
    "radiation_by_obliquity",
    "roll_pitch_yaw",
]

_BODY, _LIGHT = "#d8c9a3", "#f5d76e"


def focal_ellipse() -> Any:
    """Draw an ellipsoid, confocal ones inside it, and the ellipse to which they shrink."""
    a, b, c = 1.0, 0.8, 0.55
    p, q = np.sqrt(a * a - c * c), np.sqrt(b * b - c * c)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.9), layout="constrained")
    for part in (1.0, 0.6, 0.3, 0.1):
        # The squares of all semi-axes differ by the same number.
        shift = c * c * (1.0 - part)
        width, height = 2.0 * np.sqrt(a * a - shift), 2.0 * np.sqrt(c * c - shift)
        outer = part == 1.0
        left.add_patch(Ellipse((0, 0), width, height, fc=_BODY if outer else "none", ec="C0", lw=1.0 + outer))
    left.plot([-p, p], [0, 0], "C3", lw=3)
    left.set(title="in the xz-plane", xlabel="x", ylabel="z")
    left.annotate("focal ellipse", (0.5 * p, 0.0), (0.25, -0.85), arrowprops={"arrowstyle": "->"})
    left.annotate("confocal ellipsoids", (0.0, np.sqrt(0.3) * c), (-0.95, 0.75), arrowprops={"arrowstyle": "->"})
    x, y = np.meshgrid(np.linspace(-p, p, 201), np.linspace(-q, q, 201))
    inside = 1.0 - (x / p) ** 2 - (y / q) ** 2
    density = np.where(inside > 0.0, np.sqrt(np.abs(inside)), np.nan)
    right.add_patch(Ellipse((0, 0), 2 * a, 2 * b, fc=_BODY, ec="C0", lw=2))
    drawn = right.pcolormesh(x, y, density, cmap="Reds", vmin=0.0, shading="auto")
    figure.colorbar(drawn, ax=right, label="surface density, centre = 1")
    nodes, _ = np.polynomial.legendre.leggauss(9)
    radii = np.sqrt(1.0 - nodes[nodes > 1e-9] ** 2)
    angles = 2.0 * np.pi * (np.arange(14) + 0.5) / 14
    right.plot(p * np.outer(radii, np.cos(angles)), q * np.outer(radii, np.sin(angles)), "k.", ms=3)
    right.set(title="in the xy-plane, with nodes of the rule", xlabel="x", ylabel="y")
    for axes in (left, right):
        axes.set(aspect="equal", xlim=(-1.1, 1.1), ylim=(-1.0, 1.0))
    return figure


def lune() -> Any:
    """Draw the visible and illuminated part of the unit sphere: seen from its pole, and as a lune."""
    angle = np.radians(70.0)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 4.2), layout="constrained")
    left.add_patch(Circle((0, 0), 1, fc="0.92", ec="k"))
    half = np.linspace(-np.pi / 2, np.pi / 2, 100)
    lit = np.linspace(angle - np.pi / 2, np.pi / 2, 100)
    left.fill(np.concatenate([[0], np.cos(lit)]), np.concatenate([[0], np.sin(lit)]), color=_LIGHT, zorder=2)
    left.plot(1.05 * np.cos(half), 1.05 * np.sin(half), "C0", lw=3, label="visible")
    left.plot(1.11 * np.cos(half + angle), 1.11 * np.sin(half + angle), "C1", lw=3, label="illuminated")
    for direction, name, colour in ((0.0, r"$\mathbf{p}$, observer", "C0"), (angle, r"$\mathbf{q}$, Sun", "C1")):
        tip = 1.55 * np.array([np.cos(direction), np.sin(direction)])
        left.annotate("", tip, (0, 0), arrowprops={"arrowstyle": "->", "color": colour, "lw": 2}, zorder=3)
        left.text(*(tip + np.array([0.0, 0.1])), name, color=colour, ha="center")
    left.add_patch(Arc((0, 0), 0.6, 0.6, theta1=0, theta2=70, zorder=4))
    left.text(0.36, 0.24, r"$\alpha$", zorder=4)
    for longitude, name in ((angle - np.pi / 2, r"terminator, $l=\alpha-\pi/2$"), (np.pi / 2, r"limb, $l=\pi/2$")):
        left.plot([0, np.cos(longitude)], [0, np.sin(longitude)], "k:", zorder=3)
        left.text(
            1.3 * np.cos(longitude) - 0.1,
            1.3 * np.sin(longitude),
            name,
            ha="right" if longitude > 1 else "left",
            va="center",
        )
    left.legend(loc="lower left", frameon=False)
    left.set(xlim=(-1.7, 2.4), ylim=(-1.5, 1.8), title=r"from the pole, along $\mathbf{p}\times\mathbf{q}$")
    right.add_patch(Circle((0, 0), 1, fc="0.6", ec="k"))
    tilt = np.linspace(-np.pi / 2, np.pi / 2, 100)
    # In the view along p the point of longitude l is at sin l, and the height z is upwards.
    edge = np.sin(angle - np.pi / 2)
    limb, terminator = (np.stack([x * np.cos(tilt), np.sin(tilt)], axis=1) for x in (1.0, edge))
    right.add_patch(Polygon(np.concatenate([limb, terminator[::-1]]), fc=_LIGHT, ec="k"))
    for z in (-0.6, -0.3, 0.0, 0.3, 0.6):
        rho = np.sqrt(1.0 - z * z)
        right.plot([edge * rho, rho], [z, z], "k", lw=0.8)
    right.annotate("a parallel", (0.6, 0.3), (1.05, 0.75), arrowprops={"arrowstyle": "->"})
    right.annotate("terminator", (edge * 0.8, -0.6), (-1.45, -1.15), arrowprops={"arrowstyle": "->"})
    right.annotate("limb", (0.8, -0.6), (1.05, -1.0), arrowprops={"arrowstyle": "->"})
    right.set(xlim=(-1.6, 1.7), ylim=(-1.4, 1.4), title="as the observer sees it")
    for axes in (left, right):
        axes.set(aspect="equal")
        axes.axis("off")
    return figure


def roll_pitch_yaw() -> Any:
    """Draw a body in the frame of its orbit, with the senses of the three angles."""
    figure = plt.figure(figsize=(7.5, 3.8))
    axes = figure.add_axes((-0.15, -0.42, 1.05, 1.6), projection="3d")
    u, v = np.mgrid[0 : 2 * np.pi : 60j, 0 : np.pi : 30j]
    axes.plot_surface(
        np.cos(u) * np.sin(v), 0.65 * np.sin(u) * np.sin(v), 0.5 * np.cos(v), color=_BODY, alpha=0.9, linewidth=0
    )
    arc = np.linspace(0.0, 1.6 * np.pi, 60)
    circle = 0.28 * np.stack([np.cos(arc), np.sin(arc)])
    texts = (
        (np.array([2.4, 0, 0]), "x, to the other body", "roll", "C0"),
        (np.array([0, 1.9, 0]), "y", "pitch", "C2"),
        (np.array([0, 0, 1.5]), "z, normal of the orbit", "yaw", "C3"),
    )
    for index, (tip, name, angle, colour) in enumerate(texts):
        axes.quiver(0, 0, 0, *tip, color=colour, arrow_length_ratio=0.08, lw=2)
        axes.text(*(1.06 * tip), name, color=colour)
        ring = np.zeros((3, len(arc)))
        ring[(index + 1) % 3], ring[(index + 2) % 3] = circle
        ring += 0.75 * tip[:, None]
        axes.plot(*ring, color=colour)
        axes.quiver(*ring[:, -1], *(ring[:, -1] - ring[:, -4]), color=colour, length=1.0, arrow_length_ratio=2.0)
        axes.text(*(0.75 * tip + 0.42 * np.roll([0, 0, 1], index)), angle, color=colour)
    # The secondary moves against y: x points to the primary, and z is along the normal of the orbit.
    axes.quiver(0, -0.7, 0, 0, -1.0, 0, color="k", arrow_length_ratio=0.15)
    axes.text(0, -1.8, 0.12, "motion", ha="right")
    axes.set(xlim=(-1.2, 2.2), ylim=(-1.7, 1.7), zlim=(-1.2, 1.6))
    axes.set_box_aspect((3.4, 3.4, 2.8))
    axes.view_init(elev=24, azim=-50)
    axes.axis("off")
    return figure


def freely_falling() -> Any:
    """Draw the path of a third body, and its acceleration in the freely falling frame."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained", width_ratios=(1.25, 1))
    sun, middle = np.array([3.4, 1.2]), np.zeros(2)
    bodies = ((np.array([-0.25, -0.12]), 0.3), (np.array([0.75, 0.36]), 0.14))
    path = np.linspace(-0.75, 0.75, 50)
    left.plot(*(np.array([3.6, 0.0])[:, None] + np.stack([-0.35 * path**2, 2.0 * path])), "C1--", lw=1)
    left.add_patch(Circle(sun, 0.22, fc=_LIGHT, ec="C1"))
    left.text(sun[0] + 0.3, sun[1] + 0.1, "third body, on a\nprescribed path", color="C1")
    for centre, radius in bodies:
        left.add_patch(Circle(centre, radius, fc=_BODY, ec="k"))
    body = bodies[1][0]
    for start, end, name, colour, shift in (
        (middle, sun, r"$\mathbf{p}$", "C0", (0.0, -0.22)),
        (middle, body, r"$\mathbf{r}$", "C2", (-0.12, 0.14)),
        (sun, body, r"$\mathbf{d}=\mathbf{r}-\mathbf{p}$", "C3", (0.0, 0.2)),
    ):
        left.annotate("", end, start, arrowprops={"arrowstyle": "->", "color": colour, "lw": 1.8})
        left.text(*((start + end) / 2 + shift), name, color=colour, ha="center")
    left.plot(0, 0, "k+", ms=10)
    left.annotate("nominal barycentre,\nat rest in this frame", (0, 0), (-1.5, -1.35), arrowprops={"arrowstyle": "->"})
    left.set(xlim=(-1.6, 5.4), ylim=(-1.6, 1.9), title="positions")
    x, y = np.meshgrid(np.linspace(-1.2, 1.2, 9), np.linspace(-1.2, 1.2, 9))
    direction = sun / np.linalg.norm(sun)
    component = x * direction[0] + y * direction[1]
    # For a distant body the acceleration is 3 (r.p) p - r with a unit vector p, in units of mu/p^3.
    right.quiver(
        x, y, 3 * component * direction[0] - x, 3 * component * direction[1] - y, color="C0", scale=28, width=0.006
    )
    for centre, radius in bodies:
        right.add_patch(Circle(centre, radius, fc=_BODY, ec="k", zorder=3))
    right.plot(0, 0, "k+", ms=10, zorder=4)
    right.annotate("", 2.3 * direction, 1.6 * direction, arrowprops={"arrowstyle": "->", "color": "C1", "lw": 1.8})
    right.text(1.65, 0.35, "to the third body", color="C1")
    right.set(xlim=(-1.7, 3.0), ylim=(-1.5, 1.5), title="acceleration $\\mathbf{a}$ in this frame")
    for axes in (left, right):
        axes.set(aspect="equal")
        axes.axis("off")
    return figure


def byorp() -> Any:
    """Draw a secondary of unequal sides on its orbit, and the mean force of the light."""
    figure, axes = plt.subplots(figsize=(5.6, 4.6), layout="constrained")
    axes.add_patch(Circle((0, 0), 1.0, fc="none", ec="0.6", ls="--"))
    axes.add_patch(Circle((0, 0), 0.28, fc=_BODY, ec="k"))
    for longitude in np.radians([20.0, 110.0, 200.0, 290.0]):
        cosine, sine = np.cos(longitude), np.sin(longitude)
        radial, forward = np.array([cosine, sine]), np.array([-sine, cosine])
        # A wedge: its trailing side is broad and flat, its leading side narrow.
        corners = ((1.16, 0.0), (0.84, 0.0), (0.95, 0.16), (1.05, 0.16))
        axes.add_patch(Polygon([r * radial + s * forward for r, s in corners], fc=_BODY, ec="k", zorder=3))
        ends = radial + 0.16 * forward, radial + 0.5 * forward
        axes.add_patch(FancyArrowPatch(*ends, color="C3", arrowstyle="-|>", mutation_scale=14))
        axes.plot(*np.stack([0.3 * radial, 0.84 * radial]).T, color="0.7", lw=0.8)
    axes.text(0.62, 1.0, r"$\mathbf{F}$, fixed in the secondary", color="C3")
    axes.text(0, 0, "primary", ha="center", va="center", fontsize=8)
    for y in (-0.9, -0.45, 0.0, 0.45, 0.9):
        axes.annotate("", (-1.45, y), (-1.85, y), arrowprops={"arrowstyle": "->", "color": "C1"})
    axes.text(-1.85, 1.12, "sunlight", color="C1")
    axes.annotate("", (0.62, -0.78), (0.9, -0.44), arrowprops={"arrowstyle": "<-", "color": "k"})
    axes.text(0.95, -0.75, "orbit")
    axes.set(aspect="equal", xlim=(-1.95, 1.9), ylim=(-1.5, 1.5))
    axes.axis("off")
    return figure


def radiation_by_obliquity() -> Any:
    """Draw the coefficients of YORP and BYORP of the radar shape of 1999 KW4's secondary against the obliquity."""
    system, _ = fullbody.systems.kw4(shape="radar")
    alpha, beta = system.bodies
    angle = np.linspace(0.0, np.pi, 91)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.4), layout="constrained")
    lines = {
        "without Alpha": {"towards": (1, 0, 0)},
        "in the shadow of Alpha": {"other": alpha, "position": (2.548, 0, 0)},
    }
    for color, (label, options) in zip(("C0", "C3"), lines.items(), strict=True):
        coefficients = fullbody.forces.radiation_coefficients(beta, **options)
        force = coefficients.synchronous_force(angle)[:, 1] * coefficients.outwards / coefficients.radius**2
        right.plot(np.degrees(angle), force, color, label=label)
        if label == "without Alpha":
            for torque, name, style in zip(
                coefficients.spin_torques(angle), ("along", "across"), ("C0", "C1"), strict=True
            ):
                left.plot(np.degrees(angle), 1e3 * torque / coefficients.radius**3, style, label=f"{name} the spin")
    left.set(ylabel="YORP coefficient (10$^{-3}$)")
    right.set(ylabel="BYORP coefficient")
    for axes in (left, right):
        axes.axhline(0.0, color="0.6", lw=0.8)
        axes.set(xlabel="obliquity (deg)", xlim=(0, 180), xticks=range(0, 181, 45))
        axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    return figure


def cost_of_distance() -> Any:
    """Draw the processor time of an interaction of two radar shapes against their distance."""
    # Measured by benches/polyhedra.py at a tolerance of 1e-10, in km and ms.
    distance = [2.55, 2.0, 1.7, 1.5, 1.35, 1.3, 1.25, 1.2, 1.15, 1.1, 1.08, 1.0598, 1.0006, 0.9799, 0.974]
    cost = [0.017, 0.022, 0.028, 0.044, 0.091, 0.118, 0.116, 2.237, 4.28, 8.669, 11.255, 17.103, 85.855, 294.9, 838.5]
    contact, touching = 0.9710, 1.08
    figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
    axes.loglog(np.array(distance) - contact, cost, "C0o-")
    axes.axvline(touching - contact, color="0.6", ls="--")
    axes.text(0.95 * (touching - contact), 0.02, "circumscribed\nspheres touch", color="0.4", ha="right")
    axes.set(xlabel="distance from contact (km)", ylabel="processor time (ms)")
    axes.grid(alpha=0.3)
    return figure
