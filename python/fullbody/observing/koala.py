"""Files of stellar occultations in the format of KOALA, which ADAM reads too."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.units import need
from ..files.text import Text
from ..frames import rotation
from ..typing import Floats
from .geometry import Geometry
from .report import masked_dates, selected
from .sky import east_and_north

#: The time in s by which the geometry extends beyond the times of the chords.
_MARGIN = 3600.0
#: The number of columns of a chord that are read, and the type of a chord that is a miss.
_COLUMNS, _MISS = 9, -1
_CHORD = tuple(range(_COLUMNS, 20))

#: The vector to the Earth, its rate of change, and the words of the chords of an event.
_Event = tuple[Floats, Floats, list[list[str]]]


def read_koala(path: Any, event: int | None, scale: str) -> dict[str, Any]:
    """Return arguments of an event; see :meth:`fullbody.observing.StellarOccultation.read_koala`."""
    text = Text(path)
    text.lines = [line.split("<-")[0].split("#")[0] for line in text.lines]
    to_earth, velocity, chords = selected(_events(text), event, path)
    return _arguments(to_earth, velocity, chords, scale)


def _events(text: Text) -> list[_Event]:
    """Return the events of a file."""
    rows, form = text.words(), "in the format of KOALA"
    if not rows:
        text.fail(None, f"the file is empty and not {form}; expected the number of events")
    line, words = rows[0]
    if not words[0].isdecimal():
        text.fail(line, f"the line begins with {words[0]!r}, not {form}; expected the number of events")
    events: list[_Event] = []
    first = 1
    for _ in range(int(words[0])):
        vectors = []
        for k, what in enumerate(("the vector to the Earth in km", "its rate of change in km/s")):
            line, words = text.expected(rows, first + k, (3,), f"{what}, three numbers")
            vectors.append(np.array([text.number(line, word, what) for word in words]))
        line, words = text.expected(rows, first + 3, tuple(range(1, 10)), "the number of chords")
        count = text.whole_number(line, words[0], "the number of chords")
        chords = []
        for k in range(first + 4, first + 4 + count):
            line, words = text.expected(rows, k, _CHORD, f"a line for each chord, of {_COLUMNS} columns")
            for column, word in enumerate(words[:_COLUMNS], 1):
                text.number(line, word, f"column {column} of a chord")
            chords.append(words[:_COLUMNS])
        events.append((vectors[0], vectors[1], chords))
        first += 4 + count
    return events


def _arguments(to_earth: Floats, velocity: Floats, chords: list[list[str]], scale: str) -> dict[str, Any]:
    with need("observing", "the chords of a file"):
        from astropy import units as u
        from astropy.time import Time

    days = [[chord[k].partition(".") for k in (0, 4)] for chord in chords]
    integer, fraction = (
        np.array([[float(f"{prefix}{day[k]}") for day in row] for row in days]) for k, prefix in ((0, ""), (2, "0."))
    )
    times = Time(integer, fraction, format="jd", scale=scale)
    start = times[0, 0]
    elapsed = np.asarray((times - start).to_value("s"))
    middle = elapsed.mean()
    numbers = np.array(chords, dtype=np.float64)
    # The coordinates are to the west and to the north, in a plane that moves with the shadow.
    positions = np.stack([-numbers[:, [2, 6]], numbers[:, [3, 7]]], axis=-1)
    star = -to_earth / np.linalg.norm(to_earth)
    drift = east_and_north(star, rotation("equatorial", "ecliptic")[:, 2]) @ velocity
    stations = positions - positions.mean(axis=(0, 1)) - (elapsed - middle)[..., None] * drift
    ends = np.array([elapsed.min() - _MARGIN, elapsed.max() + _MARGIN])
    vectors = to_earth + np.outer(ends - middle, velocity)
    is_miss = numbers[:, 8] == _MISS
    return {
        "star": star,
        "stations": stations * u.km,
        "disappearance": masked_dates(times[:, 0], is_miss),
        "reappearance": masked_dates(times[:, 1], is_miss),
        "sigma": numbers[:, [1, 5]] * u.s,
        "geometry": Geometry(start + ends * u.s, to_observer=vectors * u.km, frame="ecliptic"),
        "watched": (times[:, 0], times[:, 1]) if is_miss.any() else None,
    }
