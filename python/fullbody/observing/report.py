"""Reports of the stations of an occultation, as programs have them, data from them, and their files of SODIS.

SODIS, the data base of IOTA/ES, takes and gives the report of each station as a text file with lines ``#Key: value``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..base.atomic import replacing
from ..base.unit_names import unit_named
from ..base.units import need
from ..errors import InvalidInput
from ..files.text import Text, naming
from .times import unmasked

_ANGLE = re.compile(r"([+-]?)\s*(\d+(?:\.\d*)?)(?:\s+(\d+(?:\.\d*)?))?(?:\s+(\d+(?:\.\d*)?))?")
_TIME = re.compile(r"(\d+)[\s:]+(\d+)[\s:]+(\d+(?:\.\d*)?)")
#: The forms of dates, and the standard error in s of times whose report has none.
_DATES, _SIGMA = ("%d %B %Y", "%d %b %Y", "%d.%m.%Y", "%Y-%m-%d"), 0.5
_DAY, _NONE = 86400.0, (np.nan, np.nan)
_FIELD = re.compile(r"#([^:]*):(.*)")


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
    return masked_dates(days + np.nan_to_num(seconds) * unit_named("s"), np.isnan(seconds))


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


def read_sodis(paths: Any) -> dict[str, Any]:
    """Return arguments of an event from the reports of its stations, one file each."""
    files = [paths] if isinstance(paths, str | Path) else list(paths)
    if not files:
        raise InvalidInput("paths is empty; expected the report of one station or more")
    return arguments_of([_report(Text(path)) for path in files])


def _report(text: Text) -> Report:
    """Return the report of a file."""
    fields: dict[str, tuple[int, str]] = {}
    for line, content in enumerate(text.lines, 1):
        if match := _FIELD.match(content):
            fields[match[1].strip().lower()] = line, match[2].strip()
    if missing := [key for key in ("date", "latitude", "longitude", "d", "r") if key not in fields]:
        text.fail(None, f"there is no line #{missing[0].upper()}; expected a report of SODIS")

    def number(key: str, default: float) -> float:
        line, value = fields.get(key, (None, ""))
        return text.number(line, value, key.upper()) if value else default

    def time(key: str) -> float:
        """Return a time such as ``D23:50:12.34`` in seconds since the beginning of the day; NaN for a miss."""
        line, value = fields.get(key, (None, ""))
        value = value.lstrip("DRdr").strip()
        with naming(f"{text.path}, line {line}"):
            return np.nan if value.upper() in ("", "M") else to_seconds(value, key.upper())

    def angle(key: str) -> float:
        line, value = fields[key]
        with naming(f"{text.path}, line {line}"):
            return to_degrees(value, key.upper())

    first, begin, end, last = (time(key) for key in ("startobs", "d", "r", "endobs"))
    watched = (first, last) if np.isfinite([first, last]).all() else None
    # Times that are before the beginning of the watch, or of the chord, are after midnight.
    start = first if watched else begin
    begin, end, last = (moment + _DAY if moment < start else moment for moment in (begin, end, last))
    watched = watched and (first, last)
    position = angle("longitude"), angle("latitude"), number("altitude", 0.0)
    errors = number("acc_d", _SIGMA), number("acc_r", _SIGMA)
    name = fields.get("observer1", (None, ""))[1]
    return Report(name, _date(text, *fields["date"]), position, (begin, end), errors, watched, "main")


def _date(text: Text, line: int, value: str) -> str:
    for form in _DATES:
        with suppress(ValueError):
            return datetime.strptime(value, form).date().isoformat()
    text.fail(line, f"DATE is {value!r}; expected one such as '11 December 2008'")


def write_sodis(folder: Any, reports: Sequence[Report], asteroid: tuple[Any, str], star: str) -> list[Path]:
    """Write the report of each station into a folder, and return their paths."""
    paths = []
    for number, report in enumerate(reports, 1):
        finite = [time for time in (*(report.watched or ()), *report.times) if np.isfinite(time)]
        day = datetime.fromisoformat(report.date) + timedelta(days=min(finite, default=0.0) // _DAY)
        begin, end, first, last = (
            time_text(time % _DAY, ":") if np.isfinite(time) else ""
            for time in (*report.times, *(report.watched or _NONE))
        )
        is_miss = not (begin or end)
        fields = {
            "Occultation": "NEGATIVE" if is_miss else "POSITIVE",
            "DATE": day.strftime("%d %B %Y"),
            "STAR": star,
            "ASTEROID": asteroid[1],
            "Nr": str(asteroid[0]),
            "Observer1": report.name,
            "Latitude": angle_text(report.position[1], 2),
            "Longitude": angle_text(report.position[0], 3),
            "Altitude": f"{report.position[2]:.1f}",
            "StartObs": first,
            "D": "M" if is_miss else begin and f"D{begin}",
            "Acc_D": f"{report.errors[0]:.3f}",
            "R": "M" if is_miss else end and f"R{end}",
            "Acc_R": f"{report.errors[1]:.3f}",
            "EndObs": last,
        }
        path = Path(folder, f"{day:%Y%m%d}_{asteroid[0]}_station_{number}.txt")
        with replacing(path) as temporary:
            temporary.write_text("".join(f"#{key}: {value}\n" for key, value in fields.items()), encoding="utf-8")
        paths.append(path)
    return paths
