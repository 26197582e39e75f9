"""Files of asteroidal occultations as the program Occult writes them, version 2.15 of their format.

An event has the tags of the format's description: ``Date``, ``Star`` and ``Asteroid`` under ``Details``, and for each
observer under ``Observations`` an ``ID`` with the coordinates, and ``D`` and ``R`` with the times of disappearance and
reappearance. Items of a tag are separated by vertical bars.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from ..base.atomic import content, replacing
from ..base.units import need
from ..errors import InconsistentInput, InvalidInput, caution
from .report import Report, angle_text, arguments_of, selected, time_text, to_degrees, to_seconds

#: Codes of contacts with the main star, by the main body and by a satellite; of misses; and of those that do not count.
_MAIN, _SATELLITE, _MISS = ("D", "R"), ("G", "B"), "M"
#: The standard errors in s of times without one, by the codes of the method and of the source of time.
_GOOD_CLOCKS, _RECORDED = "adef", "abc"
#: What a plot code leaves out: both contacts, all but the first, all but the second.
_LEFT_OUT = {"x": (True, True), "y": (False, True), "z": (True, False)}
#: The number of items of the tags that are read, up to the last one that is used.
_ITEMS = {"Date": 4, "Star": 6, "ID": 9, "D": 2, "R": 2}
VERSION = "2.15"


class OccultEvent(NamedTuple):
    """An event of a file: right ascension and declination in degrees, and the reports of its observers."""

    ra: float
    dec: float
    reports: list[Report]


def read_occult(path: Any, event: int | None) -> tuple[dict[str, Any], list[str | None]]:
    """Return arguments of an event, and for each station ``"main"`` or ``"satellite"``, ``None`` for a miss."""
    try:
        root = ElementTree.fromstring(content(path))
    except ElementTree.ParseError as error:
        raise InvalidInput(f"{path} is not a file of Occult: {error}") from error
    events = root.findall("Event") if root.tag != "Event" else [root]
    parsed = _event(selected(events, event, path), f"{path}, event {event or 0}")
    with need("observing", "a star"):
        from astropy import units as u
        from astropy.coordinates import SkyCoord

    star = SkyCoord(parsed.ra * u.deg, parsed.dec * u.deg)
    bodies = [report.body if np.isfinite(report.times).any() else None for report in parsed.reports]
    return {"star": star} | arguments_of(parsed.reports), bodies


def _items(parent: ElementTree.Element, tag: str, what: str) -> list[str]:
    """Return the items of a tag, of which there have to be as many as are used."""
    element = parent if parent.tag == tag else parent.find(tag)
    text = "" if element is None or element.text is None else element.text
    items = [item.strip() for item in text.split("|")]
    if len(items) < _ITEMS[tag]:
        raise InvalidInput(f"{what}: the tag {tag} is {text!r}; expected {_ITEMS[tag]} items or more")
    return items


def _number(text: str, what: str) -> float:
    try:
        return float(text)
    except ValueError as error:
        raise InvalidInput(f"{what} is {text!r}; expected a number") from error


def _event(element: ElementTree.Element, what: str) -> OccultEvent:
    details, observed = element.find("Details"), element.find("Observations")
    if details is None or observed is None:
        raise InvalidInput(f"{what}: the tags Details and Observations are missing; expected both")
    year, month, day = (int(_number(item, f"{what}: Date")) for item in _items(element, "Date", what)[:3])
    date = f"{year:04d}-{month:02d}-{day:02d}"
    star = _items(details, "Star", what)
    reports: list[Report] = []
    left_out: list[str] = []
    for observer in observed.findall("Observer"):
        identity = _items(observer, "ID", what)
        observer_text = f"{what}, observer {identity[0]}"
        ends, body = [], "main"
        rows = [[*_items(observer, tag, observer_text), "", "", "", ""] for tag in ("D", "R")]
        plotted = {items[5] for items in rows}
        for side, items in enumerate(rows):
            code = items[1] or _MISS
            if code == _SATELLITE[side]:
                body = "satellite"
            elif code not in (_MAIN[side], _MISS):
                body = "other"
            excluded = any(_LEFT_OUT.get(plot, (False, False))[side] for plot in plotted)
            time = np.nan if code == _MISS or excluded else to_seconds(items[0], f"{observer_text}: a time")
            sigma = _number(items[2], observer_text) if items[2] else _accuracy(identity)
            ends.append((time, sigma, excluded))
        (begin, begin_error, first), (end, end_error, second) = ends
        if body == "other" or (first and second):
            left_out.append(identity[0])
            continue
        longitude, latitude = (to_degrees(text, f"{observer_text}: longitude or latitude") for text in identity[6:8])
        height = _number(identity[8] or "0", f"{observer_text}: height")
        name, errors = " and ".join(part for part in identity[1:3] if part), (begin_error, end_error)
        reports.append(Report(name, date, (longitude, latitude, height), (begin, end), errors, None, body))
    if left_out:
        caution(
            f"{what}: the observers {', '.join(left_out)} are left out, since they saw another star, a ring or nothing "
            "for clouds, or are excluded by their plot code",
            InconsistentInput,
        )
    return OccultEvent(15.0 * _number(star[4], f"{what}: Star"), _number(star[5], f"{what}: Star"), reports)


def _accuracy(identity: Sequence[str]) -> float:
    """Return the standard error in s that Occult takes for times without one."""
    method, source = (identity[k] if len(identity) > k else "" for k in (12, 13))
    if method not in tuple(_RECORDED):
        return 1.0
    return 0.5 if source in tuple(_GOOD_CLOCKS) else 1.5


def write_occult(path: Any, ra: float, dec: float, reports: Sequence[Report], asteroid: tuple[Any, str]) -> None:
    """Write an event of one star at (ra, dec) in degrees; see :meth:`fullbody.observing.StellarOccultation`."""
    root = ElementTree.Element("AsteroidOccultations")
    ElementTree.SubElement(root, "FileVersion").text = VERSION
    event = ElementTree.SubElement(root, "Event")
    times = [t for report in reports for t in report.times if np.isfinite(t)]
    date = (str(int(part)) for part in reports[0].date.split("-"))
    ElementTree.SubElement(event, "Date").text = "|".join([*date, f"{np.mean(times) / 3600.0:.1f}"])
    details = ElementTree.SubElement(event, "Details")
    ElementTree.SubElement(details, "Star").text = f"G-coords||-1||{ra / 15.0:.10f}|{dec:+.9f}|||||||||||"
    ElementTree.SubElement(details, "Asteroid").text = f"{asteroid[0]}|{asteroid[1]}|||||||||||"
    observed = ElementTree.SubElement(event, "Observations")
    for number, report in enumerate(reports, 1):
        observer = ElementTree.SubElement(observed, "Observer")
        longitude, latitude, height = report.position
        coordinates = f"{angle_text(longitude, 3)}|{angle_text(latitude, 2)}|{height:.1f}"
        ElementTree.SubElement(observer, "ID").text = f"{number}|{report.name}||0|||{coordinates}||||||"
        ElementTree.SubElement(observer, "Conditions").text = "||||"
        for side, tag in enumerate(("D", "R")):
            time, code = report.times[side], (_SATELLITE if report.body == "satellite" else _MAIN)[side]
            code = code if np.isfinite(time) else _MISS
            text = time_text(time if np.isfinite(time) else 0.0, " ")
            ElementTree.SubElement(observer, tag).text = f"{text}|{code}|{report.errors[side]:.3f}|||"
    ElementTree.indent(root)
    with replacing(path) as temporary:
        temporary.write_bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))
