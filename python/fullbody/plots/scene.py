"""Pictures of the bodies: paths in a plane, and scenes in 3D, in sunlight with shadows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import figures, rotations
from ..base.figures import LINES
from ..base.kinds import choice
from ..record.record import Record
from ..typing import Floats
from . import _style
from ._style import RunPlots
from .between import dense_times, poses, relative_path, time_in_run
from .sunlight import Sunlight, directions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d.axes3d import Axes3D

    from ..observing.vectors import Vectors

#: The indices of the horizontal and the vertical coordinate of each plane.
_PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
#: The length of the drawn body axes relative to the radius of the body.
_AXIS_LENGTH = 1.4
#: The height of the strip for the legend below the axes, relative to their height.
_LEGEND_HEIGHT = 0.11
#: The colours of the bodies' surfaces.
_COLOURS = ("#9ecae1", "#fdae6b", "#d9d9d9", "#a1d99b", "#e7cbdc", "#cfe8f7")


def orbit(
    plots: RunPlots, ax: Any = None, *, about: int | str = 0, plane: str = "xy", shapes: bool = True, **kwargs: Any
) -> Axes:
    """Draw paths about one body, projected on a plane of the inertial frame, with the bodies' outlines at the end.

    Parameters
    ----------
    about : int or str
        The body at the origin; its index in the system, or its name.
    plane : {"xy", "xz", "yz"}
        The plane of the inertial frame.
    shapes : bool
        Whether to draw the bodies' outlines.
    """
    choice(plane, "plane", _PLANES)
    run = plots.sampled()
    about = run.context.index(about, "about")
    ax = figures.single(ax, (5.5, 5.0))
    horizontal, vertical = _PLANES[plane]
    position = run.arrays["position"]
    kwargs = figures.full_option_names(kwargs)
    near, far = _style.near_and_far(run, about)
    for index, body in enumerate(k for k in near if k != about):
        points, is_curve = relative_path(run, body, about)
        style = figures.line(index, {"linewidth": 0.9, "label": _style.label_of(run, body)})
        style |= {} if is_curve else {"linestyle": "none", "marker": ".", "markersize": 3.0}
        ax.plot(points[:, horizontal], points[:, vertical], **{**style, **kwargs})
    for body, distance in far:
        ax.plot([], [], linestyle="none", label=_style.label_of_far(run, body, distance))
    if shapes:
        for body in near:
            end = (position[-1, body] - position[-1, about])[[horizontal, vertical]]
            _outline(ax, run, body, end, [horizontal, vertical])
    ax.set_aspect("equal", adjustable="datalim")
    for set_label, letter in zip((ax.set_xlabel, ax.set_ylabel), plane, strict=True):
        set_label(_style.label(run, f"{letter} from {_style.label_of(run, about)}", "length"))
    figures.grid(ax)
    figures.legend(ax)
    return ax


def _outline(ax: Any, run: Record, body: int, centre: Floats, plane: list[int]) -> None:
    """Draw the outlines of a body's parts, projected along the third axis, about a centre (2,) in the plane.

    That of an ellipsoid is the ellipse of P R diag(a^2) R^T P^T, with the projection P and the rotation R.
    """
    surfaces = _style.surfaces(run, body)
    if not surfaces:
        ax.plot(*centre[:, None], marker="+", color=LINES[2]["color"], linestyle="none")
        return
    matrix = _style.matrices(run, body)[-1][plane]
    angles = np.linspace(0.0, 2.0 * np.pi, 73)
    for surface in surfaces:
        columns = matrix @ surface.columns
        if surface.triangles is not None:
            corners = surface.triangles @ columns.T + (centre + matrix @ surface.position)
            # Edges are not drawn: the outline is that of all faces together.
            style = {"facecolor": "0.8", "edgecolor": "0.8", "linewidth": 0.3, "zorder": 3}
            ax.add_collection(figures.matplotlib("collections").PolyCollection(corners, **style))
            continue
        edge = np.linalg.cholesky(columns @ columns.T) @ np.array([np.cos(angles), np.sin(angles)])
        position = centre + matrix @ surface.position
        ax.fill(*(position[:, None] + edge), facecolor="0.8", edgecolor="0.2", linewidth=0.8, zorder=3)


def scene(
    plots: RunPlots,
    time: Any = None,
    ax: Any = None,
    *,
    path: bool = True,
    geometry: Vectors | None = None,
    **kwargs: Any,
) -> Axes3D:
    """Draw the bodies in 3D about the barycentre, with their axes, at a time.

    Parameters
    ----------
    time : float or Quantity, optional
        A time within the run; by default its end. Between samples the bodies are drawn from the continuous solution
        (``dense=True``); without one, from a cubic through positions and velocities and the shorter rotation
        between attitudes.
    ax : matplotlib Axes3D, optional
    path : bool
        Whether to draw the paths of the centres.
    geometry : fullbody.observing.Geometry, optional
        The geometry whose Sun lights the bodies, with their shadows on each other. A polyhedron casts the shadow of
        an ellipsoid.
    **kwargs
        Passed to ``Axes3D.plot_surface``.
    """
    run = plots.sampled()
    if ax is None:
        ax = new_axes(figures.matplotlib().figure(figsize=(7.0, 5.2)))
    else:
        figures.check_axes(ax, "ax", "3d")
    time_shown = time_in_run(run, time)
    centres, attitude = (values[0] for values in poses(run, np.array([time_shown])))
    paths = poses(run, dense_times(run, time_shown))[0]
    names = [_style.label_of(run, body) for body in range(len(run.context))]
    surface = _surface(kwargs)
    light = None
    if geometry is not None:
        light = Sunlight(run, directions(run, geometry, np.array([time_shown]))[0], centres, attitude)
    near, far = _style.near_and_far(run)
    for body in near:
        if path:
            ax.plot(*paths[:, body].T, **figures.line(body, {"color": "0.45", "linewidth": 0.8}))
        draw_body(ax, run, body, centres[body], attitude[body], names[body], surface, light=light)
    for body, distance in far:
        names[body] = _style.label_of_far(run, body, distance)
        ax.plot([], [], linestyle="none", label=names[body])
    all_paths = poses(run, dense_times(run, time_in_run(run, None)))[0]
    set_range(ax, run, np.concatenate([all_paths, centres[None]])[:, near], near)
    title(ax, run, _style.rounded(time_shown))
    entries = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    order = [*names, *(name for name in entries if name not in names)]
    columns = len(order) if len(order) < 6 else (len(order) + 1) // 2
    style = {"frameon": False, "fontsize": "small", "handlelength": 2.6, "ncols": columns}
    position = {"loc": "lower center", "bbox_to_anchor": (0.5, -_LEGEND_HEIGHT)}
    ax.legend([entries[name] for name in order], order, **position, **style)
    return ax


def new_axes(figure: Any) -> Any:
    """Make axes in 3D that leave room for the labels outside their box and for the legend below them."""
    return figure.add_axes((0.02, 0.83 * _LEGEND_HEIGHT, 0.9, 0.83), projection="3d")


def _surface(kwargs: dict[str, Any]) -> dict[str, Any]:
    """Return the caller's options of a surface under the long names that the package uses."""
    # Under this name matplotlib takes an array of colours for a surface, but not one colour for all faces.
    face_colours = {name: kwargs.pop(name) for name in ("facecolors",) if name in kwargs}
    return {**figures.full_option_names(kwargs, "collections.PolyCollection"), **face_colours}


def title(ax: Any, run: Record, time: str) -> None:
    """Write the time with its unit above a scene."""
    ax.set_title(f"time {time} {_style.unit(run, 'time')}".rstrip(), fontsize="medium")


def draw_body(
    ax: Any,
    run: Record,
    body: int,
    centre: Floats,
    attitude: Floats,
    name: str,
    kwargs: dict[str, Any],
    mesh: tuple[int, int] = (37, 19),
    light: Sunlight | None = None,
) -> list[Any]:
    """Draw the surfaces and axes of a body at a centre (3,) and an attitude (4,), and return the artists.

    ``mesh`` is the number of points of an ellipsoid in longitude and latitude, ``light`` the sunlight on the surface.
    """
    surfaces = _style.surfaces(run, body)
    if not surfaces:
        return list(ax.plot(*centre[:, None], marker="o", color=LINES[body % len(LINES)]["color"], label=name))
    matrix = rotations.matrices(attitude)
    style: dict[str, Any] = {"color": _COLOURS[body % len(_COLOURS)], "edgecolor": "0.45", "linewidth": 0.15}
    style |= {"rstride": 1, "cstride": 1}
    artists = []
    if light is not None:
        mesh = (2 * mesh[0] - 1, 2 * mesh[1] - 1)
        # The legend shows the colour of the day side.
        artists += ax.plot([], [], linestyle="none", marker="s", markersize=9.0, color=style["color"], label=name)
    ball = _style.sphere_grid(*mesh)
    for k, surface in enumerate(surfaces):
        options: dict[str, Any] = {"label": name} if k == 0 and light is None else {}
        if surface.triangles is not None:
            corners = (surface.triangles @ surface.columns.T + surface.position) @ matrix.T + centre
            if light is None:
                artists.append(ax.add_collection3d(_facets(corners, {**style, **options, **kwargs})))
                continue
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, None]
        else:
            grid = (ball @ surface.columns.T + surface.position) @ matrix.T + centre
            if light is None:
                artists.append(ax.plot_surface(*np.moveaxis(grid, -1, 0), **{**style, **options, **kwargs}))
                continue
            # Normals of an ellipsoid are along the points of the unit sphere divided by the semi-axes.
            corners, normals = (_cells(values) for values in (grid, ball @ np.linalg.inv(surface.columns) @ matrix.T))
        pieces, shades = light.pieces(body, k, corners, normals)
        # Edges in the colours of the faces cover the seams between these.
        colours = _colours(style["color"], shades)
        options = {**style, "facecolors": colours, "edgecolor": colours, "linewidth": 0.3}
        artists.append(ax.add_collection3d(_facets(pieces, {**options, **kwargs})))
    radius = _style.radius(run, body)
    for column, letter in enumerate("xyz"):
        # The axis begins at the surface, since a plot in 3D does not hide lines inside a body.
        edge = max(surface.position[column] + np.linalg.norm(surface.columns[column]) for surface in surfaces)
        ends = centre + np.outer([max(edge, 0.0), _AXIS_LENGTH * radius], matrix[:, column])
        artists += ax.plot(*ends.T, **figures.line(column, {"linewidth": 1.4, "label": f"body {letter}"}))
    return artists


def _cells(grid: Floats) -> Floats:
    """Return the four corners (M, 4, 3) of each cell of a grid (A, B, 3)."""
    return np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2).reshape(-1, 4, 3)


def _colours(name: str, shades: Floats) -> Floats:
    """Return a colour scaled by shades (M,), as (M, 4)."""
    colour = np.array(figures.matplotlib("colors").to_rgb(name))
    return np.concatenate([colour * shades[:, None], np.ones((len(shades), 1))], axis=-1)


def _facets(corners: Any, style: dict[str, Any]) -> Any:
    """Make polygons in 3D of their corners (F, k, 3), with the options of a surface."""
    colour = style.pop("color", None)
    style = {name: value for name, value in style.items() if name not in ("rstride", "cstride", "cmap")}
    style.setdefault("facecolors", style.pop("facecolor", colour))
    # Faces lit by the Sun have their shades already.
    return _style.polygons_3d(corners, shade=np.ndim(style["facecolors"]) < 2, **style)


def set_range(ax: Any, run: Record, centres: Floats, bodies: list[int]) -> None:
    """Set equal scales of the axes for the whole paths (T, n, 3) of n bodies, and label the axes with units."""
    sizes = [_AXIS_LENGTH * _style.radius(run, body) for body in bodies]
    low = (centres - np.array(sizes)[:, None]).min(axis=(0, 1))
    high = (centres + np.array(sizes)[:, None]).max(axis=(0, 1))
    span = np.where(high > low, high - low, 1.0)
    ax.set(xlim=(low[0], low[0] + span[0]), ylim=(low[1], low[1] + span[1]), zlim=(low[2], low[2] + span[2]))
    digits = len(f"{np.abs([low, low + span]).max():.0f}")
    for letter, fraction in zip("xyz", span / span.max(), strict=True):
        getattr(ax, f"set_{letter}label")(_style.label(run, letter, "length"))
        # There are fewer ticks on a shorter axis, and where their numbers are long.
        count = max(2, round((6 if digits < 5 else 4) * float(fraction)))
        getattr(ax, f"{letter}axis").set_major_locator(figures.matplotlib("ticker").MaxNLocator(count))
    # Numbers beside the vertical axis are centred on a point near it, so that long ones need more room.
    extra_digits = max(0, digits - 2)
    ax.tick_params(axis="z", pad=ax.zaxis.get_tick_padding() + 2.5 * extra_digits)
    ax.zaxis.labelpad += 5.0 * extra_digits
    _fill(ax, span)


def _fill(ax: Any, span: Floats) -> None:
    """Set equal scales of axes in 3D for ranges of these sizes (3,), and enlarge the box until it fills their place."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    ax.set_box_aspect(span)
    ax.apply_aspect()
    corners = np.array([(x, y, z) for x in ax.get_xlim() for y in ax.get_ylim() for z in ax.get_zlim()])
    x, y, _ = proj_transform(*corners.T, ax.get_proj())
    box = ax.transData.transform(np.stack([x, y], axis=1))
    low, high = box.min(axis=0), box.max(axis=0)
    # The numbers and the labels outside the box keep their size.
    renderer = figures.matplotlib("backends.backend_agg").RendererAgg(*ax.figure.bbox.size.round(), ax.figure.dpi)
    outer = [axis.get_tightbbox(renderer) for axis in (ax.xaxis, ax.yaxis, ax.zaxis)]
    below = np.maximum(low - np.min([box.min for box in outer], axis=0), 0.0)
    above = np.maximum(np.max([box.max for box in outer], axis=0) - high, 0.0)
    labels = np.array([below[0] + above[0], 2.0 * max(below[1], above[1])])
    room = ax.get_position(original=True).size * ax.figure.bbox.size
    ax.set_box_aspect(span, zoom=float((np.maximum(room - labels, 0.3 * room) / (high - low)).min()))
