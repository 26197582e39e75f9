"""Reports of single stations as SODIS, the data base of IOTA/ES, takes and writes them: lines ``#Key: value``."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from ..base.atomic import replacing
from ..errors import InvalidInput
from ..files.text import Text
from .report import Report, arguments_of, sexagesimal, to_degrees

#: The forms of dates, and the standard error in s of times whose report has none.
_DATES, _SIGMA = ("%d %B %Y", "%d %b %Y", "%d.%m.%Y", "%Y-%m-%d"), 0.5
_DAY = 86400.0


def read_sodis(paths: Any) -> dict[str, Any]:
    """Return arguments of an event from the reports of its stations, one file each."""
    files = [paths] if isinstance(paths, str | Path) else list(paths)
    if not files:
        raise InvalidInput("paths is empty; expected the report of one station or more")
    return arguments_of([_report(Text(path)) for path in files])


def _report(text: Text) -> Report:
    fields: dict[str, str] = {}
    for line in text.lines:
        if line.startswith("#") and ":" in line:
            key, _, value = line[1:].partition(":")
            fields[key.strip().lower()] = value.strip()
    if missing := [key for key in ("date", "latitude", "longitude", "d", "r") if key not in fields]:
        text.fail(None, f"there is no line #{missing[0].upper()}; expected a report of SODIS")
    date = None
    for form in _DATES:
        try:
            date = datetime.strptime(fields["date"], form)
            break
        except ValueError:
            continue
    if date is None:
        text.fail(None, f"DATE is {fields['date']!r}; expected one such as '11 December 2008'")
    assert date is not None
    latitude, longitude = (to_degrees(fields[key], f"{text.path}: {key}") for key in ("latitude", "longitude"))
    height = text.number(None, fields.get("altitude") or "0", "Altitude")
    begin, end = (_time(text, fields[key], key.upper()) for key in ("d", "r"))
    if end < begin:
        # The night goes on after midnight.
        end += _DAY
    errors = tuple(text.number(None, fields[key], key) if fields.get(key) else _SIGMA for key in ("acc_d", "acc_r"))
    watch = tuple(_time(text, fields.get(key, ""), key) for key in ("startobs", "endobs"))
    watched = None
    if np.isfinite(watch).all():
        watched = (watch[0], watch[1] + _DAY if watch[1] < watch[0] else watch[1])
        if np.isfinite(begin) and begin < watched[0]:
            begin, end = begin + _DAY, end + _DAY
    name = fields.get("observer1", "")
    place = (longitude, latitude, height)
    return Report(name, (date.year, date.month, date.day), place, (begin, end), (errors[0], errors[1]), watched, "main")


def _time(text: Text, value: str, what: str) -> float:
    """Return the seconds since the beginning of the day of a time such as ``D23:50:12.34``; NaN for a miss."""
    plain = value.lstrip("DRdr").strip()
    if plain.upper() in ("", "M"):
        return np.nan
    parts = plain.replace(":", " ").split()
    if len(parts) != 3:
        text.fail(None, f"{what} is {value!r}; expected a time such as 23:50:12.34, or M for a miss")
    hours, minutes, seconds = (text.number(None, part, what) for part in parts)
    return 3600.0 * hours + 60.0 * minutes + seconds


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
            "Latitude": sexagesimal(report.place[1], 2),
            "Longitude": sexagesimal(report.place[0], 3),
            "Altitude": f"{report.place[2]:.1f}",
            "StartObs": _clock(report.watched[0]) if report.watched else "",
        }
        for side, key in enumerate("DR"):
            fields[key] = key + _clock(report.times[side]) if timed[side] else "M" if not any(timed) else ""
            fields[f"Acc_{key}"] = f"{report.errors[side]:.3f}"
        fields["EndObs"] = _clock(report.watched[1]) if report.watched else ""
        path = Path(folder, f"{day:%Y%m%d}_{asteroid[0]}_station_{number}.txt")
        with replacing(path) as temporary:
            temporary.write_text("".join(f"#{key}: {value}\n" for key, value in fields.items()), encoding="utf-8")
        paths.append(path)
    return paths


def _first(report: Report) -> float:
    """Return the first of the times of a report in s since the beginning of its day."""
    known = [*(report.watched or ()), *(time for time in report.times if np.isfinite(time))]
    return min(known, default=0.0)


def _clock(seconds: float) -> str:
    hours, rest = divmod(round(seconds % _DAY, 3), 3600.0)
    return f"{int(hours):02d}:{int(rest // 60):02d}:{rest % 60:06.3f}"
