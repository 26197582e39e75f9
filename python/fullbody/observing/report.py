"""Reports of the stations of an occultation, as files of several programs have them, and data from them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base.units import need
from ..errors import InvalidInput

_ANGLE = re.compile(r"([+-]?)\s*(\d+(?:\.\d*)?)(?:\s+(\d+(?:\.\d*)?))?(?:\s+(\d+(?:\.\d*)?))?")


class Report(NamedTuple):
    """The report of one station.

    Attributes
    ----------
    name : str
    date : tuple of int, (3,)
        The year, the month and the day, in UTC, from whose beginning times count.
    place : tuple of float, (3,)
        Longitude and latitude in degrees, and the height in m, on the ellipsoid of WGS84.
    times, errors : tuple of float, (2,)
        The times of disappearance and reappearance in s, NaN where they were not timed, with their standard errors.
    watched : tuple of float, (2,), or None
        The first and the last time of the watch.
    body : str
        ``"main"`` or ``"satellite"``.
    """

    name: str
    date: tuple[int, int, int]
    place: tuple[float, float, float]
    times: tuple[float, float]
    errors: tuple[float, float]
    watched: tuple[float, float] | None
    body: str


def to_degrees(text: str, what: str) -> float:
    """Return an angle in degrees from degrees, minutes and seconds with a sign, such as ``-110 58 12.5``."""
    if (match := _ANGLE.fullmatch(text.strip())) is None:
        raise InvalidInput(f"{what} is {text!r}; expected degrees, minutes and seconds such as '+14 24 01.2'")
    sign, *parts = match.groups()
    size = sum(float(part or 0.0) / 60.0**k for k, part in enumerate(parts))
    return -size if sign == "-" else size


def sexagesimal(degrees: float, digits: int) -> str:
    """Return an angle as degrees, of a number of digits, minutes and seconds with a sign."""
    minutes, seconds = divmod(round(abs(degrees) * 3600.0, 2), 60.0)
    whole, minutes = divmod(int(minutes), 60)
    return f"{'-' if degrees < 0.0 else '+'}{whole:0{digits}d} {minutes:02d} {seconds:05.2f}"


def arguments_of(reports: Sequence[Report]) -> dict[str, Any]:
    """Return the arguments of an occultation that reports contain."""
    if not reports:
        raise InvalidInput("the event has no station whose report counts; expected one or more")
    with need("observing", "the stations of an occultation"):
        from astropy import units as u
        from astropy.coordinates import EarthLocation
        from astropy.time import Time

    days = Time(["{:04d}-{:02d}-{:02d}".format(*report.date) for report in reports], scale="utc")
    times = np.array([report.times for report in reports])
    longitude, latitude, height = np.array([report.place for report in reports]).T
    found: dict[str, Any] = {
        "stations": EarthLocation.from_geodetic(longitude * u.deg, latitude * u.deg, height * u.m),
        "sigma": np.array([report.errors for report in reports]) * u.s,
    }
    for side, name in enumerate(("disappearance", "reappearance")):
        found[name] = _dates(days, times[:, side])
    if any(report.watched for report in reports):
        watch = np.array([report.watched or (np.nan, np.nan) for report in reports])
        found["watched"] = tuple(_dates(days, watch[:, side]) for side in (0, 1))
    return found


def timed(arguments: dict[str, Any]) -> Any:
    """Return which contacts (S, 2) of arguments with dates were timed: 1, or NaN."""
    masks = [np.asarray(getattr(arguments[name], "mask", False)) for name in ("disappearance", "reappearance")]
    count = len(arguments["sigma"])
    return np.where(np.stack([np.broadcast_to(mask, (count,)) for mask in masks], axis=1), np.nan, 1.0)


def _dates(days: Any, seconds: Any) -> Any:
    """Return days plus seconds, masked where these are NaN."""
    from astropy import units as u

    dates = days + np.nan_to_num(seconds) * u.s
    if (missing := np.isnan(seconds)).any():
        dates[missing] = np.ma.masked
    return dates


def reports_of(
    stations: Any, chords: Any, errors: Any, watched: Any, bodies: Sequence[str], names: Sequence[str]
) -> list[Report]:
    """Return reports of stations on the Earth from dates (S, 2), errors in s (S, 2) and watches (S, 2), with their day.

    Dates are masked where a contact was not timed, and where no watch is known.
    """
    from astropy.time import Time

    def unmasked(dates: Any) -> tuple[Any, Any]:
        return (dates.unmasked, np.asarray(dates.mask)) if dates.masked else (dates, np.zeros(dates.shape, dtype=bool))

    plain, missing = unmasked(chords.utc)
    first = plain[~missing].min().isot[:10]
    year, month, day = (int(part) for part in first.split("-"))
    start = Time(first, scale="utc")

    def seconds(dates: Any) -> Any:
        known, missing = unmasked(dates.utc)
        return np.where(missing, np.nan, (known - start).to_value("s"))

    times = seconds(chords)
    watches = np.full(times.shape, np.nan) if watched is None else seconds(watched)
    reports = []
    for k, (name, body) in enumerate(zip(names, bodies, strict=True)):
        place = stations[k].to_geodetic("WGS84")
        where = tuple(float(part) for part in (place.lon.deg, place.lat.deg, place.height.to_value("m")))
        watch = tuple(watches[k].tolist()) if np.isfinite(watches[k]).all() else None
        error = tuple(np.broadcast_to(errors, times.shape)[k].tolist())
        reports.append(Report(name, (year, month, day), where, tuple(times[k].tolist()), error, watch, body))  # type: ignore[arg-type]
    return reports
