"""The table of the ready-made systems and their pictures, from the files of the systems and their starts."""

from __future__ import annotations

from typing import Any

import fullbody
import matplotlib.pyplot as plt
import numpy as np
from fullbody import Ellipsoid, Polyhedron, Sphere, systems
from fullbody.systems import Published
from scipy.spatial import ConvexHull

__all__ = ["names", "pictures", "table"]

_COLUMNS = (
    "system",
    "period",
    "a",
    "masses, kg",
    "density, g/cm³ (published)",
    "m₂/m₁",
    "J₂ of the first",
    "epoch",
    "sources",
)


def names() -> list[str]:
    """Return the systems of real bodies, in the order of the module's table."""
    return sorted(set(systems.__all__) - {"Published", "Value", "published", "case1", "case2"}, key=_position)


def _position(name: str) -> int:
    assert systems.__doc__ is not None
    return systems.__doc__.index(f":func:`{name}`")


def table() -> str:
    """Return the table in Markdown: a row for each system, with published values and their errors."""
    rows = [_row(name) for name in names()]
    lines = ["| " + " | ".join(_COLUMNS) + " |", "|---" * len(_COLUMNS) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def _row(name: str) -> list[str]:
    system, _ = getattr(systems, name)()
    facts = systems.published(name)
    masses = [float(mass) for mass in system.masses]
    return [
        f"{{func}}`~fullbody.systems.{name}`",
        _value(facts, "orbital period"),
        _value(facts, "semi-major axis"),
        ", ".join(f"{mass:.4g}" for mass in masses),
        "; ".join(_density(body, facts) for body in system.bodies),
        ", ".join(f"{mass / masses[0]:.3g}" for mass in masses[1:]),
        _j2(system.bodies[0]),
        (facts.epoch or "none").replace("T", " ", 1),
        " ".join(key for key in facts.sources if key != "JPL"),
    ]


def _value(facts: Published, quantity: str) -> str:
    """Return the published values of a quantity, also those of the third body of a triple."""
    prefixes = f"{quantity} of", f"{quantity} (not used)"
    names = [name for name in facts.values if name == quantity or name.startswith(prefixes)]
    return "<br>".join(str(facts.values[name]) for name in names[:2]) or "-"


def _density(body: Any, facts: Published) -> str:
    density = f"{body.density / 1e12:.2f}" if body.density else "-"
    published = next(
        (
            facts.values[key]
            for key in (f"density of {body.name} (not used)", "density (not used)")
            if key in facts.values
        ),
        None,
    )
    return density if published is None else f"{density} ({str(published).removesuffix(' g/cm^3')})"


def _j2(body: Any) -> str:
    """Return J2 for the radius of the sphere of equal volume."""
    if not isinstance(body.shape, Ellipsoid | Sphere):
        return "-"
    a, b, c = body.shape.semi_axes
    return f"{(a * a + b * b - 2 * c * c) / 10 / (a * b * c) ** (2 / 3):.4f}"


def pictures() -> Any:
    """Draw each system from the pole of its orbit, to scale, with the osculating orbits."""
    all_names = names()
    figure, grid = plt.subplots(
        (len(all_names) + 3) // 4, 4, figsize=(10, 2.6 * ((len(all_names) + 3) // 4)), layout="constrained"
    )
    for axes in grid.flat[len(all_names) :]:
        axes.axis("off")
    for axes, name in zip(grid.flat, all_names, strict=False):
        options = {} if systems.published(name).frame is None else {"frame": "orbit"}
        system, state = getattr(systems, name)(**options)
        position = state.position - state.position[0]
        distance = np.linalg.norm(position, axis=1)
        for body in range(1, len(system)):
            # The orbits of the files are about the barycentre of the inner bodies.
            inner = distance < distance[body]
            shares = system.masses[inner] / system.masses[inner].sum()
            centre = shares @ position[inner]
            orbit = fullbody.KeplerElements.from_cartesian(
                position[body] - centre,
                state.velocity[body] - shares @ state.velocity[inner],
                mu=system.G * (system.masses[inner].sum() + system.masses[body]),
            )
            path = np.stack(
                [
                    fullbody.KeplerElements(orbit.a, orbit.e, orbit.i, orbit.Omega, orbit.omega, anomaly).to_cartesian(
                        1.0
                    )[0]
                    for anomaly in np.linspace(0.0, 2.0 * np.pi, 121)
                ]
            )
            axes.plot(*(path + centre)[:, :2].T, color="0.75", lw=0.8)
        for body, attitude, centre in zip(system.bodies, state.rotation_matrix, position, strict=True):
            points = _surface(body) @ attitude.T + centre
            if len(points) > 1:
                corners = points[ConvexHull(points[:, :2]).vertices, :2]
                axes.fill(corners[:, 0], corners[:, 1], color="#b79a5b", zorder=2)
            axes.plot(centre[0], centre[1], ".", color="k", ms=2, zorder=3)
        axes.set(aspect="equal")
        axes.set_title(name, fontsize=9)
        axes.tick_params(labelsize=7)
    figure.supxlabel("km, from the pole of the orbit", fontsize=9)
    return figure


def _surface(body: Any) -> Any:
    """Return points of the surface in the body frame; for a composite those of its parts."""
    u, v = np.mgrid[0 : 2 * np.pi : 60j, 0 : np.pi : 30j]
    sphere = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1).reshape(-1, 3)
    shape = body.shape
    if isinstance(shape, Ellipsoid | Sphere):
        return sphere * shape.semi_axes
    if isinstance(shape, Polyhedron):
        return shape.vertices
    if not hasattr(shape, "parts"):
        return np.zeros((1, 3))
    # The lobes of the ready-made systems lie along the x-axis of their frame.
    parts = [sphere * part.shape.semi_axes + np.asarray(part.position) for part in shape.parts]
    return np.concatenate(parts) + np.asarray(body.working_frame.position)
