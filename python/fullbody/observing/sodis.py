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
from .report import Report, angle_text, arguments_of, time_text, to_degrees, to_seconds

#: The forms of dates, and the standard error in s of times whose report has none.
_DATES, _SIGMA = ("%d %B %Y", "%d %b %Y", "%d.%m.%Y", "%Y-%m-%d"), 0.5
_DAY, _NONE = 86400.0, (np.nan, np.nan)
_FIELD = re.compile(r"#([^:]*):(.*)")


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
