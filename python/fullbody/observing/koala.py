"""Files of stellar occultations in the format of KOALA, which ADAM reads too."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.units import need
from ..errors import InvalidInput
from ..files.text import Text
from ..frames import rotation
from ..typing import Floats
from .geometry import Geometry
from .star import sky_axes

#: The time in s by which the geometry extends beyond the times of the chords.
_MARGIN = 3600.0
#: The number of columns of a chord, and the type of one that is a miss.
_COLUMNS, _MISS = 9, -1


def read_koala(path: Any, event: int | None, scale: str) -> dict[str, Any]:
    """Return arguments of an event; see :meth:`fullbody.observing.StellarOccultation.read_koala`."""
    lines = [line.split("<-")[0].split("#")[0].split() for line in Text(path).lines]
    events = _events([line for line in lines if line], str(path))
    if event is None and len(events) != 1:
        raise InvalidInput(f"{path} has {len(events)} events; expected event=, a number from 0 to {len(events) - 1}")
    index = 0 if event is None else event
    if index not in range(len(events)):
        raise InvalidInput(f"event is {event!r}; expected a number from 0 to {len(events) - 1}")
    return _arguments(*events[index], scale)


def _events(lines: list[list[str]], name: str) -> list[tuple[Floats, Floats, list[list[str]]]]:
    """Return for each event the vector to the Earth, its rate of change, and the lines of its chords."""
    events = []
    try:
        place = 1
        for _ in range(int(lines[0][0])):
            to_earth, velocity = (np.array(lines[place + k], dtype=np.float64) for k in (0, 1))
            count = int(lines[place + 3][0])
            chords = lines[place + 4 : place + 4 + count]
            if to_earth.shape != (3,) or velocity.shape != (3,) or len(chords) != count:
                raise ValueError("vectors have three numbers each, and there is a line for each chord")
            if any(len(chord) < _COLUMNS for chord in chords):
                raise ValueError(f"a chord has {_COLUMNS} columns")
            events.append((to_earth, velocity, chords))
            place += 4 + count
    except (IndexError, ValueError) as error:
        raise InvalidInput(f"{name} is not in the format of KOALA: {error}") from error
    return events


def _arguments(to_earth: Floats, velocity: Floats, chords: list[list[str]], scale: str) -> dict[str, Any]:
    with need("observing", "the chords of a file"):
        from astropy import units as u
        from astropy.time import Time

    days = [[chord[k].partition(".") for k in (0, 4)] for chord in chords]
    whole, part = (
        np.array([[float(f"{sign}{day[k]}") for day in row] for row in days]) for k, sign in ((0, ""), (2, "0."))
    )
    times = Time(whole, part, format="jd", scale=scale)
    first = times[0, 0]
    since = np.asarray((times - first).to_value("s"))
    middle = since.mean()
    numbers = np.array([chord[:_COLUMNS] for chord in chords], dtype=np.float64)
    # The coordinates are to the west and to the north, in a plane that moves with the shadow.
    places = np.stack([-numbers[:, [2, 6]], numbers[:, [3, 7]]], axis=-1)
    star = -to_earth / np.linalg.norm(to_earth)
    axes = np.stack(sky_axes(star, rotation("equatorial", "ecliptic")[:, 2]))
    drift = axes @ velocity
    stations = places - places.mean(axis=(0, 1)) - (since - middle)[..., None] * drift
    ends = np.array([since.min() - _MARGIN, since.max() + _MARGIN])
    vectors = to_earth + np.outer(ends - middle, velocity)
    missed = numbers[:, 8] == _MISS
    seen = np.where(missed, np.nan, 1.0)
    seconds = since * seen[:, None]
    masked = [_masked(times[:, side], missed) for side in (0, 1)]
    return {
        "star": star,
        "stations": stations * u.km,
        "disappearance": masked[0],
        "reappearance": masked[1],
        "sigma": numbers[:, [1, 5]] * u.s,
        "geometry": Geometry(first + ends * u.s, to_observer=vectors * u.km, frame="ecliptic"),
        "watched": (times[:, 0], times[:, 1]) if np.isnan(seconds).any() else None,
    }


def _masked(times: Any, missed: Any) -> Any:
    """Return dates of which some are masked."""
    found = times.copy()
    if missed.any():
        found[missed] = np.ma.masked
    return found
