"""Pictures of sweeps: a quantity along one parameter, or over two, with the members that failed marked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import figures
from ..base.kinds import choice
from ..errors import InvalidInput
from . import _style

if TYPE_CHECKING:
    import xarray

#: The variables of a sweep beside its measures.
_FAILURE = ("error", "error_text", "error_stage")
#: Marks of members that failed, by the kind of error.
_MARKS = "xP*vs^"


def sweep(
    dataset: xarray.Dataset, measure: str, ax: Any = None, *, x: str | None = None, y: str | None = None, **kwargs: Any
) -> Any:
    """Draw a measure of a sweep along one parameter, or as a heat map over two; members that failed are marked.

    Parameters
    ----------
    dataset : xarray.Dataset
        What :func:`fullbody.sweep` returns, with one or two dimensions; of a larger sweep, a part such as
        ``found.isel(mass=0)``.
    measure : str
        The name of a variable with one number or text for each member.
    ax : matplotlib Axes, optional
        Those to draw on, which are returned.
    x, y : str, optional
        The coordinates along the axes; by default the dimensions. Parameters that were paired or drawn share a
        dimension, and ``x`` and ``y`` then choose two of them; without ``y``, the measure itself is the vertical axis.
    **kwargs
        Passed to ``Axes.plot`` along one parameter, to ``Axes.pcolormesh`` over a grid of two and to ``Axes.scatter``
        for members that are not on a grid.

    Returns
    -------
    Axes

    Raises
    ------
    InvalidInput
        For a variable with several numbers for a member, and for a sweep of three or more dimensions.

    Examples
    --------
    >>> import fullbody
    >>> def setup(speed):
    ...     system, state = fullbody.systems.case1()
    ...     return system, state.kick("B", [speed, 0.0, 0.0])
    >>> def eccentricity(run):
    ...     return {"eccentricity": run.elements().e[-1]}
    >>> found = fullbody.sweep(setup, {"speed": [0.0, 0.1]}, 5.0, output=1.0, measure=eccentricity)
    >>> fullbody.plots.sweep(found, "eccentricity").get_xlabel()
    'speed'
    """
    names = [str(name) for name in dataset.data_vars if name not in _FAILURE]
    if not names:
        raise InvalidInput("the sweep has no measure: all members ended with an error, as its variable error says")
    choice(measure, "measure", names)
    dims = [str(dim) for dim in dataset.error.dims]
    if dataset[measure].dims != dataset.error.dims:
        raise InvalidInput(
            f"{measure} has the dimensions {', '.join(map(str, dataset[measure].dims))}; expected a variable with one "
            f"value for a member, along {', '.join(dims)}"
        )
    if not 1 <= len(dims) <= 2:
        raise InvalidInput(
            f"the sweep has the dimensions {', '.join(dims) or 'none'}; expected one or two, such as a part "
            f"dataset.isel({dims[0] if dims else 'mass'}=0)"
        )
    horizontal = _coordinate(dataset, x or dims[0], "x")
    vertical = _coordinate(dataset, y or dims[1], "y") if y is not None or len(dims) == 2 else None
    ax = figures.single(ax, (6.0, 4.0))
    failed, values = dataset.error.values != "", dataset[measure]
    if vertical is None:
        _curve(ax, horizontal.values, values, figures.full_option_names(kwargs))
        ax.set_ylabel(_title(values))
    else:
        grid_of_members = len(dims) == 2 and horizontal.ndim == vertical.ndim == 1
        _map(ax, horizontal.values, vertical.values, values, kwargs, grid_of_members)
        ax.set_ylabel(_title(vertical))
    ax.set_xlabel(_title(horizontal))
    for axis, coordinate in ((ax.xaxis, horizontal), (ax.yaxis, vertical)):
        if coordinate is not None and dataset[coordinate.name].values.dtype.kind == "U":
            axis.set_ticks(range(coordinate.size), [_style.escaped(text) for text in dataset[coordinate.name].values])
    kinds = sorted(set(dataset.error.values[failed].tolist()))
    for kind, marker in zip(kinds, _MARKS * len(kinds), strict=False):
        members = np.nonzero(dataset.error.values == kind)
        style = {"linestyle": "none", "marker": marker, "markersize": 6.0, "color": "#D55E00"}
        style["label"] = f"failed: {kind}"
        if vertical is None:
            # Members without a value are marked at the foot of the axes.
            style |= {"transform": ax.get_xaxis_transform(), "clip_on": False}
            ax.plot(horizontal.values[members], np.zeros(len(members[0])), **style)
        else:
            ax.plot(*(part.values[members[dims.index(str(part.dims[0]))]] for part in (horizontal, vertical)), **style)
    figures.legend(ax, markerscale=1.0)
    return ax


def _coordinate(dataset: xarray.Dataset, name: str, what: str) -> Any:
    """Return a coordinate, or the indices of members along a dimension that has none."""
    choice(name, what, sorted({*map(str, dataset.coords), *map(str, dataset.error.dims)}))
    coordinate = dataset[name]
    if coordinate.values.dtype.kind not in "iuf":
        return coordinate.copy(data=np.arange(coordinate.size))
    return coordinate


def _title(variable: Any) -> str:
    """Return the label of an axis: the name of a variable with its unit."""
    text = _style.escaped(str(variable.name).replace("_", " "))
    return f"{text} [{variable.attrs['units']}]" if "units" in variable.attrs else text


def _coded(values: Any) -> tuple[Any, list[str]]:
    """Return numbers (...) and no names, or for texts the indices in a list of their names."""
    if values.values.dtype.kind in "biuf":
        return np.asarray(values.values, dtype=np.float64), []
    # A member that failed has an empty text.
    names = sorted({*values.values.ravel().tolist()} - {""})
    codes = {"": np.nan, **{name: float(k) for k, name in enumerate(names)}}
    return np.vectorize(codes.get, otypes=[float])(values.values), names


def _curve(ax: Any, x: Any, values: Any, kwargs: dict[str, Any]) -> None:
    """Draw the measure against a parameter, in the order of this."""
    numbers, names = _coded(values)
    order = np.argsort(x)
    style = {"marker": "o", "markersize": 3.5, **({"linestyle": "none"} if names else {})}
    # Members of a sweep of random draws are not joined.
    style |= {} if np.array_equal(order, np.arange(len(x))) else {"linestyle": "none"}
    finite = order[np.isfinite(numbers[order])]
    ax.plot(x[finite], numbers[finite], **figures.line(0, {**style, **kwargs}))
    if names:
        ax.set_yticks(range(len(names)), [_style.escaped(name) for name in names])
    figures.grid(ax)


def _map(ax: Any, x: Any, y: Any, values: Any, kwargs: dict[str, Any], grid_of_members: bool) -> None:
    """Draw the measure over two parameters, with a colour bar."""
    numbers, names = _coded(values)
    colours: dict[str, Any] = {}
    if names:
        kinds = [line["color"] for line in figures.LINES]
        listed = figures.matplotlib("colors").ListedColormap([kinds[k % len(kinds)] for k in range(len(names))])
        colours = {"cmap": listed, "vmin": -0.5, "vmax": len(names) - 0.5}
    if grid_of_members:
        artist = ax.pcolormesh(x, y, numbers.T, **{"shading": "nearest", **colours, **kwargs})
    else:
        artist = ax.scatter(x, y, **{"c": numbers, "s": 16.0, **colours, **kwargs})
    bar = ax.figure.colorbar(artist, ax=ax, label=_title(values))
    if names:
        bar.set_ticks(range(len(names)), labels=[_style.escaped(name) for name in names])
