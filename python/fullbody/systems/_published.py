"""Published numbers as data: one table for computations, documentation and users."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from ..errors import InvalidInput

__all__ = ["Published", "Value", "published"]

_F = TypeVar("_F", bound=Callable[..., Any])
_REGISTRY: dict[str, Published] = {}


@dataclass(frozen=True, slots=True)
class Value:
    """A published number.

    Attributes
    ----------
    value : float or tuple of float
    unit : str
    uncertainty : str
        The uncertainty as published; empty if there is none.
    source : str
        The key of the reference in ``Published.sources``.
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
    frame : str
        The frame of the published poles and elements.
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
    frame: str
    epoch: str | None = None
    second_hand: tuple[str, ...] = ()
    unconfirmed: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Any:
        return self.values[name].value

    def table(self) -> str:
        """Format the values, assumptions and sources as text."""
        lines = [f"{name}: {value} [{value.source}]" for name, value in self.values.items()]
        lines += [f"frame of the poles and elements: {self.frame}", f"epoch of time zero: {self.epoch or 'arbitrary'}"]
        lines += [f"assumed: {text}" for text in self.assumed]
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
        The name of the function, such as ``"didymos"``.

    Returns
    -------
    Published

    Raises
    ------
    InvalidInput
        For another name.

    Examples
    --------
    >>> import fullbody
    >>> print(fullbody.systems.published("antiope").values["separation"])
    171 +- 1 km
    """
    if not isinstance(name, str) or name not in _REGISTRY:
        raise InvalidInput(f"nothing is tabulated of {name!r}; expected one of {', '.join(sorted(_REGISTRY))}")
    return _REGISTRY[name]


#: Descriptions of parameters that most systems have; that of the frame depends on the frame of the published poles.
_FRAMES = {
    "ecliptic": """frame : {"ecliptic", "equatorial", "orbit"}
    Frame of the state: the ecliptic of J2000, the ICRS, or the orbit's plane as xy-plane and its node as x-axis.""",
    "equatorial": """frame : {"equatorial", "ecliptic", "orbit"}
    Frame of the state: the ICRS, the ecliptic of J2000, or the orbit's plane as xy-plane and its node as x-axis.""",
}
_SUN = """sun : bool
    Whether the Sun's gravity acts, as a :class:`fullbody.forces.ThirdBody` on the heliocentric orbit of the table
    below."""
_UNITS = """units : bool or (length, time, mass)
    ``True`` for Quantities in km, hour, kg, or three units for Quantities in these. Plain numbers are km, hour, kg.
**options
    Passed to :class:`fullbody.System`."""


def documented(facts: Published) -> Callable[[_F], _F]:
    """Write the common parameters and the table of the published numbers into a function's docstring.

    They replace ``{frame}``, ``{sun}``, ``{units}`` and ``{published}``.
    """
    texts = {"frame": _FRAMES.get(facts.frame, ""), "sun": _SUN, "units": _UNITS, "published": facts.table()}
    if facts.epoch is None:
        texts["sun"] = f"{_SUN[:-1]}: at time zero as at the epoch of its elements, unless the system has an ``epoch``."

    def decorate(function: _F) -> _F:
        _REGISTRY[function.__name__] = facts
        if function.__doc__ is not None:
            for name, text in texts.items():
                function.__doc__ = function.__doc__.replace(f"{{{name}}}", text.replace("\n", "\n    "))
        return function

    return decorate
