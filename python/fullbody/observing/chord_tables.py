"""Tables of observed chords, with a row for each station."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..base.foreign import are_dates
from ..base.units import need
from ..errors import InvalidInput

#: The columns that hold places on the Earth, and vectors; those of the vectors at the second time have the suffix.
_EARTH, _VECTOR, _LATER = ("longitude", "latitude", "height"), ("x", "y", "z"), "_at_reappearance"
_TIMES = ("disappearance", "reappearance")
_WATCH = ("watched_from", "watched_until")
_KNOWN = (*_TIMES, "sigma_disappearance", "sigma_reappearance", "body", *_WATCH, *_EARTH, *_VECTOR)


def to_table(stations: Any, chords: Any, watched: Any, errors: Any, bodies: tuple[Any, ...]) -> Any:
    """Return an astropy ``QTable`` of chords: dates, masked where not known, or others (S, 2) with NaN."""
    with need("observing", "a table"):
        from astropy.table import QTable

    columns: dict[str, Any] = {name: _masked(chords[:, side]) for side, name in enumerate(_TIMES)}
    columns |= {f"sigma_{name}": errors[:, side] for side, name in enumerate(_TIMES)}
    columns["body"] = ["" if body is None else str(body) for body in bodies]
    if watched is not None:
        columns |= {name: _masked(watched[:, side]) for side, name in enumerate(_WATCH)}
    if stations.on_earth:
        place = stations.locations.to_geodetic("WGS84")
        columns |= dict(zip(_EARTH, (place.lon, place.lat, place.height), strict=True))
    else:
        vectors = stations.vectors
        parts = [vectors] if vectors.ndim == 2 else [vectors[:, 0], vectors[:, 1]]
        for part, suffix in zip(parts, ("", _LATER), strict=False):
            columns |= {f"{_VECTOR[k]}{suffix}": part[:, k] for k in range(part.shape[1])}
    return QTable(columns)


def _masked(times: Any) -> Any:
    """Return times as a column in which those that are not known are masked."""
    if are_dates(times):
        return times
    from astropy.table import MaskedColumn

    values = np.asarray(getattr(times, "value", times))
    return MaskedColumn(np.nan_to_num(values), mask=np.isnan(values), unit=getattr(times, "unit", None))


def from_table(
    table: Any, columns: Mapping[str, Any] | None, unit: Any, dates: tuple[str, str] | None, options: dict[str, Any]
) -> dict[str, Any]:
    """Return arguments of an occultation from a table; see :meth:`fullbody.observing.StellarOccultation.from_table`."""
    found = getattr(table, "colnames", getattr(table, "columns", None))
    if found is None:
        raise InvalidInput(f"table of StellarOccultation is {table!r}; expected a table of astropy or pandas")
    names = dict(columns or {})
    present = list(found)

    def has(name: str) -> bool:
        return names.get(name, name) in present

    def column(name: str) -> Any:
        called = names.get(name, name)
        if called not in present:
            raise InvalidInput(f"the table has no column {called!r} for {name} of StellarOccultation; it has {present}")
        return table[called]

    arguments: dict[str, Any] = {name: _times(column(name), unit, dates) for name in _TIMES}
    if "sigma" not in options:
        parts = [column(f"sigma_{name}") for name in _TIMES]
        arguments["sigma"] = np.stack([_united(part, unit) for part in parts], axis=-1)
    if "body" not in options and has("body"):
        arguments["body"] = [str(body) or None for body in column("body")]
    if all(map(has, _WATCH)):
        arguments["watched"] = tuple(_times(column(name), unit, dates) for name in _WATCH)
    if "stations" not in options:
        arguments["stations"] = _stations(has, column)
    return arguments


def _times(values: Any, unit: Any, dates: tuple[str, str] | None) -> Any:
    if dates is None or are_dates(values):
        return values if are_dates(values) else _united(values, unit)
    from astropy.time import Time

    mask = np.ma.getmaskarray(np.ma.asarray(values))
    plain = np.where(mask, np.asarray(values)[int(np.argmin(mask))], np.asarray(values))
    found = Time(plain, format=dates[0], scale=dates[1])
    if mask.any():
        found[mask] = np.ma.masked
    return found


def _united(values: Any, unit: Any) -> Any:
    """Return a column as numbers or a Quantity, with NaN for masked values."""
    own = getattr(values, "unit", None) or unit
    plain = getattr(values, "unmasked", values)
    numbers = np.array(getattr(plain, "value", plain), dtype=np.float64)
    if (mask := getattr(values, "mask", None)) is not None and np.shape(mask) == numbers.shape:
        numbers[np.asarray(mask)] = np.nan
    if own is None:
        return numbers
    from astropy import units as u

    return numbers * u.Unit(own)


def _stations(has: Any, column: Any) -> Any:
    """Return the stations of a table."""
    if all(map(has, _EARTH)):
        from astropy import units as u
        from astropy.coordinates import EarthLocation

        longitude, latitude, height = (
            _united(column(name), unit) for name, unit in zip(_EARTH, ("deg", "deg", "m"), strict=True)
        )
        return EarthLocation.from_geodetic(longitude.to(u.deg), latitude.to(u.deg), height.to(u.m))
    count = 3 if has("z") else 2
    places = [np.stack([_united(column(name), None) for name in _VECTOR[:count]], axis=-1)]
    if has(f"x{_LATER}"):
        places.append(np.stack([_united(column(f"{name}{_LATER}"), None) for name in _VECTOR[:count]], axis=-1))
        return np.stack(places, axis=1)
    return places[0]
