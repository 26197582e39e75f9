"""Fields on surfaces as maps and in 3D, and the rotating frame of a pair with what it tells."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..base.arguments import named_options
from ..errors import InvalidInput
from ..fields.samples import samples
from ._style import LINES, check_axes, grid, matplotlib, numbers, plain, single, unit_of, world

if TYPE_CHECKING:
    from ..fields.surface import SurfaceField
    from ..fields.synodic import Synodic

__all__ = ["roche_lobes", "surface_map", "surface_scene", "zero_velocity"]

_Numbers = npt.NDArray[np.float64]
#: What can be shown of a surface, and how it is called.
_SHOWN = {"slope": "slope", "geopotential": "geopotential", "surface_acceleration": "surface acceleration"}


def _values(field: SurfaceField, quantity: str) -> tuple[_Numbers, str]:
    """Numbers of a quantity, an angle in degrees, and its label."""
    if quantity not in _SHOWN:
        raise InvalidInput(f"quantity is {quantity!r}; expected one of {', '.join(map(repr, _SHOWN))}")
    value = getattr(field, quantity)
    if quantity == "slope":
        return np.degrees(numbers(value)), "slope [deg]"
    return numbers(value), f"{_SHOWN[quantity]} [{unit_of(value)}]"


def _length(value: Any, letter: str) -> str:
    return f"{letter} [{unit_of(value)}]"


@named_options
def surface_map(field: SurfaceField, quantity: str = "slope", ax: Any = None, **kwargs: Any) -> Any:
    """A field on a body's surface as a map of longitudes and latitudes, in degrees.

    Parameters
    ----------
    field : SurfaceField
        Of :func:`fullbody.fields.surface`.
    quantity : {"slope", "geopotential", "surface_acceleration"}
    ax : matplotlib Axes, optional
    **kwargs
        To ``PolyCollection``: ``cmap``, ``clim`` and others.

    Returns
    -------
    matplotlib Axes
    """
    values, label = _values(field, quantity)
    ax = single(ax, (8.0, 4.4))
    corners = numbers(field.cells)
    x, y, z = np.moveaxis(corners, -1, 0)
    middle = np.degrees(numbers(field.longitude))[:, None]
    ring = np.hypot(x, y)
    longitude = middle + (np.degrees(np.arctan2(y, x)) - middle + 180.0) % 360.0 - 180.0
    # A pole has all longitudes: that of the next corner, on either side.
    pole = ring < 1e-9 * np.abs(corners).max()
    for k in range(4):
        beside = np.where(pole[:, k - 1], longitude[:, (k + 1) % 4], longitude[:, k - 1])
        longitude[:, k] = np.where(pole[:, k], beside, longitude[:, k])
    cells = np.stack([longitude, np.degrees(np.arctan2(z, ring))], axis=-1)
    # Cells across the edge of the map stand on both sides of it.
    right, left = (longitude > 180.0).any(axis=1), (longitude < -180.0).any(axis=1)
    turn = np.array([360.0, 0.0])
    cells = np.concatenate([cells, cells[right] - turn, cells[left] + turn])
    colours = np.concatenate([values, values[right], values[left]])
    style = {"array": colours, "antialiased": False, "rasterized": True, **kwargs}
    drawn = ax.add_collection(matplotlib("collections").PolyCollection(cells, **style))
    ax.figure.colorbar(drawn, ax=ax, label=label, shrink=0.85)
    world(ax)
    ax.set_title(plain(field.name))
    return ax


@named_options
def surface_scene(field: SurfaceField, quantity: str = "slope", ax: Any = None, **kwargs: Any) -> Any:
    """A field on a body's surface in 3D, in the body frame.

    Parameters
    ----------
    field : SurfaceField
    quantity : {"slope", "geopotential", "surface_acceleration"}
    ax : matplotlib Axes3D, optional
    **kwargs
        To ``Poly3DCollection``: ``cmap``, ``clim`` and others.

    Returns
    -------
    matplotlib Axes3D
    """
    values, label = _values(field, quantity)
    ax = _stage(ax)
    cells = numbers(field.cells)
    drawn = ax.add_collection3d(_polygons(cells, **{"array": values, "linewidths": 0.0, **kwargs}))
    ax.figure.colorbar(drawn, ax=ax, label=label, shrink=0.6, pad=0.1)
    _equal(ax, cells, field.point)
    ax.set_title(plain(field.name))
    return ax


@named_options
def zero_velocity(pair: Synodic, levels: Any = None, ax: Any = None, *, extent: Any = None, **kwargs: Any) -> Any:
    """Zero-velocity curves of a pair in the plane z = 0 of its rotating frame, with its equilibrium points.

    Full marks are stable points, open ones are not. The curve through the point between the bodies bounds their Roche
    lobes.

    Parameters
    ----------
    pair : Synodic
    levels : sequence of float or Quantity, optional
        Jacobi constants; those of the equilibrium points unless given.
    ax : matplotlib Axes, optional
    extent : float or Quantity, optional
        Half the side of the picture.
    **kwargs
        To ``Axes.contour``.

    Returns
    -------
    matplotlib Axes
    """
    units, points = pair._units, pair.equilibria()
    constants = {point.name: float(numbers(point.jacobi)) for point in points}
    asked = (
        list(constants.values()) if levels is None else [units.number(c, "potential", "one of levels") for c in levels]
    )
    # Nearly equal ones would be drawn over each other.
    wanted: list[float] = []
    for level in sorted(asked):
        if not wanted or level - wanted[-1] > 1e-9 * abs(level):
            wanted.append(level)
    ax = single(ax, (6.4, 5.6))
    x, y, found = (numbers(value) for value in pair.plane(extent))
    low, high = (min(constants.values(), default=found.min()), max(constants.values(), default=found.max()))
    span = max(high - low, 0.05 * abs(high))
    shades = {"levels": np.linspace(low, high + span, 16), "cmap": "Greys", "extend": "max", "alpha": 0.6}
    filled = ax.contourf(x, y, found, **shades)
    ax.figure.colorbar(filled, ax=ax, label=f"Jacobi constant [{unit_of(pair.jacobi([[0.0, 0.0, 0.0]]))}]", shrink=0.85)
    colours = [LINES[k % len(LINES)]["color"] for k in range(len(wanted))]
    ax.contour(x, y, found, **{"levels": wanted, "colors": colours, "linewidths": 1.1, **kwargs})
    for k, body in enumerate(pair._bodies):
        _silhouette(ax, pair, k, body)
    for point in points:
        place = numbers(point.position)
        face = "black" if point.stable else "white"
        ax.plot(*place[:2], marker="o", markersize=5, color="black", markerfacecolor=face, zorder=4)
        ax.annotate(point.name, place[:2], xytext=(5, 5), textcoords="offset points", fontsize="small", zorder=4)
    ax.set(xlabel=_length(pair.position, "x"), ylabel=_length(pair.position, "y"), aspect="equal")
    ax.set_title(plain(f"rotating frame of {' and '.join(pair.system.names)}"), fontsize="medium")
    grid(ax)
    return ax


@named_options
def roche_lobes(pair: Synodic, ax: Any = None, *, rows: int = 45, **kwargs: Any) -> Any:
    """The Roche lobes of a pair in 3D, with the bodies in them.

    Parameters
    ----------
    pair : Synodic
    ax : matplotlib Axes3D, optional
    rows : int
        Of the lobes' meshes.
    **kwargs
        To ``Axes3D.plot_surface``.

    Returns
    -------
    matplotlib Axes3D
    """
    ax = _stage(ax)
    all_points = []
    for k, (name, body) in enumerate(zip(pair.system.names, pair._bodies, strict=True)):
        colour = LINES[k % len(LINES)]["color"]
        points = numbers(pair.roche_lobe(name, rows=rows).points)
        all_points.append(points.reshape(-1, 3))
        style = {"color": colour, "alpha": 0.18, "linewidth": 0.1, "rstride": 1, "cstride": 1, "label": plain(name)}
        ax.plot_surface(*np.moveaxis(points, -1, 0), **{**style, **kwargs})
        cells = _cells(pair, k, body)
        if len(cells):
            ax.add_collection3d(_polygons(cells, facecolors=colour, shade=True))
        else:
            ax.plot(*pair._centres[k][:, None], marker="o", color=colour)
    _equal(ax, np.concatenate(all_points), pair.position)
    ax.legend(loc="upper left", frameon=False, fontsize="small")
    return ax


def _cells(pair: Synodic, place: int, body: Any) -> _Numbers:
    """The cells of a body's surface (S, 4, 3) in the rotating frame."""
    turn = pair._turn.T @ pair._attitudes[place]
    cells: _Numbers = pair._centres[place] + samples(body, 24).cells @ turn.T
    return cells


def _silhouette(ax: Any, pair: Synodic, place: int, body: Any) -> None:
    """A body as seen along z, or a dot."""
    cells = _cells(pair, place, body)[..., :2]
    style = {"facecolors": "#56B4E9", "edgecolors": "#56B4E9", "linewidths": 0.3, "zorder": 3}
    if len(cells):
        ax.add_collection(matplotlib("collections").PolyCollection(cells, **style))
    else:
        ax.plot(*pair._centres[place][:2], marker=".", color="#56B4E9", zorder=3)


def _stage(ax: Any) -> Any:
    """The caller's axes in 3D, or new ones."""
    if ax is not None:
        return check_axes(ax, "ax", "3d")
    return matplotlib().figure(figsize=(7.0, 5.4), layout="constrained").add_subplot(projection="3d")


def _polygons(cells: _Numbers, **style: Any) -> Any:
    """Polygons in 3D."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    return Poly3DCollection(cells, **style)


def _equal(ax: Any, points: _Numbers, like: Any) -> None:
    """Equal scales about points (..., 3); labels with the unit of a length."""
    low, high = points.reshape(-1, 3).min(axis=0), points.reshape(-1, 3).max(axis=0)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set_box_aspect(high - low)
    for letter in "xyz":
        getattr(ax, f"set_{letter}label")(_length(like, letter))
