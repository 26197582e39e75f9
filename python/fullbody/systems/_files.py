"""The files of the ready-made systems: their contents, their variants, and changes to them."""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any

from ..base.kinds import choice
from ..setups.toml_bodies import FIGURES, MASSES, SHAPES


@cache
def names() -> tuple[str, ...]:
    """Return the names of all ready-made systems, which are those of the files."""
    return tuple(sorted(file.stem for file in Path(__file__).parent.glob("*.toml")))


@cache
def contents(name: str) -> dict[str, Any]:
    """Return the contents of a system's file."""
    import tomllib

    return tomllib.loads(path(name).read_text(encoding="utf-8"))


def path(name: str) -> Path:
    """Return the path of a system's file."""
    return Path(__file__).with_name(f"{name}.toml")


def variants(content: dict[str, Any]) -> tuple[str, ...]:
    """Return the names of the variants of a system, the default first."""
    table = content.get("variants", {})
    return (table["default"], *(name for name, part in table.items() if isinstance(part, dict))) if table else ()


def changed(content: dict[str, Any], variant: Any, changes: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Return the contents with a variant, and with other values of bodies by the name of the body.

    A change of a body removes the period that was found for the start, which belongs to the body as it was.
    """
    if names := variants(content):
        choice(variant, content["variants"]["option"], names)
        content = _merged(content, content["variants"].get(variant, {}))
    if not changes:
        return content
    content = _merged(content, changes)
    content.get("binary", {}).pop("start_period", None)
    return content


def _merged(content: dict[str, Any], overlay: dict[str, Any]) -> dict[str, Any]:
    """Return a copy of the contents with the tables and values of the overlay, bodies by their names."""
    result = deepcopy(content)
    bodies = {body["name"]: body for body in result["body"]}
    for key, value in overlay.items():
        if key in bodies:
            for group in (SHAPES, MASSES):
                if not value.keys().isdisjoint(group):
                    for previous in (*group, *(FIGURES if group is SHAPES else ())):
                        bodies[key].pop(previous, None)
            bodies[key].update(deepcopy(value))
        elif isinstance(value, dict) and key in result:
            result[key].update(deepcopy(value))
        else:
            result[key] = deepcopy(value)
    return result
