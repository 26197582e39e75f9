"""The functions of the ready-made systems, with their signatures and documentation from the files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from inspect import Parameter, Signature
from textwrap import indent
from typing import Any

import numpy as np

from ..base.limits import Limits
from ..base.units import UNITLESS
from ..errors import InvalidInput
from ..model.state import State
from ..motion.system import System
from ..setups.toml_bodies import FIGURES
from . import _files
from ._build import FRAMES, ready
from ._published import of_contents

Ready = Callable[..., tuple[System, State]]

_FRAME = """The axes of the state: the ecliptic of J2000, the equator of J2000 (taken as the ICRS), or the orbit's plane
as xy-plane with its node on the x-axis, in a triple the plane of the orbit about a single body."""
_SUN = """Whether the Sun's gravity acts, as a :class:`fullbody.forces.ThirdBody` on the heliocentric orbit of the table
below, at time zero as at the epoch of its elements unless the system has an ``epoch``."""
_UNITS = """``True`` for Quantities in km, hour, kg, or three units for Quantities in these. Plain numbers are km, hour,
kg."""


def function(name: str) -> Ready:
    """Return the function that makes a ready-made system."""
    content = _files.contents(name)
    table, parameters_of_file = content.get("variants", {}), content.get("parameters", {})
    parameters = list(_parameters(content))
    signature = Signature([parameter for parameter, _, _ in parameters])

    def make(*args: Any, **kwargs: Any) -> tuple[System, State]:
        bound = signature.bind(*args, **kwargs)
        bound.apply_defaults()
        arguments = bound.arguments
        options = arguments.pop("options")
        variant = arguments.pop(table["option"]) if table else None
        changes: dict[str, dict[str, Any]] = {}
        for key, parameter in parameters_of_file.items():
            for body, value in _changes(key, parameter, arguments.pop(key)):
                if parameter["key"] in FIGURES and body in table.get(variant, {}):
                    option = f"{table['option']} is {variant!r}"
                    raise InvalidInput(f"{key} of {body} are {value} and {option}; expected one of the two")
                changes.setdefault(body, {})[parameter["key"]] = list(value) if np.ndim(value) else value
        return ready(name, variant, changes, **arguments, **options)

    make.__name__ = make.__qualname__ = name
    make.__module__ = __package__ or ""
    make.__signature__ = signature  # type: ignore[attr-defined]
    make.__doc__ = _documentation(content, parameters)
    return make


def _parameters(content: dict[str, Any]) -> Iterator[tuple[Parameter, str, str]]:
    """Yield the parameters of a system's function with their types and their descriptions."""

    def keyword(name: str, default: Any, kind: Any = Parameter.KEYWORD_ONLY) -> Parameter:
        return Parameter(name, kind, default=default)

    if variants := _files.variants(content):
        table = content["variants"]
        choices = ", ".join(f'"{name}"' for name in variants)
        first = keyword(table["option"], table["default"], Parameter.POSITIONAL_OR_KEYWORD)
        yield first, f"{{{choices}}}", table["text"]
    for name, table in content.get("parameters", {}).items():
        default = _nested(table["default"])
        yield keyword(name, default, Parameter.POSITIONAL_OR_KEYWORD), table["type"], table["text"]
    frame = content["system"].get("frame")
    if frame is not None:
        default = content.get("default_frame", frame)
        choices = ", ".join(f'"{name}"' for name in sorted(FRAMES, key=lambda name: name != default))
        yield keyword("frame", default), f"{{{choices}}}", _FRAME
    if "sun" in content:
        yield keyword("sun", False), "bool", _SUN
    if "units" in content["system"]:
        yield keyword("units", False), "bool or (length, time, mass)", _UNITS
    yield Parameter("options", Parameter.VAR_KEYWORD), "", "Passed to :class:`fullbody.System`."


def _nested(value: Any) -> Any:
    """Return lists as tuples."""
    return tuple(map(_nested, value)) if isinstance(value, list) else value


def _changes(name: str, table: dict[str, Any], value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the bodies that a parameter changes, each with the value of its key; nothing for the default."""
    dimension = table.get("dimension", "number")
    default = np.array(table["default"])
    numbers = UNITLESS.numbers(value, dimension, name, default.shape, Limits(text=table["expected"]))
    bodies, factors = table["bodies"], np.array(table.get("factors", 1.0))
    parts = numbers * factors if len(bodies) > 1 else [numbers]
    defaults = default * factors if len(bodies) > 1 else [default]
    for body, part, usual in zip(bodies, parts, defaults, strict=True):
        if not np.array_equal(part, usual):
            yield body, tuple(part.tolist()) if np.ndim(part) else float(part)


def _documentation(content: dict[str, Any], parameters: list[tuple[Parameter, str, str]]) -> str:
    """Return the docstring of a system's function."""
    described = "\n".join(
        f"{parameter.name if kind else '**options'}{' : ' if kind else ''}{kind}\n{indent(text, '    ')}"
        for parameter, kind, text in parameters
    )
    sections = [
        f"{content['title']}.",
        content.get("text", "").strip(),
        f"Parameters\n----------\n{described}",
        "Returns\n-------\nsystem : System\nstate : State",
        f"Notes\n-----\n{of_contents(content).table()}",
        f"Examples\n--------\n{content.get('example', '').strip()}",
    ]
    return "\n\n".join(section for section in sections if section) + "\n"
