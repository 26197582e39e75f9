"""Shared parts of the plots: line styles that are distinct in grey print, labels with units, and numbers to draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

import fullbody._core as _core

from ..base import rotations
from ..base.figures import grid, legend
from ..errors import InvalidInput
from ..model.freeform import ConvexShape
from ..record.record import Record
from ..typing import Floats

ArrayOfAxes: TypeAlias = npt.NDArray[np.object_]

#: The longest time axis in one unit before the next larger unit is used.
_LONG = 1000.0

#: The distance, in sizes of the innermost orbit, beyond which a body is left out of the picture.
_BEYOND = 20.0

#: The longest name of a body that is shown in full, in characters.
_NAME = 12


def unit(run: Record, dimension: str) -> str:
    """Return the unit of a dimension as text, empty if the system has none."""
    units = run.context.units
    return str(units.unit(dimension).to_string("unicode")) if units.defined else ""


def label(run: Record, text: str, dimension: str) -> str:
    """Return an axis label with its unit."""
    name = unit(run, dimension)
    return f"{text} [{name}]" if name else f"{text} [system units]"


def short(name: str, length: int = _NAME) -> str:
    """Return a name, abbreviated if it is longer than a number of characters."""
    return name if len(name) <= length else f"{name[: length - 1]}…"


def label_of(run: Record, body: int) -> str:
    """Return a body's name for a picture, with dollar signs escaped, as they would begin a formula."""
    return escaped(short(run.context.names[body]))


def escaped(text: str) -> str:
    """Escape a text so that matplotlib shows it as it is."""
    return text.replace("$", r"\$")


def names_of(run: Record) -> str:
    """Return the bodies' names as an enumeration."""
    *names, last = (short(name) for name in run.context.names)
    return f"{', '.join(names)} and {last}" if names else last


def axis_unit(run: Record) -> tuple[float, str]:
    """Return the unit of the time axis in the system's unit of time, and its name: days or years for a long run."""
    units = run.context.units
    if not units.defined:
        return 1.0, "system units"
    span = np.abs(run.arrays["time"]).max(initial=0.0)
    for name, word in (("d", "days"), ("yr", "years")):
        per = float(units.unit("time").to(name))
        if span > _LONG and per < 1.0 and (name == "yr" or span * per <= _LONG):
            return 1.0 / per, word
    return 1.0, unit(run, "time")


def unit_of_rate(run: Record) -> str:
    """Return the unit of the time axis in the singular; empty for a system without units."""
    name = axis_unit(run)[1]
    return {"days": "day", "years": "year", "system units": ""}.get(name, name)


def rounded(time: float) -> str:
    """Return a time as the text of a title, with four digits or as a whole number."""
    if time == 0.0:
        return "0"
    decimals = max(0, 3 - int(np.floor(np.log10(abs(time)))))
    text = f"{time:.{decimals}f}"
    return text.rstrip("0").rstrip(".") if decimals else text


def times(run: Record, moments: Floats | None = None) -> Floats:
    """Return the samples' times, or others, in the unit that :func:`time_label` names."""
    return (run.arrays["time"] if moments is None else moments) / axis_unit(run)[0]


def time_label(ax: Any, run: Record) -> None:
    """Label the time axis."""
    ax.set_xlabel(f"time [{axis_unit(run)[1]}]")


def label_axes(ax: Any, text: str, title: str = "") -> None:
    """Label the vertical axis, write a title if there is one, and draw the grid and the legend of named artists."""
    ax.set_ylabel(text)
    if title:
        # With a height, the title stays below pictures above the axes.
        ax.set_title(title, fontsize="medium", loc="left", y=1.0)
    grid(ax)
    legend(ax)


def in_si(value: Any) -> Any:
    """Return energies in joules, those of a unit of mass in m2/s2, and other values as they are."""
    for unit in ("J", "m2 / s2"):
        if hasattr(value, "unit") and value.unit.is_equivalent(unit):
            return value.to(unit)
    return value


def colour_bar(ax: Any, artist: Any, label: str, unit: str, **kwargs: Any) -> Any:
    """Draw a colour bar beside axes, as high as they are, with a power of ten in its label instead of its numbers."""
    bar = ax.figure.colorbar(artist, cax=ax.inset_axes([1.02, 0.0, 0.025, 1.0]), **kwargs)
    largest = np.abs(artist.get_clim()).max()
    power = int(np.floor(np.log10(largest))) if np.isfinite(largest) and largest > 0.0 else 0
    if 10.0**power < 1e4 and power > -3:
        power = 0
    else:
        bar.ax.yaxis.set_major_formatter(lambda value, _: f"{value / 10.0**power:.4g}".replace("-", "\N{MINUS SIGN}"))
    bar.set_label(f"{label} [$10^{{{power}}}$ {unit}]" if power else f"{label} [{unit}]")
    return bar


def set_up_map(ax: Any) -> None:
    """Set up the axes of a map of all longitudes and latitudes, in degrees."""
    ax.set(xlim=(-180, 180), ylim=(-90, 90), xlabel="longitude [deg]", ylabel="latitude [deg]", aspect="equal")
    ax.set(xticks=range(-180, 181, 60), yticks=range(-90, 91, 30))


def polygons_3d(corners: Any, **style: Any) -> Any:
    """Make polygons in 3D of their corners (F, k, 3)."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    return Poly3DCollection(corners, **style)


def body_indices(run: Record, bodies: Sequence[int | str] | None) -> list[int]:
    """Return the indices of the bodies to draw."""
    if bodies is None:
        return list(range(len(run.context)))
    if isinstance(bodies, str):
        raise InvalidInput(f"bodies is {bodies!r}; expected a list of indices or names")
    indices = [run.context.index(body, "one of bodies") for body in bodies]
    if not indices:
        raise InvalidInput("bodies is empty; expected at least one body")
    return indices


def near_and_far(run: Record, about: int | None = None) -> tuple[list[int], list[tuple[int, float]]]:
    """Return the bodies in one picture with ``about``, or with the nearest two, and the others with their distances."""
    position, count = run.arrays["position"], len(run.context)
    if about is None:

        def gap(pair: tuple[int, int]) -> float:
            return float(np.linalg.norm(position[:, pair[0]] - position[:, pair[1]], axis=1).min())

        about = min(combinations(range(count), 2), key=gap, default=(0, 0))[0]
    distance = np.linalg.norm(position - position[:, about, None], axis=2)
    innermost = np.delete(distance.max(axis=0), about).min(initial=np.inf)
    least = distance.min(axis=0)
    outside = least > _BEYOND * innermost if innermost > 0.0 else np.zeros(count, dtype=bool)
    far = [(body, float(least[body])) for body in np.flatnonzero(outside).tolist()]
    return np.flatnonzero(~outside).tolist(), far


def label_of_far(run: Record, body: int, distance: float) -> str:
    """Return the label of a body that is outside the picture."""
    return f"{label_of(run, body)}: outside, {distance:.2g} {unit(run, 'length')}".rstrip()


def check_samples(run: Record) -> None:
    """Raise an error for a run without samples."""
    if len(run) == 0:
        raise InvalidInput("the run has no samples; expected at least one to draw")


class RunPlots:
    """Base class of :class:`fullbody.plots.Plots`, whose methods are functions that take an object of this class."""

    __slots__ = ("run",)

    def __init__(self, run: Record) -> None:
        self.run = run

    def sampled(self) -> Record:
        """Return the run, or raise an error for one without samples."""
        check_samples(self.run)
        return self.run


def matrices(run: Record, body: int) -> Floats:
    """Return the rotation matrices (K, 3, 3) of one body along the run."""
    return rotations.matrices(run.arrays["attitude"][:, body])


@dataclass(frozen=True, slots=True)
class Surface:
    """The surface of a part with positive mass, in its body's frame, in the system's units.

    The ``columns`` (3, 3) are the semi-axes as vectors, for a polyhedron those of its circumscribed sphere; then
    ``triangles`` (F, 3, 3) are the corners of its faces, scaled so that this is the unit sphere.
    """

    columns: Floats
    position: Floats
    triangles: Floats | None = None

    @property
    def radius(self) -> float:
        """An upper bound of the distance of the surface's points from the body's centre."""
        return float(np.linalg.norm(self.position) + np.linalg.norm(self.columns, axis=0).max())


def sphere_grid(meridians: int, parallels: int) -> Floats:
    """Return a grid of points (parallels, meridians, 3) of the unit sphere; the first meridian is also the last one."""
    u, v = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, meridians), np.linspace(0.0, np.pi, parallels))
    return np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)


def surfaces(run: Record, body: int) -> list[Surface]:
    """Return the surfaces of a body, without its voids; none for a point and for Stokes coefficients."""
    convex = run.system.bodies[body].shape
    if isinstance(convex, ConvexShape):
        solid = convex.polyhedron()
        vertices = run.context.units.strip(solid.vertices, "length", "vertices")
        size = float(np.linalg.norm(vertices, axis=1).max())
        return [Surface(np.eye(3) * size, np.zeros(3), (vertices / size)[solid.faces])]

    def surface(shape: Any, position: Any, rotation: Any) -> Surface:
        if not isinstance(shape, _core.Polyhedron):
            return Surface(np.array(rotation) * shape, np.array(position))
        size = shape.circumradius
        return Surface(np.array(rotation) * size, np.array(position), (shape.vertices / size)[shape.faces])

    return [
        surface(shape, position, rotation)
        for shape, mass, position, rotation in run.context.bodies[body].parts
        if shape is not None and not isinstance(shape, _core.StokesCoefficients) and mass > 0.0
    ]


def radius(run: Record, body: int) -> float:
    """Return an upper bound of the distance of a body's points from its centre; zero for a point."""
    return max((surface.radius for surface in surfaces(run, body)), default=0.0)
