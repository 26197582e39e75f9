"""Tables of observed chords, with a row for each station."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base.foreign import are_dates
from .columns import DataColumn
from .event_tables import table_of

_TIMES, _WATCH = ("disappearance", "reappearance"), ("watched_from", "watched_until")
#: The columns of stations on the Earth, and of vectors; those of vectors at the second time have the suffix.
_EARTH, _VECTOR, _LATER = ("longitude", "latitude", "height"), ("x", "y", "z"), "_at_reappearance"
_STATIONS = (*_EARTH, *_VECTOR, *(f"{name}{_LATER}" for name in _VECTOR))

#: The columns of a table.
COLUMNS = (
    *(DataColumn(name, kind="times") for name in _TIMES),
    DataColumn("sigma", parts=tuple(f"sigma_{name}" for name in _TIMES)),
    DataColumn("body", required=False, kind="labels"),
    *(DataColumn(name, required=False, kind="times") for name in _WATCH),
    *(DataColumn(name, required=False, kind="numbers") for name in _STATIONS),
)


def to_table(stations: Any, chords: Any, watched: Any, errors: Any, bodies: tuple[Any, ...]) -> Any:
    """Return an astropy ``QTable`` of chords: dates, masked where they were not timed, or others (S, 2) with NaN."""
    columns: dict[str, Any] = {name: _masked(chords[:, side]) for side, name in enumerate(_TIMES)}
    columns |= {f"sigma_{name}": errors[:, side] for side, name in enumerate(_TIMES)}
    columns["body"] = ["" if body is None else str(body) for body in bodies]
    if watched is not None:
        columns |= {name: _masked(watched[:, side]) for side, name in enumerate(_WATCH)}
    if stations.on_earth:
        geodetic = stations.locations.to_geodetic("WGS84")
        columns |= dict(zip(_EARTH, (geodetic.lon, geodetic.lat, geodetic.height), strict=True))
    else:
        vectors = stations.vectors
        parts = [vectors] if vectors.ndim == 2 else [vectors[:, 0], vectors[:, 1]]
        for part, suffix in zip(parts, ("", _LATER), strict=False):
            columns |= {f"{_VECTOR[k]}{suffix}": part[:, k] for k in range(part.shape[1])}
    return table_of(columns)


def _masked(times: Any) -> Any:
    """Return times as a column in which those that are NaN are masked."""
    if are_dates(times):
        return times
    from astropy.table import MaskedColumn

    values = np.asarray(getattr(times, "value", times))
    return MaskedColumn(np.nan_to_num(values), mask=np.isnan(values), unit=getattr(times, "unit", None))


def arguments_of_columns(columns: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments of an occultation that the columns of a table contain."""
    arguments = {name: values for name, values in columns.items() if name not in (*_WATCH, *_STATIONS, "body")}
    if "body" in columns:
        arguments["body"] = [str(body) or None for body in columns["body"]]
    if all(name in columns for name in _WATCH):
        arguments["watched"] = tuple(columns[name] for name in _WATCH)
    if all(name in columns for name in _EARTH):
        from astropy import units as u
        from astropy.coordinates import EarthLocation

        units = zip(_EARTH, (u.deg, u.deg, u.m), strict=True)
        arguments["stations"] = EarthLocation.from_geodetic(*(u.Quantity(columns[name], unit) for name, unit in units))
    elif "x" in columns:
        at_times = [
            np.stack([columns[f"{name}{suffix}"] for name in _VECTOR if f"{name}{suffix}" in columns], axis=-1)
            for suffix in ("", _LATER)
            if f"x{suffix}" in columns
        ]
        arguments["stations"] = at_times[0] if len(at_times) == 1 else np.stack(at_times, axis=1)
    return arguments
