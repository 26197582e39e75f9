"""The bodies in 3D."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..record.track import attitudes
from ._style import (
    LINES,
    Array,
    called,
    check_axes,
    check_samples,
    far_label,
    label,
    line,
    matplotlib,
    reach,
    split_far,
    surfaces,
    unit,
    wishes,
)
from .between import at, moment, track

if TYPE_CHECKING:
    from ..record.base import BaseRun

#: Body axes reach this far, in units of what the body does.
_REACH = 1.7
#: Height of the strip for the legend below the axes, in units of their height.
_MARGIN = 0.11
_FACE = ("#9ecae1", "#fdae6b", "#d9d9d9", "#a1d99b", "#e7cbdc", "#cfe8f7")


def scene(run: BaseRun, time: Any, ax: Any, *, path: bool, **kwargs: Any) -> Any:
    """See :meth:`fullbody.plots.Plots.scene`."""
    check_samples(run)
    if ax is None:
        ax = stage(matplotlib().figure(figsize=(7.0, 5.2)))
    else:
        check_axes(ax, "ax", "3d")
    now = moment(run, time)
    centres, attitude = (values[0] for values in at(run, np.array([now])))
    paths = at(run, track(run, now))[0]
    names = [called(run, body) for body in range(len(run.system))]
    surface = _surface(kwargs)
    near, far = split_far(run)
    for body in near:
        if path:
            style = line(body, {"color": "0.45", "linewidth": 0.8})
            ax.plot(*paths[:, body].T, **style)
        draw_body(ax, run, body, centres[body], attitude[body], names[body], surface)
    for body, distance in far:
        names[body] = far_label(run, body, distance)
        ax.plot([], [], linestyle="none", label=names[body])
    whole = at(run, track(run, moment(run, None)))[0]
    frame(ax, run, np.concatenate([whole, centres[None]])[:, near], near)
    title(ax, run, f"{now:.6g}")
    entries = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    order = [*names, *(name for name in entries if name not in names)]
    ax.legend(
        [entries[name] for name in order],
        order,
        loc="lower center",
        bbox_to_anchor=(0.5, -_MARGIN),
        ncols=len(order) if len(order) < 6 else (len(order) + 1) // 2,
        frameon=False,
        fontsize="small",
        handlelength=2.6,
    )
    return ax


def stage(figure: Any) -> Any:
    """Axes in 3D that leave room for the labels of their box, which stand outside it, and for the legend below them."""
    return figure.add_axes((0.02, 0.86 * _MARGIN, 0.9, 0.86), projection="3d")


def _surface(kwargs: dict[str, Any]) -> dict[str, Any]:
    """The caller's options of a surface under the names of its own style."""
    # For a surface these names mean an array of colours, and not one colour of all faces.
    kept = {name: value for name, value in kwargs.items() if name == "facecolors"}
    rest = {name: value for name, value in kwargs.items() if name not in kept}
    return {**wishes(rest, "collections.PolyCollection"), **kept}


def title(ax: Any, run: BaseRun, time: str) -> None:
    """The time with its unit above a scene."""
    ax.set_title(f"time {time} {unit(run, 'time')}".rstrip(), fontsize="medium")


def draw_body(
    ax: Any,
    run: BaseRun,
    body: int,
    centre: Array,
    attitude: Array,
    name: str,
    kwargs: dict[str, Any],
    mesh: tuple[int, int] = (37, 19),
) -> list[Any]:
    """Surface and axes of a body; gives the artists."""
    drawn = surfaces(run, body)
    if not drawn:
        return list(ax.plot(*centre[:, None], marker="o", color=LINES[body % len(LINES)]["color"], label=name))
    matrix = attitudes(attitude[None]).rotation_matrix[0]
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, mesh[0]), np.linspace(0.0, np.pi, mesh[1]))
    ball = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    style = {"color": _FACE[body % len(_FACE)], "edgecolor": "0.45", "linewidth": 0.15, "rstride": 1, "cstride": 1}
    artists = []
    for k, surface in enumerate(drawn):
        named = {"label": name} if k == 0 else {}
        if surface.triangles is not None:
            corners = (surface.triangles @ surface.columns.T + surface.position) @ matrix.T + centre
            artists.append(ax.add_collection3d(_facets(corners, {**style, **named, **kwargs})))
            continue
        x, y, z = np.moveaxis((ball @ surface.columns.T + surface.position) @ matrix.T + centre, -1, 0)
        artists.append(ax.plot_surface(x, y, z, **{**style, **named, **kwargs}))
    whole = reach(run, body)
    for column, letter in enumerate("xyz"):
        # From the surface outwards: a plot in 3D hides no line behind a body, so none is drawn inside.
        edge = max(surface.position[column] + np.linalg.norm(surface.columns[column]) for surface in drawn)
        ends = centre + np.outer([max(edge, 0.0), _REACH * whole], matrix[:, column])
        artists += ax.plot(*ends.T, **line(column, {"linewidth": 1.4, "label": f"body {letter}"}))
    return artists


def _facets(corners: Array, style: dict[str, Any]) -> Any:
    """Triangles (F, 3, 3) in 3D, with the options of a surface."""
    colour = style.pop("color")
    style = {name: value for name, value in style.items() if name not in ("rstride", "cstride", "cmap")}
    style.setdefault("facecolors", style.pop("facecolor", colour))
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    return Poly3DCollection(corners, shade=True, **style)


def frame(ax: Any, run: BaseRun, centres: Array, bodies: list[int]) -> None:
    """Equal scales on all axes, wide enough for the whole paths (T, n, 3) of some bodies; labels with units."""
    sizes = [_REACH * reach(run, body) for body in bodies]
    low = (centres - np.array(sizes)[:, None]).min(axis=(0, 1))
    high = (centres + np.array(sizes)[:, None]).max(axis=(0, 1))
    span = np.where(high > low, high - low, 1.0)
    ax.set(xlim=(low[0], low[0] + span[0]), ylim=(low[1], low[1] + span[1]), zlim=(low[2], low[2] + span[2]))
    # As large as fits: the box's width and height as seen from matplotlib's usual place, 30 degrees up.
    x, y, z = span / np.linalg.norm(span)
    wide, high_up = 0.87 * x + 0.5 * y, 0.25 * x + 0.43 * y + 0.87 * z
    ax.set_box_aspect(span, zoom=min(1.05 / wide, 0.84 / high_up))
    digits = len(f"{np.abs([low, low + span]).max():.0f}")
    for letter, width in zip("xyz", span / span.max(), strict=True):
        getattr(ax, f"set_{letter}label")(label(run, letter, "length"))
        # Fewer ticks on a shorter axis, and where their numbers are long.
        count = max(2, round((6 if digits < 5 else 4) * float(width)))
        getattr(ax, f"{letter}axis").set_major_locator(matplotlib("ticker").MaxNLocator(count))
    # Numbers beside the upright axis are centred on a place near it: long ones need more room.
    more = max(0, digits - 2)
    ax.tick_params(axis="z", pad=ax.zaxis.get_tick_padding() + 2.5 * more)
    ax.zaxis.labelpad += 5.0 * more
