"""Light curves in the Asteroid Lightcurve Data Exchange Format (ALCDEF), read and written."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base.atomic import replacing
from ..base.foreign import are_dates
from ..base.kinds import choice, flag, instance
from ..base.units import is_quantity, need
from ..errors import InvalidInput
from ..files.text import NOT_NEGATIVE, Text
from ..typing import Floats
from .photometry import Photometry
from .scatter import Curve, refuse_options, standard_errors
from .times import LIGHT_SPEED
from .vectors import Vectors

_KEYWORD = re.compile(r"([A-Z][A-Z0-9]*)\s*=(.*)")
_DELIMITERS = {"PIPE": "|", "TAB": "\t"}
#: Values of the keywords of corrections: not applied, one value for the block, or one for each point.
_APPLIED = ("NONE", "AVERAGE", "POINT")
#: The values that the standard allows for keywords.
_ALLOWED = {
    "LTCAPP": _APPLIED,
    "LTCTYPE": ("NONE", "LIGHTTIME"),
    "REDUCEDMAGS": _APPLIED,
    "DELIMITER": tuple(_DELIMITERS),
    "STANDARD": ("NONE", "INTERNAL", "TRANSFORMED"),
}
#: Other keywords that the reader uses. Like those above, each is in a block at most once.
_SINGLE = ("OBJECTNUMBER", "OBJECTNAME", "SESSIONDATE", "SESSIONTIME", "FILTER", "LTCDAYS", "UCORMAG", "MAGADJUST")
#: Keywords that the writer sets itself, and those that its user has to give.
_WRITTEN = ("SESSIONDATE", "SESSIONTIME", "LTCAPP", "LTCTYPE", "LTCDAYS", "REDUCEDMAGS", "UCORMAG", "DIFFERMAGS")
_REQUIRED = ("OBJECTNUMBER", "OBJECTNAME", "CONTACTNAME", "CONTACTINFO", "OBSERVERS", "FILTER", "MAGBAND", "STANDARD")
#: The least error and airmass that are written: numbers have six decimals, and an error of zero counts as absent.
_LEAST = 1e-6


class _Block(NamedTuple):
    """A block of a file: its first line, its keywords with their lines and values, and its rows (K, 4).

    A row has JD, magnitude, error and airmass, the last two NaN where they are absent.
    """

    line: int
    metadata: dict[str, tuple[int, str]]
    rows: Floats

    def word(self, keyword: str) -> str:
        """Return the value of a keyword in capitals, or "NONE" if the block does not have it."""
        return self.metadata.get(keyword, (0, ""))[1].upper() or "NONE"

    def number(self, text: Text, keyword: str, reason: str = "") -> float:
        """Return the number of a keyword, zero if the block lacks it, or an error if there is a ``reason`` for it."""
        line, value = self.metadata.get(keyword, (self.line, ""))
        if not value and reason:
            text.fail(line, f"the block has no {keyword}, and has {reason}; expected a number")
        return text.number(line, value, keyword) if value else 0.0

    @property
    def name(self) -> str:
        """The date and time of the session with its filter, as the name of the night."""
        parts = [self.metadata.get(key, (0, ""))[1] for key in ("SESSIONDATE", "SESSIONTIME", "FILTER")]
        return " ".join(part for part in parts if part) or f"line {self.line}"


def read_alcdef(
    path: Any, *, geometry: Vectors, sigma: Any = None, airmass: bool = False, **options: Any
) -> list[Photometry]:
    """Read the light curves of an asteroid in a file of the format ALCDEF 2.

    Parameters
    ----------
    path : str or Path
        The file.
    geometry : Geometry
        A geometry that includes the Sun, with ``light_time=False`` for a file in which light time is subtracted from
        each time (``LTCAPP=POINT``).
    sigma : float, Quantity or array_like, () or (C,), or "estimate"
        Standard errors in magnitudes in place of those of the file: one number, or one for each of the C blocks. A file
        without errors has them estimated as by :func:`read_damit`.
    airmass : bool
        Whether to take the airmasses of the file; each block then has a free slope in airmass, its extinction.
    **options
        Options of :class:`Photometry` other than ``zero``, ``night``, ``filter`` and ``reduced``.

    Returns
    -------
    list of Photometry
        One for each block, with a free zero point named by its date, time and filter. One light time
        (``LTCAPP=AVERAGE``) and one correction to unit distances (``REDUCEDMAGS=AVERAGE``) for the whole block are
        removed, and ``MAGADJUST`` is added.

    Raises
    ------
    InvalidInput
        For lines that are not of the format, values that the standard does not allow, keywords that contradict each
        other, blocks of several asteroids, and times whose light time is not treated as in the geometry; the message
        names the line.

    Notes
    -----
    Keywords that the standard does not have are ignored, as it prescribes. Some files of the archive lack ``ENDDATA``,
    or have errors of zero, which count as absent.

    References
    ----------
    Stephens, Warner et al., Asteroid Lightcurve Data Exchange Format: Definition and Standards, https://alcdef.org.

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
    refuse_options(options, "read_alcdef")
    instance(geometry, "geometry", Vectors, "an observing.Geometry")
    flag(airmass, "airmass")
    text = Text(path)
    blocks = list(_blocks(text))
    if not blocks:
        text.fail(None, "the file has no line STARTMETADATA; expected a file of the format ALCDEF")
    for block in blocks:
        _check(text, block, blocks[0], geometry)
    errors: Any = [block.rows[:, 2] for block in blocks]
    if sigma is not None or any(np.isnan(error).any() for error in errors):
        if sigma is None and not all(np.isnan(error).all() for error in errors):
            incomplete = next(block for block, error in zip(blocks, errors, strict=True) if np.isnan(error).any())
            text.fail(
                incomplete.line,
                f"the block of {incomplete.name} has points without errors, and others have them; give sigma=",
            )
        curves = [Curve(f"{block.name} (line {block.line})", block.rows[:, 0], block.rows[:, 1]) for block in blocks]
        errors = standard_errors(sigma, curves, path)
    return [
        _photometry(text, block, error, geometry, airmass, options) for block, error in zip(blocks, errors, strict=True)
    ]


def _photometry(
    text: Text, block: _Block, sigma: Any, geometry: Vectors, airmass: bool, options: dict[str, Any]
) -> Photometry:
    """Return the photometry of a block, with the constants of the block applied."""
    with need("observing", "dates of light curves"):
        from astropy.time import Time

    if airmass and np.isnan(block.rows[:, 3]).any():
        text.fail(block.line, f"the block of {block.name} has points without an airmass; expected airmass=False")
    # Both were added in the file: the light time as a negative number of days, the correction in magnitudes.
    days = block.number(text, "LTCDAYS", "LTCAPP=AVERAGE") if block.word("LTCAPP") == "AVERAGE" else 0.0
    correction = block.number(text, "UCORMAG", "REDUCEDMAGS=AVERAGE") if block.word("REDUCEDMAGS") == "AVERAGE" else 0.0
    return Photometry(
        Time(block.rows[:, 0], -days, format="jd", scale="utc"),
        block.rows[:, 1] - correction + block.number(text, "MAGADJUST"),
        sigma,
        geometry=geometry,
        night=np.full(len(block.rows), block.name),
        airmass=block.rows[:, 3] if airmass else None,
        reduced=block.word("REDUCEDMAGS") == "POINT",
        **options,
    )


def _blocks(text: Text) -> Iterator[_Block]:
    """Yield the blocks of a file; a line that a block may not have at its place is an error."""
    # The first line of the block, zero between blocks; the rows are None until the metadata have ended.
    start = 0
    metadata: dict[str, tuple[int, str]] = {}
    rows: list[list[float]] | None = None
    for line, raw in enumerate(text.lines, 1):
        content = raw.strip()
        match = _KEYWORD.fullmatch(content)
        if not content:
            continue
        if content == "STARTMETADATA" and (not start or rows):
            if rows:
                yield _Block(start, metadata, np.array(rows))
            start, metadata, rows = line, {}, None
        elif start and rows is None and content == "ENDMETADATA":
            rows = []
        elif start and rows is None and match and match[1] != "DATA":
            key, value = match[1], match[2].strip()
            if key in metadata and key in (*_ALLOWED, *_SINGLE):
                text.fail(line, f"{key} is given twice, first in line {metadata[key][0]}; expected one value")
            if value and value.upper() not in _ALLOWED.get(key, (value.upper(),)):
                text.fail(line, f"{key} is {value!r}; expected {' or '.join(_ALLOWED[key])}")
            metadata[key] = line, value
        elif rows is not None and match and match[1] == "DATA":
            delimiter = _DELIMITERS[metadata.get("DELIMITER", (0, ""))[1].upper() or "PIPE"]
            rows.append(_point(text, line, raw.partition("=")[2].rstrip(f" {delimiter}").split(delimiter)))
        elif rows and content == "ENDDATA":
            yield _Block(start, metadata, np.array(rows))
            start, rows = 0, None
        else:
            expected = "STARTMETADATA" if not start else "KEYWORD=value or ENDMETADATA" if rows is None else "DATA=..."
            text.fail(line, f"the line is {content!r:.60}; expected {expected}{' or ENDDATA' if rows else ''}")
    if rows:
        yield _Block(start, metadata, np.array(rows))
    elif start:
        text.fail(len(text.lines), f"the file ends in the block of line {start}; expected lines DATA=...")


def _point(text: Text, line: int, words: Sequence[str]) -> list[float]:
    """Return JD, magnitude, error and airmass; the last two are NaN where they are absent or zero."""
    if not 2 <= len(words) <= 4:
        text.fail(line, f"DATA has {len(words)} fields; expected JD, magnitude, its error and the airmass")
    numbers = [
        text.number(line, word.strip(), what) for word, what in zip(words, ("JD", "the magnitude"), strict=False)
    ]
    for word, what in zip(words[2:], ("the error of the magnitude", "the airmass"), strict=False):
        numbers.append(text.number(line, word.strip(), what, NOT_NEGATIVE) if word.strip() else 0.0)
    return numbers[:2] + [value or math.nan for value in [*numbers[2:], 0.0, 0.0][:2]]


def _check(text: Text, block: _Block, first: _Block, geometry: Vectors) -> None:
    """Raise an error for a block of another asteroid, or whose light time is not treated as in the geometry."""
    for key in ("OBJECTNUMBER", "OBJECTNAME"):
        line, name = block.metadata.get(key, (block.line, ""))
        if name != (expected := first.metadata.get(key, (0, ""))[1]):
            text.fail(
                line, f"{key} is {name!r}, after {expected!r} in the first block; expected blocks of one asteroid"
            )
    applied, ltc_type = block.word("LTCAPP"), block.word("LTCTYPE")
    if "LTCTYPE" in block.metadata and (applied == "NONE") != (ltc_type == "NONE"):
        text.fail(
            block.metadata["LTCTYPE"][0],
            f"LTCTYPE is {ltc_type} and LTCAPP {applied}; expected NONE for both or for neither",
        )
    if geometry.light_time != (applied != "POINT"):
        times = "less light time" if applied == "POINT" else "those at the observer"
        expected = f"expected a geometry with light_time={applied != 'POINT'}"
        text.fail(block.line, f"times of the block are {times}, by LTCAPP={applied}; {expected}")


def write_alcdef(path: Any, data: Photometry | Sequence[Photometry], metadata: Mapping[str, Any]) -> None:
    """Write light curves to a file of the format ALCDEF 2, which :func:`read_alcdef` reads.

    Parameters
    ----------
    path : str or Path
        A file that exists is replaced.
    data : Photometry or sequence of Photometry
        Data whose times are dates. Each night of each data set is a block.
    metadata : dict
        Values by keyword: ``OBJECTNUMBER`` (0 for none), ``OBJECTNAME``, ``CONTACTNAME``, ``CONTACTINFO``,
        ``OBSERVERS``, ``FILTER``, ``MAGBAND`` and ``STANDARD`` (NONE for differential magnitudes, INTERNAL or
        TRANSFORMED), and any others of the standard. The keywords of the session, differential magnitudes, light time
        and the correction to unit distances follow from these and the data.

    Raises
    ------
    InvalidInput
        For times that are not dates, keywords that are missing, not in capitals or set by the writer, values of several
        lines, errors and airmasses below 1e-6, several filters in one data set, and a geometry without units of length
        where its distances are needed.

    Notes
    -----
    JD are written in UTC to 1 ms, magnitudes to 1e-6.

    Examples
    --------
    >>> import astropy.units as u, pathlib, tempfile
    >>> from astropy.time import Time
    >>> from fullbody import observing
    >>> view = {"to_observer": [1.0, 0.1, 0.0] * u.au, "to_sun": [2.0, 0.1, 0.0] * u.au}
    >>> times = Time(["2011-09-13T01:00:00", "2011-09-13T01:30:00"], scale="utc")
    >>> data = observing.Photometry(times, [7.3, 7.4], 0.01, geometry=observing.Geometry(times, **view))
    >>> about = {"OBJECTNUMBER": 1, "OBJECTNAME": "Ceres", "FILTER": "C", "MAGBAND": "V", "STANDARD": "INTERNAL",
    ...          "OBSERVERS": "A. Person", "CONTACTNAME": "A. Person", "CONTACTINFO": "person@example.org"}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder, "ceres.txt")
    ...     observing.write_alcdef(path, data, about)
    ...     print(path.read_text().splitlines()[-2])
    DATA=2455817.56250000|+7.400000|+0.010000
    """
    keywords = {
        str(key): str(value).strip() for key, value in instance(metadata, "metadata", Mapping, "a dict").items()
    }
    for key, value in keywords.items():
        line = f"{key}={value}"
        if not (_KEYWORD.fullmatch(line) and line.isprintable()) or key in (*_WRITTEN, "DATA", "DELIMITER"):
            raise InvalidInput(
                f"metadata has {key!r}: {value!r}; expected keywords in capitals that the data do not give, with "
                "printable text of one line"
            )
    if missing := [key for key in _REQUIRED if not keywords.get(key)]:
        raise InvalidInput(f"metadata has no {missing[0]}; expected {', '.join(_REQUIRED)}")
    choice(keywords["STANDARD"], "STANDARD", _ALLOWED["STANDARD"])
    data_sets = [data] if isinstance(data, Photometry) else instance(data, "data", Iterable, "a Photometry, or several")
    lines = [line for photometry in data_sets for line in _lines_of(photometry, keywords)]
    if not lines:
        raise InvalidInput("data is empty; expected one Photometry or more")
    with replacing(path) as file:
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _lines_of(data: Photometry, keywords: dict[str, str]) -> Iterator[str]:
    """Yield the lines of the blocks of a data set, one block for each night."""
    instance(data, "data", Photometry, "a Photometry")
    if not are_dates(data.times):
        raise InvalidInput("times of data are not dates; expected astropy Times, as ALCDEF has JD")
    if data.sigma.min() < _LEAST:
        raise InvalidInput(f"sigma of data has the value {data.sigma.min():.3g}; expected errors from 1e-6 on")
    if data.filters is not None and len(data.filters) > 1:
        raise InvalidInput(f"data has the filters {', '.join(map(str, data.filters))}; expected one, named by FILTER")
    if data.airmass is not None and data.airmass.min() < _LEAST:
        raise InvalidInput(f"airmass of data has the value {data.airmass.min():.3g}; expected airmasses above zero")
    table = data.to_table()
    for night in data.nights:
        rows = table[table["night"] == night]
        utc = rows["times"].utc
        middle = utc[0] + 0.5 * (utc[-1] - utc[0])
        day, clock = middle.isot.split("T")
        words = {"SESSIONDATE": day, "SESSIONTIME": clock[:8], **_corrections(data, rows["times"][len(rows) // 2])}
        words["DIFFERMAGS"] = "TRUE" if keywords["STANDARD"] == "NONE" else "FALSE"
        words["DELIMITER"] = "PIPE"
        yield from (
            "STARTMETADATA",
            *(f"{key}={value}" for key, value in (keywords | words).items()),
            "ENDMETADATA",
        )
        columns = [rows["magnitude"], rows["sigma"], *([rows["airmass"]] if "airmass" in rows.colnames else [])]
        for time, *values in zip(utc, *columns, strict=True):
            # The fraction of the day is taken from the two parts of JD, since their sum would lose digits.
            days, fraction = divmod(round((time.jd1 % 1.0 + time.jd2) * 1e8), 10**8)
            yield f"DATA={math.floor(time.jd1) + days}.{fraction:08d}" + "".join(f"|{value:+.6f}" for value in values)
        yield "ENDDATA"


def _corrections(data: Photometry, time: Any) -> dict[str, str]:
    """Return the keywords of light time and unit distances for a block, with their values at one time."""
    words = {"LTCAPP": "NONE", "LTCTYPE": "NONE", "REDUCEDMAGS": "NONE"}
    if data.geometry.light_time and not data.reduced:
        return words
    vectors = data.geometry.to_observer(time), data.geometry.to_sun(time)
    if not all(map(is_quantity, vectors)):
        raise InvalidInput("the geometry of data has no units of length; expected them for its distances in au")
    observer, sun = (float(np.linalg.norm(vector.to_value("au"))) for vector in vectors)
    if not data.geometry.light_time:
        days = float(np.linalg.norm(vectors[0].to_value("km"))) / LIGHT_SPEED / 86400.0
        words |= {"LTCAPP": "POINT", "LTCTYPE": "LIGHTTIME", "LTCDAYS": f"{-days:+.8f}"}
    return words | (
        {"REDUCEDMAGS": "POINT", "UCORMAG": f"{-5.0 * np.log10(observer * sun):+.4f}"} if data.reduced else {}
    )
