"""Reports of single stations as SODIS, the data base of IOTA/ES, takes and writes them: lines ``#Key: value``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from ..base.atomic import replacing
from ..errors import InvalidInput
from ..files.text import Text, naming
from .report import Report, arguments_of, clock, sexagesimal, to_degrees, to_seconds

#: The forms of dates, and the standard error in s of times whose report has none.
_DATES, _SIGMA = ("%d %B %Y", "%d %b %Y", "%d.%m.%Y", "%Y-%m-%d"), 0.5
_DAY = 86400.0
_FIELD = re.compile(r"#([^:]*):(.*)")


def read_sodis(paths: Any) -> dict[str, Any]:
    """Return arguments of an event from the reports of its stations, one file each."""
    files = [paths] if isinstance(paths, str | Path) else list(paths)
    if not files:
        raise InvalidInput("paths is empty; expected the report of one station or more")
    return arguments_of([_report(Text(path)) for path in files])


def _report(text: Text) -> Report:
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

    date = _date(text, *fields["date"])
    begin, end = time("d"), time("r")
    if end < begin:
        # The night goes on after midnight.
        end += _DAY
    watch, watched = (time("startobs"), time("endobs")), None
    if np.isfinite(watch).all():
        watched = (watch[0], watch[1] + _DAY if watch[1] < watch[0] else watch[1])
        if np.isfinite(begin) and begin < watched[0]:
            begin, end = begin + _DAY, end + _DAY
    position = angle("longitude"), angle("latitude"), number("altitude", 0.0)
    errors = number("acc_d", _SIGMA), number("acc_r", _SIGMA)
    name = fields.get("observer1", (None, ""))[1]
    return Report(name, (date.year, date.month, date.day), position, (begin, end), errors, watched, "main")


def _date(text: Text, line: int, value: str) -> datetime:
    for form in _DATES:
        with suppress(ValueError):
            return datetime.strptime(value, form)
    text.fail(line, f"DATE is {value!r}; expected one such as '11 December 2008'")


def write_sodis(folder: Any, reports: Sequence[Report], asteroid: tuple[Any, str], star: str) -> list[Path]:
    """Write the report of each station into a folder, and return their paths."""
    paths = []
    for number, report in enumerate(reports, 1):
        timed = [np.isfinite(time) for time in report.times]
        day = datetime(*report.date) + timedelta(days=int(_first(report) // _DAY))
        fields = {
            "Occultation": "POSITIVE" if any(timed) else "NEGATIVE",
            "DATE": day.strftime("%d %B %Y"),
            "STAR": star,
            "ASTEROID": asteroid[1],
            "Nr": str(asteroid[0]),
            "Observer1": report.name,
            "Latitude": sexagesimal(report.position[1], 2),
            "Longitude": sexagesimal(report.position[0], 3),
            "Altitude": f"{report.position[2]:.1f}",
            "StartObs": clock(report.watched[0] % _DAY, ":") if report.watched else "",
        }
        for side, key in enumerate("DR"):
            fields[key] = key + clock(report.times[side] % _DAY, ":") if timed[side] else "M" if not any(timed) else ""
            fields[f"Acc_{key}"] = f"{report.errors[side]:.3f}"
        fields["EndObs"] = clock(report.watched[1] % _DAY, ":") if report.watched else ""
        path = Path(folder, f"{day:%Y%m%d}_{asteroid[0]}_station_{number}.txt")
        with replacing(path) as temporary:
            temporary.write_text("".join(f"#{key}: {value}\n" for key, value in fields.items()), encoding="utf-8")
        paths.append(path)
    return paths


def _first(report: Report) -> float:
    """Return the first of the times of a report in s since the beginning of its day."""
    return min([*(report.watched or ()), *(time for time in report.times if np.isfinite(time))], default=0.0)
