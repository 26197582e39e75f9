"""Published numbers as data: one table for computations, documentation and users."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ..errors import InvalidInput
from ..setups.toml_table import is_published
from . import _files

#: Nouns for keys of a file that are not their own names with spaces.
_NOUNS = {
    **{"diameters": "axes", "semi_axes": "semi-axes", "a/b": "axis ratio a/b", "a/c": "axis ratio a/c"},
    **{"a": "semi-major axis", "e": "eccentricity", "i": "inclination", "Omega": "ascending node"},
    **{"omega": "argument of periapsis", "M": "mean anomaly"},
}
_BINARY = {
    "period": "orbital period",
    "semi_major_axis": "semi-major axis",
    "GM": "GM of the system",
    "inclination": "inclination to the equator",
    "ascending_node": "ascending node on the equator",
}
_SUN = {
    "orbit": "heliocentric orbit (a, e, i, Omega, omega, M), ecliptic",
    "epoch": "epoch of the heliocentric orbit",
}


@dataclass(frozen=True, slots=True)
class Value:
    """A published number.

    Attributes
    ----------
    value : float or tuple of float
    unit, uncertainty, source : str
        The uncertainty as published, empty if there is none; and the key of the reference in ``Published.sources``.
    """

    value: Any
    unit: str
    uncertainty: str
    source: str

    def __str__(self) -> str:
        numbers = self.value if isinstance(self.value, tuple) else (self.value,)
        spread = f" +- {self.uncertainty}" if self.uncertainty else ""
        return f"{', '.join(f'{n:.10g}' for n in numbers)}{spread} {self.unit}".strip()


@dataclass(frozen=True, slots=True)
class Published:
    """The published numbers of a system, and the assumptions made beyond them.

    Attributes
    ----------
    values : dict of str to Value
    sources : dict of str to str
        References with their DOI, by key.
    assumed : tuple of str
        Assumptions beyond the published numbers, one sentence each.
    frame : str or None
        The frame of the published poles and elements, if there is one.
    epoch : str or None
        The date of time zero, if the phase is published.
    second_hand : tuple of str
        Names of the values that were taken from texts quoting the source, as the source could not be read.
    unconfirmed : tuple of str
        Names of the values, or ``"uncertainty of"`` them, that could not be read anywhere.
    """

    values: dict[str, Value]
    sources: dict[str, str]
    assumed: tuple[str, ...]
    frame: str | None
    epoch: str | None = None
    second_hand: tuple[str, ...] = ()
    unconfirmed: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Any:
        return self.values[name].value

    def table(self) -> str:
        """Format the values, assumptions and sources as text."""
        lines = [f"{name}: {value} [{value.source}]" for name, value in self.values.items()]
        lines.append(f"frame of the poles and elements: {self.frame or 'none'}")
        lines.append(f"epoch of time zero: {self.epoch or 'arbitrary'}")
        lines += [f"assumed: {text}" for text in self.assumed]
        exact = [name for name, value in self.values.items() if not value.uncertainty and name not in _SUN.values()]
        if exact:
            lines.append(f"without an uncertainty, as far as could be read: {', '.join(exact)}")
        if self.second_hand:
            lines.append(f"not confirmed against the source, quoted alike by others: {', '.join(self.second_hand)}")
        if self.unconfirmed:
            lines.append(f"not confirmed against the source nor by others: {', '.join(self.unconfirmed)}")
        lines += [f"[{key}] {text}" for key, text in self.sources.items()]
        return "\n".join(f"- {line}" for line in lines)


def published(name: str) -> Published:
    """Return the numbers of a ready-made system, with uncertainties, sources and assumptions.

    Parameters
    ----------
    name : str
        The name of the function, such as ``"didymos"``; others are refused.

    Raises
    ------
    InvalidInput
        For another name.

    Examples
    --------
    >>> import fullbody
    >>> print(fullbody.systems.published("antiope").values["semi-major axis"])
    171 +- 1 km
    """
    if not isinstance(name, str) or name not in _files.names():
        raise InvalidInput(f"name is {name!r}; expected one of {', '.join(_files.names())}")
    return of_contents(_files.contents(name))


def of_contents(content: dict[str, Any]) -> Published:
    """Return the published numbers of the contents of a file."""
    items = dict(_numbers(content))
    parts = [(name, part) for name, item in items.items() for part in item.get("doubt", "").split(", ")]

    def doubtful(word: str) -> tuple[str, ...]:
        doubts = ((name, part.startswith("error")) for name, part in parts if part.endswith(word))
        return tuple(f"uncertainty of {name}" if of_error else name for name, of_error in doubts)

    values = {}
    for name, item in items.items():
        value = tuple(item["value"]) if isinstance(item["value"], list) else item["value"]
        values[name] = Value(value, *(item.get(key, "") for key in ("unit", "error", "source")))
    frame, epoch = (content["system"].get(key) for key in ("frame", "epoch"))
    doubts = (doubtful("second-hand"), doubtful("unconfirmed"))
    return Published(values, content["sources"], tuple(content["assumed"]), frame, epoch, *doubts)


def _numbers(content: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the published numbers of a file with their names."""

    def of(table: dict[str, Any], name: str, nouns: dict[str, str] = _NOUNS, note: str = "") -> Any:
        for key, item in table.items():
            if is_published(item):
                yield f"{nouns.get(key, key.replace('_', ' '))}{name}{note}", item
            elif key in ("orbit", "part"):
                for k, part in enumerate([item] if isinstance(item, dict) else item):
                    yield from of(part, name if key == "orbit" else f" of lobe {k + 1}{name}")

    for body in content["body"]:
        yield from of(body, f" of {body['name']}")
    angles = "right ascension, declination" if content["system"].get("frame") == "equatorial" else "longitude, latitude"
    yield from of(content.get("binary", {}), "", {**_BINARY, "pole": f"pole ({angles})"})
    for variant in _files.variants(content)[1:]:
        for body, table in content["variants"][variant].items():
            yield from of(table, f" of {body}", note=f" ({variant})")
    yield from of(content.get("sun", {}), "", _SUN)
    yield from of(content.get("not_used", {}), "", note=" (not used)")
