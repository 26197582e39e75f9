"""Fields and impacts on surfaces, and the rotating frame of a pair with equilibrium points and Roche lobes."""

from __future__ import annotations

from itertools import compress
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.figures import LINES, check_axes, grid, matplotlib, single, unit_of
from ..base.kinds import choice
from ..base.units import without_unit
from ..errors import InvalidInput
from ..fields.surface import samples
from ..typing import Floats
from ._style import colour_bar, escaped, in_si, polygons_3d, set_up_map

if TYPE_CHECKING:
    from ..fields.surface import SurfaceField, SurfaceRange
    from ..fields.synodic import Synodic
    from ..particles.flight import Flight

#: Edges of cells that extend over fewer degrees of longitude than this are straight on a map.
_STRAIGHT = 4.0
#: The quantities that can be shown on a surface.
_QUANTITIES = ["slope", "geopotential", "surface_acceleration", "least_slope", "greatest_slope"]
_QUANTITIES += ["least_surface_acceleration", "greatest_surface_acceleration"]
#: The quantities that may colour an impact, with their labels.
_COLOURS = {"time": "time", "speed": "speed", "incidence": "angle of incidence"}


def _values(field: SurfaceField | SurfaceRange, quantity: str) -> tuple[Floats, str, str]:
    """Return the numbers of a quantity, with angles in degrees, its name and its unit."""
    choice(quantity, "quantity", [name for name in _QUANTITIES if hasattr(field, name)])
    value, phrase = in_si(getattr(field, quantity)), quantity.replace("_", " ")
    if quantity.endswith("slope"):
        return np.degrees(without_unit(value)), phrase, "deg"
    return without_unit(value), phrase, unit_of(value)


def _length(value: Any, letter: str) -> str:
    return f"{letter} [{unit_of(value)}]"


def surface_map(field: SurfaceField | SurfaceRange, quantity: str = "slope", ax: Any = None, **kwargs: Any) -> Any:
    """Draw a field on a body's surface as a map of longitudes and latitudes, in degrees.

    Parameters
    ----------
    field : SurfaceField or SurfaceRange
        The result of :func:`fullbody.fields.surface` or :func:`fullbody.fields.surface_along`.
    quantity : str
        ``"slope"``, ``"geopotential"`` or ``"surface_acceleration"``; along a run ``"least_slope"``,
        ``"greatest_slope"``, ``"least_surface_acceleration"`` or ``"greatest_surface_acceleration"``.
    ax : matplotlib Axes, optional
        Those to draw on, which are returned.
    **kwargs
        Passed to ``PolyCollection``: ``cmap``, ``clim`` and others.
    """
    values, phrase, unit = _values(field, quantity)
    ax = single(ax, (8.0, 4.4))
    outlines = _outlines(without_unit(field.cells), np.degrees(without_unit(field.longitude)))
    # Cells across the edge of the map are drawn on both sides of it.
    rotation = np.array([360.0, 0.0])
    right = [k for k, outline in enumerate(outlines) if outline[:, 0].max() > 180.0]
    left = [k for k, outline in enumerate(outlines) if outline[:, 0].min() < -180.0]
    cells = [*outlines, *(outlines[k] - rotation for k in right), *(outlines[k] + rotation for k in left)]
    colours = np.concatenate([values, values[right], values[left]])
    style = {"array": colours, "antialiased": False, "rasterized": True, **kwargs}
    artist = ax.add_collection(matplotlib("collections").PolyCollection(cells, **style))
    set_up_map(ax)
    colour_bar(ax, artist, phrase, unit)
    ax.set_title(escaped(field.name))
    return ax


def _outlines(cells: Floats, middle: Floats) -> list[Floats]:
    """Return the outlines of cells (S, 4, 3) on a map, in degrees; see :func:`_outline`."""
    x, y, z = np.moveaxis(cells, -1, 0)
    ring = np.hypot(x, y)
    longitude = middle[:, None] + (np.degrees(np.arctan2(y, x)) - middle[:, None] + 180.0) % 360.0 - 180.0
    curved = (np.ptp(longitude, axis=1) > _STRAIGHT) | (ring < 1e-9 * np.abs(cells).max()).any(axis=1)
    outlines = list(np.stack([longitude, np.degrees(np.arctan2(z, ring))], axis=-1))
    for k in np.flatnonzero(curved):
        outlines[k] = _outline(cells[k], middle[k])
    return outlines


def _outline(corners: Floats, middle: float) -> Floats:
    """Return the outline of a cell (M, 2) on a map: longitudes and latitudes in degrees, the former near ``middle``.

    A pole has all longitudes. A corner there becomes an edge between the longitudes of its neighbours, and a cell
    around a pole extends to it over a whole turn.
    """
    corners = _refined(corners[np.any(corners != np.roll(corners, 1, axis=0), axis=1)])
    x, y, z = corners.T
    ring = np.hypot(x, y)
    latitude = np.degrees(np.arctan2(z, ring))
    at_pole = ring < 1e-9 * np.abs(corners).max()
    off_pole = corners[~at_pole]
    longitude = np.degrees(np.arctan2(off_pole[:, 1], off_pole[:, 0]))
    # Edges between corners take the shorter way.
    steps = (np.diff(longitude, append=longitude[:1]) + 180.0) % 360.0 - 180.0
    longitude = longitude[0] + np.concatenate([[0.0], np.cumsum(steps[:-1])])
    if not at_pole.any() and abs(steps.sum()) > 180.0:
        end, last = np.copysign(90.0, z.sum()), longitude[0] + steps.sum()
        around = np.concatenate([longitude, [last, last, longitude[0]]])
        outline = np.stack([around, np.concatenate([latitude, [latitude[0], end, end]])], axis=1)
    elif not at_pole.any():
        outline = np.stack([longitude, latitude], axis=1)
    else:
        longitudes = dict(zip(np.flatnonzero(~at_pole).tolist(), longitude.tolist(), strict=True))
        rows, count = [], len(corners)
        for k in range(count):
            if not at_pole[k]:
                rows.append((longitudes[k], latitude[k]))
                continue
            steps = ((longitudes.get((k + n) % count), longitudes.get((k + 2 * n) % count, middle)) for n in (-1, 1))
            beside = [second if first is None else first for first, second in steps]
            rows += [(item, latitude[k]) for item in beside]
        outline = np.array(rows)
    shift = 360.0 * np.round((middle - 0.5 * (outline[:, 0].max() + outline[:, 0].min())) / 360.0)
    return np.asarray(outline + np.array([shift, 0.0]))


def _refined(corners: Floats) -> Floats:
    """Subdivide edges that are long in longitude, as near a pole a straight edge is curved on the map."""
    ring = np.hypot(corners[:, 0], corners[:, 1])
    longitude = np.degrees(np.arctan2(corners[:, 1], corners[:, 0]))
    steps = np.abs((np.roll(longitude, -1) - longitude + 180.0) % 360.0 - 180.0)
    at_pole = ring < 1e-9 * np.abs(corners).max()
    steps[at_pole | np.roll(at_pole, -1)] = 0.0
    rows = []
    for corner, other, step in zip(corners, np.roll(corners, -1, axis=0), steps, strict=True):
        count = max(1, int(np.ceil(step / _STRAIGHT - 1e-9)))
        # The order of points is the one that the cell on the other side of the edge has, too.
        rows += [corner + (other - corner) * (k / count) for k in range(count)]
    return np.array(rows)


def surface_scene(field: SurfaceField | SurfaceRange, quantity: str = "slope", ax: Any = None, **kwargs: Any) -> Any:
    """Draw a field on a body's surface in 3D, in the body frame.

    Parameters
    ----------
    field : SurfaceField or SurfaceRange
    quantity : str
        As for :func:`surface_map`.
    ax : matplotlib Axes3D, optional
        Those to draw on, which are returned.
    **kwargs
        Passed to ``Poly3DCollection``: ``cmap``, ``clim`` and others.
    """
    values, phrase, unit = _values(field, quantity)
    ax = _axes_3d(ax)
    cells = without_unit(field.cells)
    # Smoothed edges would show the seams between the faces.
    style = {"array": values, "linewidths": 0.0, "antialiaseds": False}
    artist = ax.add_collection3d(polygons_3d(cells, **{**style, **kwargs}))
    ax.figure.colorbar(artist, ax=ax, label=f"{phrase} [{unit}]", shrink=0.6, pad=0.1)
    _set_equal_scales(ax, cells, field.point)
    ax.set_title(escaped(field.name))
    return ax


def impacts(flight: Flight, body: int | str, ax: Any = None, *, colour: str | None = "time", **kwargs: Any) -> Any:
    """Draw where particles have struck a body or lie on it, on a map of longitudes and latitudes in degrees.

    Parameters
    ----------
    flight : Flight
    body : int or str
    ax : matplotlib Axes, optional
        Those to draw on, which are returned.
    colour : {"time", "speed", "incidence"} or None
        The quantity that the colour of a dot shows: the time, the speed, or the angle to the normal of the last impact.
    **kwargs
        Passed to ``scatter``: ``s``, ``cmap``, ``norm`` and others.
    """
    index = flight.context.index(body)
    if colour is not None:
        choice(colour, "colour", _COLOURS)
    colour_options = {"c", "color"} & kwargs.keys()
    if colour_options and colour is not None:
        text = f"{colour_options.pop()} is given beside colour={colour!r}"
        raise InvalidInput(f"{text}; expected colour=None with a colour of dots")
    landed = (flight.fate_body == index) & np.isin(flight.fate, ("impact", "rest"))
    ax = single(ax, (8.0, 4.4))
    # Many dots are smaller than few.
    style: dict[str, Any] = {"s": float(np.clip(4000.0 / max(1, landed.sum()), 4.0, 25.0)), "rasterized": True}
    style |= {"edgecolors": "0.2", "linewidths": 0.3} if style["s"] > 8.0 else {"linewidths": 0.0}
    if colour is None:
        style |= {} if colour_options else {"color": LINES[0]["color"]}
    else:
        values = getattr(flight, "fate_time" if colour == "time" else colour)
        in_degrees = colour == "incidence"
        unit = "deg" if in_degrees else unit_of(values)
        style["c"] = (np.degrees(without_unit(values)) if in_degrees else without_unit(values))[landed]
    longitude, latitude = (np.degrees(flight.arrays[name][landed]) for name in ("longitude", "latitude"))
    artist = ax.scatter(longitude, latitude, **{**style, **kwargs})
    if colour is not None:
        colour_bar(ax, artist, _COLOURS[colour], unit)
    set_up_map(ax)
    ax.set_title(f"{escaped(flight.context.names[index])}, {int(landed.sum())} of {len(flight)} particles")
    grid(ax)
    return ax


def zero_velocity(pair: Synodic, levels: Any = None, ax: Any = None, *, extent: Any = None, **kwargs: Any) -> Any:
    """Draw zero-velocity curves of a pair in the plane z = 0 of its rotating frame, with its equilibrium points.

    The legend names the points. Filled marks are stable points, open marks unstable ones. The curve through the point
    between the bodies bounds their Roche lobes.

    Parameters
    ----------
    pair : Synodic
    levels : sequence of float or Quantity, optional
        Jacobi constants of the curves; by default those of the equilibrium points.
    ax : matplotlib Axes, optional
        Those to draw on, which are returned.
    extent : float or Quantity, optional
        Half the side length of the picture.
    **kwargs
        Passed to ``Axes.contour``.
    """
    number, points = pair.system.context.units.number, pair.equilibria()
    constants = {point.name: float(without_unit(point.jacobi)) for point in points}
    requested = constants.values() if levels is None else [number(c, "potential", "one of levels") for c in levels]
    # Curves of nearly equal constants would cover each other.
    distinct_levels: list[float] = []
    for level in sorted(requested):
        if not distinct_levels or level - distinct_levels[-1] > 1e-9 * abs(level):
            distinct_levels.append(level)
    ax = single(ax, (6.4, 5.6))
    *axes, jacobi = pair.plane(extent)
    x, y, values = map(without_unit, (*axes, jacobi))
    jacobi_si = in_si(jacobi)
    scale = float(without_unit(jacobi_si).flat[0] / values.flat[0])
    low, high = (min(constants.values(), default=values.min()), max(constants.values(), default=values.max()))
    span = max(high - low, 0.05 * abs(high))
    ticks = matplotlib("ticker").MaxNLocator(12).tick_values(scale * low, scale * (high + span))
    # One grey for each band between levels, and for the values below and above these.
    greys = [f"{shade:.3f}" for shade in np.linspace(1.0, 0.45, len(ticks) + 1)]
    filled = ax.contourf(x, y, scale * values, levels=ticks, colors=greys, extend="both")
    # Edges in the colours of the bands cover the seams between these.
    filled.set_edgecolor("face")
    colour_bar(ax, filled, "Jacobi constant", unit_of(jacobi_si))
    colours = [LINES[k % len(LINES)]["color"] for k in range(len(distinct_levels))]
    curves = ax.contour(x, y, values, **{"levels": distinct_levels, "colors": colours, "linewidths": 1.1, **kwargs})
    # At a maximum of the potential there is no curve for the legend to name.
    sizes = [np.ptp(path.vertices, axis=0).max() if len(path) else 0.0 for path in curves.get_paths()]
    visible = np.array(sizes) > 0.02 * np.ptp(x)
    for k, body in enumerate(pair.system.context.bodies):
        _silhouette(ax, pair, k, body)
    text = {"textcoords": "offset points", "ha": "center", "fontsize": "small", "zorder": 5}
    text["arrowprops"] = {"arrowstyle": "-", "linewidth": 0.6, "shrinkB": 2.0}
    # A name that lies on a curve interrupts it.
    text["bbox"] = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 0.8}
    for point in points:
        at = without_unit(point.position)
        face = "black" if point.stable else "white"
        ax.plot(*at[:2], marker="o", markersize=3.5, color="black", markerfacecolor=face, zorder=4)
        # Names are placed aside of the bodies, to which the points beside them are near.
        nearest = pair.frame.centres[np.argmin(np.linalg.norm(pair.frame.centres - at, axis=1))]
        above = 26.0 if abs(at[1]) < 0.2 * pair.frame.distance else 9.0
        ax.annotate(point.name, at[:2], xytext=(np.sign(at[0] - nearest[0]) * 9.0, above), **text)
    ax.set(xlabel=_length(pair.position, "x"), ylabel=_length(pair.position, "y"), aspect="equal")
    ax.set_title(escaped(f"rotating frame of {' and '.join(pair.system.context.names)}"), fontsize="medium")
    grid(ax)
    curve, dot = matplotlib("lines").Line2D, {"linestyle": "none", "marker": "o", "markersize": 4, "color": "black"}
    handles = []
    for level, colour in compress(zip(distinct_levels, colours, strict=True), visible):
        names = [name for name, constant in constants.items() if abs(constant - level) <= 1e-9 * abs(level)]
        label = f"through {', '.join(names)}" if names else f"{scale * level:.4g}"
        handles.append(curve([], [], color=colour, label=label))
    for stable, label in ((True, "stable point"), (False, "unstable point")):
        if any(point.stable == stable for point in points):
            handles.append(curve([], [], **dot, markerfacecolor="black" if stable else "white", label=label))
    style = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.11), "ncols": 4, "frameon": False, "fontsize": "small"}
    ax.legend(handles=handles, **style)
    return ax


def roche_lobes(pair: Synodic, ax: Any = None, *, rows: int = 45, **kwargs: Any) -> Any:
    """Draw the Roche lobes of a pair in 3D, with the bodies in them.

    Parameters
    ----------
    pair : Synodic
    ax : matplotlib Axes3D, optional
        Those to draw on, which are returned.
    rows : int
        The number of rows of the lobes' meshes.
    **kwargs
        Passed to ``Axes3D.plot_surface``.
    """
    ax = _axes_3d(ax)
    all_points = []
    for k, (name, body) in enumerate(zip(pair.system.context.names, pair.system.context.bodies, strict=True)):
        colour = LINES[k % len(LINES)]["color"]
        points = without_unit(pair.roche_lobe(name, rows=rows).points)
        all_points.append(points.reshape(-1, 3))
        style = {"color": colour, "alpha": 0.18, "linewidth": 0.1, "rstride": 1, "cstride": 1, "label": escaped(name)}
        ax.plot_surface(*np.moveaxis(points, -1, 0), **{**style, **kwargs})
        cells = _cells(pair, k, body)
        if len(cells):
            ax.add_collection3d(polygons_3d(cells, facecolors=colour, shade=True))
        else:
            ax.plot(*pair.frame.centres[k][:, None], marker="o", color=colour)
    _set_equal_scales(ax, np.concatenate(all_points), pair.position)
    ax.legend(loc="upper left", frameon=False, fontsize="small")
    return ax


def _cells(pair: Synodic, index: int, body: Any) -> Floats:
    """Return the cells of a body's surface (S, 4, 3) in the rotating frame."""
    rotation = pair.frame.rotation.T @ pair.frame.attitudes[index]
    return pair.frame.centres[index] + samples(body, 24).cells @ rotation.T


def _silhouette(ax: Any, pair: Synodic, index: int, body: Any) -> None:
    """Draw a body as seen along z, or a dot for a point."""
    cells = _cells(pair, index, body)[..., :2]
    style = {"facecolors": "#56B4E9", "edgecolors": "#56B4E9", "linewidths": 0.3, "zorder": 3}
    if len(cells):
        ax.add_collection(matplotlib("collections").PolyCollection(cells, **style))
    else:
        ax.plot(*pair.frame.centres[index][:2], marker=".", color="#56B4E9", zorder=3)


def _axes_3d(ax: Any) -> Any:
    """Return the caller's axes in 3D, or new ones."""
    if ax is not None:
        return check_axes(ax, "ax", "3d")
    return matplotlib().figure(figsize=(7.0, 5.4), layout="constrained").add_subplot(projection="3d")


def _set_equal_scales(ax: Any, points: Floats, like: Any) -> None:
    """Set equal scales that contain points (..., 3), and labels with the unit of a length."""
    low, high = points.reshape(-1, 3).min(axis=0), points.reshape(-1, 3).max(axis=0)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(high - low)
    for letter in "xyz":
        getattr(ax, f"set_{letter}label")(_length(like, letter))
