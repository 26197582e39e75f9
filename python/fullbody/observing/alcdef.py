"""Light curves in the Asteroid Lightcurve Data Exchange Format (ALCDEF), read and written."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base.arguments import options_of, refuse_unknown
from ..base.atomic import replacing
from ..base.foreign import are_dates
from ..base.kinds import flag, instance
from ..base.units import need
from ..errors import InvalidInput
from ..files.text import POSITIVE, Text
from ..typing import Floats
from .photometry import Photometry
from .scatter import Curve, standard_errors
from .vectors import Vectors

_KEYWORD = re.compile(r"([A-Z][A-Z0-9]*)\s*=(.*)")
_DELIMITERS = {"PIPE": "|", "TAB": "\t"}
#: The words of the corrections that data may have, by keyword: none, one for the block, or one for each point.
_APPLIED = ("NONE", "AVERAGE", "POINT")
_CHECKED = {"LTCAPP": _APPLIED, "LTCTYPE": _APPLIED, "REDUCEDMAGS": _APPLIED, "DELIMITER": tuple(_DELIMITERS)}
#: The keywords that the writer sets itself, and those without which a file is not accepted.
_WRITTEN = ("SESSIONDATE", "SESSIONTIME", "LTCAPP", "LTCTYPE", "REDUCEDMAGS", "DELIMITER")
_REQUIRED = ("OBJECTNAME", "CONTACTNAME", "CONTACTINFO", "OBSERVERS", "FILTER", "MAGBAND")


class _Block(NamedTuple):
    """A block of a file: its first line, its keywords with the lines of these, and its rows (K, 4), NaN if absent."""

    line: int
    metadata: dict[str, tuple[int, str]]
    rows: Floats

    def word(self, keyword: str) -> str:
        """Return the value of a keyword in capitals, NONE where there is none."""
        return self.metadata.get(keyword, (0, ""))[1].upper() or "NONE"

    @property
    def name(self) -> str:
        """The session with its filter, which names the night."""
        parts = [self.metadata.get(key, (0, ""))[1] for key in ("SESSIONDATE", "SESSIONTIME", "FILTER")]
        return " ".join(part for part in parts if part) or f"line {self.line}"


def read_alcdef(
    path: Any, *, geometry: Vectors, sigma: Any = None, airmass: bool = False, **options: Any
) -> list[Photometry]:
    """Read the light curves of an asteroid in a file of the format ALCDEF 2.

    Parameters
    ----------
    path : str or Path
    geometry : Geometry
        A geometry that includes the Sun, with ``light_time=False`` if the times of the file are less light time.
    sigma : float, Quantity or array_like, () or (C,), or "estimate"
        Standard errors in place of those of the file. For a file without errors, see :func:`read_damit`.
    airmass : bool
        Whether to take the airmasses of the file, in which each block then has a free slope.
    **options
        Options of :class:`Photometry` other than ``zero``, ``night``, ``filter`` and ``reduced``.

    Returns
    -------
    list of Photometry
        One for each block, with a free zero point named by its date, time and filter. Constants that a file adds to
        all magnitudes of a block, such as the correction to unit distances of ``REDUCEDMAGS=AVERAGE``, are part of it.

    Raises
    ------
    InvalidInput
        For content of another form, words of ``LTCAPP``, ``LTCTYPE``, ``REDUCEDMAGS`` and ``DELIMITER`` that are not
        those of the standard, blocks of several asteroids, and times whose light time is not that of the geometry; the
        message names the line.

    References
    ----------
    Stephens, Warner et al., Asteroid Lightcurve Data Exchange Format: Definition and Standards, v. 2.2.7 (2019),
    https://alcdef.org.

    Examples
    --------
    >>> import astropy.units as u, pathlib, tempfile
    >>> from astropy.time import Time
    >>> from fullbody import observing
    >>> view = {"to_observer": [1.0, 0.1, 0.0] * u.au, "to_sun": [2.0, 0.1, 0.0] * u.au}
    >>> geometry = observing.Geometry(Time(["2011-09-10", "2011-09-20"], scale="utc"), **view)
    >>> lines = ["STARTMETADATA", "OBJECTNAME=Ceres", "SESSIONDATE=2011-09-13", "FILTER=C", "ENDMETADATA",
    ...          "DATA=2455817.735937|+7.328|+0.004|2.224", "DATA=2455817.736235|+7.317|+0.004|2.219", "ENDDATA"]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "ceres.txt")
    ...     _ = path.write_text(chr(10).join(lines))
    ...     (night,) = observing.read_alcdef(path, geometry=geometry)
    >>> night.nights, night.magnitude, night.sigma
    (array(['2011-09-13 C'], dtype='<U12'), array([7.328, 7.317]), array([0.004, 0.004]))
    """
    own = ("times", "magnitude", "sigma", "geometry", "zero", "night", "filter", "airmass", "reduced")
    refuse_unknown(options, [name for name in options_of(Photometry) if name not in own], "read_alcdef")
    instance(geometry, "geometry", Vectors, "an observing.Geometry")
    flag(airmass, "airmass")
    text = Text(path)
    blocks = list(_blocks(text))
    if not blocks:
        text.fail(None, "the file has no line STARTMETADATA; expected a file of the format ALCDEF")
    for block in blocks:
        _check(text, block, blocks[0], geometry)
    errors: Any = [block.rows[:, 2] for block in blocks]
    if sigma is not None or any(np.isnan(one).any() for one in errors):
        if sigma is None and not all(np.isnan(one).all() for one in errors):
            bad = next(block for block, one in zip(blocks, errors, strict=True) if np.isnan(one).any())
            text.fail(bad.line, f"the block of {bad.name} has points without errors, and others have them; give sigma=")
        curves = [Curve(f"{block.name} (line {block.line})", block.rows[:, 0], block.rows[:, 1]) for block in blocks]
        errors = standard_errors(sigma, curves, path)
    return [_photometry(text, *one, geometry, airmass, options) for one in zip(blocks, errors, strict=True)]


def _photometry(
    text: Text, block: _Block, sigma: Any, geometry: Vectors, airmass: bool, options: dict[str, Any]
) -> Photometry:
    with need("observing", "dates of light curves"):
        from astropy.time import Time

    if airmass and np.isnan(block.rows[:, 3]).any():
        text.fail(block.line, f"the block of {block.name} has points without an airmass; expected airmass=False")
    return Photometry(
        Time(block.rows[:, 0], format="jd", scale="utc"),
        block.rows[:, 1],
        sigma,
        geometry=geometry,
        night=np.full(len(block.rows), block.name),
        airmass=block.rows[:, 3] if airmass else None,
        reduced=block.word("REDUCEDMAGS") == "POINT",
        **options,
    )


def _blocks(text: Text) -> Iterator[_Block]:
    start = 0
    metadata: dict[str, tuple[int, str]] = {}
    rows: list[list[float]] | None = None
    for line, raw in enumerate(text.lines, 1):
        content = raw.strip()
        expected = (
            "STARTMETADATA" if not start else "KEYWORD=value or ENDMETADATA" if rows is None else "DATA= or ENDDATA"
        )
        match = _KEYWORD.fullmatch(content)
        if not content:
            continue
        if not start and content == "STARTMETADATA":
            start, metadata, rows = line, {}, None
        elif start and rows is None and content == "ENDMETADATA":
            rows = []
        elif start and rows is None and match and match[1] != "DATA":
            key, value = match[1], match[2].strip()
            if key in metadata and key != "COMMENT":
                text.fail(line, f"{key} is given twice, first in line {metadata[key][0]}; expected one value")
            if key in _CHECKED and value and value.upper() not in _CHECKED[key]:
                text.fail(line, f"{key} is {value!r}; expected {' or '.join(_CHECKED[key])}")
            metadata[key] = line, value
        elif rows is not None and match and match[1] == "DATA":
            delimiter = _DELIMITERS[metadata.get("DELIMITER", (0, ""))[1].upper() or "PIPE"]
            rows.append(_point(text, line, match[2].split(delimiter)))
        elif rows is not None and content == "ENDDATA":
            if not rows:
                text.fail(line, "the block has no DATA lines; expected one or more")
            yield _Block(start, metadata, np.array(rows))
            start, rows = 0, None
        else:
            text.fail(line, f"the line is {content!r:.60}; expected {expected}")
    if start:
        text.fail(len(text.lines), f"the file ends in the block of line {start}; expected ENDDATA")


def _point(text: Text, line: int, words: Sequence[str]) -> list[float]:
    """Return JD, magnitude, error and airmass, NaN where the last two are absent."""
    if not 2 <= len(words) <= 4:
        text.fail(line, f"DATA has {len(words)} fields; expected JD, magnitude, its error and the airmass")
    found = [text.number(line, word.strip(), what) for word, what in zip(words, ("JD", "the magnitude"), strict=False)]
    for word, what in zip(words[2:], ("the error of the magnitude", "the airmass"), strict=False):
        found.append(text.number(line, word.strip(), what, POSITIVE) if word.strip() else math.nan)
    return found + [math.nan] * (4 - len(found))


def _check(text: Text, block: _Block, first: _Block, geometry: Vectors) -> None:
    """Raise an error for a block of another asteroid, or with times other than those of the geometry."""
    for key in ("OBJECTNUMBER", "OBJECTNAME"):
        line, name = block.metadata.get(key, (block.line, ""))
        if name != first.metadata.get(key, (0, ""))[1]:
            had = first.metadata.get(key, (0, ""))[1]
            text.fail(line, f"{key} is {name!r}, after {had!r} in the first block; expected blocks of one asteroid")
    given = {key: block.word(key) for key in ("LTCAPP", "LTCTYPE") if key in block.metadata}
    if len({word == "NONE" for word in given.values()}) > 1:
        text.fail(
            block.line,
            f"the block has LTCAPP={given['LTCAPP']} and LTCTYPE={given['LTCTYPE']}; expected both NONE or none",
        )
    if (corrected := any(word != "NONE" for word in given.values())) == geometry.light_time:
        times = "less light time" if corrected else "those at the observer"
        text.fail(block.line, f"times of the block are {times}; expected a geometry with light_time={not corrected}")


def write_alcdef(path: Any, data: Photometry | Sequence[Photometry], metadata: Mapping[str, Any]) -> None:
    """Write light curves to a file of the format ALCDEF 2, which :func:`read_alcdef` reads.

    Parameters
    ----------
    path : str or Path
        A file that exists is replaced.
    data : Photometry or sequence of Photometry
        Data whose times are dates. Each night of each of them is a block.
    metadata : dict
        Values by keyword: ``OBJECTNAME``, ``CONTACTNAME``, ``CONTACTINFO``, ``OBSERVERS``, ``FILTER`` and ``MAGBAND``,
        and any others of the standard. The dates of sessions (of their first points), the delimiter and the words on
        light time and on unit distances follow from the data.

    Raises
    ------
    InvalidInput
        For times that are not dates, keywords that are missing, of another form or set by the writer, and values of
        several lines.

    Notes
    -----
    JD are in UTC, to 1 ms, magnitudes to 1e-5.

    Examples
    --------
    >>> import astropy.units as u, pathlib, tempfile
    >>> from astropy.time import Time
    >>> from fullbody import observing
    >>> view = {"to_observer": [1.0, 0.1, 0.0] * u.au, "to_sun": [2.0, 0.1, 0.0] * u.au}
    >>> times = Time(["2011-09-13T01:00:00", "2011-09-13T01:30:00"], scale="utc")
    >>> data = observing.Photometry(times, [7.3, 7.4], 0.01, geometry=observing.Geometry(times, **view))
    >>> about = {"OBJECTNUMBER": 1, "OBJECTNAME": "Ceres", "FILTER": "C", "MAGBAND": "V", "OBSERVERS": "A. Person",
    ...          "CONTACTNAME": "A. Person", "CONTACTINFO": "person@example.org"}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "ceres.txt")
    ...     observing.write_alcdef(path, data, about)
    ...     print(path.read_text().splitlines()[-2])
    DATA=2455817.56250000|7.40000|0.01
    """
    about = {str(key): str(value).strip() for key, value in instance(metadata, "metadata", Mapping, "a dict").items()}
    for key, value in about.items():
        if not _KEYWORD.fullmatch(f"{key}={value}") or key in (*_WRITTEN, "DATA"):
            raise InvalidInput(
                f"metadata has {key!r}: {value!r}; expected keywords in capitals that the data do not give"
            )
    if missing := [key for key in _REQUIRED if not about.get(key)]:
        raise InvalidInput(f"metadata has no {missing[0]}; expected {', '.join(_REQUIRED)}")
    several = [data] if isinstance(data, Photometry) else list(data)
    lines = [line for one in several for line in _written(one, about)]
    if not lines:
        raise InvalidInput("data is empty; expected one Photometry or more")
    with replacing(path) as file:
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _written(data: Photometry, about: dict[str, str]) -> Iterator[str]:
    instance(data, "data", Photometry, "a Photometry")
    if not are_dates(data.times):
        raise InvalidInput("times of data are not dates; expected astropy Times, as ALCDEF has JD")
    words = {
        "LTCAPP": "NONE" if data.geometry.light_time else "POINT",
        "LTCTYPE": "NONE" if data.geometry.light_time else "POINT",
        "REDUCEDMAGS": "POINT" if data.reduced else "NONE",
        "DELIMITER": "PIPE",
    }
    table = data.to_table()
    for night in data.nights:
        rows = table[table["night"] == night]
        utc = rows["times"].utc
        day, clock = utc[0].isot.split("T")
        yield "STARTMETADATA"
        for key, value in (about | {"SESSIONDATE": day, "SESSIONTIME": clock[:8]} | words).items():
            yield f"{key}={value}"
        yield "ENDMETADATA"
        airmass = rows["airmass"] if "airmass" in rows.colnames else [None] * len(rows)
        for when, magnitude, sigma, mass in zip(utc, rows["magnitude"], rows["sigma"], airmass, strict=True):
            day_number, fraction = divmod(round((when.jd1 % 1.0 + when.jd2) * 1e8), 10**8)
            last = "" if mass is None else f"|{mass:.4f}"
            yield f"DATA={math.floor(when.jd1) + day_number}.{fraction:08d}|{magnitude:.5f}|{sigma:.6g}{last}"
        yield "ENDDATA"
