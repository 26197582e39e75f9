"""Maps of the points where particles strike a body."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.kinds import choice
from ..errors import InvalidInput
from ._style import LINES, colour_bar, escaped, grid, numbers, single, unit_of, world

if TYPE_CHECKING:
    from ..particles.flight import Flight

#: The quantities that may colour an impact, with their labels.
_COLOURS = {"time": "time", "speed": "speed", "incidence": "angle of incidence"}


def impacts(flight: Flight, body: int | str, ax: Any = None, *, colour: str | None = "time", **kwargs: Any) -> Any:
    """Draw where particles have struck a body or lie on it, on a map of longitudes and latitudes in degrees.

    Parameters
    ----------
    flight : Flight
    body : int or str
    ax : matplotlib Axes, optional
    colour : {"time", "speed", "incidence"} or None
        The quantity that the colour of a dot shows: the time, the speed, or the angle to the normal of the last impact.
    **kwargs
        Passed to ``scatter``: ``s``, ``cmap``, ``norm`` and others.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    InvalidInput
        For a body that the system does not have, or another colour.
    """
    index = flight.context.index(body)
    if colour is not None:
        choice(colour, "colour", _COLOURS)
    own_colour = {"c", "color"} & kwargs.keys()
    if own_colour and colour is not None:
        raise InvalidInput(
            f"{own_colour.pop()} is given beside colour={colour!r}; expected colour=None with a colour of dots"
        )
    struck = (flight.fate_body == index) & np.isin(flight.fate, ("impact", "rest"))
    ax = single(ax, (8.0, 4.4))
    style: dict[str, Any] = {"s": 4.0, "linewidths": 0.0, "rasterized": True}
    if colour is None:
        style |= {} if own_colour else {"color": LINES[0]["color"]}
    else:
        values = getattr(flight, "fate_time" if colour == "time" else colour)
        in_degrees = colour == "incidence"
        unit = "deg" if in_degrees else unit_of(values)
        style["c"] = (np.degrees(numbers(values)) if in_degrees else numbers(values))[struck]
    longitude, latitude = (np.degrees(flight.arrays[name][struck]) for name in ("longitude", "latitude"))
    drawn = ax.scatter(longitude, latitude, **{**style, **kwargs})
    if colour is not None:
        colour_bar(ax, drawn, f"{_COLOURS[colour]} [{unit}]")
    world(ax)
    ax.set_title(f"{escaped(flight.context.names[index])}, {int(struck.sum())} of {len(flight)} particles")
    grid(ax)
    return ax
