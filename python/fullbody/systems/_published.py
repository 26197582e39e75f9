"""Published numbers as data: one table for the computing, the documentation and the curious."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from ..base.arguments import named_options
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
        As published; empty where none is.
    source : str
        Key of ``Published.sources``.
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
        References with their DOI.
    assumed : tuple of str
        Each a sentence.
    frame : str
        The frame of the published poles and elements.
    epoch : str or None
        The date of time zero, where the phase is published.
    second_hand : tuple of str
        Names of the values that could be read in texts quoting the source only, not in the source.
    unconfirmed : tuple of str
        Names of the values, or ``"uncertainty of"`` them, that could be read in neither.
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
        """All of it as text."""
        lines = [f"{name}: {value} [{value.source}]" for name, value in self.values.items()]
        lines += [f"frame of the poles and elements: {self.frame}", f"epoch of time zero: {self.epoch or 'arbitrary'}"]
        lines += [f"assumed: {text}" for text in self.assumed]
        if self.second_hand:
            lines.append(f"not confirmed against the source, quoted alike by others: {', '.join(self.second_hand)}")
        if self.unconfirmed:
            lines.append(f"not confirmed against the source nor by others: {', '.join(self.unconfirmed)}")
        lines += [f"[{key}] {text}" for key, text in self.sources.items()]
        return "\n".join(f"- {line}" for line in lines)


@named_options
def published(name: str) -> Published:
    """The numbers behind a ready-made system, with uncertainties, sources and what is assumed.

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


def documented(facts: Published) -> Callable[[_F], _F]:
    """Write the table of the facts into a function's documentation, at ``{published}``."""

    def decorate(function: _F) -> _F:
        _REGISTRY[function.__name__] = facts
        if function.__doc__ is not None:
            function.__doc__ = function.__doc__.replace("{published}", facts.table().replace("\n", "\n    "))
        return function

    return decorate
