"""Pictures of the bodies in the sky, as a telescope sees them that resolves them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import figures
from ..base.rotations import matrices
from ..base.units import without_unit
from ..observing.brightness import Epochs
from ..observing.light_centres import refuse_directions
from ..observing.light_curve import epochs_of
from ..observing.limbs import EllipsoidLimb, Limb, MeshLimb, PosedLimbs, limbs_of
from ..observing.sky import east_and_north, in_mas, offsets, sky_axes
from ..record.record import Record
from ..typing import Floats
from . import _style
from ._style import RunPlots

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..observing.vectors import Vectors

#: The grey of the night side, the exponent with which screens show brightness, and the brightness mu0 / (mu + mu0) that
#: is shown as white.
_NIGHT, _GAMMA, _WHITE = 0.13, 1.0 / 2.2, 0.8
#: The numbers of meridians and of parallels of the mesh of an ellipsoid, and how often its triangles are divided into
#: four where a terminator or a shadow crosses them.
_MERIDIANS, _PARALLELS, _DIVISIONS = 72, 36, 4
#: The margin about the bodies, relative to their extent, and the share of the width that a scale takes at most.
_MARGIN, _SCALE = 0.12, 0.3
#: The directions to the east and to the north of rays, at equal position angles, on which a limb is drawn.
_RAYS = np.stack([np.sin(np.linspace(0.0, 2.0 * np.pi, 361)), np.cos(np.linspace(0.0, 2.0 * np.pi, 361))], axis=1)[:-1]


def sky(
    plots: RunPlots,
    time: Any,
    geometry: Vectors,
    ax: Any = None,
    *,
    frame: Any = "equatorial",
    names: bool = True,
    **kwargs: Any,
) -> Axes:
    """Draw the bodies in the sky at a time, in light and shadow, with north up, east to the left, and a scale.

    Surfaces have the brightness of Lommel-Seeliger's law; the night side is dark grey. Polyhedra cast their shadows on
    other bodies, but not on themselves.

    Parameters
    ----------
    time : astropy Time, float or Quantity
        The time at which the light arrives at the observer.
    geometry : fullbody.observing.Geometry
        A geometry that includes the Sun.
    ax : matplotlib Axes, optional
    frame : str or astropy frame
        The axes of the sky, as for :func:`fullbody.observing.outline`.
    names : bool
        Whether to write the names of the bodies.
    **kwargs
        Passed to ``matplotlib.collections.PolyCollection``.
    """
    run = plots.sampled()
    ax = figures.single(ax, (5.6, 5.2))
    frames = SkyFrames(run, time, geometry, frame)
    frames.prepare(ax)
    frames.draw(ax, 0, names, kwargs)
    return ax


class SkyFrames:
    """Pictures of the bodies of a run in the sky at one or more times, all to one scale.

    Parameters
    ----------
    run : Run
    times : astropy Time, or array_like or Quantity, () or (K,)
        Times at which the light arrives.
    geometry : Geometry
    frame : str or astropy frame
    """

    def __init__(self, run: Record, times: Any, geometry: Vectors, frame: Any = "equatorial") -> None:
        self._run, self._axes = run, sky_axes(run.system, frame, "a picture of the sky")
        self._frames: list[tuple[Epochs, int]] = []
        for epochs in epochs_of(run, times, geometry, "a picture of the sky"):
            refuse_directions(epochs, "a picture of the sky")
            self._frames += [(epochs, k) for k in range(len(epochs.times))]
        self._radii = np.array([_style.radius(run, body) for body in range(len(run.context))])

    def _offsets(self, epochs: Epochs, k: int, points: Floats) -> Floats:
        """Return positions in the sky (..., 2) of points (..., 3), in mas or radians."""
        line = np.broadcast_to(-epochs.to_observer[k] @ self._axes.T, points.shape)
        return without_unit(in_mas(offsets(line, points @ self._axes.T), self._run.system))

    def _angle(self, epochs: Epochs, k: int) -> float:
        """Return how large the unit of length appears at the barycentre, in mas or radians."""
        return float(without_unit(in_mas(np.array(1.0 / np.linalg.norm(epochs.to_observer[k])), self._run.system)))

    def prepare(self, ax: Any) -> None:
        """Set the limits, so that all pictures fit in, and draw the directions and a scale."""
        low, high = np.full(2, np.inf), np.full(2, -np.inf)
        for epochs, k in self._frames:
            centres, sizes = self._offsets(epochs, k, epochs.position[k]), self._radii * self._angle(epochs, k)
            low = np.minimum(low, (centres - sizes[:, None]).min(axis=0))
            high = np.maximum(high, (centres + sizes[:, None]).max(axis=0))
        span = float(np.max(high - low)) or 1.0
        low, high = low - _MARGIN * span, high + _MARGIN * span
        # Room for the arrows and the scale below the bodies.
        low[1] -= _MARGIN * span
        unit = "mas" if self._run.context.units.defined else "rad"
        ax.set(xlim=(high[0], low[0]), ylim=(low[1], high[1]), xlabel=f"east [{unit}]", ylabel=f"north [{unit}]")
        ax.set_aspect("equal", adjustable="box")
        ax.set_facecolor("black")
        style = {"color": "white", "fontsize": "small", "ha": "center", "va": "center"}
        corner = np.array([high[0] - 0.18 * span, low[1] + 0.05 * span])
        for name, direction in (("N", (0.0, 0.1)), ("E", (0.1, 0.0))):
            tip = corner + np.array(direction) * span
            arrow = {"arrowstyle": "->", "color": "white", "shrinkA": 0.0, "shrinkB": 0.0}
            ax.annotate("", tip, corner, arrowprops=arrow)
            ax.text(*(corner + 1.3 * (tip - corner)), name, **style)
        angle = self._angle(*self._frames[0])
        length = _rounded_down(_SCALE * (high[0] - low[0]) / angle)
        end = low[0] + 0.06 * span
        ax.plot([end, end + length * angle], [corner[1]] * 2, color="white", linewidth=1.5)
        label = f"{length:.6g} {_style.unit(self._run, 'length')}".rstrip()
        ax.text(end, corner[1] + 0.045 * span, label, **{**style, "ha": "right"})

    def draw(self, ax: Any, index: int, names: bool, kwargs: dict[str, Any]) -> list[Any]:
        """Draw one of the pictures, with its time and phase angle as the title, and return the artists."""
        epochs, k = self._frames[index]
        bodies = [
            PosedLimbs(limbs_of(self._run.system, body), centre, matrix)
            for body, (centre, matrix) in enumerate(zip(epochs.position[k], matrices(epochs.attitude[k]), strict=True))
        ]
        toward, sunward = (v[k] / np.linalg.norm(v[k], axis=1, keepdims=True) for v in epochs.vectors())
        distance = np.linalg.norm(epochs.to_observer[k] - epochs.position[k], axis=1)
        artists: list[Any] = []
        collection = figures.matplotlib("collections").PolyCollection
        kwargs = figures.full_option_names(kwargs, "collections.PolyCollection")
        for body in np.argsort(-distance):
            others = [other for o, other in enumerate(bodies) if o != body]
            for limb in bodies[body].limbs:
                triangles, greys = _visible_triangles(limb, bodies[body], toward[body], sunward[body], others)
                corners = self._offsets(epochs, k, triangles)
                colours = np.repeat(greys[:, None], 3, axis=1)
                # Faces without smooth edges have no seams between them; the limb is a line of its own.
                style = {"facecolors": colours, "linewidths": 0.0, "antialiaseds": False, **kwargs}
                artists.append(ax.add_collection(collection(corners, **style)))
            sight = toward[body], east_and_north(-toward[body], self._axes[2])
            edge = self._offsets(epochs, k, bodies[body].outermost(*sight, _RAYS).points)
            if bodies[body].limbs:
                artists += ax.plot(*edge[[*range(len(edge)), 0]].T, color="0.35", linewidth=0.8, zorder=1.0)
            else:
                centre = self._offsets(epochs, k, epochs.position[k][body])
                artists += ax.plot(*centre[:, None], marker=".", color="white")
            if names:
                above = edge[0] + np.array([0.0, 0.01 * np.ptp(ax.get_ylim())])
                style = {"color": "0.9", "fontsize": "small", "ha": "center", "va": "bottom", "zorder": 4.0}
                outline = figures.matplotlib("patheffects").withStroke(linewidth=1.5, foreground="black")
                name = _style.label_of(self._run, int(body))
                artists.append(ax.text(*above, name, path_effects=[outline], **style))
        phase = np.degrees(np.arccos(np.clip(np.sum(toward * sunward, axis=1), -1.0, 1.0)).mean())
        time = f"{_style.rounded(epochs.times[k])} {_style.unit(self._run, 'time')}".rstrip()
        ax.set_title(f"time {time}, phase angle {phase:.1f}°", fontsize="medium")
        return artists


def _rounded_down(value: float) -> float:
    """Return the largest number of the form 1, 2 or 5 times a power of ten that is not above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(step for step in (1.0, 2.0, 5.0) if step * power <= value * (1.0 + 1e-12)) * power)


def _visible_triangles(
    limb: Limb, body: PosedLimbs, toward: Floats, sunward: Floats, others: Iterable[PosedLimbs]
) -> tuple[Floats, Floats]:
    """Return the visible triangles (F, 3, 3) of a part of a body and their greys (F,), with shadows of other bodies."""
    curved, centre = not isinstance(limb, MeshLimb), body.centre + body.matrix @ limb.position
    columns = body.matrix @ limb.rotation * (limb.semi_axes if isinstance(limb, EllipsoidLimb) else 1.0)
    if isinstance(limb, MeshLimb):
        triangles = (body.centre + limb.vertices @ body.matrix.T)[limb.polyhedron.faces]
    else:
        triangles = _sphere_triangles() @ columns.T + centre
    inverse = np.linalg.inv(columns @ columns.T)

    def normals(points: Floats, faces: Floats) -> Floats:
        """Return unit normals of points (F, ..., 3) of triangles, those of an ellipsoid at the points themselves."""
        flat = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
        normal = (points - centre) @ inverse if curved else np.broadcast_to(flat[:, None], points.shape)
        return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))

    def shadowed(points: Floats) -> Any:
        flat = points.reshape(-1, 3)
        suns = np.broadcast_to(sunward, flat.shape)
        dark = np.zeros(len(flat), dtype=bool)
        for other in others:
            dark |= other.hides(flat, suns)
        return dark.reshape(points.shape[:-1])

    for division in range(_DIVISIONS + 1):
        facing = normals(triangles, triangles) @ toward
        triangles = triangles[(facing > 0.0).any(axis=1)]
        lit = (normals(triangles, triangles) @ sunward > 0.0) & ~shadowed(triangles)
        mixed = lit.any(axis=1) & ~lit.all(axis=1)
        if division < _DIVISIONS:
            a, b, c = np.moveaxis(triangles[mixed], 1, 0)
            p, q, r = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
            parts = [np.stack(corners, axis=1) for corners in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))]
            triangles = np.concatenate([triangles[~mixed], *parts])
    centroids = triangles.mean(axis=1, keepdims=True)
    normal = normals(centroids, triangles)[:, 0]
    mu, mu0 = np.maximum(normal @ toward, 1e-6), normal @ sunward
    lit = (mu0 > 0.0) & ~shadowed(centroids)[:, 0]
    bright = np.where(lit, mu0 / (mu + np.where(lit, mu0, 1.0)), 0.0) / _WHITE
    order = np.argsort(centroids[:, 0] @ toward)
    return triangles[order], np.clip(bright**_GAMMA, _NIGHT, 1.0)[order]


def _sphere_triangles() -> Floats:
    """Return triangles (F, 3, 3) of the surface of the unit sphere."""
    grid = np.swapaxes(_style.sphere_grid(_MERIDIANS + 1, _PARALLELS + 1), 0, 1)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    halves = [np.stack(corners, axis=2).reshape(-1, 3, 3) for corners in ((a, b, c), (a, c, d))]
    return np.concatenate(halves)
