"""Reports of the stations of an occultation, as files of several programs have them, and data from them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base.units import need
from ..errors import InvalidInput
from .times import unmasked

_ANGLE = re.compile(r"([+-]?)\s*(\d+(?:\.\d*)?)(?:\s+(\d+(?:\.\d*)?))?(?:\s+(\d+(?:\.\d*)?))?")
_TIME = re.compile(r"(\d+)[\s:]+(\d+)[\s:]+(\d+(?:\.\d*)?)")


class Report(NamedTuple):
    """The report of one station."""

    name: str
    #: The day, such as ``2024-03-01``, from whose beginning in UTC times count.
    date: str
    #: Longitude and latitude in degrees, and the height in m, on the ellipsoid of WGS84.
    position: tuple[float, float, float]
    #: The times of disappearance and reappearance in s, NaN where they were not timed, with their standard errors.
    times: Sequence[float]
    errors: Sequence[float]
    #: The first and the last time of the watch.
    watched: Sequence[float] | None
    #: ``"main"`` or ``"satellite"``.
    body: str


def to_degrees(text: str, what: str) -> float:
    """Return an angle in degrees from degrees, minutes and seconds with a sign, such as ``-110 58 12.5``."""
    if (match := _ANGLE.fullmatch(text.strip())) is None:
        raise InvalidInput(f"{what} is {text!r}; expected degrees, minutes and seconds such as '+14 24 01.2'")
    sign, *parts = match.groups()
    size = sum(float(part or 0.0) / 60.0**k for k, part in enumerate(parts))
    return -size if sign == "-" else size


def to_seconds(text: str, what: str) -> float:
    """Return the seconds since the beginning of the day of a time such as ``23 59 60.12``; hours may be above 24."""
    if (match := _TIME.fullmatch(text.strip())) is None:
        raise InvalidInput(f"{what} is {text!r}; expected hours, minutes and seconds such as '23 50 12.34'")
    return sum(float(part) * size for part, size in zip(match.groups(), (3600.0, 60.0, 1.0), strict=True))


def angle_text(degrees: float, digits: int) -> str:
    """Return an angle as degrees, of a number of digits, minutes and seconds with a sign."""
    return ("-" if degrees < 0.0 else "+") + _sexagesimal(abs(degrees) * 3600.0, digits, 2, " ")


def time_text(seconds: float, separator: str) -> str:
    """Return a time of seconds since the beginning of the day as hours, minutes and seconds to 1 ms."""
    return _sexagesimal(seconds, 2, 3, separator)


def _sexagesimal(seconds: float, digits: int, decimals: int, separator: str) -> str:
    """Return a number of seconds as units of 3600, of a number of digits, of 60 and of one."""
    minutes, seconds = divmod(round(seconds, decimals), 60.0)
    first, minutes = divmod(int(minutes), 60)
    return f"{first:0{digits}d}{separator}{minutes:02d}{separator}{seconds:0{decimals + 3}.{decimals}f}"


def arguments_of(reports: Sequence[Report]) -> dict[str, Any]:
    """Return the arguments of an occultation that reports contain."""
    if not reports:
        raise InvalidInput("the event has no station whose report counts; expected one or more")
    with need("observing", "the stations of an occultation"):
        from astropy import units as u
        from astropy.coordinates import EarthLocation
        from astropy.time import Time

    days = Time([report.date for report in reports], scale="utc")
    times = np.array([report.times for report in reports])
    longitude, latitude, height = np.array([report.position for report in reports]).T
    arguments: dict[str, Any] = {
        "stations": EarthLocation.from_geodetic(longitude * u.deg, latitude * u.deg, height * u.m),
        "sigma": np.array([report.errors for report in reports]) * u.s,
    }
    for side, name in enumerate(("disappearance", "reappearance")):
        arguments[name] = _dates(days, times[:, side])
    if any(report.watched for report in reports):
        watch = np.array([report.watched or (np.nan, np.nan) for report in reports])
        arguments["watched"] = tuple(_dates(days, watch[:, side]) for side in (0, 1))
    return arguments


def selected(events: Sequence[Any], event: int | None, path: Any) -> Any:
    """Return the event of a file with an index, or without it the only one."""
    expected = f"expected a number from 0 to {len(events) - 1}"
    if event is None and len(events) != 1:
        raise InvalidInput(f"{path} has {len(events)} events; give event=, {expected}")
    if (index := 0 if event is None else event) not in range(len(events)):
        raise InvalidInput(f"event is {event!r}; {expected}")
    return events[index]


def _dates(days: Any, seconds: Any) -> Any:
    """Return days plus seconds, masked where these are NaN."""
    from astropy import units as u

    return masked_dates(days + np.nan_to_num(seconds) * u.s, np.isnan(seconds))


def masked_dates(dates: Any, missing: Any) -> Any:
    """Return dates of which those that are ``missing`` are masked."""
    dates = dates.copy()
    if missing.any():
        dates[missing] = np.ma.masked
    return dates


def reports_of(
    stations: Any, chords: Any, errors: Any, watched: Any, bodies: Sequence[str], names: Sequence[str]
) -> list[Report]:
    """Return reports of stations on the Earth from dates (S, 2), errors in s (S, 2) and watches (S, 2), with their day.

    Dates are masked where a contact was not timed, and where no watch is known.
    """
    from astropy.time import Time

    contacts, missing = unmasked(chords.utc)
    date = contacts[~missing].min().isot[:10]
    start = Time(date, scale="utc")

    def seconds(dates: Any) -> Any:
        values, missing = unmasked(dates.utc)
        return np.where(missing, np.nan, (values - start).to_value("s"))

    times = seconds(chords)
    watches = np.full(times.shape, np.nan) if watched is None else seconds(watched)
    reports = []
    for k, (name, body) in enumerate(zip(names, bodies, strict=True)):
        geodetic = stations[k].to_geodetic("WGS84")
        position = float(geodetic.lon.deg), float(geodetic.lat.deg), float(geodetic.height.to_value("m"))
        watch = watches[k].tolist() if np.isfinite(watches[k]).all() else None
        reports.append(Report(name, date, position, times[k].tolist(), errors[k].tolist(), watch, body))
    return reports
